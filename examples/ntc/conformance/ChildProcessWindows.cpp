// SPDX-License-Identifier: MIT
#include "ChildProcess.h"

#include "../Interrupt.h"

#include <windows.h>

#include <cstdio>

namespace openntc::conformance {

namespace {

void Close(void*& handle) {
    if (handle != nullptr)
        CloseHandle(handle);
    handle = nullptr;
}

std::string DescribeLastError() {
    return "Windows error " + std::to_string(GetLastError());
}

// As CommandLineToArgvW and the C run-time library take it apart: quotes around each argument, backslashes doubled where
// a quote follows.
std::string MakeCommandLine(const std::vector<std::string>& command) {
    std::string line;
    for (const std::string& argument : command) {
        line += line.empty() ? "\"" : " \"";
        std::size_t backslashes = 0;
        for (const char c : argument) {
            if (c == '"')
                line.append(backslashes + 1, '\\');
            backslashes = c == '\\' ? backslashes + 1 : 0;
            line += c;
        }
        line.append(backslashes, '\\');
        line += '"';
    }
    return line;
}

} // namespace

ChildProcess::~ChildProcess() {
    End();
}

Expected<void> ChildProcess::Start(const std::vector<std::string>& command, bool readsErrors) {
    End();
    SECURITY_ATTRIBUTES inherited = {sizeof inherited, nullptr, TRUE};
    Handle childInput = nullptr;
    Handle childOutput = nullptr;
    if (CreatePipe(&childInput, &input_, &inherited, 0) == 0 ||
        CreatePipe(&output_, &childOutput, &inherited, 0) == 0) {
        Close(childInput);
        End();
        return Fail(Status::IOError, "pipe: %s", DescribeLastError().c_str());
    }
    SetHandleInformation(input_, HANDLE_FLAG_INHERIT, 0);
    SetHandleInformation(output_, HANDLE_FLAG_INHERIT, 0);
    STARTUPINFOA startup = {};
    startup.cb = sizeof startup;
    startup.dwFlags = STARTF_USESTDHANDLES;
    startup.hStdInput = childInput;
    startup.hStdOutput = childOutput;
    startup.hStdError = readsErrors ? childOutput : GetStdHandle(STD_ERROR_HANDLE);
    PROCESS_INFORMATION started = {};
    std::string line = MakeCommandLine(command);
    // Inherited: a crash ends the program, without a dialog.
    SetErrorMode(GetErrorMode() | SEM_FAILCRITICALERRORS | SEM_NOGPFAULTERRORBOX);
    const BOOL isStarted = CreateProcessA(nullptr, line.data(), nullptr, nullptr, TRUE, CREATE_SUSPENDED,
                                          nullptr, nullptr, &startup, &started);
    const std::string reason = isStarted == 0 ? DescribeLastError() : "";
    Close(childInput);
    Close(childOutput);
    if (isStarted == 0) {
        End();
        return Fail(Status::IOError, "cannot be started: %s", reason.c_str());
    }
    process_ = started.hProcess;
    job_ = CreateJobObjectA(nullptr, nullptr);
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits = {};
    limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
    SetInformationJobObject(job_, JobObjectExtendedLimitInformation, &limits, sizeof limits);
    AssignProcessToJobObject(job_, process_);
    ResumeThread(started.hThread);
    CloseHandle(started.hThread);
    return {};
}

// Anonymous pipes cannot be waited for with a deadline: reads are asked for what is there, and what is written is short
// enough for the pipe's buffer or cut into parts that a program which reads takes at once.
Expected<std::string> ChildProcess::ReadLine(Clock::time_point deadline, double timeoutSeconds) {
    std::string line;
    while (!TakeLine(line)) {
        if (!IsRunning())
            return Fail(Status::IOError, "not running");
        if (received_.size() > kMaxLine)
            return GiveUp("a line of more than 65536 characters");
        if (Clock::now() >= deadline) {
            End();
            return Fail(Status::IOError, "no answer within %g s", timeoutSeconds);
        }
        tool::ThrowIfInterrupted();
        if (!pending_.empty()) {
            // PIPE_NOWAIT writes nothing where there is no room.
            DWORD mode = PIPE_NOWAIT;
            SetNamedPipeHandleState(input_, &mode, nullptr, nullptr);
            DWORD written = 0;
            const DWORD part = pending_.size() < 1024 ? static_cast<DWORD>(pending_.size()) : 1024;
            if (WriteFile(input_, pending_.data(), part, &written, nullptr) != 0)
                pending_.erase(0, written);
            else
                pending_.clear(); // its end is seen when reading
        }
        DWORD available = 0;
        if (PeekNamedPipe(output_, nullptr, 0, nullptr, &available, nullptr) == 0) {
            const std::string end = WaitForEnd();
            return Fail(Status::IOError, "%s", end.c_str());
        }
        if (available == 0) {
            if (pending_.empty())
                Sleep(1);
            continue;
        }
        char bytes[16384];
        DWORD count = 0;
        if (ReadFile(output_, bytes, available < sizeof bytes ? available : sizeof bytes, &count, nullptr) !=
            0)
            received_.append(bytes, count);
    }
    return line;
}

// Its standard output is closed: it has ended, is about to, or never will.
std::string ChildProcess::WaitForEnd() {
    DWORD code = 0;
    const bool hasEnded = WaitForSingleObject(process_, 2000) == WAIT_OBJECT_0;
    GetExitCodeProcess(process_, &code);
    End();
    if (!hasEnded)
        return "closed its standard output";
    // Exceptions end a program with their NTSTATUS: 0xC0000005 is an access violation.
    char text[64];
    std::snprintf(text, sizeof text,
                  code >= 0xC0000000u ? "ended by exception 0x%08lx" : "ended with exit code %lu",
                  static_cast<unsigned long>(code));
    return text;
}

void ChildProcess::End() noexcept {
    Close(input_);
    Close(output_);
    if (process_ != nullptr)
        TerminateProcess(process_, 1);
    Close(job_);
    Close(process_);
    pending_.clear();
    received_.clear();
}

} // namespace openntc::conformance
