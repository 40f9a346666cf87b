// SPDX-License-Identifier: MIT
// What a bake says while it works: a line on a terminal, events with --json, a line now and then in a log.
#pragma once

#include "Progress.h"
#include "bake/BakeResult.h"

#include <chrono>
#include <map>
#include <mutex>
#include <string>

namespace openntc::tool {

/// May be told from several threads.
class BakeProgress {
public:
    /// `due`: materials to make.
    BakeProgress(const BakeOptions& options, std::size_t total, std::size_t due);

    /// Of a material that is being made: the share of its training that is done.
    void Advance(std::size_t index, double fraction);
    void Finish(std::size_t index, const BakeOutcome& outcome);

private:
    void Show(bool isForced);
    void Clear();
    void PrintOutcome(const BakeOutcome& outcome) const;

    const BakeOptions& options_;
    std::size_t due_, done_ = 0;
    std::map<std::size_t, double> running_;
    std::chrono::steady_clock::time_point start_, last_;
    LogPace pace_;
    bool shown_ = false;
    std::mutex mutex_;
};

} // namespace openntc::tool
