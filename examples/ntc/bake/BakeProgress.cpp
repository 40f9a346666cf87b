// SPDX-License-Identifier: MIT
#include "bake/BakeProgress.h"

#include "Json.h"
#include "Output.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace openntc::tool {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kShowInterval{250};

double GetSeconds(Clock::duration time) {
    return std::chrono::duration<double>(time).count();
}

} // namespace

BakeProgress::BakeProgress(const BakeOptions& options, std::size_t total, std::size_t due)
    : options_(options), due_(due), start_(Clock::now()), last_(start_) {
    if (options.json)
        std::fprintf(stderr, "{\"event\":\"plan\",\"total\":%zu,\"due\":%zu}\n", total, due);
    else if (!options.quiet && due > 0)
        std::fprintf(stderr, "%zu of %zu materials to make\n", due, total);
}

void BakeProgress::Advance(std::size_t index, double fraction) {
    const std::lock_guard lock(mutex_);
    running_[index] = fraction;
    Show(false);
}

void BakeProgress::Finish(std::size_t index, const BakeOutcome& outcome) {
    const std::lock_guard lock(mutex_);
    running_.erase(index);
    ++done_;
    Clear();
    PrintOutcome(outcome);
    Show(true);
}

void BakeProgress::Clear() {
    if (shown_)
        std::fputs("\r\033[K", stderr);
    shown_ = false;
}

void BakeProgress::PrintOutcome(const BakeOutcome& outcome) const {
    if (options_.json) {
        JsonWriter json(0);
        json.BeginObject();
        json.Member("event", std::string_view("material"));
        json.Member("material", std::string_view(outcome.name));
        json.Member("status", GetName(outcome.status));
        json.Member("reason", std::string_view(outcome.reason));
        if (outcome.status == BakeStatus::Made && outcome.record) {
            json.Member("psnr", outcome.record->psnr);
            json.Member("bytes", outcome.record->output.bytes);
        }
        if (!outcome.error.empty())
            json.Member("error", std::string_view(outcome.error));
        json.Member("done", static_cast<std::uint64_t>(done_));
        json.Member("due", static_cast<std::uint64_t>(due_));
        json.EndObject();
        std::fputs(json.TakeLine().c_str(), stderr);
    } else if (!options_.quiet) {
        std::string text = GetName(outcome.status);
        if (outcome.status == BakeStatus::Made && outcome.record)
            text = Format("%.2f dB, %" PRIu64 " bytes", outcome.record->psnr, outcome.record->output.bytes);
        std::fprintf(stderr, "[%zu/%zu] %s: %s (%s)\n", done_, due_, Printable(outcome.name).c_str(),
                     text.c_str(), Printable(outcome.reason).c_str());
    }
}

void BakeProgress::Show(bool isForced) {
    const Clock::time_point now = Clock::now();
    if (options_.quiet || due_ == 0 || (!isForced && now - last_ < kShowInterval))
        return;
    last_ = now;
    double work = static_cast<double>(done_);
    for (const auto& [index, fraction] : running_)
        work += fraction;
    const double fraction = work / static_cast<double>(due_), seconds = GetSeconds(now - start_);
    const double left = work > 0.0 ? seconds / work * (static_cast<double>(due_) - work) : 0.0;
    if (options_.json) {
        std::fprintf(stderr,
                     "{\"event\":\"progress\",\"activity\":\"bake\",\"done\":%zu,\"due\":%zu,\"running\":%zu,"
                     "\"fraction\":%.4f,\"seconds\":%.2f,\"secondsLeft\":%.1f}\n",
                     done_, due_, running_.size(), fraction, seconds, left);
    } else if (IsTerminal()) {
        std::fprintf(stderr, "\r%5.1f %%  %zu of %zu made, %zu running, about %.0f min left\033[K",
                     100.0 * fraction, done_, due_, running_.size(), std::ceil(left / 60.0));
        shown_ = true;
    } else if (pace_.IsDue(seconds)) {
        std::fprintf(stderr, "%.1f %%: %zu of %zu made, %zu running, about %.0f min left\n", 100.0 * fraction,
                     done_, due_, running_.size(), std::ceil(left / 60.0));
    }
}

} // namespace openntc::tool
