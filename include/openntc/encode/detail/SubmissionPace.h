// SPDX-License-Identifier: MIT
// Stability: internal
// How many steps a submission to a device holds.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Submissions that are under way, and as many steps for the next as take a device neither too short a time
/// nor so long that systems reset it.
class SubmissionPace {
public:
    static constexpr std::size_t kInFlight = 2; ///< submissions

    explicit SubmissionPace(std::size_t mostSteps) : mostSteps_(mostSteps) {}

    std::size_t GetSteps() const { return steps_; }
    std::size_t CountUnderWay() const { return underWay_.size(); }
    void Begin(std::size_t steps) { underWay_.push_back({steps, Clock::now()}); }
    /// The oldest is no longer counted. Returns its steps.
    std::size_t Take() {
        taken_ = underWay_.front();
        underWay_.pop_front();
        return taken_.steps;
    }
    /// What was taken has ended.
    void End() {
        const auto now = Clock::now();
        const double seconds = std::chrono::duration<double>(now - std::max(taken_.begin, lastEnd_)).count();
        lastEnd_ = now;
        if (seconds < kShort)
            steps_ = std::min(2 * steps_, mostSteps_);
        else if (seconds > kLong)
            steps_ = std::max<std::size_t>(steps_ / 2, 1);
    }

private:
    using Clock = std::chrono::steady_clock;
    struct Submission {
        std::size_t steps = 0;
        Clock::time_point begin;
    };
    static constexpr double kShort = 0.02, kLong = 0.1; ///< seconds

    std::size_t mostSteps_;
    std::size_t steps_ = 1; ///< of the next submission
    std::deque<Submission> underWay_;
    Submission taken_;
    Clock::time_point lastEnd_;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
