// SPDX-License-Identifier: MIT
// Stability: experimental
// The threads that read tiles. One pool may serve several demand loaders, whose tasks it takes in turns.
#pragma once

#include "openntc/core/Shared.h"
#include "openntc/streaming/detail/Threads.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

class WorkerPool;

namespace detail {

/// Who has tasks. A client keeps their order to itself; the pool only counts them.
class PoolClient {
public:
    virtual ~PoolClient() = default;
    /// Runs the client's most urgent task, if it still has one. Called from any thread of the pool.
    virtual void RunTask() noexcept = 0;
};

/// What threads and owners of a pool share; stays until the last thread has left.
struct PoolState {
    struct Entry {
        Shared<PoolClient> client;
        std::uint32_t waiting = 0;
    };
    explicit PoolState(Allocator& allocator) : entries(allocator) {}
    Mutex mutex;
    Condition wake;
    Array<Entry> entries;
    std::size_t next = 0; ///< which client comes first
    bool stop = false;
};

} // namespace detail

/// Made by Create; shared by the loaders that it is given to.
class WorkerPool {
public:
    /// `threads` 1 … kMaxThreads; where the system refuses some of them, those that started do the work.
    /// Errors: OutOfRange, OutOfMemory, Unsupported (no thread can be had: load on the caller's with
    /// DemandLoaderOptions::threads = 0).
    static Expected<Shared<WorkerPool>> Create(int threads, Allocator& allocator = GetDefaultAllocator());

    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;
    /// Waits for the tasks that run, unless Abandon was called.
    ~WorkerPool() { Stop(true); }

    int GetThreadCount() const noexcept { return started_; }

    // For the loader.
    Expected<void> Add(Shared<detail::PoolClient> client);
    /// No task of the client begins after this.
    void Remove(const detail::PoolClient& client) noexcept;
    void Notify(const detail::PoolClient& client, std::uint32_t tasks) noexcept;
    /// The threads leave as soon as they return from what they do; nobody waits for them. They use the pool's
    /// allocator until then.
    void Abandon() noexcept { Stop(false); }

private:
    template <typename Made, typename... Arguments>
    friend Expected<Shared<Made>> MakeShared(Allocator& allocator, Arguments&&... arguments);
    explicit WorkerPool(Shared<detail::PoolState> state) noexcept : state_(std::move(state)) {}

    void Stop(bool wait) noexcept;
    static void Work(Shared<detail::PoolState> state) noexcept;

    Shared<detail::PoolState> state_;
    int started_ = 0;
#if OPENNTC_THREADS
    std::thread threads_[kMaxThreads];
#endif
};

inline Expected<Shared<WorkerPool>> WorkerPool::Create(int threads, Allocator& allocator) {
    if (threads < 1 || threads > kMaxThreads)
        return Fail(Status::OutOfRange, "threads: %d: must be 1 … %d", threads, kMaxThreads);
    OPENNTC_ASSIGN(Shared<detail::PoolState> state, MakeShared<detail::PoolState>(allocator, allocator));
    OPENNTC_ASSIGN(Shared<WorkerPool> pool, MakeShared<WorkerPool>(allocator, std::move(state)));
#if OPENNTC_THREADS
    while (pool->started_ < threads) {
        std::thread& thread = pool->threads_[pool->started_];
#if defined(__cpp_exceptions)
        try {
            thread = std::thread([shared = pool->state_] { Work(shared); });
        } catch (const std::exception&) { // no thread, or no memory for one
            break;
        }
#else
        thread = std::thread([shared = pool->state_] { Work(shared); });
#endif
        ++pool->started_;
    }
#endif
    if (pool->started_ == 0)
        return Fail(Status::Unsupported, "threads: %d: the system has none", threads);
    return pool;
}

inline Expected<void> WorkerPool::Add(Shared<detail::PoolClient> client) {
    const detail::Lock lock(state_->mutex);
    return state_->entries.PushBack({std::move(client), 0});
}

inline void WorkerPool::Remove(const detail::PoolClient& client) noexcept {
    Shared<detail::PoolClient> removed; // may be the last owner: destroyed without the lock
    const detail::Lock lock(state_->mutex);
    Array<detail::PoolState::Entry>& entries = state_->entries;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (entries[i].client.Get() != &client)
            continue;
        removed = std::move(entries[i].client);
        std::swap(entries[i], entries.back());
        entries.pop_back();
        break;
    }
}

inline void WorkerPool::Notify(const detail::PoolClient& client, std::uint32_t tasks) noexcept {
    {
        const detail::Lock lock(state_->mutex);
        for (detail::PoolState::Entry& entry : state_->entries) {
            if (entry.client.Get() == &client)
                entry.waiting += tasks;
        }
    }
    if (tasks == 1)
        state_->wake.NotifyOne();
    else
        state_->wake.NotifyAll();
}

inline void WorkerPool::Stop(bool wait) noexcept {
    {
        const detail::Lock lock(state_->mutex);
        state_->stop = true;
    }
    state_->wake.NotifyAll();
#if OPENNTC_THREADS
    for (std::thread& thread : threads_) {
        if (!thread.joinable())
            continue;
        // A loader's last owner can be a thread of the pool: it cannot wait for itself.
        if (wait && thread.get_id() != std::this_thread::get_id())
            thread.join();
        else
            thread.detach();
    }
#else
    static_cast<void>(wait);
#endif
}

inline void WorkerPool::Work(Shared<detail::PoolState> state) noexcept {
    detail::Lock lock(state->mutex);
    for (;;) {
        std::size_t chosen = 0;
        const auto hasWork = [&] {
            for (std::size_t i = 0; i < state->entries.size(); ++i) {
                chosen = (state->next + i) % state->entries.size();
                if (state->entries[chosen].waiting > 0)
                    return true;
            }
            return false;
        };
        state->wake.Wait(lock, [&] { return state->stop || hasWork(); });
        if (state->stop)
            return;
        --state->entries[chosen].waiting;
        state->next = chosen + 1;
        {
            const Shared<detail::PoolClient> client = state->entries[chosen].client;
            lock.unlock();
            client->RunTask();
        }
        lock.lock();
    }
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
