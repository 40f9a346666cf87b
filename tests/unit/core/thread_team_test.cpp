// SPDX-License-Identifier: MIT
// A team does every job once, also when threads ask for jobs at the same moment and when the system refuses threads. That
// the encoder's bytes and the decoder's bits do not depend on the number of threads is tested with them.
#include "openntc/core/ThreadTeam.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <memory>
#include <thread>

#if defined(__linux__) && defined(__x86_64__)
#include <pthread.h>
#endif

using openntc::ThreadTeam;

namespace {

/// How often each of a number of jobs ran.
class JobCounts {
public:
    explicit JobCounts(int jobs)
        : jobs_(jobs), runs_(new std::atomic<int>[static_cast<std::size_t>(jobs)]()) {}
    void Add(int job) { ++runs_[static_cast<std::size_t>(job)]; }
    int GetJobCount() const { return jobs_; }
    int CountOnce() const {
        int once = 0;
        for (int job = 0; job < jobs_; ++job)
            once += runs_[static_cast<std::size_t>(job)] == 1;
        return once;
    }

private:
    int jobs_;
    std::unique_ptr<std::atomic<int>[]> runs_;
};

void CheckRunsEveryJobOnce(ThreadTeam& team) {
    constexpr int kJobs = 1000;
    JobCounts counts(kJobs);
    std::atomic<bool> threadsAreNumbered{true};
    team.Run(kJobs, [&](int job, int thread) {
        counts.Add(job);
        if (thread < 0 || thread >= team.GetThreadCount())
            threadsAreNumbered = false;
    });
    CHECK(counts.CountOnce() == kJobs);
    CHECK(threadsAreNumbered);
}

/// A counter that another thread uses whenever it can: between a load and the store that follows, and after each step.
class ContestedCounter {
public:
    explicit ContestedCounter(JobCounts& counts) : counts_(counts) {}
    int load(std::memory_order = std::memory_order_seq_cst) {
        const int value = value_;
        LetOtherTake();
        return value;
    }
    operator int() { return load(); }
    void store(int value, std::memory_order = std::memory_order_seq_cst) { value_ = value; }
    int operator=(int value) { return value_ = value; }
    int fetch_add(int add, std::memory_order = std::memory_order_seq_cst) {
        const int value = value_;
        value_ += add;
        LetOtherTake();
        return value;
    }
    int operator++(int) { return fetch_add(1); }

private:
    void LetOtherTake() {
        if (value_ < counts_.GetJobCount())
            counts_.Add(value_);
        ++value_;
    }

    JobCounts& counts_;
    int value_ = 0;
};

} // namespace

TEST_CASE("a job is given out in one step, so that no thread comes between") {
    // Without threads, and so always the same: the other one acts inside the counter.
    JobCounts counts(1000);
    ContestedCounter next(counts);
    openntc::detail::TakeJobs(next, counts.GetJobCount(), [&](int job) { counts.Add(job); });
    CHECK(counts.CountOnce() == counts.GetJobCount());
}

TEST_CASE("a team of threads runs every job once") {
    for (int threads : {1, 2, 5}) {
        ThreadTeam team(threads);
        CHECK(team.GetThreadCount() == threads);
        CheckRunsEveryJobOnce(team);
        CheckRunsEveryJobOnce(team);
    }
    CHECK(ThreadTeam(0).GetThreadCount() == 1);
    CHECK(ThreadTeam(-7).GetThreadCount() == 1);
    CHECK(openntc::CountHardwareThreads() >= 1);
    CHECK(openntc::CountHardwareThreads() <= openntc::kMaxThreads);
}

TEST_CASE("a team without jobs returns, and may be used again") {
    ThreadTeam team(3);
    std::atomic<int> runs{0};
    team.Run(0, [&](int, int) { ++runs; });
    CHECK(runs == 0);
    team.Run(1, [&](int, int) { ++runs; });
    CHECK(runs == 1);
}

TEST_CASE("a team waits for long jobs of its threads") {
    // Long enough for the caller to fall asleep; many times, as it may do so just when the last job ends.
    for (int threads : {2, 4}) {
        ThreadTeam team(threads);
        for (int round = 0; round < 100; ++round) {
            std::atomic<int> done{0};
            team.Run(threads, [&](int, int thread) {
                if (thread != 0)
                    std::this_thread::sleep_for(std::chrono::microseconds(20 * (round % 40)));
                ++done;
            });
            REQUIRE(done == threads);
        }
    }
}

TEST_CASE("threads that ask for a job at the same moment get different ones") {
    // The first jobs of every round wait until each thread is in one; then all ask for the short ones that follow, at the
    // same time. The wait also ends without them: a team that gives a job to two threads must fail here, and not hang.
    constexpr int kRounds = 3000;
    constexpr int kJobsPerRound = 250;
    constexpr int kMostSpins = 20000;
    for (int threads : {2, 3}) {
        ThreadTeam team(threads);
        JobCounts counts(kRounds * kJobsPerRound);
        std::atomic<int> arrived{0};
        team.Run(kRounds * kJobsPerRound, [&](int job, int) {
            counts.Add(job);
            if (job % kJobsPerRound >= threads)
                return;
            const int wanted = (arrived.fetch_add(1) / threads + 1) * threads;
            for (int spins = 0; arrived.load() < wanted && spins < kMostSpins; ++spins) {
                if (spins > 200)
                    std::this_thread::yield();
            }
        });
        CHECK(counts.CountOnce() == kRounds * kJobsPerRound);
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
