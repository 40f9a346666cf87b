// SPDX-License-Identifier: MIT
// Stability: internal
// The time of a run of the encoder: what has passed, what a limit leaves for training, and the pace.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class RunClock {
public:
    /// `limit`: seconds of the whole run; 0: none. `afterwards`: what comes once training has ended, in
    /// texels whose training takes as long.
    RunClock(double limit, double afterwards) : limit_(limit), afterwards_(afterwards) {}

    double GetElapsed() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }
    /// The first step is next. Times before it say nothing about the pace.
    void BeginTraining() {
        if (begin_ < 0.0)
            begin_ = GetElapsed();
    }
    void CountTexels(double texels) { texels_ += texels; }
    double GetRefining() const { return refining_; }
    void SetRefining(double seconds) { refining_ = seconds; }
    /// Since the first step.
    double GetTraining() const { return begin_ < 0.0 ? 0.0 : GetElapsed() - begin_; }
    /// Texels per second of training, without refinement.
    double GetPace() const { return texels_ / std::max(GetTraining() - refining_, 1e-6); }

    /// Seconds of the limit in which training must end: evaluation and writing come after it, and take as
    /// long as the pace so far says.
    double GetTrainingLimit() const {
        double reserve = limit_ * kLeastReserve;
        if (texels_ > 0.0)
            reserve = std::max(reserve, afterwards_ / GetPace());
        return limit_ - std::min(reserve, limit_ * kLargestReserve);
    }

private:
    static constexpr double kLeastReserve = 0.01, kLargestReserve = 0.5;

    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    double limit_, afterwards_;
    double begin_ = -1.0;
    double texels_ = 0.0;
    double refining_ = 0.0; ///< seconds
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
