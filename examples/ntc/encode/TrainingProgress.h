// SPDX-License-Identifier: MIT
// What is said while a training runs: its expected time, how far it is, and what keeps it from its promise.
#pragma once

#include "Progress.h"

#include "openntc/encode/EncodeOptions.h"

#include <cstdint>
#include <string>

namespace openntc::tool {

/// Seconds of processor that this process has used on all its threads; below 0 where the system does not say.
double GetProcessorSeconds();

/// How much of what it could use a training had of the processor, 0 … 1, from the processor's and the clock's seconds. Its
/// work is shared out in eight slices, so that some numbers of threads keep fewer busy than there are.
double GetProcessorShare(double processorSeconds, double seconds, int threads);

class TrainingProgress {
public:
    struct Settings {
        std::string file;      ///< that is being made
        double seconds = 0.0;  ///< > 0: time that the user said
        double limit = 0.0;    ///< the part of it that this run has
        bool hasEffort = true; ///< steps follow from the size: neither they nor a time were said
        double texels = 0.0;   ///< of all mips
        bool json = false, quiet = false;
        bool isAlone = true; ///< nothing else in this process takes time
    };

    explicit TrainingProgress(const Settings& settings);
    ~TrainingProgress();
    TrainingProgress(const TrainingProgress&) = delete;
    TrainingProgress& operator=(const TrainingProgress&) = delete;

    void Show(const encode::Progress& progress);
    /// The line that was drawn over and over is gone.
    void Clear();
    /// Training has ended: says where it took longer than its time, or made too few steps for a result of use.
    void Finish(const encode::EncodeResult& result);

private:
    void ShowEstimate(const encode::Progress& progress);
    void WatchTime(const encode::Progress& progress);
    void WarnOfFewSteps(std::uint64_t steps, double seconds);
    void ShowInLog(const encode::Progress& progress);
    void Warn(const std::string& text);

    Settings settings_;
    double firstProcessor_; ///< seconds, when it began
    bool shown_ = false, estimated_ = false, saysBusy_ = false, saysFew_ = false;
    LogPace logPace_;
};

} // namespace openntc::tool
