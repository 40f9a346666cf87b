// SPDX-License-Identifier: MIT
// Stability: internal
// What a training returns to: after divergence, after a refinement that was cancelled, and when a device is
// lost. And how it is known that it diverged.
#pragma once

#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/detail/StateSaver.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Running average of the quality of batches.
struct QualityCurve {
    double average = 0.0, best = 0.0; ///< dB
    bool begun = false;

    static constexpr double kHighest = 150.0;   ///< exact batches must not swamp the average
    static constexpr double kShare = 0.02;      ///< of a batch in the average
    static constexpr double kDivergence = 10.0; ///< dB below the best average: training went astray
    static constexpr double kGood = 1.0;        ///< a state as much below the best is worth returning to

    void Add(double psnr) {
        psnr = std::min(psnr, kHighest);
        average = begun ? average + kShare * (psnr - average) : psnr;
        best = begun ? std::max(best, average) : average;
        begun = true;
    }
    /// Also when it is not a number.
    bool HasDiverged() const { return begun && !(average > best - kDivergence); }
    bool IsGood() const { return average > best - kGood; }
};

class LastGoodState {
public:
    /// `fraction`: of the schedule.
    template <typename AnyTrainer>
    void Take(AnyTrainer& trainer, double fraction, const StateSaver& saver) {
        std::vector<std::byte> state;
        trainer.Save(state);
        if (state.empty()) // of a device that is lost
            return;
        state_ = std::move(state);
        fraction_ = fraction;
        saved_ = saver.GetCount();
    }
    template <typename AnyTrainer>
    void Restore(AnyTrainer& trainer) const {
        trainer.Load(state_);
    }
    /// Trainers of the processor cannot fail. When a device is lost, the state is handed over, unless a newer
    /// one has been.
    template <typename AnyTrainer>
    Expected<void> CheckDevice(const AnyTrainer& trainer, const EncodeOptions& options,
                               const StateSaver& saver) const {
        if constexpr (requires { trainer.GetStatus(); }) {
            if (!trainer.GetStatus() && options.save && saver.GetCount() == saved_)
                options.save(state_, fraction_);
            return trainer.GetStatus();
        }
        return {};
    }

private:
    std::vector<std::byte> state_;
    double fraction_ = 0.0;
    std::uint64_t saved_ = 0; ///< states that were handed over before
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
