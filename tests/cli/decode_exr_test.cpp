// SPDX-License-Identifier: MIT
// `ntc decode` to OpenEXR: textures of floats, and all textures on request.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include "encode/InputImage.h"

#include <cmath>

using namespace openntc_tests;
using openntc::tool::InputImage;

#if defined(OPENNTC_TOOL_HAS_EXR)

namespace {

float Glow(float u, float v, int c) {
    return 0.02f + 4.0f * u * (c == 0 ? 1.0f : v);
}

} // namespace

TEST_CASE("HDR textures decode to OpenEXR, which encodes again to what they were") {
    const Folder folder;
    WriteImage(folder / "glow.exr", MakeImage(16, 8, 3, Glow));
    WriteImage(folder / "flat.png", MakeImage(16, 8, 2, [](float, float, int) { return 0.5f; }));
    REQUIRE(RunProgram(folder, "encode glow.exr flat.png -o a.ntc --steps 20 --threads 1 --quiet").code == 0);
    const ProgramResult result = RunProgram(folder, "decode a.ntc -o out --mips --json");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "decode");
    CHECK(json["files"].Size() == 10);
    CHECK(fs::exists(folder / "out/flat.png"));
    CHECK(fs::exists(folder / "out/mips/glow.04.exr"));
    CHECK_FALSE(fs::exists(folder / "out/glow.png"));
    // Both are the same network's outputs: HLG decoded to linear light, rounded to half precision (2^-11).
    REQUIRE(RunProgram(folder, "decode a.ntc -o whole --format exr").code == 0);
    CHECK_FALSE(fs::exists(folder / "whole/flat.png"));
    const InputImage decoded = openntc::tool::ReadImage((folder / "out/glow.exr").string());
    REQUIRE(decoded.width == 16);
    REQUIRE(decoded.height == 8);
    WriteText(folder / "texels", "0 0 0\n0 15 0\n0 3 7\n0 9 4\n");
    const auto sampled =
        ParseValid(RunProgram(folder, "sample a.ntc --texels texels --linear --json").output, "sample");
    const int at[][2] = {{0, 0}, {15, 0}, {3, 7}, {9, 4}};
    for (rapidjson::SizeType i = 0; i < 4; ++i) {
        for (int c = 0; c < 3; ++c) {
            const double wanted =
                sampled["texels"][i]["values"][static_cast<rapidjson::SizeType>(c)].GetDouble();
            const float got = decoded.texels[static_cast<std::size_t>((at[i][1] * 16 + at[i][0]) * 4 + c)];
            CHECK(static_cast<double>(got) == doctest::Approx(wanted).epsilon(1.0 / 2048.0));
        }
    }
    // Gray and alpha in floats: stored values are linear as they are.
    const InputImage flat = openntc::tool::ReadImage((folder / "whole/flat.exr").string());
    CHECK(flat.texels[0] == 128.0f / 255.0f);
    // All or nothing, and PNG cannot hold floats.
    const ProgramResult png = RunProgram(folder, "decode a.ntc -o png --format png");
    CHECK(png.code == 1);
    CHECK(png.errors.find("glow (FLOAT16 x 3)") != std::string::npos);
    CHECK(png.errors.find("--format exr") != std::string::npos);
    const ProgramResult limited = RunProgram(folder, "--version >/dev/null; ulimit -f 0; '" NTC_PROGRAM
                                                     "' decode a.ntc -o none --format exr");
    CHECK(limited.code == 1);
    CHECK_FALSE(fs::exists(folder / "none"));
    // TGA holds what PNG holds of 8 bits.
    CHECK(RunProgram(folder, "decode a.ntc -o tga --format tga").code == 1);
    CHECK_FALSE(fs::exists(folder / "tga/glow.tga"));
    const InputImage tga = openntc::tool::ReadImage((folder / "tga/flat.tga").string());
    const InputImage same = openntc::tool::ReadImage((folder / "out/flat.png").string());
    CHECK(tga.width == 16);
    CHECK(tga.height == 8);
    CHECK(tga.texels == same.texels);
}

#endif
