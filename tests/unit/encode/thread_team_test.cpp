// SPDX-License-Identifier: MIT
// A team does all its jobs when the system refuses threads. That the encoder's bytes do not depend on the number of threads
// is tested in round_trip_test.cpp.
#include "openntc/encode/detail/ThreadTeam.h"

#include <doctest/doctest.h>

#include <atomic>
#include <cstddef>

#if defined(__linux__) && defined(__x86_64__)
#include <pthread.h>
#endif

using openntc::encode::detail::ThreadTeam;

static void CheckRunsEveryJobOnce(ThreadTeam& team) {
    constexpr int kJobs = 1000;
    std::atomic<int> runs[kJobs] = {};
    std::atomic<bool> threadsAreNumbered{true};
    team.Run(kJobs, [&](int job, int thread) {
        ++runs[job];
        if (thread < 0 || thread >= team.GetThreadCount())
            threadsAreNumbered = false;
    });
    int once = 0;
    for (const std::atomic<int>& count : runs)
        once += count == 1;
    CHECK(once == kJobs);
    CHECK(threadsAreNumbered);
}

TEST_CASE("a team of threads runs every job once") {
    for (int threads : {1, 2, 5}) {
        ThreadTeam team(threads);
        CHECK(team.GetThreadCount() == threads);
        CheckRunsEveryJobOnce(team);
        CheckRunsEveryJobOnce(team);
    }
}

#if defined(__linux__) && defined(__x86_64__)
TEST_CASE("a team goes on without the threads that the system refuses") {
    // Half of the address space for one stack: no thread can start.
    pthread_attr_t before, huge;
    REQUIRE(pthread_getattr_default_np(&before) == 0);
    REQUIRE(pthread_attr_init(&huge) == 0);
    REQUIRE(pthread_attr_setstacksize(&huge, std::size_t{1} << 46) == 0);
    REQUIRE(pthread_setattr_default_np(&huge) == 0);
    {
        ThreadTeam team(4);
        REQUIRE(pthread_setattr_default_np(&before) == 0);
        CHECK(team.GetThreadCount() < 4);
        CheckRunsEveryJobOnce(team);
    }
    pthread_attr_destroy(&huge);
    pthread_attr_destroy(&before);
}
#endif
