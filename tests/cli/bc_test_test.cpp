// SPDX-License-Identifier: MIT
// `ntc bc-test`: its numbers against a sum of squares of our own, its forms, and its baseline.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include "textures/BlockCoding.h"

#include "openntc/bc/BlockDecoder.h"

#include <rapidjson/writer.h>

#include <cmath>
#include <map>
#include <random>

using namespace openntc_tests;
using namespace openntc;

namespace {

/// 13 x 10 texels, different in every channel; three channels.
TestImage MakeColors() {
    std::mt19937 random(7);
    TestImage image{13, 10, 3, {}};
    for (int i = 0; i < 13 * 10 * 3; ++i)
        image.samples.push_back(static_cast<float>(random() % 256) / 255.0f);
    return image;
}

TestImage MakeFlat() {
    TestImage image{8, 8, 3, {}};
    for (int i = 0; i < 8 * 8 * 3; ++i)
        image.samples.push_back(0.2f); // 51
    return image;
}

/// PSNR of the R channel through BC4, texel by texel.
double GetRedPsnr(const TestImage& image, tool::BlockEffort effort) {
    tool::TextureFormat format;
    format.block = bc::BlockFormat::Bc4Unsigned;
    format.channels = 1;
    std::vector<std::byte> red, blocks;
    for (std::size_t i = 0; i < image.samples.size(); i += 3)
        red.push_back(static_cast<std::byte>(std::lround(image.samples[i] * 255.0f)));
    const auto width = static_cast<std::uint32_t>(image.width),
               height = static_cast<std::uint32_t>(image.height);
    tool::EncodeTexelBlocks(format, effort, {red, width, height}, 1, "test", blocks);
    std::vector<float> texels(red.size() * 4);
    REQUIRE(bc::DecodeBlocksToFloats(*format.block, blocks, width, height, texels).has_value());
    double sum = 0.0;
    for (std::size_t i = 0; i < red.size(); ++i) {
        const double difference =
            255.0 * static_cast<double>(texels[i * 4]) - static_cast<double>(std::to_integer<int>(red[i]));
        sum += difference * difference;
    }
    return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(red.size()) / sum);
}

} // namespace

TEST_CASE("bc-test: PSNR of every level, pooled over images") {
    const Folder folder;
    WriteImage(folder / "colors.png", MakeColors());
    WriteImage(folder / "flat.png", MakeFlat());
    const ProgramResult result = RunProgram(folder, "bc-test colors.png flat.png --bc bc4 --repeat 1 --json");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "bc-test");
    CHECK(json["threads"].GetInt() == 1);
    REQUIRE(json["results"].Size() == 9); // two images and both together, three levels
    std::map<std::string, double> psnr;
    for (const auto& row : json["results"].GetArray()) {
        const std::string image = row["image"].GetString(), quality = row["quality"].GetString();
        CHECK(std::string(row["format"].GetString()) == "bc4");
        CHECK(row["channels"].GetInt() == 1);
        CHECK(row["megapixelsPerSecond"].GetDouble() >= 0.0);
        if (image == "flat.png") {
            CHECK(std::string(row["psnr"].GetString()) == "inf");
            CHECK(row["bytes"].GetInt() == 4 * 8);
        } else {
            psnr[image + quality] = row["psnr"].GetDouble();
            CHECK(row["bytes"].GetInt() == (image.empty() ? 16 * 8 : 12 * 8));
        }
    }
    const std::pair<const char*, tool::BlockEffort> levels[] = {{"fast", tool::BlockEffort::Fast},
                                                                {"normal", tool::BlockEffort::Normal},
                                                                {"best", tool::BlockEffort::Best}};
    for (const auto& [name, effort] : levels) {
        // Texels are whole fractions of a binary32: seven digits.
        CHECK(psnr[std::string("colors.png") + name] ==
              doctest::Approx(GetRedPsnr(MakeColors(), effort)).epsilon(1e-5));
        // The flat image adds texels without an error: 130 of 194.
        CHECK(psnr[name] ==
              doctest::Approx(psnr[std::string("colors.png") + name] + 10.0 * std::log10(194.0 / 130.0))
                  .epsilon(1e-9));
    }
    CHECK(psnr["colors.pngnormal"] >= psnr["colors.pngfast"]);
    CHECK(psnr["colors.pngbest"] >= psnr["colors.pngnormal"]);
}

TEST_CASE("bc-test: every format that suits an image; tables and CSV") {
    const Folder folder;
    WriteImage(folder / "colors.png", MakeColors());
    const ProgramResult table =
        RunProgram(folder, "bc-test colors.png --repeat 1 --quality fast --threads 2");
    INFO(table.errors);
    REQUIRE(table.code == 0);
    const ProgramResult csv = RunProgram(folder, "bc-test colors.png --repeat 1 --quality fast,best --csv");
    REQUIRE(csv.code == 0);
    CHECK(csv.output.starts_with(
        "image,format,quality,psnr,worst,alphaMoved,megapixelsPerSecond,bytes,hinted\n"));
    for (const bc::BlockFormat format : {bc::BlockFormat::Bc1, bc::BlockFormat::Bc4Unsigned,
                                         bc::BlockFormat::Bc5Unsigned, bc::BlockFormat::Bc7}) {
        const std::string name = bc::BlockFormatToString(format);
        const bool hasEncoder = tool::HasBlockEncoder(format);
        CHECK((table.output.find(" " + name + " ") != std::string::npos) == hasEncoder);
        CHECK((csv.output.find("colors.png," + name + ",best,") != std::string::npos) == hasEncoder);
    }
    // A channel of its own: blue of this image is not its red.
    const auto getBc4 = [&](const std::string& channel) {
        return RunProgram(folder,
                          "bc-test colors.png --bc bc4 --repeat 1 --csv --quality fast --channel " + channel)
            .output.substr(0, 120);
    };
    CHECK(getBc4("r").substr(0, 110) != getBc4("b").substr(0, 110));
}

TEST_CASE("bc-test: BC7 with hints is as good as the search that they come from, and levels stay in order") {
    const Folder folder;
    WriteImage(folder / "colors.png", MakeColors());
    const ProgramResult result =
        RunProgram(folder, "bc-test colors.png --bc bc4,bc7 --hints --repeat 1 --json");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "bc-test");
    REQUIRE(json["results"].Size() == 3 + 6);
    std::map<std::pair<std::string, bool>, double> psnr;
    for (const auto& row : json["results"].GetArray()) {
        CHECK((!row["hinted"].GetBool() || row["format"] == "bc7"));
        if (row["format"] == "bc7")
            psnr[{row["quality"].GetString(), row["hinted"].GetBool()}] = row["psnr"].GetDouble();
    }
    CHECK(psnr.size() == 6);
    CHECK(psnr[{"best", true}] == psnr[{"best", false}]);
    CHECK(psnr[{"fast", true}] <= psnr[{"normal", true}]);
    CHECK(psnr[{"normal", true}] <= psnr[{"best", true}]);
    CHECK(RunProgram(folder, "bc-test colors.png --bc bc7 --quality fast --hints --repeat 1")
              .output.find(" fast, hinted ") != std::string::npos);
    // A baseline tells the two apart.
    WriteText(folder / "before.json", result.output);
    const ProgramResult without = RunProgram(
        folder, "bc-test colors.png --bc bc4,bc7 --repeat 1 --max-slower 100 --baseline before.json");
    CHECK(without.code == 1);
    CHECK(without.output.find("worse: colors.png: bc7 best, hinted: missing") != std::string::npos);
    CHECK(without.errors == "ntc: before.json: baseline: 3 results are worse\n");
}

TEST_CASE("bc-test: a baseline says what got worse") {
    const Folder folder;
    WriteImage(folder / "colors.png", MakeColors());
    const std::string command = "bc-test colors.png --bc bc4 --repeat 1 --max-slower 100 ";
    const ProgramResult first = RunProgram(folder, command + "--json");
    REQUIRE(first.code == 0);
    WriteText(folder / "same.json", first.output);
    CHECK(RunProgram(folder, command + "--baseline same.json").code == 0);

    // The same file, in which everything was better.
    rapidjson::Document edited;
    edited.Parse(first.output.c_str());
    for (auto& row : edited["results"].GetArray())
        row["psnr"].SetDouble(row["psnr"].GetDouble() + 0.02);
    edited["results"][1]["image"].SetString("gone.png");
    const auto save = [&](const char* name) {
        rapidjson::StringBuffer buffer;
        rapidjson::Writer<rapidjson::StringBuffer> writer(buffer);
        edited.Accept(writer);
        WriteText(folder / name, buffer.GetString());
    };
    save("better.json");
    const ProgramResult worse = RunProgram(folder, command + "--baseline better.json");
    CHECK(worse.code == 1);
    CHECK(worse.errors == "ntc: better.json: baseline: 3 results are worse\n");
    CHECK(worse.output.find("worse: colors.png: bc4 fast: PSNR: ") != std::string::npos);
    CHECK(worse.output.find("worse: colors.png: bc4 best: PSNR: ") != std::string::npos);
    CHECK(worse.output.find("worse: gone.png: bc4 normal: missing") != std::string::npos);
    CHECK(RunProgram(folder, command + "--max-loss 0.5 --baseline same.json").code == 0);
    const ProgramResult json = RunProgram(folder, command + "--json --baseline better.json");
    CHECK(json.code == 1);
    CHECK(ParseValid(json.output, "bc-test")["worse"].Size() == 3);

    edited["results"][0]["megapixelsPerSecond"].SetDouble(1e9);
    save("faster.json");
    CHECK(RunProgram(folder, "bc-test colors.png --bc bc4 --repeat 1 --max-slower 90 --baseline faster.json")
              .output.find("worse: colors.png: bc4 fast: speed: ") != std::string::npos);

    CheckFails(RunProgram(folder, command + "--csv --json"), 2);
    WriteText(folder / "bad.json", "{\"threads\": 1, \"results\": [{}]}");
    for (const std::string bad : {"bad.json", "missing.json", "colors.png"})
        CHECK(RunProgram(folder, command + "--baseline " + bad).code == 3);
    CHECK(RunProgram(folder, command + "--threads 2 --baseline same.json").code == 2);
    CheckFails(RunProgram(folder, "bc-test missing.png"), 3);
    CheckFails(RunProgram(folder, "bc-test colors.png --bc bc8"), 2);
    CheckFails(RunProgram(folder, "bc-test colors.png --quality better"), 2);
    CheckFails(RunProgram(folder, "bc-test colors.png --channel x"), 2);
    CheckFails(RunProgram(folder, "bc-test"), 2);
}
