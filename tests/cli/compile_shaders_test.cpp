// SPDX-License-Identifier: MIT
// `ntc compile-shaders`: its outputs agree with each other, and errors name the file, the permutation and the macro.
#include "cli/Program.h"

#include "openntc/permutation/ShaderBlob.h"

#include <cstdint>
#include <cstring>
#include <set>

using namespace openntc_tests;

namespace {

void WriteShaders(const Folder& folder) {
    fs::create_directories(folder / "more");
    WriteText(folder / "a.comp",
              "#version 460\n#include \"limits.h\"\n"
              "layout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer B { int x[]; };\n"
              "void main() { x[0] = SHAPE + LIMIT; }\n");
    WriteText(folder / "more/limits.h",
              "#include \"inner.h\"\n#if SHAPE > 7\n#error SHAPE must be 0 to 7\n#endif\n");
    WriteText(folder / "more/inner.h", "#define LIMIT 8\n");
    WriteText(folder / "b.frag.hlsl",
              "float4 main() : SV_Target0 { return float4(SHAPE, NTC_HLSL, 0, 1); }\n");
}

std::vector<std::uint32_t> ToWords(const std::string& bytes) {
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    return words;
}

} // namespace

TEST_CASE("compile-shaders: files, blob, header and JSON agree") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    WriteShaders(folder);
    const ProgramResult result = RunProgram(
        folder, "compile-shaders a.comp b.frag.hlsl --network small,xlarge -D 'SHAPE={0,3}' -D 'EXTRA={,1}' "
                "-I more --output-dir out/deep --blob all.bin --header my-shaders.h --json --jobs 3");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "compile-shaders");
    const auto& permutations = json["permutations"];
    REQUIRE(permutations.Size() == 2 * 2 * 2 * 2);
    CHECK(json["leftOut"].Empty());

    const auto blobWords = ToWords(ReadText(folder / "all.bin"));
    const auto blob = openntc::ShaderBlob::Open(blobWords);
    REQUIRE(blob);
    CHECK(blob->GetCount() == 16);
    const std::string header = ReadText(folder / "my-shaders.h");
    CHECK(header.find("namespace my_shaders {") != std::string::npos);
    std::string index;
    std::set<std::string> files;
    for (const auto& item : permutations.GetArray()) {
        const std::string source = item["source"].GetString();
        const std::string defines = item["defines"].GetString();
        const std::string file = item["file"].GetString();
        CAPTURE(file);
        const auto words = ToWords(ReadText(folder / ("out/deep/" + file)));
        const auto found = blob->Find(source, defines);
        REQUIRE(found);
        CHECK(words == std::vector<std::uint32_t>(found->begin(), found->end()));
        CHECK(item["bytes"].GetUint64() == 4 * words.size());
        std::string line = "{\"";
        line.append(source).append("\", \"").append(defines).append("\", kWords");
        CHECK(header.find(line) != std::string::npos);
        index.append(file).append("\t").append(source).append("\t").append(defines).append("\n");
        files.insert(file);
    }
    CHECK(files.count("a.comp+NETWORK_VERSION=4+SHAPE=3+EXTRA=1.spv") == 1);
    CHECK(files.count("b.frag.hlsl+NETWORK_VERSION=1+SHAPE=0.spv") == 1);
    CHECK(ReadText(folder / "out/deep/index.txt") == index);
    // Nothing temporary stays behind: 16 modules and the index.
    CHECK(std::distance(fs::directory_iterator(folder / "out/deep"), fs::directory_iterator()) == 17);

    const ProgramResult dry = RunProgram(folder, "compile-shaders a.comp b.frag.hlsl --network small,xlarge "
                                                 "-D 'SHAPE={0,3}' -D 'EXTRA={,1}' --dry-run");
    CHECK(dry.code == 0);
    CHECK(dry.output == index);
}

TEST_CASE(
    "compile-shaders: a header compiles with OpenNTC's folders alone, in two files, and finds its shaders") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    WriteShaders(folder);
    REQUIRE(
        RunProgram(folder, "compile-shaders a.comp --network small -D 'SHAPE={0,3}' -I more --header made.h")
            .code == 0);
    WriteText(folder / "second.cpp",
              "#include \"made.h\"\nstd::size_t CountShaders() { return made::GetShaders().size(); }\n");
    WriteText(folder / "main.cpp",
              "#include \"made.h\"\nstd::size_t CountShaders();\nint main() {\n"
              "    const auto found = made::FindShader(\"a.comp\", \"SHAPE=3 NETWORK_VERSION=1\");\n"
              "    openntc::PermutationKey key;\n    key.networkVersion = 1;\n"
              "    const auto covering = made::FindCoveringShader(\"a.comp\", key, \"SHAPE=3\");\n"
              "    if (!found || found->front() != 0x07230203u || CountShaders() != 2)\n        return 1;\n"
              "    return covering && covering->words.data() == found->data() ? 0 : 2;\n}\n");
    const std::string command =
        "cd '" + folder.GetPath().string() +
        "' && '" NTC_CXX_COMPILER "' -std=c++20 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror "
        "-I '" NTC_INCLUDE_DIR "' -I '" NTC_SHADER_DIR "' -idirafter '" NTC_EXPECTED_DIR
        "' main.cpp second.cpp -o program && ./program";
    CHECK(std::system(command.c_str()) == 0);
}

TEST_CASE("compile-shaders: HLSL with a buffer as a parameter, for every target environment") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    // glslang 12 crashes on it when it writes SPIR-V later than 1.3.
    WriteText(folder / "buffer.comp.hlsl",
              "[[vk::binding(0)]] ByteAddressBuffer source;\n[[vk::binding(1)]] RWByteAddressBuffer target;\n"
              "uint Load(ByteAddressBuffer buffer, uint at) { return buffer.Load(at); }\n"
              "[numthreads(1, 1, 1)] void main(uint3 id : SV_DispatchThreadID) { target.Store(0, "
              "Load(source, 4)); }\n");
    for (const char* environment : {"vulkan1.0", "vulkan1.1", "vulkan1.2", "vulkan1.3"}) {
        CAPTURE(environment);
        const ProgramResult result =
            RunProgram(folder, std::string("compile-shaders buffer.comp.hlsl --blob all.bin --target-env ") +
                                   environment);
        CAPTURE(result.errors);
        CHECK(result.code == 0);
        const auto words = ToWords(ReadText(folder / "all.bin"));
        const auto blob = openntc::ShaderBlob::Open(words);
        REQUIRE(blob);
        CHECK(blob->Find("buffer.comp.hlsl", "").has_value());
    }
}

TEST_CASE("compile-shaders: a crash of the compiler is one line that names the file and the permutation") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    // glslang descends into a sum once for every term: more of them than its stack holds.
    std::string text = "#version 460\nlayout(local_size_x = 1) in;\nlayout(binding = 0) buffer B { int x; "
                       "};\nvoid main() { x = x";
    for (int i = 0; i < 100000; ++i)
        text += "+x";
    WriteText(folder / "deep.comp", text + "; }\n");
    WriteText(folder / "good.comp", "#version 460\nvoid main() {}\n");
    const ProgramResult result = RunProgram(
        folder, "compile-shaders good.comp deep.comp -D A={1,2} --output-dir out --blob all.bin --jobs 2");
    if (result.code == 0) {
        MESSAGE("SKIP: this glslang compiles sums of 100000 terms");
        return;
    }
    CheckFails(result, 3);
    CHECK(result.errors.starts_with("ntc: deep.comp: A=1: the compiler crashed: "));
    CHECK_FALSE(fs::exists(folder / "out"));
    CHECK_FALSE(fs::exists(folder / "all.bin"));
}

TEST_CASE("compile-shaders: list files") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    WriteShaders(folder);
    WriteText(folder / "more/list.txt", "// comment\r\n../a.comp -T cs_6_4 -D SHAPE={1,2} // two\n\n"
                                        "#if 0\nnowhere -X\n#ifdef Y\n#else\nnowhere\n#endif\n#else\n"
                                        "  ../b.frag.hlsl\t-T ps -E main -DSHAPE=5\n#endif\n");
    const ProgramResult result = RunProgram(folder, "compile-shaders --list more/list.txt --dry-run");
    CHECK(result.code == 0);
    CHECK(result.output == "a.comp+SHAPE=1.spv\ta.comp\tSHAPE=1\na.comp+SHAPE=2.spv\ta.comp\tSHAPE=2\n"
                           "b.frag.hlsl+SHAPE=5.spv\tb.frag.hlsl\tSHAPE=5\n");
    for (const char* line : {"a.comp -T cs -D", "a.comp -T gs", "a.comp -O3", "a.comp -D 1X", "#if X",
                             "#endif", "#if 1", "#else", "a.comp -D X=a;b"}) {
        CAPTURE(line);
        WriteText(folder / "bad.txt", std::string("a.comp -T cs\n") + line + "\n");
        const ProgramResult bad = RunProgram(folder, "compile-shaders --list bad.txt --dry-run");
        CheckFails(bad, 3);
        CHECK(bad.errors.find("bad.txt: ") != std::string::npos);
        CHECK((bad.errors.find("bad.txt: line 2: ") != std::string::npos) == (std::string(line) != "#if 1"));
    }
}

TEST_CASE("compile-shaders: errors name the file, the permutation and the macro, and leave nothing behind") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    WriteShaders(folder);
    ProgramResult result = RunProgram(
        folder, "compile-shaders a.comp -D 'SHAPE={0,1,2,8,9}' -I more --output-dir out --blob all.bin");
    CheckFails(result, 3);
    CHECK(
        result.errors.starts_with("ntc: a.comp: SHAPE=8: more/limits.h:3: '#error' : SHAPE must be 0 to 7"));
    CHECK_FALSE(fs::exists(folder / "out"));
    CHECK_FALSE(fs::exists(folder / "all.bin"));

    result = RunProgram(folder, "compile-shaders a.comp -D SHAPE=1 --blob all.bin"); // no -I
    CheckFails(result, 3);
    CHECK(result.errors.find("limits.h") != std::string::npos);
    CheckFails(RunProgram(folder, "compile-shaders none.comp --blob all.bin"), 3);
    CheckFails(RunProgram(folder, "compile-shaders more --stage comp --blob all.bin"), 3);
    CheckFails(RunProgram(folder, "compile-shaders --list none.txt --blob all.bin"), 3);
    CheckFails(RunProgram(folder, "compile-shaders a.comp -D SHAPE=1 -I more --blob none/all.bin"), 1);
    CheckFails(RunProgram(folder, "compile-shaders a.comp -D SHAPE=1 -I more --output-dir a.comp/x"), 1);
    for (const char* usage :
         {"a.comp", "--blob all.bin", "a.comp --network tiny --blob x", "a.comp --math int4 --blob x",
          "a.comp -D '1X' --blob x", "a.comp -D 'X={0' --blob x", "a.comp -D 'X=a b' --blob x",
          "a.comp a.comp --dry-run", "more/limits.h --dry-run", "a.comp --entry Fill --dry-run",
          "a.comp --target-env vulkan9 --dry-run", "a.comp --jobs 0 --dry-run",
          "a.comp --stage geom --dry-run"}) {
        CAPTURE(usage);
        CheckFails(RunProgram(folder, std::string("compile-shaders ") + usage), 2);
    }
    // HLSL has no cooperative vectors, so nothing is left to compile.
    CheckFails(RunProgram(folder, "compile-shaders b.frag.hlsl --math coopvec_int8 --dry-run"), 4);
}

TEST_CASE("compile-shaders: the validator refuses what the compiler lets through") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    // An OpIAdd (128) whose result is a float.
    WriteText(
        folder / "wrong.comp",
        "#version 460\n#extension GL_EXT_spirv_intrinsics : require\nlayout(local_size_x = 1) in;\n"
        "layout(binding = 0) buffer B { int x; };\n"
        "spirv_instruction(id = 128) float Wrong(int a, int b);\nvoid main() { x = int(Wrong(x, x)); }\n");
    const ProgramResult result = RunProgram(folder, "compile-shaders wrong.comp --blob all.bin");
    CheckFails(result, 3);
    CHECK(result.errors.starts_with("ntc: wrong.comp: SPIR-V word "));
    CHECK_FALSE(fs::exists(folder / "all.bin"));
    CHECK(RunProgram(folder, "compile-shaders wrong.comp --blob all.bin --no-validation").code == 0);
}
