// SPDX-License-Identifier: MIT
#include "encode/TrainingProgress.h"

#include "Output.h"

#include "openntc/encode/UsefulSteps.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <ctime>

namespace openntc::tool {

namespace {

constexpr double kEstimateSeconds = 1.0; ///< after which the pace is known
constexpr double kWatchSeconds = 2.0; ///< after which it is known whether other programs take the processor
constexpr double kFairShare = 0.7;    ///< of the processor; eight threads that had all of it used 0.76

std::string DescribeTime(double seconds) {
    if (seconds < 90.0)
        return Format("%.0f s", std::ceil(seconds));
    const double minutes = std::ceil(seconds / 60.0);
    return minutes < 120.0 ? Format("%.0f min", minutes) : Format("%.1f h", minutes / 60.0);
}

} // namespace

double GetProcessorSeconds() {
#if defined(_WIN32)
    return -1.0; // there clock() is the time of day
#else
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
#endif
}

double GetProcessorShare(double processorSeconds, double seconds, int threads) {
    constexpr int kSlices = 8;
    const int rounds = (kSlices + threads - 1) / threads;
    const double busy = static_cast<double>(kSlices) / rounds;
    return std::clamp(processorSeconds / std::max(seconds * busy, 1e-9), 0.0, 1.0);
}

TrainingProgress::TrainingProgress(const Settings& settings)
    : settings_(settings), firstProcessor_(GetProcessorSeconds()) {}

TrainingProgress::~TrainingProgress() {
    Clear();
}

void TrainingProgress::Clear() {
    if (shown_ && !settings_.json)
        std::fputs("\r\033[K", stderr);
    shown_ = false;
}

void TrainingProgress::Warn(const std::string& text) {
    Clear();
    PrintWarning(settings_.file + ": " + text, settings_.json);
}

void TrainingProgress::Show(const encode::Progress& progress) {
    WatchTime(progress);
    if (settings_.quiet)
        return;
    ShowEstimate(progress);
    if (!settings_.json && !IsTerminal()) {
        ShowInLog(progress);
        return;
    }
    shown_ = true;
    if (settings_.json) {
        std::fprintf(stderr,
                     "{\"event\":\"progress\",\"activity\":\"encode\",\"step\":%" PRIu64 ",\"steps\":%" PRIu64
                     ",\"fraction\":%.4f,\"psnr\":%.3f,\"seconds\":%.2f,\"secondsLeft\":%.1f}\n",
                     progress.step, progress.steps, progress.fraction, progress.psnr, progress.seconds,
                     progress.secondsLeft);
        return;
    }
    constexpr int kWidth = 24;
    const int full = static_cast<int>(progress.fraction * kWidth);
    std::fprintf(stderr,
                 "\r[%.*s%*s] step %" PRIu64 "/%" PRIu64 "  ~%.2f dB  %.1f M texels/s  %.0f s left \033[K",
                 full, "########################", kWidth - full, "", progress.step, progress.steps,
                 progress.psnr, progress.texelsPerSecond * 1e-6, progress.secondsLeft);
}

/// Once, when the pace is known.
void TrainingProgress::ShowEstimate(const encode::Progress& progress) {
    if (estimated_ || progress.seconds < kEstimateSeconds)
        return;
    estimated_ = true;
    const double whole = progress.seconds + std::max(progress.secondsLeft, 0.0);
    if (settings_.json) {
        std::fprintf(stderr,
                     "{\"event\":\"estimate\",\"kernel\":\"%s\",\"threads\":%d,\"steps\":%" PRIu64
                     ",\"seconds\":%.1f}\n",
                     progress.kernel, progress.threads, progress.steps, whole);
        return;
    }
    Clear();
    std::fprintf(stderr, "%s: %" PRIu64 " steps, about %s (%s, %d thread%s)\n",
                 Printable(settings_.file).c_str(), progress.steps, DescribeTime(whole).c_str(),
                 progress.kernel, progress.threads, progress.threads == 1 ? "" : "s");
    constexpr double kLongSeconds = 120.0;
    if (settings_.hasEffort && progress.secondsLeft > kLongSeconds)
        std::fputs("  --effort fast is a look at it; --seconds N ends after N seconds\n", stderr);
}

/// Whoever says a time neither knows how many steps that makes nor who else is at work.
void TrainingProgress::WatchTime(const encode::Progress& progress) {
    if (settings_.seconds <= 0.0 || progress.seconds < kWatchSeconds)
        return;
    const double used = GetProcessorSeconds() - firstProcessor_;
    const double share = GetProcessorShare(used, progress.seconds, progress.threads);
    if (!saysBusy_ && settings_.isAlone && firstProcessor_ >= 0.0 && share < kFairShare) {
        saysBusy_ = true;
        Warn(Format(
            "--seconds %g: other programs are at work: training has %.0f %% of the processor time of its "
            "%d threads, and makes so many fewer steps",
            settings_.seconds, 100.0 * share, progress.threads));
    }
    WarnOfFewSteps(progress.steps, settings_.seconds);
}

void TrainingProgress::WarnOfFewSteps(std::uint64_t steps, double seconds) {
    const std::uint64_t needed = encode::GetUsefulSteps(settings_.texels);
    if (saysFew_ || steps >= needed)
        return;
    saysFew_ = true;
    Warn(Format("--seconds %g: %" PRIu64 " steps: too few for this quality: a useful result needs %" PRIu64
                " or more at this size, about %.0f seconds here",
                settings_.seconds, steps, needed,
                std::ceil(seconds * static_cast<double>(needed) /
                          static_cast<double>(std::max<std::uint64_t>(steps, 1)))));
}

void TrainingProgress::ShowInLog(const encode::Progress& progress) {
    if (!logPace_.IsDue(progress.seconds))
        return;
    std::fprintf(stderr, "%s: step %" PRIu64 " of %" PRIu64 ", about %.2f dB, %.0f s left\n",
                 Printable(settings_.file).c_str(), progress.step, progress.steps, progress.psnr,
                 progress.secondsLeft);
}

void TrainingProgress::Finish(const encode::EncodeResult& result) {
    Clear();
    if (settings_.seconds <= 0.0 || result.cancelled)
        return;
    WarnOfFewSteps(result.steps, result.seconds);
    constexpr double kLate = 1.05, kLateSeconds = 0.5; // a sweep of refinement is not interrupted
    if (result.seconds > settings_.limit * kLate + kLateSeconds)
        Warn(Format("--seconds %g: took %.1f s: it cannot be done sooner here%s", settings_.seconds,
                    result.seconds, saysBusy_ ? " while other programs are at work" : ""));
}

} // namespace openntc::tool
