// SPDX-License-Identifier: MIT
#include "ChildProcess.h"

#include "../Interrupt.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

extern char** environ;

namespace openntc::conformance {

namespace {

// Pipes are not passed on to other children.
bool MakePipe(int (&ends)[2]) {
    if (pipe(ends) != 0)
        return false;
    for (const int end : ends)
        fcntl(end, F_SETFD, FD_CLOEXEC);
    return true;
}

void Close(int& descriptor) {
    if (descriptor >= 0)
        close(descriptor);
    descriptor = -1;
}

} // namespace

ChildProcess::~ChildProcess() {
    End();
}

Expected<void> ChildProcess::Start(const std::vector<std::string>& command, bool readsErrors) {
    End();
    signal(SIGPIPE, SIG_IGN); // a program that ends early is an error of write(), not the end of this one
    int toChild[2] = {-1, -1};
    int fromChild[2] = {-1, -1};
    if (!MakePipe(toChild) || !MakePipe(fromChild))
        return Fail(Status::IOError, "pipe: %s", std::strerror(errno));
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, toChild[0], STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, fromChild[1], STDOUT_FILENO);
    if (readsErrors)
        posix_spawn_file_actions_adddup2(&actions, fromChild[1], STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    posix_spawnattr_setpgroup(&attributes, 0); // so that whatever it starts can be ended with it
    sigset_t defaults;
    sigemptyset(&defaults);
    sigaddset(&defaults, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    std::vector<char*> arguments;
    arguments.reserve(command.size() + 1);
    for (const std::string& argument : command)
        arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    const int error = posix_spawnp(&process_, arguments[0], &actions, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    Close(toChild[0]);
    Close(fromChild[1]);
    input_ = toChild[1];
    output_ = fromChild[0];
    if (error != 0) {
        process_ = 0;
        End();
        return Fail(Status::IOError, "cannot be started: %s", std::strerror(error));
    }
    fcntl(input_, F_SETFL, O_NONBLOCK);
    return {};
}

Expected<std::string> ChildProcess::ReadLine(Clock::time_point deadline, double timeoutSeconds) {
    std::string line;
    while (!TakeLine(line)) {
        if (!IsRunning())
            return Fail(Status::IOError, "not running");
        if (received_.size() > kMaxLine)
            return GiveUp("a line of more than 65536 characters");
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
        if (left.count() <= 0) {
            End();
            return Fail(Status::IOError, "no answer within %g s", timeoutSeconds);
        }
        pollfd files[2] = {{output_, POLLIN, 0}, {pending_.empty() ? -1 : input_, POLLOUT, 0}};
        tool::ThrowIfInterrupted();
        if (poll(files, 2, static_cast<int>(left.count() < 1000 ? left.count() : 1000)) < 0 && errno != EINTR)
            return GiveUp(std::strerror(errno));
        if (files[1].revents != 0) {
            const ssize_t written = write(input_, pending_.data(), pending_.size());
            if (written > 0)
                pending_.erase(0, static_cast<std::size_t>(written));
            else if (written < 0 && errno != EAGAIN && errno != EINTR)
                pending_.clear(); // its end is seen when reading
        }
        if (files[0].revents != 0) {
            char bytes[16384];
            const ssize_t count = read(output_, bytes, sizeof bytes);
            if (count > 0)
                received_.append(bytes, static_cast<std::size_t>(count));
            else if (count == 0) {
                const std::string end = WaitForEnd();
                return Fail(Status::IOError, "%s", end.c_str());
            }
        }
    }
    return line;
}

// Its standard output is closed: it has ended, is about to, or never will.
std::string ChildProcess::WaitForEnd() {
    int status = 0;
    for (int attempt = 0; attempt < 100; ++attempt) {
        if (waitpid(process_, &status, WNOHANG) == process_) {
            process_ = 0;
            End();
            if (WIFSIGNALED(status))
                return "ended by signal " + std::to_string(WTERMSIG(status)) + " (" +
                       strsignal(WTERMSIG(status)) + ")";
            return "ended with exit code " + std::to_string(WEXITSTATUS(status));
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    End();
    return "closed its standard output";
}

void ChildProcess::End() noexcept {
    Close(input_);
    Close(output_);
    if (process_ > 0) {
        kill(-process_, SIGKILL);
        kill(process_, SIGKILL);
        int status = 0;
        while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
    }
    process_ = 0;
    pending_.clear();
    received_.clear();
}

} // namespace openntc::conformance
