// SPDX-License-Identifier: MIT
// `ntc-renderer` as a program: its options, its errors, what it writes.
#ifdef RENDERER_PROGRAM
#include "cli/Program.h"

using namespace openntc_tests;

namespace {

/// On lavapipe, without LLVM's optimisations; `before` is what the shell starts in the place of the program.
ProgramResult RunRenderer(const Folder& folder, const std::string& arguments,
                          const std::string& before = "") {
    return RunProgram(folder, "--version >/dev/null; GALLIVM_PERF=nopt " + before +
                                  " '" RENDERER_PROGRAM "' --device llvmpipe --size 24x16 " + arguments);
}

void CheckRefuses(const ProgramResult& result, int code, const std::string& text) {
    INFO(result.errors);
    CHECK(result.code == code);
    CHECK(result.output.empty());
    CHECK(result.errors.starts_with("ntc-renderer: "));
    CHECK(result.errors.find('\n') == result.errors.size() - 1);
    CHECK(result.errors.find(text) != std::string::npos);
}

} // namespace

TEST_CASE("ntc-renderer: wrong options and inputs are one line that names them, and leave no file") {
    const Folder folder;
    CHECK(RunRenderer(folder, "--help").code == 0);
    CheckRefuses(RunRenderer(folder, ""), 2, "-o");
    CheckRefuses(RunRenderer(folder, "-o a.gif"), 2, "png, jpg, bmp or tga");
    CheckRefuses(RunRenderer(folder, "-o a.png --size 0x0"), 2, "--size");
    CheckRefuses(RunRenderer(folder, "-o a.png --size 0x16"), 2, "--size");
    CheckRefuses(RunRenderer(folder, "-o a.png --mode on-disk"), 2,
                 "one of reference|on-load|on-sample|on-feedback");
    CheckRefuses(RunRenderer(folder, "-o a.png --mode on-load --no-inferenceOnLoad"), 2, "--mode: on-load");
    CheckRefuses(RunRenderer(folder, "-o a.png --mode on-feedback --no-inferenceOnFeedback"), 2,
                 "--mode: on-feedback");
    CheckRefuses(RunRenderer(folder, "-o a.png --tile-size 48"), 2,
                 "--tile-size: 48: must be a power of two");
    CheckRefuses(RunRenderer(folder, "-o a.png --mode on-load --referenceMaterials"), 2, "--mode on-load");
    CheckRefuses(RunRenderer(folder, "-o a.png --bc bc9"), 2, "bc9");
    CheckRefuses(RunRenderer(folder, "-o a.png --camera nowhere"), 2, "courtyard");
    CheckRefuses(RunRenderer(folder, "-o a.png --test-scene nothing"), 2, "transmission");
    CheckRefuses(RunRenderer(folder, "-o a.png nothing.gltf"), 3, "nothing.gltf");
    WriteText(folder / "bare.gltf", R"({"asset": {"version": "2.0"}})");
    CheckRefuses(RunRenderer(folder, "-o a.png --mode on-sample bare.gltf"), 3, "--mode reference");
    CHECK_FALSE(fs::exists(folder / "a.png"));
}

TEST_CASE("ntc-renderer: a picture and its numbers; an interrupt ends it without one") {
    const Folder folder;
    const ProgramResult result = RunRenderer(folder, "--mode reference --samples 2 -o a.png --stats a.json");
    if (result.code == 4) {
        MESSAGE("SKIP: ntc-renderer on lavapipe: ", result.errors);
        return;
    }
    INFO(result.errors);
    REQUIRE(result.code == 0);
    CHECK(ReadText(folder / "a.png").starts_with("\x89PNG"));
    rapidjson::Document stats;
    stats.Parse(ReadText(folder / "a.json").c_str());
    REQUIRE(stats.IsObject());
    CHECK(std::string(stats["mode"].GetString()) == "reference");
    CHECK(stats["texelsPerPixel"].GetDouble() > 0.5);
    CHECK(stats["texelsDecodedPerPixel"].GetDouble() == 0.0);
    CHECK(stats["milliseconds"]["frame"].GetDouble() > 0.0);
    CHECK(stats["permutations"].Size() > 0);
    CHECK(stats["bytes"]["sourceTextures"].GetUint64() > 0);
    CheckRefuses(RunRenderer(folder, "--mode reference --samples 65535 -o b.png", SignalAfter(4)), 1,
                 "interrupted");
    CHECK_FALSE(fs::exists(folder / "b.png"));
}
#endif
