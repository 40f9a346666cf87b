// SPDX-License-Identifier: MIT
// Stability: internal
// A team of threads that runs numbered jobs. Which thread runs which job is not determined; results must not
// depend on it. The encoder keeps one for a whole training, the fast decoder has one for the duration of a
// call. C++ libraries without threads (mingw's win32 flavour) run everything on the caller. Link a thread
// library (CMake: Threads::Threads).
#pragma once

#include <cstdint>

#if defined(__has_include)
#if __has_include(<version>)
#include <version>
#endif
#endif

#if defined(__GLIBCXX__) && !defined(_GLIBCXX_HAS_GTHREADS)
#define OPENNTC_THREADS 0
#else
#define OPENNTC_THREADS 1
#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#endif

#include "openntc/core/HideMacros.h"

namespace openntc {

inline constexpr int kMaxThreads = 256; ///< of one team

/// 1 … kMaxThreads.
inline int CountHardwareThreads() noexcept {
#if OPENNTC_THREADS
    const unsigned count = std::thread::hardware_concurrency();
    return count < 1 ? 1 : count > static_cast<unsigned>(kMaxThreads) ? kMaxThreads : static_cast<int>(count);
#else
    return 1;
#endif
}

namespace detail {

/// Runs work(job) for the jobs that `next` gives out below `jobs`. A job is read and counted in one step,
/// or two threads would get the same.
template <typename Counter, typename Callable>
void TakeJobs(Counter& next, int jobs, Callable&& work) {
    for (int job = next.fetch_add(1); job < jobs; job = next.fetch_add(1))
        work(job);
}

} // namespace detail

/// Not for use by several threads at once; allocates nothing itself.
class ThreadTeam {
public:
    /// `threads` includes the calling thread; cut to 1 … kMaxThreads. When the system refuses a thread, those
    ///that started
    /// do its share.
    explicit ThreadTeam(int threads) noexcept {
#if OPENNTC_THREADS
        while (started_ < threads - 1 && started_ < kMaxThreads - 1) {
            const int thread = started_ + 1;
#if defined(__cpp_exceptions)
            try {
                workers_[started_] = std::thread([this, thread] { Work(thread); });
            } catch (const std::exception&) { // no thread, or no memory for one
                break;
            }
#else
            workers_[started_] = std::thread([this, thread] { Work(thread); });
#endif
            ++started_;
        }
#else
        static_cast<void>(threads);
#endif
    }
    ThreadTeam(const ThreadTeam&) = delete;
    ThreadTeam& operator=(const ThreadTeam&) = delete;
    ~ThreadTeam() {
#if OPENNTC_THREADS
        jobs_ = 0;
        stop_ = true;
        Start();
        for (int i = 0; i < started_; ++i)
            workers_[i].join();
#endif
    }

    int GetThreadCount() const noexcept {
        return started_ + 1;
    }

    /// Runs work(job, thread) for every job in 0 … jobs - 1, with thread in 0 … GetThreadCount() - 1, and
    /// returns when all are done. An exception of `work` on another thread than the caller's ends the
    /// program.
    template <typename Callable>
    void Run(int jobs, Callable&& work) {
#if OPENNTC_THREADS
        using Pointer = decltype(&work);
        work_ = &work;
        call_ = [](const void* callable, int job, int thread) {
            (*static_cast<Pointer>(const_cast<void*>(callable)))(job, thread);
        };
        jobs_ = jobs;
        next_.store(0, std::memory_order_relaxed);
        busy_.store(started_, std::memory_order_relaxed);
        Start();
        TakeJobs(0);
        for (int spins = 0; busy_.load(std::memory_order_acquire) != 0; ++spins) {
            if (spins >= kSpins + kYields) {
                WaitForOthers();
                break;
            }
            if (spins >= kSpins)
                std::this_thread::yield();
        }
#else
        for (int job = 0; job < jobs; ++job)
            work(job, 0);
#endif
    }

private:
    int started_ = 0; ///< beside the caller

#if OPENNTC_THREADS
    // Some microseconds: about what the phases of a training step differ by. After some yields the caller
    // sleeps: on a loaded machine it would take the others' time.
    static constexpr int kSpins = 4000;
    static constexpr int kYields = 50;

    void Start() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            generation_.fetch_add(1, std::memory_order_release);
        }
        if (sleepers_.load() > 0)
            wake_.notify_all();
    }
    void TakeJobs(int thread) {
        detail::TakeJobs(next_, jobs_, [&](int job) { call_(work_, job, thread); });
    }
    void Work(int thread) {
        std::uint64_t seen = 0;
        for (;;) {
            int spins = 0;
            while (generation_.load(std::memory_order_acquire) == seen && spins < kSpins)
                ++spins;
            if (generation_.load(std::memory_order_acquire) == seen) {
                std::unique_lock<std::mutex> lock(mutex_);
                sleepers_.fetch_add(1);
                wake_.wait(lock, [&] { return generation_.load() != seen; });
                sleepers_.fetch_sub(1);
            }
            seen = generation_.load(std::memory_order_acquire);
            if (stop_)
                return;
            TakeJobs(thread);
            if (busy_.fetch_sub(1) == 1 && callerSleeps_.load()) {
                const std::lock_guard<std::mutex> lock(mutex_);
                done_.notify_one();
            }
        }
    }
    void WaitForOthers() {
        std::unique_lock<std::mutex> lock(mutex_);
        callerSleeps_.store(true); // the last worker sees this, or was done before the first look below
        done_.wait(lock, [&] { return busy_.load() == 0; });
        callerSleeps_.store(false);
    }

    std::thread workers_[kMaxThreads - 1];
    std::mutex mutex_;
    std::condition_variable wake_, done_;
    const void* work_ = nullptr; ///< of the current Run
    void (*call_)(const void* work, int job, int thread) = nullptr;
    int jobs_ = 0;
    bool stop_ = false;
    std::atomic<int> next_{0}, busy_{0}, sleepers_{0};
    std::atomic<bool> callerSleeps_{false};
    std::atomic<std::uint64_t> generation_{0};
#endif
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
