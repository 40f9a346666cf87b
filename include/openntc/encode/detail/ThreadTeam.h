// SPDX-License-Identifier: MIT
// A team of threads that runs numbered jobs. Which thread runs which job is not determined; results must not
// depend on it.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace openntc::encode::detail {

class ThreadTeam {
public:
    /// `threads` >= 1 includes the calling thread. When the system refuses a thread, those that started do its share.
    explicit ThreadTeam(int threads) {
        // Before the first thread: what fails here leaves no thread that nobody joins.
        workers_.reserve(static_cast<std::size_t>(threads > 1 ? threads - 1 : 0));
        for (int i = 1; i < threads; ++i) {
#if defined(__cpp_exceptions)
            try {
                workers_.emplace_back([this, i] { Work(i); });
            } catch (const std::exception&) { // no thread, or no memory for one
                break;
            }
#else
            workers_.emplace_back([this, i] { Work(i); });
#endif
        }
    }
    ThreadTeam(const ThreadTeam&) = delete;
    ThreadTeam& operator=(const ThreadTeam&) = delete;
    ~ThreadTeam() {
        jobs_ = 0;
        stop_ = true;
        Start();
        for (std::thread& worker : workers_)
            worker.join();
    }

    int GetThreadCount() const {
        return static_cast<int>(workers_.size()) + 1;
    }

    /// Runs work(job, thread) for every job in 0 ... jobs - 1 and returns when all are done.
    void Run(int jobs, const std::function<void(int, int)>& work) {
        work_ = &work;
        jobs_ = jobs;
        next_.store(0, std::memory_order_relaxed);
        busy_.store(static_cast<int>(workers_.size()), std::memory_order_relaxed);
        Start();
        TakeJobs(0);
        int spins = 0;
        while (busy_.load(std::memory_order_acquire) != 0) {
            if (++spins > kSpins)
                std::this_thread::yield();
        }
    }

private:
    static constexpr int kSpins = 4000; ///< some microseconds: about what a step's phases differ by

    void Start() {
        {
            const std::lock_guard<std::mutex> lock(mutex_);
            generation_.fetch_add(1, std::memory_order_release);
        }
        if (sleepers_.load() > 0)
            wake_.notify_all();
    }
    void TakeJobs(int thread) {
        for (int job = next_.fetch_add(1); job < jobs_; job = next_.fetch_add(1))
            (*work_)(job, thread);
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
            busy_.fetch_sub(1, std::memory_order_release);
        }
    }

    std::vector<std::thread> workers_;
    std::mutex mutex_;
    std::condition_variable wake_;
    const std::function<void(int, int)>* work_ = nullptr;
    int jobs_ = 0;
    bool stop_ = false;
    std::atomic<int> next_{0}, busy_{0}, sleepers_{0};
    std::atomic<std::uint64_t> generation_{0};
};

} // namespace openntc::encode::detail
