// SPDX-License-Identifier: MIT
// `ntc compile-shaders --flatten`: what the text holds, for sources of every kind, and what is refused.
#include "cli/Program.h"

using namespace openntc_tests;

TEST_CASE("compile-shaders --flatten: one text without directives") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    WriteText(folder / "a.frag",
              "#version 300 es\n// a comment\n#include \"half.h\"\nprecision highp float;\nout vec4 color;\n"
              "void main() {\n#ifdef GL_ES\n    color = vec4(HALF(SHAPE));\n#endif\n}\n");
    WriteText(folder / "half.h",
              "#extension GL_OES_other : enable\n#ifndef H\n#define H\n#include \"half.h\"\n"
              "#define HALF(x) (0.5 * float(x))\n#endif\n");
    WriteText(folder / "b.comp.hlsl",
              "#include \"half.h\"\n#if NTC_HLSL\n[[vk::binding(0)]] RWByteAddressBuffer b;\n"
              "[numthreads(1, 1, 1)] void main() { b.Store(0, asuint(HALF(SHAPE))); }\n#endif\n");
    WriteText(folder / "f.h", "#include \"half.h\"\n#if NTC_HLSL\nint Language() { return 1; }\n#else\n"
                              "int Language() { return __VERSION__; }\n#endif\n");
    const ProgramResult result =
        RunProgram(folder, "compile-shaders a.frag f.h -D 'SHAPE={3,4}' --flatten --output-dir out");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const std::string license = ", flattened; OpenNTC's functions in it: MIT license\n";
    CHECK(ReadText(folder / "out/a.frag+SHAPE=3.glsl") ==
          "#version 300 es\n#extension GL_OES_other : enable\n// a.frag SHAPE=3" + license +
              "precision highp float;\nout vec4 color;\nvoid main(){\ncolor = vec4((0.5 * float(3)));\n}\n");
    // Of functions alone the host says the version.
    CHECK(ReadText(folder / "out/f.h+SHAPE=4.glsl") ==
          "#extension GL_OES_other : enable\n// f.h SHAPE=4" + license + "int Language(){ return 460;}\n");
    CHECK(ReadText(folder / "out/index.txt") ==
          "a.frag+SHAPE=3.glsl\ta.frag\tSHAPE=3\na.frag+SHAPE=4.glsl\ta.frag\tSHAPE=4\n"
          "f.h+SHAPE=3.glsl\tf.h\tSHAPE=3\nf.h+SHAPE=4.glsl\tf.h\tSHAPE=4\n");

    // Another call into the folder: the index says what is there, the files of the call last.
    REQUIRE(RunProgram(folder, "compile-shaders a.frag -D 'SHAPE={4,5}' --flatten --output-dir out").code ==
            0);
    fs::remove(folder / "out/f.h+SHAPE=3.glsl");
    REQUIRE(RunProgram(folder, "compile-shaders a.frag -D 'SHAPE={4,5}' --flatten --output-dir out").code ==
            0);
    CHECK(ReadText(folder / "out/index.txt") ==
          "a.frag+SHAPE=3.glsl\ta.frag\tSHAPE=3\nf.h+SHAPE=4.glsl\tf.h\tSHAPE=4\n"
          "a.frag+SHAPE=4.glsl\ta.frag\tSHAPE=4\na.frag+SHAPE=5.glsl\ta.frag\tSHAPE=5\n");

    WriteText(folder / "half.h", "#define HALF(x) (0.5f * float(x))\n");
    const ProgramResult hlsl =
        RunProgram(folder, "compile-shaders b.comp.hlsl --flatten -D SHAPE=1 --output-dir out/hlsl --json");
    REQUIRE(hlsl.code == 0);
    const std::string text = ReadText(folder / "out/hlsl/b.comp.hlsl+SHAPE=1.hlsl");
    const auto json = ParseValid(hlsl.output, "compile-shaders");
    CHECK(json["permutations"][0]["bytes"].GetUint64() == text.size());
    CHECK(std::string(json["permutations"][0]["file"].GetString()) == "b.comp.hlsl+SHAPE=1.hlsl");
    CHECK(text.starts_with("// b.comp.hlsl SHAPE=1"));
    CHECK(text.find("asuint((0.5f * float(1)))") != std::string::npos);
    CHECK(text.find('#') == std::string::npos);
    // The language of a header is said by its macro.
    REQUIRE(RunProgram(folder, "compile-shaders f.h --flatten -D NTC_HLSL --output-dir out/hlsl").code == 0);
    CHECK(ReadText(folder / "out/hlsl/f.h+NTC_HLSL=1.hlsl").find("return 1;") != std::string::npos);
}

TEST_CASE("compile-shaders --flatten: the headers, and what is refused") {
    const Folder folder;
    if (IsShaderCompilerAbsent(folder))
        return;
    const std::string shaders = NTC_SHADER_DIR;
    const ProgramResult result = RunProgram(
        folder, "compile-shaders '" + shaders +
                    "/openntc/Inference.h' --flatten --network small,gen3 "
                    "--math int8 -D NTC_NO_PRECISE -D NTC_NO_LOOP_ATTRIBUTES --output-dir out -I '" +
                    shaders + "'");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    for (const char* network : {"1", "6"}) {
        std::string name = "out/Inference.h+NETWORK_VERSION=";
        name.append(network).append("+NTC_MATH=1+NTC_NO_PRECISE=1+NTC_NO_LOOP_ATTRIBUTES=1.glsl");
        const std::string text = ReadText(folder / name);
        CHECK(text.find("NtcEvaluateNetwork(") != std::string::npos);
        CHECK(text.find("precise") == std::string::npos);
        CHECK(text.find('#') == std::string::npos);
        CHECK(text.find("NTC_") == text.find("NTC_MATH")); // no macro is left but in the comment
    }
    const ProgramResult bad = RunProgram(folder, "compile-shaders '" + shaders +
                                                     "/openntc/Inference.h' --flatten -D NETWORK_VERSION=9 "
                                                     "--output-dir bad -I '" +
                                                     shaders + "'");
    CheckFails(bad, 3);
    CHECK(bad.errors.find("NETWORK_VERSION must be") != std::string::npos);
    CHECK_FALSE(fs::exists(folder / "bad"));
    CheckFails(RunProgram(folder, "compile-shaders none.h --flatten --output-dir out"), 3);
    for (const char* usage :
         {"a.h --flatten", "a.h --flatten --blob all.bin --output-dir out", "a.h --flatten --header all.h"}) {
        CAPTURE(usage);
        CheckFails(RunProgram(folder, std::string("compile-shaders ") + usage), 2);
    }
}
