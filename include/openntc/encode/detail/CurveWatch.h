// SPDX-License-Identifier: MIT
// Stability: internal
// Where the quality of a training no longer grows, its schedule goes faster.
#pragma once

#include <algorithm>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Part of the state of a training: means of its quality over windows of steps. It follows from steps and
/// their errors alone, never from time, so that equal runs stay equal. While the curve is flat the schedule
/// advances `kSpeed` steps a step: rates fall, and when that wins something again, it goes at its own pace.
struct CurveWatch {
    double sum = 0.0;     ///< dB of the window's steps
    double last = 0.0;    ///< mean of the window before
    double skipped = 0.0; ///< steps of the schedule that were not made
    std::uint64_t count = 0, windows = 0;
    std::uint64_t flat = 0; ///< windows in a row that won nothing

    static constexpr double kBegin = 0.1; ///< fraction of the schedule; before it rates rise and much moves
    static constexpr double kWindow = 0.02;
    static constexpr double kLeastWindow = 64.0; ///< steps: a mean of fewer batches says little
    static constexpr double kGain = 0.01;        ///< dB that a window must win
    static constexpr std::uint64_t kFlatWindows = 3;
    static constexpr double kSpeed = 4.0;

    /// A step at `fraction` of a schedule of `steps`, with latents still in training, had `psnr` dB.
    void Add(double psnr, double fraction, double steps) {
        if (fraction < kBegin)
            return;
        if (flat >= kFlatWindows)
            skipped += kSpeed - 1.0;
        sum += psnr;
        if (static_cast<double>(++count) < std::max(kWindow * steps, kLeastWindow))
            return;
        const double mean = sum / static_cast<double>(count);
        flat = windows > 0 && mean < last + kGain ? flat + 1 : 0;
        last = mean;
        ++windows;
        sum = 0.0;
        count = 0;
    }
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
