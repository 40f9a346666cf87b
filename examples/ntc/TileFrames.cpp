// SPDX-License-Identifier: MIT
#include "TileFrames.h"

#include "Failure.h"
#include "Interrupt.h"

#include "openntc/streaming/TileManager.h"

#include <algorithm>
#include <ctime>
#include <random>

namespace openntc::tool {

namespace {

constexpr int kWarmUpFrames = 12;
constexpr std::uint32_t kRegions = 64;

/// CPU milliseconds of this thread.
double GetCpuTime() {
#if defined(CLOCK_THREAD_CPUTIME_ID)
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_nsec);
#else
    return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
#endif
}

template <typename T>
T Need(Expected<T>&& result) {
    return Require(std::move(result), ExitCode::Failed, "bench tiles");
}

TileManager MakeManager() {
    TileManagerDesc desc;
    desc.tilesPerHeap = 256;
    desc.standbyTarget = 1000;
    return Need(TileManager::Create(desc));
}

TileLayout MakeLayout() {
    TileLayoutDesc desc;
    desc.width = desc.height = 2048;
    desc.tileWidth = desc.tileHeight = 256;
    desc.mips = 12;
    desc.levelCount = 4;
    return Need(TileLayout::Create(desc));
}

/// One run: textures, their feedback, and frames of a manager over them.
class TileFrames {
public:
    TileFrames(const TileFramesOptions& options, std::uint64_t seed)
        : options_(options), random_(seed), manager_(MakeManager()),
          feedback_(static_cast<std::size_t>(options.textures) * kRegions), isChanged_(Count()),
          isTouched_(Count()) {
        const TileLayout layout = MakeLayout();
        for (int i = 0; i < options.textures; ++i)
            ids_.push_back(Need(manager_.AddTexture(layout)));
        for (std::uint8_t& value : feedback_)
            value = PickValue();
        std::fill(isChanged_.begin(), isChanged_.end(), char{1}); // the first frame sees all of it
        for (std::size_t i = 0; i < Count(); ++i)
            changed_.push_back(static_cast<std::uint32_t>(i));
    }

    /// The feedback of the next frame; not timed.
    int Change() {
        for (const std::uint32_t i : changed_)
            isChanged_[i] = 0;
        changed_.clear();
        const double share = options_.changePercent / 100;
        const double of = static_cast<double>(options_.variant == 'C' ? Count() : feedback_.size());
        const int count = std::max(1, static_cast<int>(share * of));
        for (int i = 0; i < count; ++i) {
            const std::size_t picked = random_() % static_cast<std::size_t>(of);
            const std::size_t texture = options_.variant == 'C' ? picked : picked / kRegions;
            const std::size_t first = options_.variant == 'C' ? picked * kRegions : picked;
            for (std::size_t region = first; region < first + (options_.variant == 'C' ? kRegions : 1);
                 ++region)
                feedback_[region] = PickValue();
            if (isChanged_[texture] == 0) {
                isChanged_[texture] = 1;
                changed_.push_back(static_cast<std::uint32_t>(texture));
            }
        }
        std::sort(changed_.begin(), changed_.end());
        return count * (options_.variant == 'C' ? static_cast<int>(kRegions) : 1);
    }

    /// One frame; adds the time of each phase.
    void Run(std::array<double, kTilePhases>& phases) {
        std::size_t phase = 0;
        double before = GetCpuTime();
        const auto end = [&] {
            const double now = GetCpuTime();
            phases[phase++] = now - before;
            before = now;
        };
        ++frame_;
        TileUpdateOptions update;
        update.time = frame_;
        update.timeout = 4;
        manager_.SetStandbyTarget(1000);
        updates_.clear();
        if (options_.variant == 'A') {
            for (std::size_t i = 0; i < Count(); ++i)
                AddUpdate(i);
        } else {
            for (const std::uint32_t i : changed_)
                AddUpdate(i);
        }
        if (options_.isEach) {
            for (const TextureFeedback& of : updates_)
                Need(manager_.UpdateWithSamplerFeedback(of.texture, of.map, update));
        } else {
            Need(manager_.UpdateWithSamplerFeedback(updates_, update));
        }
        end();
        while (manager_.GetHeapCount() < manager_.GetNumDesiredHeaps())
            Need(manager_.AddHeap(manager_.GetHeapCount()));
        end();
        Need(manager_.TrimStandbyTiles());
        end();
        Need(manager_.AllocateRequestedTiles());
        end();
        const TileOrders orders = manager_.FetchOrders();
        touched_ = changed_;
        for (const std::uint32_t i : changed_)
            isTouched_[i] = 1;
        for (const TileUnmapOrder& order : orders.unmaps)
            Touch(order.texture.index);
        for (const TileMapOrder& order : orders.maps)
            Touch(order.texture.index);
        maps_ = orders.maps.size();
        unmaps_ = orders.unmaps.size();
        end();
        if (manager_.ConfirmOrders(orders.maps).stale != 0)
            throw CommandError(ExitCode::Failed, "bench tiles", "confirmations: stale: none may be");
        end();
        for (const std::uint32_t i : touched_) {
            std::array<std::uint8_t, kRegions> map{};
            Need(manager_.WriteMinMipData(ids_[i], map));
            sum_ += map[frame_ % kRegions]; // read by the caller, so that nothing is left out
            isTouched_[i] = 0;
        }
        end();
    }

    std::size_t GetMaps() const { return maps_; }
    std::size_t GetUnmaps() const { return unmaps_; }
    std::uint64_t GetSum() const { return sum_; }
    TileManagerStatistics GetStatistics() const { return manager_.GetStatistics(); }
    Expected<void> Check() const { return manager_.CheckInvariants(); }

private:
    std::size_t Count() const { return static_cast<std::size_t>(options_.textures); }

    std::uint8_t PickValue() {
        const auto value = static_cast<std::uint8_t>(random_() % 6);
        return value == 5 ? std::uint8_t{255} : value;
    }

    void AddUpdate(std::size_t i) {
        updates_.push_back({ids_[i], std::span(feedback_).subspan(i * kRegions, kRegions)});
    }

    void Touch(std::uint32_t texture) {
        if (isTouched_[texture] == 0) {
            isTouched_[texture] = 1;
            touched_.push_back(texture);
        }
    }

    TileFramesOptions options_;
    std::mt19937_64 random_;
    TileManager manager_;
    std::vector<ManagedTextureId> ids_;
    std::vector<std::uint8_t> feedback_;
    std::vector<TextureFeedback> updates_;
    std::vector<std::uint32_t> changed_;
    std::vector<std::uint32_t> touched_;
    std::vector<char> isChanged_;
    std::vector<char> isTouched_;
    std::uint32_t frame_ = 0;
    std::size_t maps_ = 0;
    std::size_t unmaps_ = 0;
    std::uint64_t sum_ = 0;
};

double GetQuantile(std::vector<double> values, double q) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

} // namespace

TileFramesResult RunTileFrames(const TileFramesOptions& options) {
    TileFramesResult result;
    result.variant = options.variant;
    result.textures = options.textures;
    result.changePercent = options.changePercent;
    std::vector<double> totals;
    std::array<std::vector<double>, kTilePhases> phases;
    for (int run = 0; run < options.repeat; ++run) {
        TileFrames frames(options, static_cast<std::uint64_t>(run) + 1);
        for (int frame = 0; frame < kWarmUpFrames + options.frames; ++frame) {
            ThrowIfInterrupted();
            if (frame > 0)
                result.changedRegions = frames.Change();
            std::array<double, kTilePhases> times{};
            frames.Run(times);
            if (frame < kWarmUpFrames)
                continue;
            double total = 0;
            for (std::size_t i = 0; i < kTilePhases; ++i) {
                phases[i].push_back(times[i]);
                total += times[i];
            }
            totals.push_back(total);
            result.mapOrders += static_cast<double>(frames.GetMaps());
            result.unmapOrders += static_cast<double>(frames.GetUnmaps());
        }
        Require(frames.Check(), ExitCode::Failed, "bench tiles");
        result.usedSlots = frames.GetStatistics().usedSlots;
        result.heaps = frames.GetStatistics().heaps;
    }
    result.mapOrders /= static_cast<double>(totals.size());
    result.unmapOrders /= static_cast<double>(totals.size());
    result.total = {GetQuantile(totals, 0.5), GetQuantile(totals, 0.25), GetQuantile(totals, 0.75)};
    for (std::size_t i = 0; i < kTilePhases; ++i)
        result.phases[i] = GetQuantile(phases[i], 0.5);
    return result;
}

} // namespace openntc::tool
