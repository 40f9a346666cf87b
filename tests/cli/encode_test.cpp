// SPDX-License-Identifier: MIT
// `ntc encode` on good input: formats, manifests, mips, masks, constants, resuming, JSON.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <cmath>
#include <set>
#include <sstream>

using namespace openntc_tests;

namespace {

float Wave(float u, float v, int c) {
    return 0.5f + 0.4f * std::sin(6.3f * (u + static_cast<float>(c) * 0.3f)) * std::cos(6.3f * v);
}

// "inf" and "nan" are strings in the program's JSON.
double GetNumber(const rapidjson::Value& value) {
    return value.IsString() ? std::strtod(value.GetString(), nullptr) : value.GetDouble();
}

double ComparePsnr(const Folder& folder, const std::string& files) {
    const ProgramResult result = RunProgram(folder, "compare --json " + files);
    INFO(result.errors);
    REQUIRE(result.code == 0);
    return GetNumber(ParseValid(result.output, "compare")["psnr"]);
}

} // namespace

TEST_CASE("every image format is read as it was written") {
    const Folder folder;
    const TestImage image = MakeImage(24, 16, 3, Wave);
    WriteImage(folder / "a.png", image);
    for (const std::string name : {"a.tga", "a.bmp", "a.jpg"}) {
        WriteImage(folder / name, image);
        CAPTURE(name);
        const double psnr = ComparePsnr(folder, "a.png " + name);
        // JPEG at quality 95 loses a little, mostly colour; the others are lossless.
        CHECK((name == "a.jpg" ? psnr > 30.0 : std::isinf(psnr)));
    }
    // 16 bits: the difference from 8 bits is the rounding to 1/255, uniform: 20 log10(255 sqrt 12) = 58.9 dB.
    WriteImage(folder / "b.png", image, 16);
    const double deep = ComparePsnr(folder, "a.png b.png");
    CHECK(deep > 57.0);
    CHECK(deep < 61.0);
    TestImage hdr = MakeImage(24, 16, 3, [](float u, float v, int c) { return 6.0f * Wave(u, v, c); });
    WriteImage(folder / "a.hdr", hdr);
#if defined(OPENNTC_TOOL_HAS_EXR)
    WriteImage(folder / "a.exr", hdr);
    // The Radiance format has 8 bits per component under a common exponent: at worst half of 1/128 of the
    // largest component, and HLG's slope for linear light is at most that of the square root over the range
    // here.
    CHECK(ComparePsnr(folder, "a.exr a.hdr") > 45.0);
#else
    MESSAGE("SKIP: OpenEXR: this build has no tinyexr");
#endif
}

TEST_CASE("encode images: packed in order, JSON result and events") {
    const Folder folder;
    WriteImage(folder / "base_color.jpg", MakeImage(32, 32, 3, Wave));
    WriteImage(folder / "height.png", MakeImage(32, 32, 1, Wave), 16);
    WriteImage(folder / "rough.tga", MakeImage(32, 32, 1, Wave));
    WriteImage(folder / "opaque.png",
               MakeImage(32, 32, 4, [](float u, float v, int c) { return c == 3 ? 1.0f : Wave(u, v, c); }));
    WriteImage(folder / "glow.hdr", MakeImage(32, 32, 3, Wave));
    const ProgramResult result =
        RunProgram(folder, "encode base_color.jpg height.png rough.tga opaque.png glow.hdr -o m.ntc --json "
                           "--steps 20 --threads 2 --mips 3");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto encoded = ParseValid(result.output, "encode");
    CHECK(encoded["steps"].GetInt() == 20);
    CHECK(encoded["bytes"].GetUint64() == fs::file_size(folder / "m.ntc"));
    CHECK(encoded["mipPsnr"].Size() == 3);
    CHECK(encoded["channelPsnr"].Size() == 11); // the fourth image's alpha is constantly 1 and left out

    const auto info = ParseValid(RunProgram(folder, "info --json m.ntc").output, "info");
    const auto& textures = info["textures"];
    REQUIRE(textures.Size() == 5);
    CHECK(textures[0]["name"].GetString() == std::string("base_color"));
    CHECK(textures[0]["rgbColorSpace"].GetString() == std::string("sRGB"));
    CHECK(textures[1]["firstChannel"].GetInt() == 3);
    CHECK(textures[1]["channelFormat"].GetString() == std::string("UNORM16"));
    CHECK(textures[3]["numChannels"].GetInt() == 3);
    CHECK(textures[4]["channelFormat"].GetString() == std::string("FLOAT16"));
    CHECK(info["mips"].GetInt() == 3);
}

TEST_CASE("events are JSON, one a line") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, Wave));
    WriteImage(folder / "small.png", MakeImage(16, 8, 1, Wave));
    const ProgramResult result =
        RunProgram(folder, "encode a.png small.png -o a.ntc --json --seconds 0.7 --threads 1");
    REQUIRE(result.code == 0);
    std::istringstream lines(result.errors);
    int progress = 0, warnings = 0;
    for (std::string line; std::getline(lines, line);) {
        const auto event = ParseValid(line, "encode-event");
        progress += event["event"].GetString() == std::string("progress") ? 1 : 0;
        // A machine that is busy may be late, and is told so.
        const bool isLate = line.find(": took ") != std::string::npos;
        warnings += event["event"].GetString() == std::string("warning") && !isLate ? 1 : 0;
    }
    CHECK(progress >= 1);
    // The second image was rescaled, there were few steps, and 1024 texels are fewer bytes than any network.
    CHECK(warnings == 3);
    for (const char* text :
         {"small.png: image: 16 x 8", "too few for this quality", "the set is too small to gain"})
        CHECK(result.errors.find(text) != std::string::npos);
}

TEST_CASE("a manifest: swizzle, first channels, given mips, flips; the mask's exact 0 and 1 survive") {
    const Folder folder;
    const auto disc = [](float u, float v, int c) {
        const float distance = std::hypot(u - 0.5f, v - 0.5f);
        return c < 3 ? Wave(u, v, c) : distance < 0.3f ? 1.0f : distance > 0.35f ? 0.0f : 0.5f;
    };
    WriteImage(folder / "color.png", MakeImage(64, 64, 4, disc));
    WriteImage(folder / "color1.png", MakeImage(32, 32, 4, disc));
    WriteImage(folder / "flat.bmp",
               MakeImage(64, 64, 3, [](float, float, int c) { return static_cast<float>(c) * 0.4f + 0.1f; }));
    WriteText(folder / "m.json", R"({"textures":[
        {"fileName":"color.png","name":"Color","isSRGB":true,"semantics":{"Albedo":"RGB","AlphaMask":"A"}},
        {"fileName":"color1.png","name":"Color","isSRGB":true,"mipLevel":1},
        {"fileName":"flat.bmp","name":"Flat","channelSwizzle":"BR","firstChannel":6,"verticalFlip":true}]})");
    const ProgramResult result =
        RunProgram(folder, "encode m.json -o m.ntc --json --steps 500 --bits-per-pixel 8 --discard-masked "
                           "--strict --quiet");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto encoded = ParseValid(result.output, "encode");
    CHECK(encoded["maskViolations"].GetUint64() == 0);
    CHECK(encoded["channelPsnr"][6].IsString()); // constants are exact: infinite
    CHECK(encoded["channelPsnr"][4].IsNull());   // no texture

    REQUIRE(RunProgram(folder, "decode m.ntc -o out --mips").code == 0);
    for (const std::string name : {"Color.png", "mips/Color.01.png"}) {
        CAPTURE(name);
        const TestImage decoded = ReadPngImage(folder / ("out/" + name));
        const TestImage source = MakeImage(decoded.width, decoded.height, 4, disc);
        REQUIRE(decoded.channels == 4);
        int exact = 0;
        for (std::size_t i = 3; i < source.samples.size(); i += 4) {
            if (source.samples[i] != 0.5f) {
                REQUIRE(decoded.samples[i] == source.samples[i]);
                ++exact;
            }
        }
        CHECK(exact > decoded.width * decoded.height / 2);
    }
    const TestImage flat = ReadPngImage(folder / "out/Flat.png");
    CHECK(flat.samples[0] == std::floor(0.9f * 255.0f + 0.5f) / 255.0f); // B
    CHECK(flat.samples[1] == std::floor(0.1f * 255.0f + 0.5f) / 255.0f); // R

    // With next to no training the mask cannot hold: counted, and a failure only with --strict.
    const std::string command = "encode m.json -o n.ntc --json --steps 1 --bits-per-pixel 1 --quiet";
    const ProgramResult careless = RunProgram(folder, command);
    CHECK(careless.code == 0);
    CHECK(ParseValid(careless.output, "encode")["maskViolations"].GetUint64() > 0);
    const ProgramResult strict = RunProgram(folder, command + " --strict");
    CHECK(strict.code == 1);
    CHECK(strict.errors.find("mask: ") != std::string::npos);
}

TEST_CASE("constant channels decode exactly, without training") {
    const Folder folder;
    WriteImage(folder / "flat.png",
               MakeImage(16, 16, 3, [](float, float, int c) { return static_cast<float>(c) * 0.3f + 0.2f; }));
    const ProgramResult result = RunProgram(folder, "encode flat.png -o flat.ntc --json");
    REQUIRE(result.code == 0);
    const auto encoded = ParseValid(result.output, "encode");
    CHECK(encoded["steps"].GetInt() == 0);
    CHECK(encoded["psnr"].GetString() == std::string("inf"));
    CHECK(std::isinf(ComparePsnr(folder, "flat.png flat.ntc")));
}

TEST_CASE("an interrupt keeps the state and leaves no other file; --resume goes on") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, Wave));
    const ProgramResult result = RunProgram(
        folder, "--version >/dev/null; " + SignalAfter(2) +
                    "'" NTC_PROGRAM "' encode a.png -o a.ntc --steps 1000000000 --bits-per-pixel 1 --quiet");
    CheckFails(result, 1);
    CHECK(result.errors.find("--resume") != std::string::npos);
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder.GetPath()))
        found.insert(entry.path().filename().string());
    CHECK(found == std::set<std::string>{"a.png", "a.ntc.state"});

    // A state of other texels, a damaged one and a missing one are refused.
    const std::string state = ReadText(folder / "a.ntc.state");
    const std::string resume = " --resume --steps 10 --bits-per-pixel 1 --quiet";
    WriteImage(folder / "b.png", MakeImage(32, 32, 3, [](float u, float v, int c) { return Wave(v, u, c); }));
    CheckFails(RunProgram(folder, "encode b.png -o a.ntc" + resume), 3);
    std::string damaged = state;
    damaged[damaged.size() / 2] ^= 1;
    WriteText(folder / "c.ntc.state", damaged);
    CheckFails(RunProgram(folder, "encode a.png -o c.ntc" + resume), 3);
    CheckFails(RunProgram(folder, "encode a.png -o d.ntc" + resume), 3);
    CHECK_FALSE(fs::exists(folder / "d.ntc"));
    // The shape is known to the small network too.
    const ProgramResult other = RunProgram(folder, "encode a.png -o a.ntc --network small" + resume);
    CheckFails(other, 3);
    CHECK(other.errors.find("a.ntc.state: state: network: medium: this command trains small") !=
          std::string::npos);
    CHECK(ReadText(folder / "a.ntc.state") == state);

    REQUIRE(RunProgram(folder, "encode a.png -o a.ntc" + resume).code == 0);
    CHECK(RunProgram(folder, "validate a.ntc").code == 0);
    CHECK_FALSE(fs::exists(folder / "a.ntc.state"));
}

TEST_CASE("the search for a quality says what it tried") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(32, 32, 3, Wave));
    const std::string command = "encode a.png -o a.ntc --steps 40 --max-bits-per-pixel 1.5 --json --quiet";
    ProgramResult result = RunProgram(folder, command + " --target-psnr 5");
    CHECK(result.code == 0);
    CHECK(GetNumber(ParseValid(result.output, "encode")["psnr"]) >= 5.0);
    std::istringstream lines(result.errors);
    int trials = 0;
    for (std::string line; std::getline(lines, line);)
        trials += ParseValid(line, "encode-event")["event"].GetString() == std::string("trial") ? 1 : 0;
    CHECK(trials >= 1);
    result = RunProgram(folder, command + " --target-psnr 90");
    CHECK(result.code == 1);
    CHECK(fs::exists(folder / "a.ntc")); // the best
}
