// SPDX-License-Identifier: MIT
// examples/load_time: sizes that follow from the textures, and its three forms.
#include "cli/Program.h"
#include "cli/TextureFiles.h"

using namespace openntc_tests;

namespace {

/// Without LLVM's optimisations lavapipe compiles the encoders of BC6H and BC7 in a fraction of the time.
constexpr const char* kQuickCompiler = "GALLIVM_PERF=nopt";

ProgramResult RunLoadTime(const Folder& folder, const std::string& arguments,
                          const std::string& environment = "") {
    return RunProgram(folder, "--version >/dev/null; " + environment +
                                  " '" LOAD_TIME_PROGRAM "' --warm-up 0 " + arguments);
}

/// False, and said to be skipped, without the device.
bool HasRunOnLavapipe(const ProgramResult& gpu) {
    if (gpu.code == 4) {
        MESSAGE("SKIP: load_time on lavapipe: ", gpu.errors);
        return false;
    }
    REQUIRE_MESSAGE(gpu.code == 0, gpu.errors);
    return true;
}

} // namespace

TEST_CASE("load_time: bytes of every way, as text, markdown and JSON") {
    const Folder folder;
    fs::create_directory(folder / "sets");
    WriteManyFormats(folder / "sets/a.ntc", 16, 16, 5);
    WriteManyFormats(folder / "sets/b.ntc", 8, 4, 1);
    const ProgramResult result = RunLoadTime(folder, "sets --bc bc4 --repeat 1 --json");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "load-time");
    REQUIRE(json["sets"].Size() == 2);
    CHECK(json["textures"].GetInt() == 14);
    CHECK(std::string(json["decompress"].GetString()) == "none"); // of generation 1
    CHECK(json["ways"][2]["decompressMilliseconds"].GetDouble() == 0.0);
    constexpr int kTexels = 256 + 64 + 16 + 4 + 1 + 32;
    CHECK(json["texels"].GetInt() == kTexels);
    const auto& ways = json["ways"];
    // RGBA8 twice, R8, RG8, RG16, RGBA16F, RGBA32F; BC4 has 16 + 4 + 1 + 1 + 1 and 2 blocks a texture.
    CHECK(ways[0]["diskBytes"].GetInt() == kTexels * (4 + 4 + 1 + 2 + 4 + 8 + 16));
    CHECK(ways[0]["memoryBytes"].GetInt() == ways[0]["diskBytes"].GetInt());
    for (const rapidjson::SizeType i : {1U, 2U})
        CHECK(ways[i]["memoryBytes"].GetInt() == (23 + 2) * 8 * 7);
    const auto files = fs::file_size(folder / "sets/a.ntc") + fs::file_size(folder / "sets/b.ntc");
    for (const rapidjson::SizeType i : {2U, 3U})
        CHECK(ways[i]["diskBytes"].GetUint64() == files);
    CHECK(ways[3]["memoryBytes"].GetUint64() < files);
    CHECK(ways[2]["decodeMilliseconds"].GetDouble() > 0.0);
    CHECK(ways[2]["transcodeMilliseconds"].GetDouble() > 0.0);
    CHECK(ways[3]["decodeMilliseconds"].GetDouble() == 0.0);
    // What convert-gltf writes names files beside itself.
    WriteText(folder / "sets/materials.json", R"({"files": [{"file": "b.ntc"}]})");
    const ProgramResult list = RunLoadTime(folder, "sets/materials.json --bc bc4 --repeat 1 --markdown");
    CHECK(list.code == 0);
    CHECK(list.output.find("| NTC on load | ") != std::string::npos);
    CHECK(list.output.find("1 sets, 7 textures") != std::string::npos);
    CHECK(RunLoadTime(folder, "sets/a.ntc --bc bc4 --repeat 1 --backend reference")
              .output.find("NTC on sample") != std::string::npos);
}

TEST_CASE("load_time: a Vulkan device makes the blocks of the CPU, in batches of any size") {
    const Folder folder;
    fs::create_directory(folder / "sets");
    WriteManyFormats(folder / "sets/a.ntc", 21, 13, 5);
    WriteManyFormats(folder / "sets/b.ntc", 8, 4, 1);
    WriteManyFormats(folder / "sets/c.ntc", 1, 1, 1);
    for (const std::string format : {"bc1", "bc2", "bc3", "bc4", "bc5"}) {
        CAPTURE(format);
        const ProgramResult cpu = RunLoadTime(folder, "sets --repeat 1 --json --bc " + format);
        REQUIRE(cpu.code == 0);
        const auto expected = ParseValid(cpu.output, "load-time")["blocksCrc32"].GetUint();
        for (const std::string batch : {"1", "2", "8"}) {
            if (batch != "2" && format != "bc1") // batches know nothing of formats
                continue;
            std::string arguments = "sets --repeat 1 --json --backend vulkan --device llvmpipe --batch ";
            arguments.append(batch).append(" --bc ").append(format);
            const ProgramResult gpu = RunLoadTime(folder, arguments, kQuickCompiler);
            if (!HasRunOnLavapipe(gpu))
                return;
            const auto json = ParseValid(gpu.output, "load-time");
            CHECK(json["blocksCrc32"].GetUint() == expected);
            CHECK(json["ways"][2]["uploadMilliseconds"].GetDouble() > 0.0);
            CHECK(json["ways"][2]["decodeMilliseconds"].GetDouble() > 0.0);
        }
    }
}

TEST_CASE("load_time: sets of generation 3, decompressed as they are parsed") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 45, 29, 5, 3);
    const ProgramResult cpu = RunLoadTime(folder, "a.ntc --repeat 1 --json --bc bc4");
    INFO(cpu.errors);
    REQUIRE(cpu.code == 0);
    const auto json = ParseValid(cpu.output, "load-time");
    const auto expected = json["blocksCrc32"].GetUint();
    // 11 x 7, 5 x 3, ... latent texels of 2 bytes in 2 layers; and weights, and constants.
    CHECK(json["ways"][3]["memoryBytes"].GetUint64() > 4 * (11 * 7 + 5 * 3 + 2 + 1));
    const std::string sameBlocks = "a.ntc --repeat 1 --json --bc bc4 --backend ";
    CHECK(ParseValid(RunLoadTime(folder, sameBlocks + "reference").output, "load-time")["blocksCrc32"]
              .GetUint() == expected);
    const ProgramResult gpu = RunLoadTime(folder, sameBlocks + "vulkan --device llvmpipe", kQuickCompiler);
    if (HasRunOnLavapipe(gpu))
        CHECK(ParseValid(gpu.output, "load-time")["blocksCrc32"].GetUint() == expected);
    // BC7 modes that the set keeps: the blocks of the search that found them, and other ones at another level.
    REQUIRE(RunProgram(folder, "optimize-bc a.ntc --in-set -o b.ntc --bc bc7 --quality fast").code == 0);
    const auto load = [&](const std::string& arguments) {
        const ProgramResult result = RunLoadTime(folder, "b.ntc --repeat 1 --json --bc bc7 " + arguments);
        INFO(result.errors);
        REQUIRE(result.code == 0);
        return ParseValid(result.output, "load-time")["blocksCrc32"].GetUint();
    };
    CHECK(load("--set-modes") == load(""));
    CHECK(load("--set-modes --quality normal") != load("--quality normal"));
    CHECK(RunLoadTime(folder, "a.ntc --repeat 1 --bc bc7 --set-modes").code == 3);
}

TEST_CASE("load_time: latents that files keep compressed, decompressed on the CPU, or by a device that can") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 89, 61, 3, 3); // layers of 660 bytes, compressed; smaller ones are not
    const ProgramResult cpu = RunLoadTime(folder, "a.ntc --repeat 1 --json --bc bc4");
    INFO(cpu.errors);
    REQUIRE(cpu.code == 0);
    const auto json = ParseValid(cpu.output, "load-time");
    const auto expected = json["blocksCrc32"].GetUint();
    CHECK(std::string(json["decompress"].GetString()) == "cpu");
    for (const rapidjson::SizeType i : {2U, 3U})
        CHECK(json["ways"][i]["decompressMilliseconds"].GetDouble() > 0.0);
    const ProgramResult one = RunLoadTime(folder, "a.ntc --repeat 1 --json --bc bc4 --threads 1");
    CHECK(ParseValid(one.output, "load-time")["blocksCrc32"].GetUint() == expected);
    CHECK(RunLoadTime(folder, "a.ntc --repeat 1 --bc bc4").output.find("decompressed by cpu") !=
          std::string::npos);
    CHECK(RunLoadTime(folder, "a.ntc --decompress gpu").code == 2);
    CHECK(RunLoadTime(folder, "a.ntc --decompress gdeflate").code == 2);
    for (const std::string where : {"cpu", "gpu", "shader"}) {
        CAPTURE(where);
        const ProgramResult gpu = RunLoadTime(
            folder,
            "a.ntc --repeat 1 --json --bc bc4 --backend vulkan --device llvmpipe --decompress " + where,
            kQuickCompiler);
        if (!HasRunOnLavapipe(gpu))
            continue; // lavapipe does not decompress by itself
        if (where == "shader")
            CHECK(std::string(ParseValid(gpu.output, "load-time")["decompress"].GetString()) == "shader");
        CHECK(ParseValid(gpu.output, "load-time")["blocksCrc32"].GetUint() == expected);
    }
}

TEST_CASE("load_time: a Vulkan device makes BC6H and BC7 too, as the file says") {
    const Folder folder;
    // One mip: lavapipe compiles an encoder again where a side turns from a power of two into another number.
    WriteManyFormats(folder / "a.ntc", 21, 13, 1);
    const ProgramResult gpu =
        RunLoadTime(folder, "a.ntc --repeat 1 --json --backend vulkan --device llvmpipe", kQuickCompiler);
    if (!HasRunOnLavapipe(gpu))
        return;
    const auto json = ParseValid(gpu.output, "load-time");
    CHECK(json["uncompressed"].Size() == 2);
    CHECK(json["blocksCrc32"].GetUint() ==
          ParseValid(RunLoadTime(folder, "a.ntc --repeat 1 --json").output, "load-time")["blocksCrc32"]
              .GetUint());
}

TEST_CASE("load_time: BC7 with hints makes the blocks of the search, on a GPU too") {
    const Folder folder;
    fs::create_directory(folder / "sets");
    WriteManyFormats(folder / "sets/a.ntc", 45, 29, 4); // down to 5 x 3: one variant for lavapipe, as above
    WriteManyFormats(folder / "sets/b.ntc", 8, 4, 1);   // has none
    REQUIRE(RunProgram(folder, "optimize-bc sets/a.ntc --bc bc7 --quality fast").code == 0);
    const auto run = [&](const std::string& arguments) {
        const ProgramResult result = RunLoadTime(folder, "sets --bc bc7 --repeat 1 --json " + arguments);
        INFO(result.errors);
        REQUIRE(result.code == 0);
        return ParseValid(result.output, "load-time");
    };
    const auto searched = run("--no-hints");
    const auto hinted = run("");
    const auto hintBytes = fs::file_size(folder / "sets/a.bcmodes");
    CHECK(searched["hintBytes"].GetUint64() == 0);
    CHECK(hinted["hintBytes"].GetUint64() == hintBytes);
    CHECK(hinted["ways"][2]["diskBytes"].GetUint64() ==
          searched["ways"][2]["diskBytes"].GetUint64() + hintBytes);
    CHECK(hinted["ways"][3]["diskBytes"].GetUint64() == searched["ways"][3]["diskBytes"].GetUint64());
    const auto expected = searched["blocksCrc32"].GetUint();
    CHECK(hinted["blocksCrc32"].GetUint() == expected);
    // At another quality hints do change blocks: they are used.
    CHECK(run("--quality normal")["blocksCrc32"].GetUint() !=
          run("--quality normal --no-hints")["blocksCrc32"].GetUint());
    const std::string one = "sets/a.ntc --bc bc7 --repeat 1 --json ";
    const ProgramResult gpu = RunLoadTime(folder, one + "--backend vulkan --device llvmpipe", kQuickCompiler);
    if (HasRunOnLavapipe(gpu)) {
        CHECK(
            ParseValid(gpu.output, "load-time")["blocksCrc32"].GetUint() ==
            ParseValid(RunLoadTime(folder, one + "--no-hints").output, "load-time")["blocksCrc32"].GetUint());
    }
    fs::copy_file(folder / "sets/a.bcmodes", folder / "sets/b.bcmodes");
    const ProgramResult other = RunLoadTime(folder, "sets --bc bc7 --repeat 1");
    CHECK(other.code == 3);
    CHECK(other.errors.starts_with("load_time: sets/b.bcmodes: "));
}

TEST_CASE("load_time: bad inputs") {
    const Folder folder;
    fs::create_directory(folder / "empty");
    WriteText(folder / "bad.json", "{}");
    WriteText(folder / "none.json", R"({"files": []})");
    WriteText(folder / "cut.ntc", "NTEX");
    for (const std::string input : {"missing.ntc", "empty", "bad.json", "none.json", "cut.ntc"}) {
        CAPTURE(input);
        const ProgramResult result = RunLoadTime(folder, input + " --bc bc4");
        CHECK(result.code == 3);
        CHECK(result.output.empty());
        CHECK(result.errors.starts_with("load_time: " + input));
    }
    CHECK(RunLoadTime(folder, "missing.ntc --bc bc9").code == 2);
    CHECK(RunLoadTime(folder, "missing.ntc --quality most").code == 2);
    CHECK(RunLoadTime(folder, "missing.ntc --json --markdown").code == 2);
}
