// SPDX-License-Identifier: MIT
// `ntc-renderer` as a program: its options, its errors, what it writes.
#ifdef RENDERER_PROGRAM
#include "cli/Program.h"

using namespace openntc_tests;

namespace {

/// On lavapipe, without LLVM's optimisations; `before` is what the shell starts in the place of the program.
ProgramResult RunRenderer(const Folder& folder, const std::string& arguments, const std::string& before = "",
                          const std::string& size = "24x16") {
    return RunProgram(folder, "--version >/dev/null; GALLIVM_PERF=nopt " + before +
                                  " '" RENDERER_PROGRAM "' --device llvmpipe --size " + size + " " +
                                  arguments);
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
    for (const char* const vectors :
         {"--math coopvec_int8 --no-coopvec", "--math coopvec_fp8 --no-coopVec",
          "--math coopvec_int8 --no-coopVecInt8", "--math coopvec_fp8 --no-coopVecFP8"})
        CheckRefuses(RunRenderer(folder, std::string("-o a.png ") + vectors), 2,
                     ": switched off by another option");
    CheckRefuses(RunRenderer(folder, "-o a.png --camera nowhere"), 2, "courtyard");
    CheckRefuses(RunRenderer(folder, "-o a.png --test-scene nothing"), 2, "transmission");
    CheckRefuses(RunRenderer(folder, "-o a.png nothing.gltf"), 3, "nothing.gltf");
    WriteText(folder / "bare.gltf", R"({"asset": {"version": "2.0"}})");
    CheckRefuses(RunRenderer(folder, "-o a.png --mode on-sample bare.gltf"), 3, "--mode reference");
    CHECK_FALSE(fs::exists(folder / "a.png"));
}

TEST_CASE(
    "ntc-renderer: a picture and its numbers, the same after warming up; an interrupt ends it without one") {
    const Folder folder;
    const ProgramResult result =
        RunRenderer(folder, "--mode reference --samples 2 --warm-up 1 --no-coopVec --no-coopVecInt8 "
                            "--no-coopVecFP8 -o a.png --stats a.json");
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
    REQUIRE(RunRenderer(folder, "--mode reference --samples 2 -o cold.png --stats cold.json").code == 0);
    CHECK(ReadText(folder / "cold.png") == ReadText(folder / "a.png"));
    rapidjson::Document cold;
    cold.Parse(ReadText(folder / "cold.json").c_str());
    CHECK(cold["texelsPerPixel"].GetDouble() == stats["texelsPerPixel"].GetDouble());
    const ProgramResult feedback =
        RunRenderer(folder, "--mode on-feedback --bc none --filter nearest --tile-size 16 --stats b.json");
    INFO(feedback.errors);
    REQUIRE(feedback.code == 0);
    stats.Parse(ReadText(folder / "b.json").c_str());
    REQUIRE(stats.IsObject());
    CHECK(stats["tiles"]["complete"].GetBool());
    CHECK(stats["tiles"]["resident"].GetUint64() >= stats["tiles"]["requested"].GetUint64());
    CHECK(stats["tiles"]["passesUntilSettled"].GetUint64() == stats["tiles"]["decodedPerPass"].Size());
    CHECK(stats["bytes"]["atlases"].GetUint64() > 0);
    CHECK(stats["bytes"]["pageTable"].GetUint64() > 0);
    CHECK(stats["bytes"]["latents"].GetUint64() > 0);
    CheckRefuses(RunRenderer(folder, "--mode on-feedback --budget 0.001 -o b.png"), 2,
                 "--budget: 0.001 MiB: the coarsest tiles alone take");
    CheckRefuses(RunRenderer(folder, "--mode reference --samples 65535 -o b.png", SignalAfter(4)), 1,
                 "interrupted");
    CHECK_FALSE(fs::exists(folder / "b.png"));
}

#ifdef VIEWER_PROGRAM
namespace {

constexpr const char* kScript = R"(# every step that a script has
--mode reference --filter bilinear
frames 2
screenshot reference.png
capture window.png
--mode on-load --bc none --size 72x48 --samples 1
frames 1
screenshot on-load.jpg
--size 1x1   # next to nothing
frames 1
minimize
frames 1
restore
--size 40x30 --mode on-feedback
frames 1
screenshot small.tga
quit
)";

ProgramResult RunViewer(const Folder& folder, const std::string& before, const std::string& arguments) {
    return RunProgram(folder, "--version >/dev/null; export GALLIVM_PERF=nopt XDG_RUNTIME_DIR=. ; " + before +
                                  " '" VIEWER_PROGRAM "' --device llvmpipe --size 96x64 " + arguments);
}

} // namespace

TEST_CASE("ntc-viewer: what is wrong is said before a window opens, and without a display there is none") {
    const Folder folder;
    WriteText(folder / "a.txt", "frames 1\n\n  --mode on-disk # no such mode\n");
    const ProgramResult script = RunViewer(folder, "", "--play a.txt");
    CHECK(script.code == 3);
    CHECK(script.errors.starts_with("ntc-viewer: a.txt: line 3: --mode: on-disk: one of reference|"));
    WriteText(folder / "a.txt", "frames none\n");
    CHECK(RunViewer(folder, "", "--play a.txt").errors.find("line 1: frames") != std::string::npos);
    WriteText(folder / "a.txt", "screenshot a.gif\n");
    CHECK(RunViewer(folder, "", "--play a.txt").errors.find("png, jpg, bmp or tga") != std::string::npos);
    CHECK(RunViewer(folder, "", "--frames 2").code == 2); // of the program without a window
    const std::string noDisplay = "env -u DISPLAY -u WAYLAND_DISPLAY";
    for (const ProgramResult& result :
         {RunViewer(folder, noDisplay, ""), RunRenderer(folder, "--window --filter nearest", noDisplay)}) {
        INFO(result.errors);
        CHECK(result.code == 4);
        CHECK(result.errors.starts_with("ntc-viewer: window: "));
        CHECK(result.errors.find('\n') == result.errors.size() - 1);
    }
}

TEST_CASE("ntc-viewer: a script on a display of its own: modes, sizes, pictures, the same bits as without a "
          "window") {
    const Folder folder;
    if (std::system("command -v xvfb-run >/dev/null") != 0) {
        MESSAGE("SKIP: no xvfb-run");
        return;
    }
    WriteText(folder / "a.txt", kScript);
    const std::string display = "xvfb-run -a -s '-screen 0 640x480x24'";
    ProgramResult result = RunViewer(folder, display, "--play a.txt --debug");
    if (result.code == 4 && result.errors.find("layer not installed") != std::string::npos) {
        MESSAGE("not checked by the validation layer, which is not here");
        result = RunViewer(folder, display, "--play a.txt");
    }
    if (result.code == 4) {
        MESSAGE("SKIP: ntc-viewer on lavapipe: ", result.errors);
        return;
    }
    INFO(result.errors);
    REQUIRE(result.code == 0);
    CHECK(result.errors.empty());
    CHECK(result.output.empty());
    REQUIRE(RunRenderer(folder, "--mode reference --filter bilinear --samples 2 -o headless.png", "", "96x64")
                .code == 0);
    CHECK(ReadText(folder / "reference.png") == ReadText(folder / "headless.png"));
    CHECK(ReadText(folder / "window.png") != ReadText(folder / "headless.png")); // with the panel
    REQUIRE(
        RunRenderer(folder, "--mode on-load --bc none --filter bilinear -o headless.jpg", "", "72x48").code ==
        0);
    CHECK(ReadText(folder / "on-load.jpg") == ReadText(folder / "headless.jpg"));
    CHECK(fs::file_size(folder / "small.tga") == 18 + 40 * 30 * 3);
}
#endif

#ifdef NTC_BUILD_DIR
TEST_CASE(
    "ntc-renderer, installed, takes shaders and the sample scene's texture sets from where it is installed") {
    const Folder folder;
    const std::string prefix = (folder / "prefix").string();
    const ProgramResult install = RunProgram(folder, "--version >/dev/null; '" CMAKE_PROGRAM
                                                     "' --install '" NTC_BUILD_DIR "' --prefix '" +
                                                         prefix + "' >/dev/null");
    INFO(install.errors);
    REQUIRE(install.code == 0);
    const fs::path data = fs::path(prefix) / "share/openntc";
    REQUIRE(fs::remove(data / "examples/materials/data/grille.ntc"));
    const std::string run =
        "--version >/dev/null; GALLIVM_PERF=nopt '" + prefix +
        "/bin/ntc-renderer' --device llvmpipe --size 24x16 --mode on-load --bc none -o a.png";
    const ProgramResult result = RunProgram(folder, run);
    if (result.code == 4) {
        MESSAGE("SKIP: ntc-renderer on lavapipe: ", result.errors);
        return;
    }
    INFO(result.errors);
    CHECK(result.code == 0);
    CHECK(result.errors.find(prefix + "/share/openntc/examples/materials/data/grille.ntc") !=
          std::string::npos);
    CHECK(fs::exists(folder / "a.png"));
    REQUIRE(fs::remove(data / "examples/renderer/shaders/Sky.comp"));
    CheckRefuses(RunProgram(folder, run), 3, "Sky.comp: shader: not in " + prefix);
}
#endif
#endif
