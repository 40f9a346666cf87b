// SPDX-License-Identifier: MIT
// `ntc compare`: which textures of two sides belong together.
#include "TextureImage.h"
#include "cli/ImageFiles.h"
#include "cli/Program.h"
#include "encode/ComparedSet.h"
#include "support/Files.h"

#include "openntc/core/Half.h"
#include "openntc/image/ColorEncoding.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <cmath>
#include <numeric>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

TestImage MakeRamp(int channels, float offset) {
    return MakeImage(16, 8, channels, [offset](float u, float v, int c) {
        return c == 0 ? 0.5f * u + offset : 0.5f * v + offset;
    });
}

/// Whether an image holds the value that decodes to `stored`: a PNG its nearest code, OpenEXR a half of linear light.
bool IsImageOf(ChannelFormat format, float stored, float image) {
    if (format == ChannelFormat::UNORM8 || format == ChannelFormat::UNORM16) {
        const std::uint16_t most = format == ChannelFormat::UNORM8 ? 255 : 65535;
        return image == static_cast<float>(tool::QuantiseUnorm(stored, most)) / static_cast<float>(most);
    }
    // A half is within 2^-11 of its value, or half its smallest step; as much again for the conversions.
    const float linear = image::DecodeColor(ColorSpace::HLG, stored);
    const float error = std::fabs(linear) * 0x1p-10f + 0x1p-24f;
    return image >= image::EncodeColor(ColorSpace::HLG, linear - error) &&
           image <= image::EncodeColor(ColorSpace::HLG, linear + error);
}

/// Texels of a texture, of all mips of `a`, that the other side does not have.
std::size_t CountOthers(const tool::ComparedSet& a, const tool::ComparedSet& b, const Texture& texture) {
    std::size_t others = 0;
    for (std::size_t m = 0; m < a.mips.size(); ++m) {
        for (int c = texture.firstChannel; c < texture.firstChannel + texture.numChannels; ++c) {
            for (std::size_t i = 0; i < a.mips[m].planes[c].size(); ++i)
                others +=
                    IsImageOf(texture.channelFormat, a.mips[m].planes[c][i], b.mips[m].planes[c][i]) ? 0 : 1;
        }
    }
    return others;
}

} // namespace

TEST_CASE("compare: textures are paired by name, whatever their channels") {
    const Folder folder;
    WriteImage(folder / "z.png", MakeRamp(3, 0.0f));
    WriteImage(folder / "a.png", MakeRamp(1, 0.5f));
    WriteImage(folder / "extra.png", MakeRamp(1, 0.25f));
    const std::string z = R"({"fileName":"z.png","name":"Zebra"})",
                      a = R"({"fileName":"a.png","name":"Ant"})",
                      shortZ = R"({"fileName":"z.png","name":"Zebra","channelSwizzle":"RG"})",
                      extra = R"({"fileName":"extra.png","name":"Extra"})";
    WriteText(folder / "first.json", R"({"textures":[)" + z + "," + a + "]}");
    WriteText(folder / "second.json", R"({"textures":[)" + a + "," + extra + "," + shortZ + "]}");
    const auto json = ParseValid(
        RunProgram(folder, "compare --json first.json second.json --images out").output, "compare");
    CHECK(json["pairing"].GetString() == std::string("name"));
    CHECK(json["psnr"].GetString() == std::string("inf"));
    REQUIRE(json["textures"].Size() == 2);
    CHECK(json["textures"][0]["name"].GetString() == std::string("Zebra"));
    CHECK(json["textures"][1]["name"].GetString() == std::string("Ant"));
    REQUIRE(json["channels"].Size() == 3);
    CHECK(json["channels"][2]["channel"].GetInt() == 3); // Ant's, by the numbers of the first
    CHECK(json["onlyInA"]["textures"].Empty());
    REQUIRE(json["onlyInA"]["channels"].Size() == 1);
    CHECK(json["onlyInA"]["channels"][0].GetInt() == 2);
    REQUIRE(json["onlyInB"]["textures"].Size() == 1);
    CHECK(json["onlyInB"]["textures"][0].GetString() == std::string("Extra"));
    CHECK(json["onlyInB"]["channels"][0].GetInt() == 1); // by the numbers of the second
    const TestImage shown = ReadPngImage(folder / "out/Ant.png");
    CHECK(shown.samples[0] == shown.samples[16]);
    const std::string text = RunProgram(folder, "compare first.json second.json").output;
    CHECK(text.find("note: only in first.json, not compared: channels 2 of Zebra\n") != std::string::npos);
    CHECK(text.find("note: only in second.json, not compared: texture Extra\n") != std::string::npos);
    CHECK(text.find("compared by channel") == std::string::npos);
}

TEST_CASE("compare: without a name on both sides channels are compared, and that is said") {
    const Folder folder;
    WriteImage(folder / "rgb.png", MakeRamp(3, 0.0f));
    WriteImage(folder / "gray.png", MakeRamp(1, 0.0f));
    CHECK(RunProgram(folder, "compare rgb.png gray.png")
              .output.find("note: no texture has the same name on both sides: compared by channel\n") !=
          std::string::npos);
    const auto json = ParseValid(RunProgram(folder, "compare --json rgb.png gray.png").output, "compare");
    CHECK(json["pairing"].GetString() == std::string("channel"));
    CHECK(json["channels"][0]["psnr"].GetString() == std::string("inf"));
}

TEST_CASE("compare: the images of a set are its textures, also where names are none of files") {
    const Folder folder;
    WriteImage(folder / "x.png", MakeRamp(3, 0.0f));
    WriteImage(folder / "y.png", MakeRamp(2, 0.5f));
    WriteText(folder / "set.json", R"({"textures":[{"fileName":"x.png","name":"wall/x"},)"
                                   R"({"fileName":"y.png","name":"wall/a"}]})");
    REQUIRE(RunProgram(folder, "encode set.json -o set.ntc --steps 2 --quiet").code == 0);
    REQUIRE(RunProgram(folder, "decode set.ntc -o images --mips").code == 0);
    for (const char* order : {"set.ntc images", "images set.ntc"}) {
        CAPTURE(order);
        const auto json =
            ParseValid(RunProgram(folder, std::string("compare --json ") + order).output, "compare");
        CHECK(json["pairing"].GetString() == std::string("name"));
        CHECK(json["channels"].Size() == 5); // of the third that decode gives two channels nothing is said
        CHECK(json["onlyInA"]["channels"].Empty());
        CHECK(json["onlyInB"]["channels"].Empty());
    }
}

TEST_CASE("compare: every conformance set is its own decode") {
    if (!fs::exists(GetConformanceFolder())) {
        MESSAGE("SKIP: no conformance vectors: set OPENNTC_SHARED_DIR");
        return;
    }
    int sets = 0;
    for (const auto& entry : fs::directory_iterator(GetConformanceFolder())) {
        if (entry.path().extension() != ".ntc")
            continue;
        ++sets;
        CAPTURE(entry.path().filename().string());
        const Folder folder;
        REQUIRE(RunProgram(folder, "decode '" + entry.path().string() + "' -o images --mips").code == 0);
        auto [set, images] = tool::LoadComparedSets(entry.path().string(), (folder / "images").string());
        const tool::ComparedPairs pairs = tool::PairChannels(set, images);
        CHECK(pairs.isByName);
        CHECK(pairs.channels == set.declared);
        CHECK(pairs.onlyInA.channels.empty());
        CHECK(pairs.onlyInB.channels.empty());
        REQUIRE(images.mips.size() >= set.mips.size());
        const std::vector<std::byte> file = ReadBytes(entry.path());
        ReadOnlyMemoryStream stream(file);
        const auto metadata = TextureSetMetadata::Load(stream);
        REQUIRE(metadata);
        for (const Texture& texture : metadata->GetTextures()) {
            CAPTURE(std::string(texture.name));
            CHECK(CountOthers(set, images, texture) == 0);
        }
    }
    CHECK(sets > 0);
}
