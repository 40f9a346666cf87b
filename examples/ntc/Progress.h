// SPDX-License-Identifier: MIT
// Progress of long work on standard error: a counter on a terminal, one JSON object a line with --json, else
// nothing.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace openntc::tool {

/// True if standard error is a terminal: only there a line may be drawn over and over.
bool IsTerminal();

/// One line on standard error; with `json` an event (schemas/encode-event.schema.json).
void PrintWarning(const std::string& text, bool json);

/// When work that takes `seconds` so far writes a line into a log: after ten seconds and then ever more rarely, at least
/// every five minutes. A run of any length leaves few lines, and is seen to be alive.
class LogPace {
public:
    /// True if a line is due now; the next one is due later.
    bool IsDue(double seconds);

private:
    double next_ = 10.0;
};

class Progress {
public:
    /// `activity` is one word, for example "decode"; `total` is in units of work (texels).
    Progress(std::string activity, std::uint64_t total, bool json);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Reports at most four times a second.
    void Advance(std::uint64_t units);

private:
    std::string activity_;
    std::uint64_t total_;
    std::uint64_t done_ = 0;
    bool json_;
    bool terminal_;
    bool shown_ = false;
    std::chrono::steady_clock::time_point last_;
};

} // namespace openntc::tool
