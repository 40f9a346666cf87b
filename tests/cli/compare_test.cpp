// SPDX-License-Identifier: MIT
// `ntc compare`: figures against values that follow from the images.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <cmath>

using namespace openntc_tests;

TEST_CASE("PSNR, worst texel and images of a known difference") {
    const Folder folder;
    const auto flat = [](float, float, int) { return 0.4f; };
    const TestImage first = MakeImage(16, 8, 3, flat);
    TestImage second = first;
    for (std::size_t i = 1; i < second.samples.size(); i += 3)
        second.samples[i] = 0.6f; // green everywhere: 51 of 255
    second.samples[(5 * 16 + 9) * 3 + 2] = 1.0f;
    WriteImage(folder / "a.png", first);
    WriteImage(folder / "b.png", second);
    const ProgramResult result = RunProgram(folder, "compare a.png b.png --json --images out");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "compare");
    CHECK(json["channels"][0]["psnr"].GetString() == std::string("inf"));
    // 20 log10(255 / 51); images are compared with their generated mips, which for green are equal to mip 0
    CHECK(std::fabs(json["channels"][1]["psnr"].GetDouble() - 13.9794) < 1e-3);
    CHECK(json["worst"]["mip"].GetInt() == 0);
    CHECK(json["worst"]["x"].GetInt() == 9);
    CHECK(json["worst"]["y"].GetInt() == 5);
    CHECK(json["worst"]["channel"].GetInt() == 2);
    CHECK(std::fabs(json["worst"]["difference"].GetDouble() - 0.6) < 1e-3);
    const TestImage shown = ReadPngImage(folder / "out/b.png");
    CHECK(shown.width == 48);
    CHECK(shown.samples[1] == 102.0f / 255.0f);
    CHECK(shown.samples[16 * 3 + 1] == 153.0f / 255.0f);
    CHECK(shown.samples[32 * 3 + 1] == 1.0f); // 8 x 51 of 255, clamped
    CHECK(shown.samples[32 * 3] == 0.0f);
    const ProgramResult text = RunProgram(folder, "compare a.png b.png");
    CHECK(text.code == 0);
    CHECK(text.output.find("worst: mip 0, texel 9 5, channel 2: 0.6") != std::string::npos);
}

TEST_CASE("what only one side has is named, and a PSNR can be demanded") {
    const Folder folder;
    const auto ramp = [](float u, float v, int c) { return c == 0 ? u : v; };
    WriteImage(folder / "rgb.png", MakeImage(16, 8, 3, ramp));
    WriteImage(folder / "gray.png", MakeImage(16, 8, 1, [](float u, float, int) { return u + 0.1f; }));
    const ProgramResult text = RunProgram(folder, "compare rgb.png gray.png");
    CHECK(text.code == 0);
    CHECK(text.output.find("note: only in rgb.png, not compared: channels 1, 2\n") != std::string::npos);
    const auto json = ParseValid(RunProgram(folder, "compare --json rgb.png gray.png").output, "compare");
    REQUIRE(json["onlyInA"]["channels"].Size() == 2);
    CHECK(json["onlyInA"]["channels"][0].GetInt() == 1);
    CHECK(json["onlyInA"]["channels"][1].GetInt() == 2);
    CHECK(json["onlyInB"]["channels"].Empty());
    REQUIRE(RunProgram(folder, "encode rgb.png -o a.ntc --steps 2 --mips 2 --quiet").code == 0);
    const ProgramResult mips = RunProgram(folder, "compare a.ntc rgb.png");
    CHECK(mips.output.find("note: only in rgb.png, not compared: mips 2 to 4\n") != std::string::npos);
    const auto counted = ParseValid(RunProgram(folder, "compare --json a.ntc rgb.png").output, "compare");
    CHECK(counted["onlyInB"]["mips"].GetInt() == 3);
    CHECK(counted["onlyInA"]["mips"].GetInt() == 0);
    // 20 log10(1 / 0.1) = 20 dB, with rounding to 8 bits and the last columns cut at 1.
    CHECK(RunProgram(folder, "compare rgb.png gray.png --min-psnr 19.5").code == 0);
    const ProgramResult missed = RunProgram(folder, "compare rgb.png gray.png --min-psnr 30");
    CHECK(missed.code == 1);
    CHECK(missed.output.starts_with("psnr "));
    CHECK(missed.errors.starts_with("ntc: --min-psnr: "));
    CHECK(missed.errors.find("less than 30") != std::string::npos);
    CHECK(RunProgram(folder, "compare rgb.png rgb.png --min-psnr 1000").code == 0); // infinite
}

TEST_CASE("discarded texels are outside the measure, in encode's report and in compare") {
    const Folder folder;
    // Half of the texels are masked out; their colour is free.
    WriteImage(folder / "leaf.png", MakeImage(32, 32, 4, [](float u, float v, int c) {
                   return c == 3 ? (u < 0.5f ? 0.0f : 1.0f)
                                 : 0.5f + 0.4f * std::sin(9.0f * (u + v * static_cast<float>(c)));
               }));
    WriteText(folder / "leaf.json",
              R"({"textures":[{"fileName":"leaf.png","semantics":{"Albedo":"RGB","AlphaMask":"A"}}]})");
    const ProgramResult result = RunProgram(folder, "encode leaf.json -o a.ntc --steps 40 --threads 1 "
                                                    "--bits-per-pixel 8 --discard-masked --json --quiet");
    REQUIRE(result.code == 0);
    const double reported = ParseValid(result.output, "encode")["psnr"].GetDouble();
    const auto compared =
        ParseValid(RunProgram(folder, "compare leaf.json a.ntc --discard-masked --json").output, "compare");
    // References have 16 bits while training: as for the PSNR of whole sets.
    CHECK(std::fabs(compared["psnr"].GetDouble() - reported) < 0.05);
    const auto all = ParseValid(RunProgram(folder, "compare leaf.json a.ntc --json").output, "compare");
    CHECK(all["psnr"].GetDouble() < reported - 0.5);
    CheckFails(RunProgram(folder, "compare leaf.png a.ntc --discard-masked"), 2);
}

TEST_CASE("FLIP of textures of three channels, where it is asked for") {
    const Folder folder;
    WriteImage(folder / "black.png", MakeImage(16, 8, 3, [](float, float, int) { return 0.0f; }));
    WriteImage(folder / "white.png", MakeImage(16, 8, 3, [](float, float, int) { return 1.0f; }));
    const auto json =
        ParseValid(RunProgram(folder, "compare black.png white.png --flip --json").output, "compare");
    CHECK(std::fabs(json["textures"][0]["flip"]["mean"].GetDouble() - 0.967380) <
          2e-5); // unit_renderer has more
    CHECK(RunProgram(folder, "compare black.png white.png --flip")
              .output.find("flip 0.96738, at most 0.96738") != std::string::npos);
    CHECK(RunProgram(folder, "compare black.png white.png").output.find("flip") == std::string::npos);
}
