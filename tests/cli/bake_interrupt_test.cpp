// SPDX-License-Identifier: MIT
// `ntc bake` stopped in every way, and two of them in one folder.
#include "cli/BakeTree.h"

#include <random>

using namespace openntc_tests;

namespace {

// Trainings without end, for what must be met while it runs.
const std::string kEndless = "bake art -o out --steps 1000000000 --bits-per-pixel 1 --quiet --threads 1 ";

} // namespace

TEST_CASE("bake: SIGTERM keeps the states of all that runs; the same command goes on, to the same bytes") {
    const Folder folder;
    for (int i = 0; i < 3; ++i)
        WriteSource(folder / ("art/M" + std::to_string(i) + "_D.png"), i);
    const std::string settings = kLongSteps + "--bits-per-pixel 1 --quiet --jobs 2 ";
    const ProgramResult result =
        RunInterrupted(folder, "bake art -o out" + settings + "--save-every 0.01", "*.state", 2, 0, "TERM");
    INFO(result.errors);
    CHECK(result.code == 1);
    CHECK(result.errors.find("interrupted: finished files and states are kept") != std::string::npos);
    CHECK(CountFiles(folder / "out", ".state") == 2);
    CHECK(CountFiles(folder / "out", ".ntc") == 0);
    const ProgramResult again = RunProgram(folder, "bake art -o out" + settings);
    REQUIRE(again.code == 0);
    CHECK(again.errors.find("begun again") == std::string::npos);
    CHECK(CountFiles(folder / "out", ".state") == 0);
    REQUIRE(RunProgram(folder, "bake art -o whole" + settings).code == 0);
    CHECK(ReadSets(folder / "out") == ReadSets(folder / "whole"));
}

TEST_CASE("bake: states of other images, other settings and damaged ones are not gone on from") {
    const Folder folder;
    WriteSource(folder / "art/M_D.png", 1);
    const std::string settings = " --steps 4 --bits-per-pixel 1 --quiet";
    REQUIRE(RunInterrupted(folder, kEndless + "--save-every 0.01", "*.state", 1, 0, "TERM").code == 1);
    REQUIRE(CountFiles(folder / "out", ".state") == 1);
    // Other settings: a state of another name, and the old one goes.
    REQUIRE(RunProgram(folder, "bake art -o out" + settings).code == 0);
    CHECK(CountFiles(folder / "out", ".state") == 0);
    // A damaged one is said and begun again.
    fs::remove_all(folder / "out");
    const std::string whole = "bake art -o out" + kLongSteps + "--bits-per-pixel 1 --quiet ";
    REQUIRE(RunInterrupted(folder, whole + "--save-every 0.01", "*.state", 1, 0, "KILL").code != 0);
    REQUIRE(CountFiles(folder / "out", ".state") == 1);
    for (const auto& entry : fs::directory_iterator(folder / "out/.bake")) {
        if (entry.path().extension() == ".state")
            WriteText(entry.path(), "damaged");
    }
    const ProgramResult result = RunProgram(folder, whole);
    CHECK(result.code == 0);
    CHECK(result.errors.find("begun again") != std::string::npos);
    CHECK(RunProgram(folder, "validate out/M.ntc").code == 0);
}

TEST_CASE("bake: a hundred materials interrupted at random end with the bytes of a bake that was not") {
    const Folder folder;
    for (int i = 0; i < 100; ++i)
        WriteSource(folder / ("art/group" + std::to_string(i % 7) + "/M" + std::to_string(i) + "_D.png"), i,
                    8 + i % 3 * 4);
    const std::string settings = " --steps 6 --bits-per-pixel 1 --quiet --jobs 2 --save-every 0.001 ";
    const unsigned seed = std::random_device()();
    CAPTURE(seed);
    MESSAGE("seed " << seed);
    std::mt19937 random(seed);
    int states = 0;
    for (int made = 0, tries = 0; made < 90 && tries < 12; ++tries) {
        const int more = made + static_cast<int>(random() % 16), late = static_cast<int>(random() % 100);
        const std::string signal = random() % 3 == 0 ? "TERM" : "KILL";
        RunInterrupted(folder, "bake art -o out" + settings, "*.ntc", more, late, signal);
        made = CountFiles(folder / "out", ".ntc");
        states += CountFiles(folder / "out", ".state");
    }
    CHECK(states > 0); // some were met in their training
    const ProgramResult last = RunProgram(folder, "bake art -o out" + settings);
    INFO(last.errors);
    REQUIRE(last.code == 0);
    REQUIRE(RunProgram(folder, "bake art -o whole" + settings).code == 0);
    const auto sets = ReadSets(folder / "out");
    CHECK(sets.size() == 100);
    CHECK(sets == ReadSets(folder / "whole"));
    CHECK(CountFiles(folder / "out", ".state") == 0);
    CHECK(CountFiles(folder / "out", ".tmp") == 0);
}

TEST_CASE("bake: two bakes do not work in one folder, but at materials of their own") {
    const Folder folder;
    WriteSource(folder / "art/A_D.png", 1);
    WriteSource(folder / "art/B_D.png", 2);
    const auto runBeside = [&](const std::string& first, const std::string& second) {
        return RunProgram(
            folder,
            "--version >/dev/null; '" NTC_PROGRAM "' " + kEndless + first +
                " --save-every 0.01 >/dev/null 2>&1 & p=$!; while kill -0 $p 2>/dev/null && "
                "! find out -name '*.state' 2>/dev/null | grep -q .; do sleep 0.02; done; '" NTC_PROGRAM
                "' bake art -o out --steps 1 --bits-per-pixel 1 --quiet " +
                second + "; code=$?; kill $p; wait $p; exit $code");
    };
    ProgramResult result = runBeside("--material A", "");
    CheckFails(result, 1);
    CHECK(result.errors.find("ntc: out: lock: another bake (process ") == 0);
    fs::remove_all(folder / "out");
    result = runBeside("", "--material B");
    CheckFails(result, 1);
    fs::remove_all(folder / "out");
    result = runBeside("--material A", "--material B");
    INFO(result.errors);
    CHECK(result.code == 0);
    CHECK(fs::exists(folder / "out/B.ntc"));
    // One that is being made is waited for, and this can be interrupted.
    fs::remove_all(folder / "out");
    result = runBeside("--material A", "--material A & q=$!; sleep 0.5; kill -TERM $q; wait $q");
    CHECK(result.code == 1);
    CHECK_FALSE(fs::exists(folder / "out/A.ntc"));
}

TEST_CASE("bake: an image that changes while it is encoded is no record of what was made") {
    const Folder folder;
    WriteSource(folder / "art/A_D.png", 1);
    WriteSource(folder / "late.png", 2);
    const std::string settings = "bake art -o out --bits-per-pixel 1" + kLongSteps,
                      bake = settings + "--quiet --threads 1 ";
    const ProgramResult result =
        RunProgram(folder, "--version >/dev/null; '" NTC_PROGRAM "' " + bake +
                               "--save-every 0.01 & p=$!; while kill -0 $p 2>/dev/null && "
                               "! find out -name '*.state' 2>/dev/null | grep -q .; do sleep 0.02; done; "
                               "cp late.png art/A_D.png; wait $p");
    CHECK(result.code == 1);
    CHECK(result.errors.find("changed while it was being encoded") != std::string::npos);
    REQUIRE(RunProgram(folder, bake).code == 0);
    CHECK(RunProgram(folder, settings + "--dry-run").output == "1 material: 1 unchanged\n");
}
