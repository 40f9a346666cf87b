// SPDX-License-Identifier: MIT
#include "shader_compiler/Processes.h"

#include "shader_compiler/Failure.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#ifdef _WIN32
#include <atomic>
#include <mutex>
#include <thread>
#else
#include <cerrno>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#endif

namespace openntc::shader_compiler {

#ifdef _WIN32

void RunInProcesses(std::size_t count, std::size_t processes,
                    const std::function<std::string(std::size_t)>& work,
                    const std::function<bool(std::size_t, Answer)>& done) {
    std::atomic<std::size_t> next{0};
    std::atomic<bool> stop{false};
    std::mutex mutex;
    const auto run = [&] {
        for (std::size_t i = next++; i < count && !stop; i = next++) {
            Answer answer{work(i), {}};
            const std::lock_guard lock(mutex);
            if (!done(i, std::move(answer)))
                stop = true;
        }
    };
    std::vector<std::thread> threads;
    for (std::size_t i = 1; i < std::min(count, processes); ++i)
        threads.emplace_back(run);
    run();
    for (std::thread& thread : threads)
        thread.join();
}

#else

namespace {

using Number = std::uint64_t;

struct Child {
    pid_t process = -1;
    int socket = -1;
    bool isBusy = false;
    std::size_t index = 0;
    std::string received; // a Number of bytes, and these
};

bool ReadFully(int socket, void* data, std::size_t size) {
    auto* at = static_cast<char*>(data);
    while (size > 0) {
        const ssize_t count = read(socket, at, size);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return false;
        at += count;
        size -= static_cast<std::size_t>(count);
    }
    return true;
}

bool WriteFully(int socket, const void* data, std::size_t size) {
    const auto* at = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t count = send(socket, at, size, MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR)
            continue;
        if (count <= 0)
            return false;
        at += count;
        size -= static_cast<std::size_t>(count);
    }
    return true;
}

/// The child's side: answers until nobody asks any more.
[[noreturn]] void Serve(int socket, const std::function<std::string(std::size_t)>& work) {
    Number index = 0;
    while (ReadFully(socket, &index, sizeof(index))) {
        const std::string bytes = work(static_cast<std::size_t>(index));
        const Number size = bytes.size();
        if (!WriteFully(socket, &size, sizeof(size)) || !WriteFully(socket, bytes.data(), bytes.size()))
            break;
    }
    _exit(0); // the parent's buffers and objects are the parent's to flush and destroy
}

std::string DescribeEnd(int status) {
    if (WIFSIGNALED(status))
        return strsignal(WTERMSIG(status));
    return "exit code " + std::to_string(WEXITSTATUS(status));
}

class Children {
public:
    explicit Children(const std::function<std::string(std::size_t)>& work) : work_(work) {}
    ~Children() {
        for (Child& child : children_)
            End(child);
    }
    Children(const Children&) = delete;
    Children& operator=(const Children&) = delete;

    void Start() {
        int sockets[2];
        if (socketpair(AF_UNIX, SOCK_STREAM, 0, sockets) != 0)
            throw Failure(FailureKind::Output, "process", strerror(errno));
        const pid_t process = fork();
        if (process == 0) {
            // An end that stayed open here would keep another child waiting for its parent.
            for (const Child& other : children_)
                close(other.socket);
            close(sockets[0]);
            Serve(sockets[1], work_);
        }
        close(sockets[1]);
        if (process < 0) {
            close(sockets[0]);
            throw Failure(FailureKind::Output, "process", strerror(errno));
        }
        Child child;
        child.process = process;
        child.socket = sockets[0];
        children_.push_back(child);
    }

    /// Waits for a child to end, and says how it did.
    static std::string End(Child& child) {
        if (child.process < 0)
            return {};
        close(child.socket);
        int status = 0;
        while (waitpid(child.process, &status, 0) < 0 && errno == EINTR) {
        }
        child.process = -1;
        child.socket = -1;
        return DescribeEnd(status);
    }

    std::vector<Child>& GetAll() { return children_; }

private:
    const std::function<std::string(std::size_t)>& work_;
    std::vector<Child> children_;
};

/// Takes what a child has sent; true when the answer is complete or there will be none.
bool Receive(Child& child, Answer& answer) {
    char part[65536];
    const ssize_t count = read(child.socket, part, sizeof(part));
    if (count < 0 && errno == EINTR)
        return false;
    if (count <= 0) {
        answer.crash = Children::End(child);
        return true;
    }
    child.received.append(part, static_cast<std::size_t>(count));
    Number size = 0;
    if (child.received.size() < sizeof(size))
        return false;
    std::memcpy(&size, child.received.data(), sizeof(size));
    if (child.received.size() - sizeof(size) < size)
        return false;
    answer.bytes = child.received.substr(sizeof(size));
    child.received.clear();
    return true;
}

} // namespace

void RunInProcesses(std::size_t count, std::size_t processes,
                    const std::function<std::string(std::size_t)>& work,
                    const std::function<bool(std::size_t, Answer)>& done) {
    Children children(work);
    for (std::size_t i = 0; i < std::min(count, processes); ++i)
        children.Start();
    std::size_t next = 0;
    bool stop = false;
    for (;;) {
        std::vector<pollfd> waiting;
        for (Child& child : children.GetAll()) {
            if (!child.isBusy && child.process >= 0 && next < count && !stop) {
                child.index = next++;
                child.isBusy = true;
                const Number index = child.index;
                WriteFully(child.socket, &index, sizeof(index)); // a child that is gone is seen below
            }
            if (child.isBusy)
                waiting.push_back({child.socket, POLLIN, 0});
        }
        if (waiting.empty())
            return;
        if (poll(waiting.data(), static_cast<nfds_t>(waiting.size()), -1) < 0)
            continue;
        for (const pollfd& ready : waiting) {
            if (ready.revents == 0)
                continue;
            auto child = std::find_if(children.GetAll().begin(), children.GetAll().end(),
                                      [&](const Child& c) { return c.socket == ready.fd; });
            Answer answer;
            if (!Receive(*child, answer))
                continue;
            child->isBusy = false;
            stop = stop || !answer.crash.empty();
            stop = !done(child->index, std::move(answer)) || stop;
        }
    }
}

#endif

} // namespace openntc::shader_compiler
