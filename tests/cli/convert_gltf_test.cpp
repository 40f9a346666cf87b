// SPDX-License-Identifier: MIT
// `ntc convert-gltf`: channels, shared files, what a second run keeps, and hostile models.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <cstdlib>
#include <set>
#include <tuple>
#include <utility>

using namespace openntc_tests;

namespace {

float Pattern(float u, float v, int c) {
    return c == 0 ? u : c == 1 ? v : 0.5f * (u + v);
}

// Two materials with equal images, one with alpha mask and specular-glossiness, one without images.
constexpr const char* kModel = R"({"asset":{"version":"2.0"},
  "images":[{"uri":"base%20color.png"},{"uri":"orm.png"},{"uri":"leaf.png"}],
  "textures":[{"source":0},{"source":1},{"source":2}],
  "materials":[
    {"name":"Wall","pbrMetallicRoughness":{"baseColorTexture":{"index":0},
      "metallicRoughnessTexture":{"index":1}},"normalTexture":{"index":1},"occlusionTexture":{"index":1},
      "emissiveTexture":{"index":0},"extensions":{"KHR_materials_transmission":{"transmissionTexture":{"index":1}}}},
    {"name":"../Wall","pbrMetallicRoughness":{"baseColorTexture":{"index":0},
      "metallicRoughnessTexture":{"index":1}},"normalTexture":{"index":1},"occlusionTexture":{"index":1},
      "emissiveTexture":{"index":0},"extensions":{"KHR_materials_transmission":{"transmissionTexture":{"index":1}}}},
    {"alphaMode":"MASK","extensions":{"KHR_materials_pbrSpecularGlossiness":{"diffuseTexture":{"index":2},
      "specularGlossinessTexture":{"index":2}}}},
    {"name":"Plain"}]})";

const std::string kConvert = "convert-gltf model.gltf -o out --steps 3 --bits-per-pixel 1 --json";

} // namespace

TEST_CASE("materials become files at fixed channels; a second run encodes only what changed") {
    const Folder folder;
    WriteText(folder / "model.gltf", kModel);
    WriteImage(folder / "base color.png", MakeImage(16, 16, 4, Pattern));
    WriteImage(folder / "orm.png", MakeImage(16, 16, 3, Pattern));
    WriteImage(folder / "leaf.png", MakeImage(16, 16, 4, Pattern));
    ProgramResult result = RunProgram(folder, kConvert + " --jobs 2");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    auto list = ParseValid(result.output, "materials");
    ParseValid(ReadText(folder / "out/materials.json"), "materials");
    REQUIRE(list["materials"].Size() == 4);
    REQUIRE(list["files"].Size() == 2);
    const std::pair<unsigned, std::string> files[] = {{6, "Wall.ntc"}, {6, "Wall.ntc"}, {2, "material2.ntc"}};
    for (unsigned i = 0; i < 3; ++i) {
        REQUIRE(list["materials"][i]["textures"].Size() == files[i].first);
        for (const auto& texture : list["materials"][i]["textures"].GetArray())
            CHECK(texture["file"].GetString() == files[i].second);
    }
    CHECK(list["materials"][3]["textures"].Empty());

    const auto wall = ParseValid(RunProgram(folder, "info --json out/Wall.ntc").output, "info");
    const auto& textures = wall["textures"];
    const std::vector<std::tuple<std::string, int, int, std::string>> expected = {
        {"BaseColor", 0, 3, "sRGB"}, {"MetallicRoughness", 4, 2, "Linear"},
        {"Normal", 8, 3, "Linear"},  {"Occlusion", 11, 1, "Linear"},
        {"Emissive", 12, 3, "sRGB"}, {"Transmission", 15, 1, "Linear"}};
    REQUIRE(textures.Size() == expected.size());
    for (unsigned i = 0; i < expected.size(); ++i) {
        const auto& [name, first, count, space] = expected[i];
        CHECK(textures[i]["name"].GetString() == name);
        CHECK(textures[i]["firstChannel"].GetInt() == first);
        CHECK(textures[i]["numChannels"].GetInt() == count);
        CHECK(textures[i]["rgbColorSpace"].GetString() == space);
    }

    const std::string first = ReadText(folder / "out/material2.ntc");
    list = ParseValid(RunProgram(folder, kConvert).output, "materials");
    CHECK(list["files"][0]["kept"].GetBool());
    CHECK(list["files"][1]["kept"].GetBool());
    WriteImage(folder / "orm.png",
               MakeImage(16, 16, 3, [](float u, float v, int c) { return Pattern(v, u, c); }));
    list = ParseValid(RunProgram(folder, kConvert).output, "materials");
    CHECK_FALSE(list["files"][0]["kept"].GetBool());
    CHECK(list["files"][1]["kept"].GetBool());
    list = ParseValid(RunProgram(folder, kConvert + " --seed 2").output, "materials");
    CHECK_FALSE(list["files"][1]["kept"].GetBool());
    CHECK(ReadText(folder / "out/material2.ntc") != first);
    list = ParseValid(RunProgram(folder, kConvert + " --seed 3 --skip-existing").output, "materials");
    CHECK(list["files"][1]["kept"].GetBool());
}

TEST_CASE("an interrupt keeps finished files and leaves nothing of the others; the same command goes on") {
    // Constant images need no training and are finished at once; the other material never is.
    const Folder folder;
    WriteText(folder / "model.gltf", R"({"asset":{"version":"2.0"},
        "images":[{"uri":"flat.png"},{"uri":"wave.png"}],"textures":[{"source":0},{"source":1}],
        "materials":[{"name":"Flat","normalTexture":{"index":0}},{"name":"Wave","normalTexture":{"index":1}}]})");
    WriteImage(folder / "flat.png", MakeImage(8, 8, 3, [](float, float, int) { return 0.5f; }));
    WriteImage(folder / "wave.png", MakeImage(16, 16, 3, Pattern));
    for (const bool again : {false, true}) {
        CAPTURE(again);
        const ProgramResult result = RunProgram(
            folder,
            "--version >/dev/null; " + SignalAfter(2) +
                "'" NTC_PROGRAM
                "' convert-gltf model.gltf -o out --steps 1000000000 --bits-per-pixel 1 --threads 1 --quiet");
        INFO(result.errors);
        CHECK(result.code == 1);
        CHECK(result.errors.find("interrupted") != std::string::npos);
        CHECK(result.errors.find("--resume") == std::string::npos); // convert-gltf has no such option
        const auto list = ParseValid(ReadText(folder / "out/materials.json"), "materials");
        REQUIRE(list["files"].Size() == 1);
        CHECK(list["files"][0]["file"].GetString() == std::string("Flat.ntc"));
        CHECK(list["files"][0]["kept"].GetBool() == again);
        CHECK(list["materials"][1]["textures"][0]["file"].IsNull());
        std::set<std::string> found;
        for (const auto& entry : fs::directory_iterator(folder / "out"))
            found.insert(entry.path().filename().string());
        CHECK(found == std::set<std::string>{"Flat.ntc", "materials.json"});
    }
    CHECK(RunProgram(folder, "validate out/Flat.ntc").code == 0);
}

TEST_CASE("broken and hostile models: exit 3, one line, no files") {
    const Folder folder;
    const std::string head = R"({"asset":{"version":"2.0"},)";
    const std::string material = R"("materials":[{"normalTexture":{"index":0}}],)";
    for (const std::string& model :
         {std::string(), std::string("{"), std::string("[]"), std::string("glTF\x02"),
          std::string(100000, '['), std::string(R"({"asset":{"version":"1.0"},"materials":[{}]})"),
          head + R"("materials":{}})", head + R"("materials":[3]})", head + R"("materials":[{"name":3}]})",
          head + R"("materials":[{"normalTexture":[]}]})", head + material + R"("textures":[]})",
          head + R"("materials":[{"normalTexture":{"index":-1}}]})",
          head + R"("materials":[{"normalTexture":{"index":4294967296}}],"textures":[{}]})",
          head + material + R"("textures":[{"source":7}],"images":[{}]})",
          head + material + R"("textures":[{"source":0}],"images":[{}]})",
          head + material + R"("textures":[{"source":0}],"images":[{"uri":"/etc/hostname"}]})",
          head + material + R"("textures":[{"source":0}],"images":[{"uri":"http://a/b.png"}]})",
          head + material + R"("textures":[{"source":0}],"images":[{"uri":"data:image/png;base64,AAAA"}]})",
          head + material + R"("textures":[{"source":0}],"images":[{"uri":"missing\n.png"}]})"}) {
        CAPTURE(model.substr(0, 200));
        WriteText(folder / "model.gltf", model);
        const ProgramResult result = RunProgram(folder, kConvert);
        CAPTURE(result.errors);
        CheckFails(result, 3);
    }
    CheckFails(RunProgram(folder, "convert-gltf missing.gltf -o out"), 3);
}

TEST_CASE("the materials of FlightHelmet are found") {
    const char* variable = std::getenv("OPENNTC_SHARED_DIR");
    const std::string shared = variable != nullptr ? variable : OPENNTC_DEFAULT_SHARED_DIR;
    const fs::path model = fs::path(shared) / "assets/FlightHelmet/FlightHelmet.gltf";
    if (shared.empty() || !fs::exists(model)) {
        MESSAGE("SKIP: no FlightHelmet model");
        return;
    }
    const Folder folder;
    const ProgramResult result =
        RunProgram(folder, "convert-gltf '" + model.string() + "' -o out --steps 1 --mips 1 --json --quiet");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto list = ParseValid(result.output, "materials");
    CHECK(list["materials"].Size() == 6);
    CHECK(list["files"].Size() == 5); // HoseMat and RubberWoodMat have equal images
}
