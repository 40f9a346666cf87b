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
