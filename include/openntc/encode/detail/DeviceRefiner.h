// SPDX-License-Identifier: MIT
// Stability: internal
// Refinement of latents on the device that trained them.
#pragma once

#include "openntc/encode/detail/DeviceTrainer.h"

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

template <typename Mirror>
class LatentRefiner<DeviceKernel<Mirror>> {
public:
    /// `trainer` outlives the refiner. Errors of the device show in its GetStatus.
    explicit LatentRefiner(Trainer<DeviceKernel<Mirror>>& trainer) : trainer_(trainer) {}

    /// As of every refiner.
    void Measure(float maskPush) {
        maskPush_ = maskPush;
        trainer_.Check(trainer_.PushNetwork());
        if (trainer_.changed_)
            trainer_.Check(trainer_.PushLatents());
        trainer_.Check(Evaluate(MakeStep(NTC_TRAIN_ROUND), {}));
    }
    std::uint64_t Try(const LatentMove& move) {
        NtcTrainStep step = MakeStep(NTC_TRAIN_ROUND | NTC_TRAIN_MOVE);
        step.move =
            static_cast<std::uint32_t>(move.feature * 8 + move.oddY * 4 + move.oddX * 2 + (move.low ? 1 : 0));
        step.levels = move.levels;
        const bool wraps = trainer_.GetNetworkShape().blended;
        if (wraps) {
            step.flags |= NTC_TRAIN_WRAPS;
            step.turn = static_cast<std::uint32_t>(move.turn);
        }
        std::vector<TrainingDispatch> decisions;
        const auto& grids = move.low ? trainer_.mirror_.GetLowGrids() : trainer_.mirror_.GetHighGrids();
        for (std::size_t n = 0; n < grids.size(); ++n) {
            const GridSize size = grids[n].size;
            const int pixels = AxisClass{size.width, move.oddX, move.turn, wraps}.GetCount() *
                               AxisClass{size.height, move.oddY, move.turn, wraps}.GetCount();
            step.neuralMip = static_cast<std::uint32_t>(n);
            if (pixels > 0)
                decisions.push_back(
                    {TrainingPass::TrainMoves, step,
                     static_cast<std::uint32_t>(pixels + NTC_TRAIN_MOVES - 1) / NTC_TRAIN_MOVES});
        }
        std::uint32_t count = 0;
        const std::uint64_t at = std::uint64_t{step.lossSlot} * kOutputs * sizeof(float);
        trainer_.Check(
            trainer_.device_->Write(TrainingBuffer::Losses, at, std::as_bytes(std::span(&count, 1))));
        trainer_.Check(Evaluate(step, decisions));
        trainer_.Check(
            trainer_.device_->Read(TrainingBuffer::Losses, at, std::as_writable_bytes(std::span(&count, 1))));
        trainer_.stale_ = true;
        return trainer_.GetStatus() ? count : 0;
    }

private:
    static constexpr std::uint32_t kTiles = Trainer<DeviceKernel<Mirror>>::kRefinedTiles;

    NtcTrainStep MakeStep(std::uint32_t flags) const {
        NtcTrainStep step{};
        step.flags = flags | trainer_.GetStreaming();
        step.maskPush = maskPush_;
        step.lossSlot = Trainer<DeviceKernel<Mirror>>::kSlots;
        return step;
    }
    /// Losses of all texels, then what decides on them.
    Expected<void> Evaluate(NtcTrainStep step, std::span<const TrainingDispatch> decisions) {
        const auto tiles = static_cast<std::uint32_t>(trainer_.tables_.tiles.size() / 2);
        std::vector<TrainingDispatch> dispatches;
        for (std::uint32_t first = 0; first < tiles; first += kTiles) {
            step.firstTile = first;
            step.tiles = std::min(kTiles, tiles - first);
            const std::uint32_t strips = step.tiles * NTC_TRAIN_STRIPS_OF_TILE;
            step.strips = std::max(strips / kStripGroups, 1u);
            step.groups = (strips + step.strips - 1) / step.strips;
            dispatches.push_back({TrainingPass::TryMoves, step, step.groups});
            if (first + kTiles >= tiles)
                dispatches.insert(dispatches.end(), decisions.begin(), decisions.end());
            OPENNTC_CHECK(trainer_.Run(dispatches, first, step.tiles));
            dispatches.clear();
        }
        return {};
    }
    static constexpr std::uint32_t kStripGroups = 1024; ///< workgroups that a large dispatch has about

    Trainer<DeviceKernel<Mirror>>& trainer_;
    float maskPush_ = 0.0f;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
