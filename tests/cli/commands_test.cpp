// SPDX-License-Identifier: MIT
// Every command on good input: outputs, JSON against the schemas, PNG files against the sampled values.
#include "cli/Program.h"
#include "support/SpecificationVectors.h"

#include "TextureImage.h"

#include "openntc/core/Crc32.h"

#include <png.h>

#include <set>
#include <sstream>

using namespace openntc_tests;

namespace {

std::string ToText(const std::vector<std::byte>& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// 8-bit samples of a PNG through libpng's simple reader.
std::vector<unsigned char> ReadPng(const fs::path& path, unsigned format, int& width, int& height) {
    png_image image = {};
    image.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&image, path.string().c_str()) != 0);
    image.format = format;
    width = static_cast<int>(image.width);
    height = static_cast<int>(image.height);
    std::vector<unsigned char> samples(PNG_IMAGE_SIZE(image));
    REQUIRE(png_image_finish_read(&image, nullptr, samples.data(), 0, nullptr) != 0);
    return samples;
}

} // namespace

TEST_CASE("info, validate and constants") {
    const Folder folder;
    WriteText(folder / "v1.ntc", ToText(SynthesizeV1()));
    for (const std::string file : {"v1.ntc", "- < v1.ntc"}) {
        CAPTURE(file);
        ProgramResult result = RunProgram(folder, "info --json " + file);
        CHECK(result.code == 0);
        const auto info = ParseValid(result.output, "info");
        CHECK(info["width"].GetInt() == 24);
        CHECK(info["network"]["name"].GetString() == std::string("small"));
        CHECK(info["weights"]["int8"].GetInt() == 13952);

        result = RunProgram(folder, "validate --json " + file);
        CHECK(result.code == 0);
        CHECK(ParseValid(result.output, "validate")["files"][0]["usable"].GetBool());

        result = RunProgram(folder, "constants --weights int8 --json " + file);
        CHECK(result.code == 0);
        const auto constants = ParseValid(result.output, "constants");
        CHECK(constants["weightBytes"].GetUint64() == 13952);
        CHECK(constants["weightCrc32"].GetUint() == 0x2c7b7511u); // format specification, V1
        CHECK(constants["latentOffset"].GetUint64() == 15884);    // 1932 + 13952
        CHECK(constants["latentSize"].GetUint64() == 56);
        CHECK(std::string(constants["constants"].GetString()).starts_with("0400000002000000"));
    }
    CHECK(RunProgram(folder, "info v1.ntc").code == 0);
    CHECK(RunProgram(folder, "validate v1.ntc").output.ends_with("v1.ntc: valid\n"));
    CHECK(RunProgram(folder, "constants v1.ntc --first-mip 1 --mips 2").code == 0);
}

TEST_CASE("sample: exact CSV, JSON, comments, standard input") {
    const Folder folder;
    WriteText(folder / "v1.ntc", ToText(SynthesizeV1()));
    WriteText(folder / "list", "# texels\n\n0 0 0\n  3\t2 1 # last\r\n0 23 19");
    const ProgramResult csv = RunProgram(folder, "sample v1.ntc --texels list --csv");
    CHECK(csv.code == 0);
    std::istringstream lines(csv.output);
    std::string line;
    std::getline(lines, line);
    CHECK(line == "mip,x,y,c0,c1,c2,c3,c4,c5,c6,c7,c8,c9,c10,c11,c12,c13,c14,c15");
    std::getline(lines, line);
    CHECK(
        line.starts_with("0,0,0,-1.01043701,0.0849552155,")); // bf815600, 3dadfd00 (format specification, V1)
    std::getline(lines, line);
    CHECK(line.starts_with("3,2,1,"));
    std::getline(lines, line);
    CHECK(line.starts_with("0,23,19,-2.59419632,")); // c0260750
    CHECK_FALSE(std::getline(lines, line));

    CHECK(RunProgram(folder, "sample v1.ntc --texels - < list").output == csv.output);
    CHECK(RunProgram(folder, "sample - --texels list < v1.ntc").output == csv.output);
    CHECK(RunProgram(folder, "sample v1.ntc --texels list --backend reference").output == csv.output);
    const ProgramResult half = RunProgram(folder, "sample v1.ntc --texels list --math int8_half --json");
    CHECK(half.code == 0);
    CHECK(ParseValid(half.output, "sample")["texels"][0]["values"][0].GetFloat() == -1.0224609375f); // bc17
}

TEST_CASE("decode: PNG files hold the quantised samples") {
    const Folder folder;
    WriteText(folder / "v1.ntc", ToText(SynthesizeV1()));
    const ProgramResult result = RunProgram(folder, "decode v1.ntc -o out/deep --mips --json");
    CHECK(result.code == 0);
    const auto files = ParseValid(result.output, "decode");
    REQUIRE(files["files"].Size() == 4);
    std::set<std::string> found;
    for (const auto& entry : fs::recursive_directory_iterator(folder / "out/deep"))
        found.insert(fs::relative(entry.path(), folder / "out/deep").string());
    CHECK(found == std::set<std::string>{"mips", "mips/t.01.png", "mips/t.02.png", "mips/t.03.png", "t.png"});

    std::string list;
    for (int y = 0; y < 20; ++y) {
        for (int x = 0; x < 24; ++x)
            list += "0 " + std::to_string(x) + " " + std::to_string(y) + "\n";
    }
    WriteText(folder / "list", list);
    const auto samples =
        ParseValid(RunProgram(folder, "sample v1.ntc --texels list --json").output, "sample");
    int width = 0;
    int height = 0;
    const std::vector<unsigned char> png = ReadPng(folder / "out/deep/t.png", PNG_FORMAT_RGBA, width, height);
    CHECK(width == 24);
    CHECK(height == 20);
    for (unsigned texel = 0; texel < 480; ++texel) {
        for (unsigned channel = 0; channel < 4; ++channel) {
            const float value = samples["texels"][texel]["values"][channel].GetFloat();
            REQUIRE(png[texel * 4 + channel] == openntc::tool::QuantiseUnorm(value, 255));
        }
    }
    CHECK(RunProgram(folder, "decode v1.ntc -o out").output == "out/t.png 24 x 20\n");
}

TEST_CASE("conformance and bench decode") {
    const Folder folder;
    fs::create_directory(folder / "run");
    WriteText(folder / "run/v1.ntc", ToText(SynthesizeV1()));
    WriteText(folder / "run/lonely.texels", "NTXL");
    // (0, 0, 0) of V1 (format specification), flags "exact"; other blocks are not compared against anything
    // wrong.
    WriteText(folder / "run/v1.expect.json", R"({"width":24,"height":20,"networkVersion":1,
        "GenericInt8":{"weightBytes":13952,"weightCrc32":746288401,"constants":"00"}})");
    ProgramResult result = RunProgram(folder, "conformance ./run");
    CHECK(result.code == 1);
    CHECK(result.output.find("FAIL v1: GenericInt8: constants of 1 bytes expected: 624, worst error 0\n") !=
          std::string::npos);
    CHECK(result.output.ends_with("total: 0 passed, 1 failed, 1 skipped\n"));

    WriteText(folder / "run/v1.expect.json", R"({"width":24,"height":20,"networkVersion":1})");
    result = RunProgram(folder, "conformance run run --backend reference");
    CHECK(result.code == 0);
    CHECK(result.output.ends_with("total: 1 passed, 0 failed, 1 skipped\n"));
    ParseValid(RunProgram(folder, "conformance run run --json").output, "conformance");

    WriteText(folder / "run/v1.expect.json", R"({"width":25})");
    result = RunProgram(folder, "conformance ./run");
    CHECK(result.output.find("FAIL v1: width: 24: expected 25, worst error 0\n") != std::string::npos);
    fs::create_directory(folder / "empty");
    result = RunProgram(folder, "conformance empty");
    CHECK(result.code == 3);
    CHECK(result.output == "");
    CHECK(result.errors.find("empty: folder: holds no vectors") != std::string::npos);

    result =
        RunProgram(folder, "bench decode run/v1.ntc --repeat 1 --json --backend cpu --backend reference");
    CHECK(result.code == 0);
    CHECK(ParseValid(result.output, "bench-decode")["texels"].GetInt() == 480 + 120 + 30 + 6);
    result = RunProgram(folder, "bench load run/v1.ntc --repeat 3 --json");
    CHECK(result.code == 0);
    CHECK(ParseValid(result.output, "bench-load")["microseconds"]["runs"].GetInt() == 3);
    result = RunProgram(folder, "bench tiles --textures 7 --change 10 --frames 3 --json");
    CHECK(result.code == 0);
    const auto tiles = ParseValid(result.output, "bench-tiles");
    REQUIRE(tiles["results"].Size() == 3);
    CHECK(tiles["results"][0]["changedRegions"].GetInt() == 44); // of 448
    CHECK(tiles["results"][2]["changedRegions"].GetInt() == 64);
    CHECK(tiles["results"][0]["usedSlots"].GetInt() > 7);
    CHECK(RunProgram(folder, "bench tiles --variant D").code == 2);
}
