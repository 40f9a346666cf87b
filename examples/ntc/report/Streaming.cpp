// SPDX-License-Identifier: MIT
#include "report/Streaming.h"

#include "Failure.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Output.h"
#include "report/Device.h"

#include "openntc/streaming/DemandLoader.h"
#include "openntc/streaming/TextureSetTileSource.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>

namespace openntc::report {

using tool::ExitCode;
using tool::Format;
using tool::Require;

namespace {

constexpr int kPlane = 4;                               // sets a side
constexpr int kTile = 8;                                // texels of a latent level
constexpr int kPictureColumns = 160, kPictureRows = 90; // pixels
constexpr int kMostRounds = 64;                         // before the path begins

/// Slots that nothing is drawn from: what is measured is how they come to be filled.
class NullPool final : public TileUploader {
public:
    Expected<void> Upload(const TileUpload&) override { return {}; }
};

/// What a pixel of the plane wants.
struct Wanted {
    int set = 0, mip = 0, x = 0, y = 0;
};

/// Above the plane, looking ahead: from far up, where one tail fills the picture, down to a texel a pixel,
/// along, and up.
struct Camera {
    double x = 0, z = 0, height = 1;
};

Camera GetCamera(double time) {
    return {0.5 + 1.5 * std::sin(2.1 * time), 6 * time,
            0.15 + 1.35 * (0.5 + 0.5 * std::cos(6.28318530718 * time))};
}

std::vector<Wanted> ListWanted(const Camera& camera, const TileLayout& layout) {
    std::vector<Wanted> wanted;
    for (int row = 0; row < kPictureRows; ++row) {
        const double down = (row + 1.0) / kPictureRows;
        const double depth = camera.height / down;
        const double across = 1.6 * depth / kPictureColumns; // of a pixel, in sets
        const double along = camera.height / (down * down * kPictureRows);
        const double texels =
            std::max(across, along) * std::max(layout.GetMipWidth(0), layout.GetMipHeight(0));
        const int mip = std::clamp(static_cast<int>(std::floor(std::log2(std::max(texels, 1e-3)) + 0.5)), 0,
                                   layout.GetMips() - 1);
        for (int column = 0; column < kPictureColumns; ++column) {
            const double u = camera.x + across * (column - kPictureColumns / 2 + 0.5), v = camera.z + depth;
            const double left = std::floor(u), top = std::floor(v);
            const auto wrap = [](double n) { return static_cast<int>(n - kPlane * std::floor(n / kPlane)); };
            const int width = layout.GetMipWidth(mip), height = layout.GetMipHeight(mip);
            wanted.push_back({wrap(top) * kPlane + wrap(left), mip,
                              std::min(static_cast<int>((u - left) * width), width - 1),
                              std::min(static_cast<int>((v - top) * height), height - 1)});
        }
    }
    return wanted;
}

/// All mips, 16 values a texel.
std::vector<std::vector<float>> DecodeMips(const Encoding& encoding, const TileLayout& layout) {
    const std::unique_ptr<tool::Decoder> decoder =
        tool::RequireDecoder(encoding.record.name, encoding.int8, {});
    std::vector<std::vector<float>> mips;
    for (int mip = 0; mip < layout.GetMips(); ++mip) {
        const int width = layout.GetMipWidth(mip), height = layout.GetMipHeight(mip);
        std::vector<float> texels(16 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
        Require(decoder->Decode(mip, {0, 0, width, height}, {DecodeMath::Int8, false}, texels),
                ExitCode::Failed, encoding.record.name);
        mips.push_back(std::move(texels));
    }
    return mips;
}

struct Sums {
    std::uint64_t pixels = 0, atWanted = 0, levels = 0, values = 0;
    double squares = 0;
};

class Flight {
public:
    Flight(const StreamingCase& c, const Encoding& encoding)
        : case_(c), encoding_(encoding), file_(tool::ReadAll(encoding.path)),
          source_(Require(TextureSetTileSource::OpenMemory(file_, kTile, kTile), ExitCode::BadInput,
                          encoding.path)),
          layout_(source_->GetLayout()), mips_(DecodeMips(encoding, layout_)), loader_(MakeLoader()) {
        TiledTextureDesc desc;
        desc.format = TileFormat::TextureSet;
        desc.hasFeedback = false;
        for (int i = 0; i < kPlane * kPlane; ++i)
            ids_.push_back(
                Require(loader_.CreateTexture(source_, desc), ExitCode::Failed, encoding.record.name).index);
        mask_ = encoding.GetOutputMask(encoding.record.channels);
    }

    StreamingRecord Fly(int frames) {
        for (int round = 0; round < kMostRounds; ++round) { // the first picture is there when the path begins
            Sums unused;
            RunFrame(0, unused);
            if (loader_.GetProgress().state != DemandState::Working)
                break;
        }
        const DemandStatistics before = loader_.GetStatistics();
        Sums sums;
        std::vector<double> milliseconds;
        for (int frame = 1; frame <= frames; ++frame) {
            tool::ThrowIfInterrupted();
            milliseconds.push_back(RunFrame(static_cast<double>(frame) / frames, sums));
        }
        const DemandStatistics after = loader_.GetStatistics();
        StreamingRecord record;
        record.id = case_.GetId();
        record.encoding = encoding_.record.name;
        record.sets = kPlane * kPlane;
        record.frames = frames;
        record.tilesAFrameLimit = case_.tilesAFrame;
        record.allTiles = slots_.all;
        record.budgetTiles = slots_.budget;
        record.allBytes = std::uint64_t{slots_.all} * slotBytes_;
        record.budgetBytes = std::uint64_t{slots_.budget} * slotBytes_;
        record.wantedShare = static_cast<double>(sums.atWanted) / static_cast<double>(sums.pixels);
        record.mipDeficit = static_cast<double>(sums.levels) / static_cast<double>(sums.pixels);
        const double error = sums.squares / static_cast<double>(sums.values);
        record.psnr = -10 * std::log10(error); // infinite where nothing differs
        record.tilesLoaded = static_cast<double>(after.uploaded - before.uploaded) / frames;
        record.bytesLoaded = static_cast<double>(after.bytesUploaded - before.bytesUploaded) / frames;
        record.millisecondsAFrame = Summarise(std::move(milliseconds));
        return record;
    }

private:
    DemandLoader MakeLoader() {
        const std::uint32_t sets = kPlane * kPlane;
        slots_.all = sets * static_cast<std::uint32_t>(layout_.GetTileCount());
        const std::uint32_t tails = sets * static_cast<std::uint32_t>(layout_.GetTailTileCount());
        slots_.budget = std::max(slots_.all / static_cast<std::uint32_t>(case_.budgetParts),
                                 tails + sets); // room to show anything
        slotBytes_ = static_cast<std::uint32_t>((source_->GetLargestTileBytes() + 15) / 16 * 16);
        DemandLoaderOptions options;
        options.slots = slots_.budget;
        options.slotBytes = slotBytes_;
        options.table = {sets, slots_.all, slots_.budget, slots_.budget, sets * NTC_MAX_MIPS, 0, 0};
        options.framesInFlight = 1;
        options.threads = 0;
        options.coalesce = false;
        options.maxOutstanding = slots_.all;
        return Require(DemandLoader::Create(options), ExitCode::Failed, "loader");
    }

    /// Milliseconds that the loader took.
    double RunFrame(double time, Sums& sums) {
        using Clock = std::chrono::steady_clock;
        const auto start = Clock::now();
        const LaunchPlan plan = Require(loader_.LaunchPrepare(pool_), ExitCode::Failed, "launch");
        const auto prepared = Clock::now();
        std::vector<std::uint32_t> stamps(slots_.budget, 0);
        std::vector<NtcTileRequest> requests;
        std::vector<bool> isRequested(slots_.all, false);
        for (const Wanted& w : ListWanted(GetCamera(time), layout_))
            Show(w, plan.context.round, stamps, requests, isRequested, sums);
        const auto rendered = Clock::now();
        DemandLimits limits;
        if (case_.tilesAFrame > 0)
            limits.maxTiles = static_cast<std::uint32_t>(case_.tilesAFrame);
        Require(
            loader_.ProcessRequests(plan.context, {{std::as_bytes(std::span(requests)), 0}, stamps}, limits),
            ExitCode::Failed, "requests");
        const auto end = Clock::now();
        return std::chrono::duration<double, std::milli>((prepared - start) + (end - rendered)).count();
    }

    /// What a shader does for a pixel: the finest mip at most as fine as the wanted one whose tile is there.
    void Show(const Wanted& wanted, std::uint32_t round, std::vector<std::uint32_t>& stamps,
              std::vector<NtcTileRequest>& requests, std::vector<bool>& isRequested, Sums& sums) {
        const std::uint32_t id = ids_[static_cast<std::size_t>(wanted.set)];
        for (int mip = wanted.mip; mip < layout_.GetMips(); ++mip) {
            const auto move = [&](int texel, int size, int toSize) {
                return std::min(
                    static_cast<int>((2 * std::int64_t{texel} + 1) * toSize / (2 * std::int64_t{size})),
                    toSize - 1);
            };
            const int x = move(wanted.x, layout_.GetMipWidth(wanted.mip), layout_.GetMipWidth(mip));
            const int y = move(wanted.y, layout_.GetMipHeight(wanted.mip), layout_.GetMipHeight(mip));
            const std::uint32_t tile = *layout_.GetTileNumber(*layout_.GetTileOfTexel(mip, x, y));
            const std::uint32_t slot = *loader_.GetPageTable().GetSlot(id, tile);
            if (slot == NTC_TILE_MISSING) {
                const std::size_t place =
                    std::size_t{id} * static_cast<std::size_t>(layout_.GetTileCount()) + tile;
                if (mip == wanted.mip && !isRequested[place]) {
                    isRequested[place] = true;
                    requests.push_back({id, tile});
                }
                continue;
            }
            stamps[slot] = round;
            ++sums.pixels;
            sums.atWanted += mip == wanted.mip ? 1 : 0;
            sums.levels += static_cast<std::uint64_t>(mip - wanted.mip);
            sums.values += static_cast<std::uint64_t>(std::popcount(mask_));
            if (mip == wanted.mip)
                return;
            const float* const shown = GetTexel(mip, x, y);
            const float* const right = GetTexel(wanted.mip, wanted.x, wanted.y);
            for (int c = 0; c < 16; ++c) {
                const double difference = (mask_ >> c & 1u) != 0
                                              ? static_cast<double>(shown[c]) - static_cast<double>(right[c])
                                              : 0.0;
                sums.squares += difference * difference;
            }
            return;
        }
        throw tool::CommandError(ExitCode::Failed, encoding_.record.name,
                                 "streaming: a tail that is not there");
    }

    const float* GetTexel(int mip, int x, int y) const {
        const std::size_t texel =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(layout_.GetMipWidth(mip)) +
            static_cast<std::size_t>(x);
        return mips_[static_cast<std::size_t>(mip)].data() + 16 * texel;
    }

    struct Slots {
        std::uint32_t all = 0, budget = 0;
    };

    StreamingCase case_;
    const Encoding& encoding_;
    std::vector<std::byte> file_;
    Shared<TextureSetTileSource> source_;
    const TileLayout& layout_;
    std::vector<std::vector<float>> mips_;
    Slots slots_;
    std::uint32_t slotBytes_ = 0;
    NullPool pool_;
    DemandLoader loader_;
    std::vector<std::uint32_t> ids_;
    std::uint32_t mask_ = 0;
};

} // namespace

std::string StreamingCase::GetId() const {
    const std::string budget = budgetParts == 1 ? "all" : Format("1/%d", budgetParts);
    return "streaming budget " + budget +
           (tilesAFrame > 0 ? Format(", %d tiles a frame", tilesAFrame) : std::string());
}

std::vector<StreamingCase> ListStreamingCases(bool quick) {
    if (quick)
        return {{1, 0}, {4, 0}, {16, 0}, {1, 8}};
    return {{1, 0}, {2, 0}, {4, 0}, {8, 0}, {16, 0}, {1, 32}, {1, 16}, {1, 8}, {1, 4}};
}

StreamingRecord MeasureStreaming(const StreamingCase& c, const Encoding& encoding, bool quick) {
    return Flight(c, encoding).Fly(quick ? 48 : 192);
}

} // namespace openntc::report
