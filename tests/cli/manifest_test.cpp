// SPDX-License-Identifier: MIT
// Manifests and their schema, and what names say about colour.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include "Failure.h"
#include "encode/ColorGuess.h"
#include "encode/EncodeInputs.h"
#include "encode/Manifest.h"

#include <set>

using namespace openntc_tests;
using namespace openntc;
using tool::ColorMeaning;

namespace {

std::set<std::string> GetProperties(const rapidjson::Value& schema) {
    std::set<std::string> names;
    for (const auto& member : schema["properties"].GetObject())
        names.insert(member.name.GetString());
    return names;
}

template <typename Names>
std::set<std::string> MakeSet(const Names& names) {
    return {names.begin(), names.end()};
}

float ManifestRamp(float u, float v, int c) {
    return c == 0 ? u : v;
}

} // namespace

TEST_CASE("the manifest's schema has the fields that the reader knows, and no others") {
    rapidjson::Document schema;
    schema.Parse(ReadText(fs::path(NTC_SCHEMA_DIR) / "manifest.schema.json").c_str());
    REQUIRE_FALSE(schema.HasParseError());
    CHECK(GetProperties(schema) == MakeSet(tool::GetManifestRootFields()));
    CHECK(GetProperties(schema["properties"]["textures"]["items"]) ==
          MakeSet(tool::GetManifestTextureFields()));
    const std::string page = ReadText(fs::path(NTC_SCHEMA_DIR) / "../docs/manifest.md");
    for (const auto& fields : {tool::GetManifestRootFields(), tool::GetManifestTextureFields()}) {
        for (const std::string_view field : fields) {
            CAPTURE(field);
            CHECK(page.find("`" + std::string(field) + "`") != std::string::npos);
        }
    }
}

TEST_CASE("reader and schema agree on what is a manifest") {
    const Folder folder;
    const std::vector<std::pair<bool, std::string>> manifests = {
        {true, R"({"textures":[{"fileName":"a.png"}]})"},
        {true, R"({"$schema":"x","width":8,"height":16384,"keepCoverage":0.5,"textures":[{"fileName":"a.png",
                   "name":"A","channelSwizzle":"BGR","firstChannel":15,"isSRGB":true,"bcFormat":"bc7","mipLevel":15,
                   "lossFunctionScale":[1,0.5],"verticalFlip":false,"semantics":{"Albedo":"RGB"}}]})"},
        {true, R"({"textures":[{"fileName":"a.png","bcFormat":"None","lossFunctionScale":0}]})"},
        {false, "[]"},
        {false, "{}"},
        {false, R"({"textures":[]})"},
        {false, R"({"textures":[{}]})"},
        {false, R"({"textures":[{"fileName":""}]})"},
        {false, R"({"textures":[7]})"},
        {false, R"({"Textures":[{"fileName":"a.png"}]})"},
        {false, R"({"textures":[{"fileName":"a.png"}],"width":0})"},
        {false, R"({"textures":[{"fileName":"a.png"}],"height":16385})"},
        {false, R"({"textures":[{"fileName":"a.png"}],"depth":1})"},
        {false, R"({"textures":[{"fileName":"a.png"}],"keepCoverage":0})"},
        {false, R"({"textures":[{"fileName":"a.png"}],"keepCoverage":1.5})"},
        {false, R"({"textures":[{"fileName":"a.png","isSrgb":true}]})"},
        {false, R"({"textures":[{"fileName":"a.png","srgb":true}]})"},
        {false, R"({"textures":[{"fileName":"a.png","isSRGB":1}]})"},
        {false, R"({"textures":[{"fileName":"a.png","channelSwizzle":"RX"}]})"},
        {false, R"({"textures":[{"fileName":"a.png","channelSwizzle":"RGBAR"}]})"},
        {false, R"({"textures":[{"fileName":"a.png","firstChannel":16}]})"},
        {false, R"({"textures":[{"fileName":"a.png","bcFormat":"BC8"}]})"},
        {false, R"({"textures":[{"fileName":"a.png","mipLevel":-1}]})"},
        {false, R"({"textures":[{"fileName":"a.png","lossFunctionScale":-1}]})"},
        {false, R"({"textures":[{"fileName":"a.png","lossFunctionScale":["x"]}]})"},
        {false, R"({"textures":[{"fileName":"a.png","semantics":{"Albedo":"RGBAR"}}]})"}};
    rapidjson::Document schemaText;
    schemaText.Parse(ReadText(fs::path(NTC_SCHEMA_DIR) / "manifest.schema.json").c_str());
    const rapidjson::SchemaDocument schema(schemaText);
    for (const auto& manifest : manifests) {
        const auto& [valid, text] = manifest;
        CAPTURE(manifest.second);
        rapidjson::Document document;
        document.Parse(text.c_str());
        REQUIRE_FALSE(document.HasParseError());
        rapidjson::SchemaValidator validator(schema);
        CHECK(document.Accept(validator) == valid);
        WriteText(folder / "m.json", text);
        bool read = true;
        try {
            tool::ReadManifest((folder / "m.json").string());
        } catch (const tool::CommandError& error) {
            read = false;
            CHECK(error.GetCode() == tool::ExitCode::BadInput);
        }
        CHECK(read == valid);
    }
}

TEST_CASE("a field that a manifest does not have is an error that names it and what was meant") {
    const Folder folder;
    WriteImage(folder / "a.png", MakeImage(8, 8, 3, ManifestRamp));
    WriteText(folder / "m.json", R"({"textures":[{"fileName":"a.png","isSrgb":true}]})");
    const ProgramResult result = RunProgram(folder, "encode m.json -o a.ntc --steps 2");
    CheckFails(result, 3);
    CHECK(result.errors == "ntc: m.json: textures[0].isSrgb: not a field of a manifest: isSRGB?\n");
    CHECK_FALSE(fs::exists(folder / "a.ntc"));
}

TEST_CASE("names of Unreal, Unity and Substance say what is colour") {
    for (const char* name : {"T_Wall_D",
                             "T_Wall_BC",
                             "wall_Color",
                             "wall_Col",
                             "wall_col_2k",
                             "wall_BaseColor",
                             "wallBaseColor",
                             "wall base color",
                             "Wall_Albedo",
                             "crate_AlbedoTransparency",
                             "T_Lamp_E",
                             "lamp_Emissive",
                             "lamp_Emission",
                             "x_Specular",
                             "x_SpecularSmoothness",
                             "T_Wall_D_01",
                             "albedo",
                             "Wall-Diffuse",
                             "oldalbedomap",
                             "wall.basemap",
                             "base_color",
                             "BaseColor",
                             "color"}) {
        CAPTURE(name);
        CHECK(tool::GuessColor(name).meaning == ColorMeaning::Color);
    }
    for (const char* name :
         {"T_Wall_N", "wall_Normal", "wall_normal_gl", "T_Wall_ORM", "T_Wall_MRAO", "wall_AO", "Roughness",
          "wall_Metallic", "crate_MetallicSmoothness", "wall_OcclusionRoughnessMetallic", "T_Wall_M",
          "T_Wall_R", "wall_Height", "wall_displacement", "Colorado_Normal", "leaf_Opacity", "wall_MaskMap",
          "diffuse_normal"}) {
        CAPTURE(name);
        CHECK(tool::GuessColor(name).meaning == ColorMeaning::Data);
    }
    for (const char* name : {"photo", "d", "bc", "wall", "", "0815", "colorado", "IMG_0001"}) {
        CAPTURE(name);
        CHECK(tool::GuessColor(name).meaning == ColorMeaning::Unknown);
    }
    CHECK(tool::GuessColor("T_Wall_D_01").reason == "by name: _D");
    CHECK(tool::GuessColor("wallBaseColor").reason == "by name: BaseColor");
    CHECK(tool::GuessColor("oldalbedomap").reason == "by name: albedo");
}

TEST_CASE("each image is explained; --srgb and --linear decide before names do") {
    const Folder folder;
    WriteImage(folder / "wall_D.png", MakeImage(8, 8, 3, ManifestRamp));
    WriteImage(folder / "photo.png", MakeImage(8, 8, 3, ManifestRamp));
    WriteImage(folder / "la.png", MakeImage(8, 8, 2, ManifestRamp));
    WriteImage(folder / "glow_E.hdr", MakeImage(8, 8, 3, ManifestRamp));
    const std::string images = "encode wall_D.png photo.png la.png glow_E.hdr -o a.ntc --steps 2 ";
    ProgramResult result = RunProgram(folder, images);
    REQUIRE(result.code == 0);
    CHECK(result.output.starts_with(
        "wall_D.png: 3 channels, sRGB (by name: _D)\n"
        "photo.png: 3 channels, Linear (no known name)\n"
        "la.png: 2 channels, Linear (no known name)\n"
        "  gray and alpha become the channels R and G; \"channelSwizzle\": \"RRRA\" in "
        "a manifest makes them colour with alpha\n"
        "glow_E.hdr: 3 channels, HLG (an image of floats)\n"));
    result = RunProgram(folder, images + "--json --quiet --srgb photo.png --linear wall_D --srgb la");
    REQUIRE(result.code == 0);
    const auto encoded = ParseValid(result.output, "encode");
    const auto& textures = encoded["textures"];
    REQUIRE(textures.Size() == 4);
    const std::vector<std::pair<std::string, std::string>> wanted = {
        {"Linear", "--linear"}, {"sRGB", "--srgb"}, {"sRGB", "--srgb"}, {"HLG", "an image of floats"}};
    for (rapidjson::SizeType i = 0; i < 4; ++i) {
        CHECK(textures[i]["colorSpace"].GetString() == wanted[i].first);
        CHECK(textures[i]["reason"].GetString() == wanted[i].second);
    }
    CHECK(textures[2].HasMember("hint"));
    WriteText(folder / "m.json", R"({"textures":[{"fileName":"wall_D.png"}]})");
    result = RunProgram(folder, "encode m.json -o a.ntc --steps 2");
    CHECK(result.output.find("Linear (the manifest has no isSRGB)") != std::string::npos);
}
