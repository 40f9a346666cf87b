// SPDX-License-Identifier: MIT
// `ntc bake --plan ninja`, run by ninja itself. The script for Slurm is run by tests/slurm.sh.
#include "cli/BakeTree.h"

using namespace openntc_tests;

namespace {

ProgramResult RunNinja(const Folder& folder, const std::string& more = "") {
    return RunProgram(folder, "--version >/dev/null; ninja -C out " + more);
}

} // namespace

TEST_CASE("bake --plan ninja: ninja makes what changed and finds new materials") {
    const Folder folder;
    if (RunProgram(folder, "--version >/dev/null; ninja --version").code != 0) {
        MESSAGE("SKIP: no ninja");
        return;
    }
    // A name that shells, ninja and its dependency files each have marks for.
    const std::string odd = "art/its $5 a #b/Wall (old) D.png";
    WriteSource(folder / odd, 1);
    WriteSource(folder / "art/A_D.png", 2);
    WriteSource(folder / "art/tex/leaf.png", 3);
    WriteText(folder / "art/leaf.json", R"({"textures":[{"fileName":"tex/leaf.png"}]})");
    const std::string settings = " --steps 1 --bits-per-pixel 1 ";
    ProgramResult result = RunProgram(folder, "bake art -o out --jobs 2 --plan ninja" + settings);
    REQUIRE(result.code == 0);
    CHECK(result.output == "out/build.ninja: materials: 3: ninja -C out\n");
    result = RunNinja(folder);
    CAPTURE(result.output);
    CAPTURE(result.errors);
    REQUIRE(result.code == 0);
    const std::string looks = "look for materials";
    CHECK(result.output.find(looks) == result.output.rfind(looks)); // once
    CHECK(ReadSets(folder / "out").contains("its $5 a #b/Wall (old).ntc"));
    REQUIRE(RunProgram(folder, "bake art -o whole" + settings).code == 0);
    CHECK(ReadSets(folder / "out") == ReadSets(folder / "whole"));
    RunNinja(folder);
    CHECK(RunNinja(folder).output.find("no work to do") != std::string::npos);

    // Touched: looked at, and left alone. Changed: made, and nothing else.
    const auto time = fs::last_write_time(folder / "out/A.ntc");
    const auto oddTime = fs::last_write_time(folder / "out/its $5 a #b/Wall (old).ntc");
    fs::last_write_time(folder / "art/A_D.png", fs::file_time_type::clock::now());
    WriteSource(folder / odd, 5);
    REQUIRE(RunNinja(folder).code == 0);
    CHECK(fs::last_write_time(folder / "out/A.ntc") == time);
    CHECK(fs::last_write_time(folder / "out/its $5 a #b/Wall (old).ntc") != oddTime);
    CHECK(RunNinja(folder).output.find("no work to do") != std::string::npos);

    // A new material, and a manifest that names another image.
    WriteSource(folder / "art/deep/New_D.png", 6);
    WriteSource(folder / "art/tex/leaf2.png", 7);
    WriteText(folder / "art/leaf.json", R"({"textures":[{"fileName":"tex/leaf2.png"}]})");
    REQUIRE(RunNinja(folder).code == 0);
    CHECK(fs::exists(folder / "out/deep/New.ntc"));
    REQUIRE(RunProgram(folder, "bake art -o whole" + settings).code == 0);
    CHECK(ReadSets(folder / "out") == ReadSets(folder / "whole"));

    // A broken one keeps none of the others from being made.
    WriteText(folder / "art/broken.json", "{\"textures\":[{\"fileName\":");
    WriteSource(folder / "art/A_D.png", 8);
    result = RunNinja(folder, "-k 0");
    CHECK(result.code == 1);
    CHECK(result.output.find("FAILED: broken.ntc") != std::string::npos);
    CHECK(fs::last_write_time(folder / "out/A.ntc") != time);
}

TEST_CASE("bake --plan ninja: an interrupted ninja goes on from the states") {
    const Folder folder;
    if (RunProgram(folder, "--version >/dev/null; ninja --version").code != 0) {
        MESSAGE("SKIP: no ninja");
        return;
    }
    WriteSource(folder / "art/A_D.png", 1);
    const std::string settings = kLongSteps + "--bits-per-pixel 1 --save-every 0.01 ";
    REQUIRE(RunProgram(folder, "bake art -o out --plan ninja" + settings).code == 0);
    const ProgramResult stopped = RunProgram(
        folder, "--version >/dev/null; ninja -C out & p=$!; while kill -0 $p 2>/dev/null && "
                "! find out -name '*.state' | grep -q .; do sleep 0.02; done; kill -TERM $p; wait $p");
    CHECK(stopped.code != 0);
    CHECK(CountFiles(folder / "out", ".state") == 1);
    CHECK_FALSE(fs::exists(folder / "out/A.ntc"));
    const ProgramResult resumed = RunNinja(folder);
    CAPTURE(resumed.output);
    CAPTURE(resumed.errors);
    REQUIRE(resumed.code == 0);
    REQUIRE(RunProgram(folder, "bake art -o whole" + settings).code == 0);
    CHECK(ReadSets(folder / "out") == ReadSets(folder / "whole"));
}
