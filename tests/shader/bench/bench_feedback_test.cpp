// SPDX-License-Identifier: MIT
// bench_feedback as users run it, small: what it says has the form that its schema promises, and numbers that fit.
#include "cli/Program.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

using namespace openntc_tests;

TEST_CASE("bench_feedback: rows for every rate, and the resolve") {
    const Folder folder;
    const char* device = std::getenv("OPENNTC_TEST_DEVICE");
    const std::string name = device != nullptr ? device : "llvmpipe";
    const ProgramResult result = RunProgram(folder, "--device " + name + " --size 64 --frames 1 --json");
    if (result.code == 4) {
        MESSAGE("SKIP: " << result.errors);
        return;
    }
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const rapidjson::Document json = ParseValid(result.output, "bench-feedback");
    CHECK(json["samples"].GetUint() == 64 * 64);
    CHECK(json["frames"].GetUint() == 1);
    const auto& rows = json["rows"];
    REQUIRE(rows.Size() == 16);
    CHECK(rows[0]["feedback"].GetString() == std::string("none"));
    CHECK(rows[0]["touchedWords"].GetUint() == 0);
    for (rapidjson::SizeType i = 0; i < 15; ++i)
        CHECK(rows[i]["bestNanoseconds"].GetDouble() <= rows[i]["medianNanoseconds"].GetDouble());
    for (const rapidjson::SizeType full : {1u, 5u}) { // rates 1, 1/16, 1/64, 1/256 of each kind
        CHECK(rows[full]["rate"].GetDouble() == 1.0);
        CHECK(rows[full]["touchedWords"].GetUint() >= 64); // a texture or more each
        for (rapidjson::SizeType i = full; i < full + 3; ++i)
            CHECK(rows[i]["touchedWords"].GetUint() >= rows[i + 1]["touchedWords"].GetUint());
    }
    for (rapidjson::SizeType i = 1; i < 5; ++i) // subgroups change the cost and not the words
        CHECK(rows[i]["touchedWords"].GetUint() == rows[i + 4]["touchedWords"].GetUint());
    for (rapidjson::SizeType i = 9; i < 15;
         ++i) { // an effect left out: with feedback as at rate 1, or without any
        const std::string kind = rows[i]["feedback"].GetString();
        CAPTURE(kind);
        const bool hasFeedback = kind != "no feedback" && kind != "no effect";
        CHECK(rows[i]["touchedWords"].GetUint() == (hasFeedback ? rows[1]["touchedWords"].GetUint() : 0));
    }
    const auto& resolve = rows[15];
    CHECK(resolve["feedback"].GetString() == std::string("resolve"));
    // Of 640 000 regions 6 400 are changed, some of them twice and so not.
    CHECK(resolve["listBytes"].GetUint() <= 16 + 6400 * 8);
    CHECK(resolve["listBytes"].GetUint() > 16 + 6000 * 8);
}

TEST_CASE("bench_feedback: options that are none, a device that is none") {
    const Folder folder;
    for (const char* options : {"--size 65", "--size 0", "--frames 0", "--frames", "--what", "--size 8256"}) {
        CAPTURE(options);
        const ProgramResult result = RunProgram(folder, options);
        CHECK(result.code == 2);
        CHECK(result.output == "");
        CHECK(result.errors.find("usage: ") == 0);
    }
    CHECK(RunProgram(folder, "--device no-such-device").code == 4);
}
