// SPDX-License-Identifier: MIT
// A program whose standard input and output are pipes, with a deadline for everything.
#pragma once

#include "openntc/core/Expected.h"

#include <chrono>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::conformance {

class ChildProcess {
public:
    using Clock = std::chrono::steady_clock;

    ChildProcess() noexcept = default;
    /// Ends the program, and what it started, if they still run.
    ~ChildProcess();
    ChildProcess(const ChildProcess&) = delete;
    ChildProcess& operator=(const ChildProcess&) = delete;

    /// Starts program and arguments. Errors: IOError with the system's reason; Unsupported on systems without
    /// posix_spawn.
    Expected<void> Start(const std::vector<std::string>& command);
    bool IsRunning() const noexcept { return process_ > 0; }

    /// Queues text for its standard input; ReadLine sends it.
    void Send(std::string_view text) { pending_ += text; }

    /// The next line of its standard output without the line feed. Fails with a text that says what happened:
    /// "no answer within 60 s", "ended by signal 11 (Segmentation fault)", "ended with exit code 3", "a line of more
    /// than 65536 characters". It has been ended then.
    Expected<std::string> ReadLine(Clock::time_point deadline, double timeoutSeconds);

    void End() noexcept;

private:
    Expected<std::string> GiveUp(const char* reason);
    std::string WaitForEnd();
    bool TakeLine(std::string& line);

    int process_ = 0;
    int input_ = -1;  // we write
    int output_ = -1; // we read
    std::string pending_;
    std::string received_;
};

} // namespace openntc::conformance
