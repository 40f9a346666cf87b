// SPDX-License-Identifier: MIT
// `ntc convert-gltf`: textures that are addressed differently are never in one file, and the list says how each is.
#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <set>
#include <string>
#include <vector>

using namespace openntc_tests;

namespace {

// Constant images need no training.
const std::string kConvertAddressed =
    "convert-gltf model.gltf -o out --steps 1 --bits-per-pixel 1 --mips 1 --json --quiet";

/// A model with three samplers (clamped, repeating, nearest) and two images; texture i has image i % 2 and sampler i / 2;
/// textures 6 and 7 have no sampler.
std::string MakeAddressedModel(const std::string& material, const std::string& more = "") {
    return R"({"asset":{"version":"2.0"},"images":[{"uri":"a.png"},{"uri":"b.png"}],
        "samplers":[{"wrapS":33071,"wrapT":33071},{"wrapS":10497,"magFilter":9729,"minFilter":9987},{"magFilter":9728}],
        "textures":[{"source":0,"sampler":0},{"source":1,"sampler":0},{"source":0,"sampler":1},
        {"source":1,"sampler":1},{"source":0,"sampler":2},{"source":1,"sampler":2},{"source":0},{"source":1}],)" +
           more + R"("materials":[{"name":"m",)" + material + "}]}";
}

std::string MakePair(const std::string& color, const std::string& normal) {
    return R"("pbrMetallicRoughness":{"baseColorTexture":{)" + color + R"(}},"normalTexture":{)" + normal +
           "}";
}

void WriteTwoImages(const Folder& folder) {
    WriteImage(folder / "a.png", MakeImage(8, 8, 3, [](float, float, int) { return 0.25f; }));
    WriteImage(folder / "b.png", MakeImage(8, 8, 3, [](float, float, int) { return 0.75f; }));
}

} // namespace

TEST_CASE("textures share a file exactly when uv set, transform and sampler are the same") {
    struct Case {
        std::string color, normal;
        const char* difference; ///< empty: none
        const char* more = "";
    };
    const std::string transform = R"("extensions":{"KHR_texture_transform":{)";
    const char* animation =
        R"("animations":[{"channels":[{"sampler":0,"target":{"path":"pointer","extensions":
        {"KHR_animation_pointer":{"pointer":
        "/materials/0/normalTexture/extensions/KHR_texture_transform/offset"}}}}],"samplers":[{}]}],)";
    const char* both = R"("animations":[3,{"channels":[{"sampler":0,"target":{"extensions":
        {"KHR_animation_pointer":{"pointer":
        "/materials/0/normalTexture/extensions/KHR_texture_transform/scale"}}}},
        {"sampler":0,"target":{"extensions":{"KHR_animation_pointer":{"pointer":
        "/materials/0/pbrMetallicRoughness/baseColorTexture/extensions/KHR_texture_transform/scale"}}}}]}],)";
    const std::vector<Case> cases = {
        {R"("index":6)", R"("index":7)", ""},
        {R"("index":0)", R"("index":1)", ""},
        {R"("index":2)", R"("index":7)", ""}, // what a sampler leaves out is repeating and linear
        {R"("index":6,"texCoord":0)", R"("index":7)", ""},
        {R"("index":6,)" + transform + R"("offset":[0,0],"scale":[1.0,1]}})", R"("index":7)", ""},
        {R"("index":6,)" + transform + R"("texCoord":2}})", R"("index":7,"texCoord":2)", ""},
        {R"("index":6,)" + transform + R"("rotation":0.5}})",
         R"("index":7,)" + transform + R"("rotation":0.5}})", ""},
        {R"("index":6)", R"("index":7)", "", both},
        {R"("index":6)", R"("index":7,"texCoord":1)", "texCoord 1 instead of 0"},
        {R"("index":6,"texCoord":1)", R"("index":7,"texCoord":1,)" + transform + R"("texCoord":0}})",
         "texCoord 0 instead of 1"},
        {R"("index":0)", R"("index":3)",
         "wrapS REPEAT instead of CLAMP_TO_EDGE, wrapT REPEAT instead of CLAMP_TO_EDGE"},
        {R"("index":4)", R"("index":7)", "magFilter LINEAR instead of NEAREST"},
        {R"("index":6,)" + transform + R"("offset":[0.5,0]}})", R"("index":7)",
         "transform offset 0 0, rotation 0, scale 1 1 instead of offset 0.5 0, rotation 0, scale 1 1"},
        {R"("index":6)", R"("index":7,)" + transform + R"("scale":[2,3]}})", "scale 2 3 instead of"},
        {R"("index":6)", R"("index":7,)" + transform + R"("rotation":1}})", "rotation 1"},
        {R"("index":6)", R"("index":7)", "an animation of the transform", animation},
    };
    const Folder folder;
    WriteTwoImages(folder);
    for (const Case& c : cases) {
        const bool differs = c.difference[0] != '\0';
        CAPTURE(c.color);
        CAPTURE(c.normal);
        WriteText(folder / "model.gltf", MakeAddressedModel(MakePair(c.color, c.normal), c.more));
        fs::remove_all(folder / "out");
        const ProgramResult result = RunProgram(folder, kConvertAddressed);
        CAPTURE(result.errors);
        REQUIRE(result.code == 0);
        const auto list = ParseValid(result.output, "materials");
        const auto& textures = list["materials"][0]["textures"];
        REQUIRE(textures.Size() == 2);
        CHECK(textures[0]["file"].GetString() == std::string("m.ntc"));
        CHECK(textures[1]["file"].GetString() == std::string(differs ? "m_Normal.ntc" : "m.ntc"));
        CHECK(list["files"].Size() == (differs ? 2u : 1u));
        for (unsigned i = 0; i < 2; ++i) {
            const std::string file = std::string("info --json out/") + textures[i]["file"].GetString();
            const auto info = ParseValid(RunProgram(folder, file).output, "info");
            CHECK(info["textures"].Size() == (differs ? 1u : 2u));
        }
        CHECK((result.errors.find("normalTexture: ") != std::string::npos) == (differs || c.more == both));
        CHECK(result.errors.find(c.difference) != std::string::npos);
        std::istringstream lines(result.errors);
        for (std::string line; std::getline(lines, line);)
            ParseValid(line, "encode-event");

        const ProgramResult strict = RunProgram(folder, kConvertAddressed + " --strict");
        if (!differs) {
            CHECK(strict.code == 0);
            continue;
        }
        CHECK(strict.code == 1);
        CHECK(strict.output.empty());
        CHECK(strict.errors.find("ntc: model.gltf: materials[0].normalTexture: ") != std::string::npos);
        CHECK(strict.errors.find(": cannot share a file with BaseColor") != std::string::npos);
    }
}

TEST_CASE("the list says how each texture is addressed") {
    const Folder folder;
    WriteTwoImages(folder);
    WriteText(folder / "model.gltf",
              MakeAddressedModel(R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0}},
        "normalTexture":{"index":1},"occlusionTexture":{"index":5,"texCoord":1,"extensions":
        {"KHR_texture_transform":{"offset":[0.5,0.25],"rotation":1.5,"scale":[2,-3]}}},
        "emissiveTexture":{"index":6})"));
    const ProgramResult result = RunProgram(folder, kConvertAddressed);
    CAPTURE(result.errors);
    REQUIRE(result.code == 0);
    const auto list = ParseValid(result.output, "materials");
    const auto& textures = list["materials"][0]["textures"];
    REQUIRE(textures.Size() == 4);
    // Equal addressing shares a file also past a texture that differs; later groups are named by their first texture.
    CHECK(textures[0]["file"].GetString() == std::string("m.ntc"));
    CHECK(textures[1]["file"].GetString() == std::string("m.ntc"));
    CHECK(textures[2]["file"].GetString() == std::string("m_Occlusion.ntc"));
    CHECK(textures[3]["file"].GetString() == std::string("m_Emissive.ntc"));
    CHECK(textures[0]["sampler"]["wrapS"].GetString() == std::string("CLAMP_TO_EDGE"));
    CHECK(textures[0]["sampler"]["magFilter"].IsNull());
    CHECK_FALSE(textures[0].HasMember("transform"));
    CHECK(textures[2]["texCoord"].GetInt() == 1);
    CHECK(textures[2]["sampler"]["wrapT"].GetString() == std::string("REPEAT"));
    CHECK(textures[2]["sampler"]["magFilter"].GetString() == std::string("NEAREST"));
    const auto& transform = textures[2]["transform"];
    CHECK(transform["offset"][0].GetDouble() == 0.5);
    CHECK(transform["offset"][1].GetDouble() == 0.25);
    CHECK(transform["rotation"].GetDouble() == 1.5);
    CHECK(transform["scale"][1].GetDouble() == -3.0);
    CHECK_FALSE(transform["animated"].GetBool());
    // Channels do not depend on the file.
    CHECK(textures[2]["firstChannel"].GetInt() == 11);
    CHECK(textures[3]["firstChannel"].GetInt() == 12);
}

TEST_CASE("addressing that makes no sense is an error of its material") {
    const Folder folder;
    WriteTwoImages(folder);
    const std::string transform = R"("index":6,"extensions":{"KHR_texture_transform":{)";
    for (const std::string& texture :
         {std::string(R"("index":6,"texCoord":-1)"), std::string(R"("index":6,"texCoord":"1")"),
          transform + R"("offset":[1]}})", transform + R"("offset":1}})", transform + R"("rotation":[0]}})",
          transform + R"("scale":["1",1]}})", transform + R"("texCoord":1.5}})",
          std::string(R"("index":6,"extensions":[])")}) {
        CAPTURE(texture);
        WriteText(folder / "model.gltf", MakeAddressedModel("\"normalTexture\":{" + texture + "}"));
        const ProgramResult result = RunProgram(folder, kConvertAddressed);
        CAPTURE(result.errors);
        CheckFails(result, 3);
        CHECK(result.errors.find("materials[0].normalTexture.") != std::string::npos);
    }
    for (const char* sampler : {R"({"wrapS":3})", R"({"magFilter":9987})", R"({"minFilter":"9729"})", "3"}) {
        CAPTURE(sampler);
        WriteText(
            folder / "model.gltf",
            std::string(R"({"asset":{"version":"2.0"},"images":[{"uri":"a.png"}],"samplers":[)") + sampler +
                R"(],"textures":[{"source":0,"sampler":0}],"materials":[{"normalTexture":{"index":0}}]})");
        CheckFails(RunProgram(folder, kConvertAddressed), 3);
    }
}
