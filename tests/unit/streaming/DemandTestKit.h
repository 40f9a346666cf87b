// SPDX-License-Identifier: MIT
// For tests of the demand loader: a source of numbers that can misbehave, and a device made of arrays. The
// device takes each launch's page table when it is prepared and runs the launch when it is told to, so that
// launches overlap as on a GPU; slots are one memory that uploads change at once.
#pragma once

#include "openntc/streaming/DemandLoader.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace demand_test {

using namespace openntc;

inline std::uint32_t Mix(std::uint32_t a, std::uint32_t b) {
    std::uint32_t h = a * 0x9E3779B1u ^ (b + 0x7F4A7C15u) * 0x85EBCA6Bu;
    h ^= h >> 15;
    h *= 0xC2B2AE35u;
    return h ^ h >> 13;
}

/// What the texel of every test image is.
inline std::uint32_t TexelOf(std::uint32_t seed, int mip, int x, int y) {
    return Mix(Mix(seed, static_cast<std::uint32_t>(mip)),
               Mix(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)));
}

inline TileLayout MakeLayout(int width, int height, int tile, int mips = 0) {
    TileLayoutDesc desc;
    desc.width = width;
    desc.height = height;
    desc.tileWidth = tile;
    desc.tileHeight = tile;
    desc.mips = mips;
    while (mips == 0 && std::max(width, height) >> desc.mips > 0)
        ++desc.mips;
    desc.levelCount = kLevelsAboveOneTile;
    auto layout = TileLayout::Create(desc);
    if (!layout) { // the coarsest mip does not fit one tile: no tail
        desc.tailTiles = 0;
        layout = TileLayout::Create(desc);
    }
    REQUIRE_MESSAGE(layout.has_value(), std::string(layout.error().GetText()));
    return *layout;
}

/// What a source does with a read, beside reading.
enum class Fault { None, Throw, ThrowInt, Error, Short, Long, Later };

class NumberSource final : public TileSource {
public:
    NumberSource(const TileLayout& layout, std::uint32_t seed)
        : layout_(layout), seed_(seed),
          reads_(std::make_unique<std::atomic<int>[]>(static_cast<std::size_t>(layout.GetTileCount()))) {}

    const TileLayout& GetLayout() const noexcept override { return layout_; }
    std::size_t GetTileBytes(std::uint32_t tile) const noexcept override {
        if (IsTail(tile))
            return 4 * tailTexels_;
        return 4 * static_cast<std::size_t>(layout_.GetTileWidth() * layout_.GetTileHeight());
    }
    std::size_t GetLargestTileBytes() const noexcept override {
        return std::max(4 * tailTexels_,
                        4 * static_cast<std::size_t>(layout_.GetTileWidth() * layout_.GetTileHeight()));
    }
    Expected<TileRead> ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                const TileCancellation& cancellation) override {
        ++reads_[tile];
        ++running;
        struct Leave {
            std::atomic<int>& count;
            ~Leave() { --count; }
        } leave{running};
        if (onRead)
            onRead(tile, cancellation);
        const Fault fault = getFault ? getFault(tile) : Fault::None;
        if (fault == Fault::Throw)
            throw std::runtime_error("disk on fire");
        if (fault == Fault::ThrowInt)
            throw 5;
        if (fault == Fault::Error)
            return Fail(Status::IOError, "tile: %u: the network is down", tile);
        if (fault == Fault::Later)
            return TileRead{TileAnswer::Later, 0};
        std::size_t at = 0;
        const auto put = [&](int mip, int x, int y) {
            const std::uint32_t texel = isUniform ? 7 : TexelOf(seed_, mip, x, y);
            std::memcpy(destination.data() + at, &texel, 4);
            at += 4;
        };
        if (IsTail(tile)) {
            for (int mip = layout_.GetTailFirstMip(); mip < layout_.GetMips(); ++mip)
                for (int y = 0; y < layout_.GetMipHeight(mip); ++y)
                    for (int x = 0; x < layout_.GetMipWidth(mip); ++x)
                        put(mip, x, y);
        } else {
            const TilePosition position = *layout_.GetTilePosition(tile);
            for (int y = 0; y < layout_.GetTileHeight(); ++y)
                for (int x = 0; x < layout_.GetTileWidth(); ++x)
                    put(position.level, position.x * layout_.GetTileWidth() + x,
                        position.y * layout_.GetTileHeight() + y);
        }
        if (fault == Fault::Short)
            at -= 4;
        if (fault == Fault::Long)
            at += 4;
        return TileRead{TileAnswer::Ready, at};
    }

    int GetReads(std::uint32_t tile) const { return reads_[tile]; }
    int GetReads() const {
        int sum = 0;
        for (int tile = 0; tile < layout_.GetTileCount(); ++tile)
            sum += reads_[static_cast<std::size_t>(tile)];
        return sum;
    }
    std::uint32_t GetSeed() const { return seed_; }
    std::span<const std::byte> GetIdentity() const noexcept override {
        return std::as_bytes(std::span(identity));
    }

    std::function<Fault(std::uint32_t tile)> getFault;
    std::function<void(std::uint32_t tile, const TileCancellation&)> onRead;
    bool isUniform = false;
    std::string identity;
    std::atomic<int> running{0};

private:
    bool IsTail(std::uint32_t tile) const {
        return tile >= static_cast<std::uint32_t>(layout_.GetRegularTileCount());
    }
    std::size_t GetTailTexels() const {
        std::size_t texels = 0;
        for (int mip = layout_.GetTailFirstMip(); mip < layout_.GetMips(); ++mip)
            texels += static_cast<std::size_t>(layout_.GetMipWidth(mip) * layout_.GetMipHeight(mip));
        return texels;
    }

    TileLayout layout_;
    std::uint32_t seed_;
    std::unique_ptr<std::atomic<int>[]> reads_;
    std::size_t tailTexels_ = GetTailTexels();
};

inline Shared<NumberSource> MakeSource(const TileLayout& layout, std::uint32_t seed) {
    auto source = MakeShared<NumberSource>(GetDefaultAllocator(), layout, seed);
    REQUIRE(source.has_value());
    return *source;
}

/// One launch: its page table, and what it needs to run.
struct Launch {
    DemandContext context;
    NtcStreamingConstants constants{};
    std::vector<std::uint32_t> table;
};

struct Fetched {
    bool resident = false;
    int mip = -1; ///< that was there
    std::uint32_t value = 0;
};

class Device final : public TileUploader {
public:
    explicit Device(const DemandLoaderOptions& options) : options_(options) {
        slots_.resize(std::size_t{options.slots} * options.slotBytes / 4);
        generations.resize(options.slots);
    }

    Expected<void> Upload(const TileUpload& upload) override {
        if (onUpload)
            OPENNTC_CHECK(onUpload(upload));
        REQUIRE(upload.offset + upload.bytes.size() <= slots_.size() * 4);
        REQUIRE(upload.bytes.size() <= options_.slotBytes);
        std::memcpy(reinterpret_cast<std::byte*>(slots_.data()) + upload.offset, upload.bytes.data(),
                    upload.bytes.size());
        ++generations[upload.slot];
        log.push_back({upload.textureId, upload.tile, upload.slot});
        return {};
    }

    /// LaunchPrepare, and what an engine does with the plan.
    Launch Prepare(DemandLoader& loader, const DemandLimits& limits = {}) {
        auto plan = loader.LaunchPrepare(*this, limits);
        REQUIRE_MESSAGE(plan.has_value(), std::string(plan.error().GetText()));
        const std::span<const std::byte> bytes = loader.GetPageTable().GetBytes();
        table_.resize(bytes.size() / 4);
        for (const PageTable::ByteRange& range : plan->tableChanges)
            std::memcpy(reinterpret_cast<std::byte*>(table_.data()) + range.offset,
                        bytes.data() + range.offset, range.size);
        REQUIRE(std::memcmp(table_.data(), bytes.data(), bytes.size()) == 0);
        const LaunchState& state = loader.GetPageTable().GetLaunchState();
        if (state_.empty()) {
            state_.resize(state.words + kGuard, kGuardWord);
            std::fill(state_.begin(), state_.begin() + state.words, 0u);
        }
        for (const StateFill& fill : plan->stateFills) {
            REQUIRE(fill.firstWord >= state.bitsWord);
            REQUIRE(fill.firstWord + fill.words <= state.stampsWord);
            std::fill_n(state_.begin() + fill.firstWord, fill.words, 0u);
        }
        fills = plan->stateFills.size();
        const NtcRequestQueue head = {0, 0, state.queueCapacity, 0};
        std::memcpy(state_.data() + state.queueWord, &head, sizeof(head));
        Launch launch;
        launch.context = plan->context;
        launch.constants = loader.GetPageTable().MakeConstants(plan->context.round);
        launch.table = table_;
        return launch;
    }

    NtcTiledTexture GetHeader(const Launch& launch, std::uint32_t texture) const {
        NtcTiledTexture header{};
        if (texture < launch.constants.textureCount)
            std::memcpy(&header, launch.table.data() + launch.constants.headersWord + texture * 88,
                        sizeof(header));
        return header;
    }

    /// Independent of the shaders': asks for a tile or page that is missing, at a rate.
    void Request(const Launch& launch, std::uint32_t texture, std::uint32_t tile) {
        if (rate < 1 && Mix(launch.context.round, ++random) >= rate * 4294967296.0)
            return;
        const std::uint32_t entry = GetHeader(launch, texture).firstEntry + tile;
        std::uint32_t& bits = state_[launch.constants.bitsWord + entry / 32];
        if ((bits >> (entry % 32) & 1u) != 0)
            return;
        bits |= 1u << (entry % 32);
        ++attempts;
        std::uint32_t* queue = state_.data() + launch.constants.queueWord;
        const std::uint32_t place = queue[0]++;
        if (place < queue[2]) {
            queue[4 + 2 * place] = texture;
            queue[5 + 2 * place] = tile;
        } else {
            ++queue[1];
        }
    }
    std::uint32_t GetEntry(const Launch& launch, std::uint32_t texture, std::uint32_t tile) const {
        return launch.table[launch.constants.entriesWord + GetHeader(launch, texture).firstEntry + tile];
    }

    /// Nearest texel: the value of the finest mip that is there, at the place of (x, y) of `mip`.
    Fetched Fetch(const Launch& launch, std::uint32_t texture, const TileLayout& layout, int mip, int x,
                  int y) {
        Fetched fetched;
        if (GetHeader(launch, texture).format == NTC_TILES_NONE)
            return fetched;
        for (int level = mip; level < layout.GetMips(); ++level) {
            const int px =
                static_cast<int>(std::int64_t{x} * layout.GetMipWidth(level) / layout.GetMipWidth(mip));
            const int py =
                static_cast<int>(std::int64_t{y} * layout.GetMipHeight(level) / layout.GetMipHeight(mip));
            const TilePosition position = *layout.GetTileOfTexel(level, px, py);
            const std::uint32_t tile = *layout.GetTileNumber(position);
            const std::uint32_t slot = GetEntry(launch, texture, tile);
            if (slot == NTC_TILE_MISSING) {
                if (level == mip)
                    Request(launch, texture, tile);
                continue;
            }
            REQUIRE(slot < options_.slots);
            state_[launch.constants.stampsWord + options_.firstSlot + slot] = launch.context.round;
            std::size_t word = (options_.slotsOffset + std::size_t{slot} * options_.slotBytes) / 4;
            if (level >= layout.GetTailFirstMip()) {
                for (int above = layout.GetTailFirstMip(); above < level; ++above)
                    word += static_cast<std::size_t>(layout.GetMipWidth(above) * layout.GetMipHeight(above));
                word += static_cast<std::size_t>(py * layout.GetMipWidth(level) + px);
            } else {
                word += static_cast<std::size_t>((py - position.y * layout.GetTileHeight()) *
                                                     layout.GetTileWidth() +
                                                 px - position.x * layout.GetTileWidth());
            }
            fetched.resident = level == mip;
            fetched.mip = level;
            fetched.value = slots_[word];
            fetchedX = px;
            fetchedY = py;
            return fetched;
        }
        return fetched;
    }

    /// Fetches, and checks that the value is the source's at the mip that was there.
    Fetched FetchChecked(const Launch& launch, DemandId texture, const NumberSource& source, int mip, int x,
                         int y) {
        const Fetched fetched = Fetch(launch, texture.index, source.GetLayout(), mip, x, y);
        if (fetched.mip >= 0)
            CHECK(fetched.value == TexelOf(source.GetSeed(), fetched.mip, fetchedX, fetchedY));
        return fetched;
    }

    /// One texel of each tile of a mip in a rectangle of tiles; how many were resident.
    int View(const Launch& launch, DemandId texture, const NumberSource& source, int mip, int tileLeft = 0,
             int tileTop = 0, int tilesX = 1 << 20, int tilesY = 1 << 20) {
        const TileLayout& layout = source.GetLayout();
        int resident = 0;
        const int width = layout.GetTileWidth(), height = layout.GetTileHeight();
        for (int y = tileTop * height; y < layout.GetMipHeight(mip) && y / height < tileTop + tilesY;
             y += height)
            for (int x = tileLeft * width; x < layout.GetMipWidth(mip) && x / width < tileLeft + tilesX;
                 x += width)
                resident += FetchChecked(launch, texture, source, mip, x, y).resident ? 1 : 0;
        return resident;
    }

    DemandReadback Read(const DemandLoader& loader) {
        const LaunchState& state = loader.GetPageTable().GetLaunchState();
        for (std::size_t i = state.words; i < state_.size(); ++i)
            REQUIRE(state_[i] == kGuardWord);
        DemandReadback readback;
        const auto requests = ReadRequests(state, std::as_bytes(std::span(state_)));
        REQUIRE(requests.has_value());
        readback.requests = *requests;
        if (hasStamps)
            readback.stamps = std::span<const std::uint32_t>(state_).subspan(
                state.stampsWord, loader.GetPageTable().GetLimits().maxSlots);
        lastRequests.clear();
        for (std::size_t i = 0; i < requests->GetCount(); ++i)
            lastRequests.push_back({(*requests)[i].textureId, (*requests)[i].tile});
        lastOverflow = requests->overflow;
        return readback;
    }

    DemandTicket Process(DemandLoader& loader, const Launch& launch, const DemandLimits& limits = {}) {
        auto ticket = loader.ProcessRequests(launch.context, Read(loader), limits);
        REQUIRE_MESSAGE(ticket.has_value(), std::string(ticket.error().GetText()));
        return *ticket;
    }

    /// Launches `render` until the loader is done or has no room; returns the launches that requested something.
    int Converge(DemandLoader& loader, const std::function<void(const Launch&)>& render, int most = 1000) {
        int rounds = 0;
        for (int i = 0; i < most; ++i) {
            const Launch launch = Prepare(loader);
            render(launch);
            const DemandTicket ticket = Process(loader, launch);
            ticket.Wait();
            rounds += lastRequests.empty() ? 0 : 1;
            const DemandProgress progress = loader.GetProgress();
            if (progress.state != DemandState::Working)
                return rounds;
            if (lastRequests.empty())
                loader.WaitIdle();
        }
        FAIL("did not converge");
        return rounds;
    }

    struct Uploaded {
        std::uint32_t texture, tile, slot;
        friend bool operator==(const Uploaded&, const Uploaded&) = default;
    };
    std::vector<Uploaded> log;
    std::vector<std::uint32_t> generations; ///< uploads into each slot
    std::vector<std::pair<std::uint32_t, std::uint32_t>> lastRequests;
    std::uint32_t lastOverflow = 0;
    std::size_t fills = 0;
    std::uint64_t attempts = 0; ///< requests that were no repetition
    std::uint32_t random = 0;
    double rate = 1;
    bool hasStamps = true;
    int fetchedX = 0, fetchedY = 0;
    std::function<Expected<void>(const TileUpload&)> onUpload;

    std::vector<std::uint32_t>& GetState() { return state_; }
    std::vector<std::uint32_t>& GetSlots() { return slots_; }

private:
    static constexpr std::size_t kGuard = 64;
    static constexpr std::uint32_t kGuardWord = 0xDEADBEEFu;

    DemandLoaderOptions options_;
    std::vector<std::uint32_t> table_, state_, slots_;
};

/// 16 × 16 tiles of 4 bytes a texel, and small tables.
inline DemandLoaderOptions MakeOptions(std::uint32_t slots, int threads = 0) {
    DemandLoaderOptions options;
    options.table = {16, 8192, slots + 4, slots + 4, 64, 4096, 1024};
    options.slots = slots;
    options.slotBytes = 16 * 16 * 4 + 512; // tails are larger than tiles
    options.firstSlot = 3;
    options.framesInFlight = 1;
    options.threads = threads;
    return options;
}

inline DemandLoader MakeLoader(const DemandLoaderOptions& options,
                               Allocator& allocator = GetDefaultAllocator()) {
    auto loader = DemandLoader::Create(options, allocator);
    REQUIRE_MESSAGE(loader.has_value(), std::string(loader.error().GetText()));
    return std::move(*loader);
}

inline DemandId AddTexture(DemandLoader& loader, const Shared<NumberSource>& source) {
    TiledTextureDesc desc;
    desc.format = TileFormat::RGBA8;
    desc.hasFeedback = false;
    const auto id = loader.CreateTexture(source, desc);
    REQUIRE_MESSAGE(id.has_value(), std::string(id.error().GetText()));
    return *id;
}

/// The sums that DemandStatistics states, with nothing outstanding but what it says.
inline void CheckSums(const DemandLoader& loader) {
    const DemandStatistics s = loader.GetStatistics();
    CHECK(s.requested == s.taken + s.restored + s.known + s.inError + s.stale + s.overLimit + s.noRoom);
    CHECK(s.started == s.taken + s.ancestors + s.tails);
    CHECK(s.started == s.filled + s.failed + s.deferred + s.cancelled + s.reading);
    CHECK(s.filled == s.uploaded + s.shared + s.pages + s.uploadFailed + s.discarded + s.waiting);
    CHECK(s.evicted == s.rescued + s.freed + s.stagedTiles);
}

} // namespace demand_test
