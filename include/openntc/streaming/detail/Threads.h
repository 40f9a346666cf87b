// SPDX-License-Identifier: MIT
// Stability: internal
// Locks and conditions, and what stands for them in C++ libraries without threads.
#pragma once

#include "openntc/core/ThreadTeam.h"

#if OPENNTC_THREADS
#include <chrono>
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

#if OPENNTC_THREADS

using Mutex = std::mutex;
using Lock = std::unique_lock<std::mutex>;

class Condition {
public:
    template <typename Predicate>
    void Wait(Lock& lock, Predicate&& isTrue) {
        condition_.wait(lock, isTrue);
    }
    /// False if the condition is still false after `milliseconds`.
    template <typename Predicate>
    bool WaitFor(Lock& lock, int milliseconds, Predicate&& isTrue) {
        return condition_.wait_for(lock, std::chrono::milliseconds(milliseconds), isTrue);
    }
    void NotifyOne() noexcept { condition_.notify_one(); }
    void NotifyAll() noexcept { condition_.notify_all(); }

private:
    std::condition_variable condition_;
};

#else

class Mutex {};
class Lock {
public:
    explicit Lock(Mutex&) noexcept {}
    void lock() noexcept {}
    void unlock() noexcept {}
};
class Condition { // nobody else could make a condition true
public:
    template <typename Predicate>
    void Wait(Lock&, Predicate&& isTrue) {
        static_cast<void>(isTrue());
    }
    template <typename Predicate>
    bool WaitFor(Lock&, int, Predicate&& isTrue) {
        return isTrue();
    }
    void NotifyOne() noexcept {}
    void NotifyAll() noexcept {}
};

#endif

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
