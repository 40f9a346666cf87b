// SPDX-License-Identifier: MIT
// Work in child processes: every answer comes, and a crash is one of them.
#include "shader_compiler/Processes.h"

#include <doctest/doctest.h>

#include <csignal>
#include <cstdlib>
#include <map>
#include <string>

using openntc::shader_compiler::Answer;
using openntc::shader_compiler::RunInProcesses;

TEST_CASE("processes: every answer comes once, whatever its size") {
    for (const std::size_t processes : {1, 3, 200}) {
        std::map<std::size_t, std::string> answers;
        RunInProcesses(
            100, processes,
            [](std::size_t i) { return std::string(i * i * i, static_cast<char>('a' + i % 26)); },
            [&](std::size_t i, Answer answer) {
                CHECK(answer.crash.empty());
                CHECK(answers.emplace(i, std::move(answer.bytes)).second);
                return true;
            });
        REQUIRE(answers.size() == 100);
        for (const auto& [i, bytes] : answers)
            CHECK(bytes == std::string(i * i * i, static_cast<char>('a' + i % 26)));
    }
    RunInProcesses(
        0, 4, [](std::size_t) { return std::string(); }, [](std::size_t, const Answer&) { return true; });
}

TEST_CASE("processes: what crashes or exits is an answer, and nothing more is begun") {
#ifdef _WIN32
    MESSAGE("SKIP: Windows has no fork: work is done by threads");
#else
    for (const bool isExit : {false, true}) {
        std::size_t good = 0, afterCrash = 0;
        std::string crash;
        RunInProcesses(
            1000, 2,
            [&](std::size_t i) {
                if (i == 20 && isExit)
                    std::_Exit(7);
                if (i == 20) {
                    std::raise(SIGKILL); // which no sanitizer catches
                }
                return std::to_string(i);
            },
            [&](std::size_t i, const Answer& answer) {
                afterCrash += crash.empty() ? 0 : 1;
                if (answer.crash.empty()) {
                    CHECK(answer.bytes == std::to_string(i));
                    ++good;
                } else {
                    CHECK(i == 20);
                    crash = answer.crash;
                }
                return true;
            });
        CHECK(good >= 20);
        // What the other process was at; how far it had come by then is the scheduler's affair.
        CHECK(afterCrash <= 1);
        CHECK(crash == (isExit ? "exit code 7" : "Killed"));
    }
#endif
}

TEST_CASE("processes: work stops when it is told to") {
    std::size_t answers = 0;
    RunInProcesses(
        1000, 3, [](std::size_t) { return std::string("x"); },
        [&](std::size_t, const Answer&) { return ++answers < 10; });
    CHECK(answers >= 10);
    CHECK(answers <= 10 + 3);
}
