// SPDX-License-Identifier: MIT
// Threads for the duration of one call. C++ libraries without threads (mingw's win32 flavour) run everything
// on the caller.
#pragma once

#if defined(__has_include)
#if __has_include(<version>)
#include <version>
#endif
#endif

#if defined(__GLIBCXX__) && !defined(_GLIBCXX_HAS_GTHREADS)
#define OPENNTC_FAST_THREADS 0
#else
#define OPENNTC_FAST_THREADS 1
#include <system_error>
#include <thread>
#endif

namespace openntc::fast {

inline constexpr int kMaxWorkers = 256;

/// At least 1.
inline int CountHardwareThreads() noexcept {
#if OPENNTC_FAST_THREADS
    const unsigned count = std::thread::hardware_concurrency();
    return count < 1 ? 1 : count > static_cast<unsigned>(kMaxWorkers) ? kMaxWorkers : static_cast<int>(count);
#else
    return 1;
#endif
}

/// Calls work(0) on this thread and work(1) … work(count - 1) on others, and waits for all. When the system
/// refuses a thread, the ones that run do its share: `work` takes jobs from a common counter.
template <typename Work>
inline void RunWorkers(int count, Work work) noexcept {
#if OPENNTC_FAST_THREADS
    std::thread threads[kMaxWorkers];
    int started = 0;
    for (int worker = 1; worker < count && started < kMaxWorkers; ++worker) {
#if defined(__cpp_exceptions)
        try {
            threads[started] = std::thread([&work, worker] { work(worker); });
        } catch (const std::system_error&) {
            break;
        }
#else
        threads[started] = std::thread([&work, worker] { work(worker); });
#endif
        ++started;
    }
    work(0);
    for (int i = 0; i < started; ++i)
        threads[i].join();
#else
    static_cast<void>(count);
    work(0);
#endif
}

} // namespace openntc::fast
