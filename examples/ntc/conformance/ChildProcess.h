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

    /// Starts program and arguments; `readsErrors`: ReadLine reads its standard error too. Errors: IOError with the
    /// system's reason.
    Expected<void> Start(const std::vector<std::string>& command, bool readsErrors = false);
    bool IsRunning() const noexcept { return process_ != kNone; }

    /// Queues text for its standard input; ReadLine sends it.
    void Send(std::string_view text) { pending_ += text; }

    /// The next line of its standard output without the line feed. Fails with a text that says what happened:
    /// "no answer within 60 s", "ended by signal 11 (Segmentation fault)", "ended with exit code 3", "a line of more
    /// than 65536 characters". It has been ended then.
    Expected<std::string> ReadLine(Clock::time_point deadline, double timeoutSeconds);

    void End() noexcept;

private:
    static constexpr std::size_t kMaxLine = 65536;
#if defined(_WIN32)
    using Handle = void*; // HANDLE
    using Process = void*;
    static constexpr Handle kClosed = nullptr;
    static constexpr Process kNone = nullptr;
#else
    using Handle = int;
    using Process = int;
    static constexpr Handle kClosed = -1;
    static constexpr Process kNone = 0;
#endif

    Expected<std::string> GiveUp(const char* reason) {
        End();
        return Fail(Status::IOError, "%s", reason);
    }
    std::string WaitForEnd();

    bool TakeLine(std::string& line) {
        const std::size_t end = received_.find('\n');
        if (end == std::string::npos)
            return false;
        line = received_.substr(0, end);
        received_.erase(0, end + 1);
        if (!line.empty() && line.back() == '\r')
            line.pop_back();
        return true;
    }

    Process process_ = kNone;
    Handle input_ = kClosed;  // we write
    Handle output_ = kClosed; // we read
#if defined(_WIN32)
    Handle job_ = nullptr; // what it starts belongs to it, and is ended with it
#endif
    std::string pending_;
    std::string received_;
};

} // namespace openntc::conformance
