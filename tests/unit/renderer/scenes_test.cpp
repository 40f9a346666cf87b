// SPDX-License-Identifier: MIT
// Generated scenes, and which texture sets materials are given.
#include "TestModel.h"

#include "renderer/scene/SampleScene.h"
#include "renderer/scene/SceneBuilder.h"
#include "renderer/scene/TestScenes.h"
#include "renderer/scene/TextureSetLookup.h"
#include "renderer/shaders/Shading.h"

#include "Decoder.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

/// What everything that draws scenes relies on.
void CheckScene(const Scene& scene) {
    INFO(scene.name);
    REQUIRE(!scene.instances.empty());
    REQUIRE(*std::max_element(scene.indices.begin(), scene.indices.end()) < scene.vertices.size());
    for (const Primitive& primitive : scene.primitives) {
        CHECK(std::size_t{primitive.firstIndex} + primitive.indexCount <= scene.indices.size());
        CHECK(primitive.indexCount % 3 == 0);
        REQUIRE(static_cast<std::size_t>(primitive.material) < scene.materials.size());
        int wrong = 0;
        for (std::uint32_t i = 0; i < primitive.indexCount; i += 3) {
            const Vertex* corners[3];
            for (std::uint32_t k = 0; k < 3; ++k) {
                corners[k] = &scene.vertices[scene.indices[primitive.firstIndex + i + k]];
                const bool hasTangent = std::fabs(glm::length(glm::vec3(corners[k]->tangent)) - 1) <= 1e-4f;
                const bool hasNormal = std::fabs(glm::length(corners[k]->normal) - 1) <= 1e-4f;
                wrong += hasTangent != primitive.hasTangents || hasNormal != primitive.hasNormals ? 1 : 0;
            }
            const glm::vec3 front = glm::cross(corners[1]->position - corners[0]->position,
                                               corners[2]->position - corners[0]->position);
            wrong += primitive.hasNormals && glm::dot(front, corners[0]->normal) <= 0.0f ? 1 : 0;
        }
        CHECK(wrong == 0);
    }
    for (const Material& material : scene.materials) {
        for (const MaterialTexture& texture : material.textures)
            CHECK(texture.image < static_cast<int>(scene.images.size()));
    }
    for (const SourceImage& image : scene.images) {
        CHECK(image.error.empty());
        CHECK(image.texels.size() == static_cast<std::size_t>(image.width * image.height * 4));
    }
    REQUIRE(scene.cameras.size() == 1);
    for (const glm::vec3 corner : {scene.bounds.low, scene.bounds.high})
        CHECK((std::isfinite(corner.x) && std::isfinite(corner.y) && std::isfinite(corner.z)));
}

const MaterialTexture& GetTexture(const Scene& scene, std::size_t material, TextureSlot slot) {
    return scene.materials.at(material).textures[static_cast<std::size_t>(slot)];
}

} // namespace

TEST_CASE("renderer scenes: every generated one is well-formed") {
    std::set<std::string> names;
    for (const TestSceneInfo& info : GetTestScenes()) {
        CheckScene(MakeTestScene(info.name));
        CHECK(names.emplace(info.name).second);
        CHECK(!info.shows.empty());
    }
    CHECK(names.size() == 14);
    CHECK(MakeTestScene("none").instances.empty());
}

TEST_CASE("renderer scenes: what must look alike is alike in numbers") {
    const Scene a = MakeTestScene("spheres"), b = MakeTestScene("spheres-glossiness");
    REQUIRE(a.materials.size() == b.materials.size());
    for (std::size_t i = 0; i < a.materials.size(); ++i) {
        const Material &m = a.materials[i], &g = b.materials[i];
        const auto first = shader::NtcrMakeMetallicRoughness(glm::vec3(m.baseColorFactor), m.metallicFactor,
                                                             m.roughnessFactor);
        const auto second = shader::NtcrMakeSpecularGlossiness(glm::vec3(g.baseColorFactor), g.specularFactor,
                                                               g.glossinessFactor);
        CHECK(glm::length(first.diffuse - second.diffuse) <= 1e-6f);
        CHECK(glm::length(first.f0 - second.f0) <= 1e-6f);
        CHECK(std::fabs(first.roughness - second.roughness) <= 1e-6f);
    }
    // Every turned quad: the frame bends the normal map's normals to the same directions, by both kinds of frame.
    const Scene turned = MakeTestScene("turned");
    const SourceImage& dome =
        turned.images[static_cast<std::size_t>(GetTexture(turned, 0, TextureSlot::Normal).image)];
    for (const Instance& instance : turned.instances) {
        const Primitive& primitive = turned.primitives[static_cast<std::size_t>(instance.primitive)];
        for (std::uint32_t i = 0; i < primitive.indexCount; ++i) {
            const Vertex& vertex = turned.vertices[turned.indices[primitive.firstIndex + i]];
            // A quarter of the way from the middle to this corner the dome rises towards the middle.
            const glm::vec2 uv = glm::vec2(0.5f) + 0.25f * (vertex.uv[0] - glm::vec2(0.5f));
            const auto texel =
                static_cast<std::size_t>(static_cast<int>(uv.y * 64) * 64 + static_cast<int>(uv.x * 64));
            glm::vec3 color;
            for (int c = 0; c < 3; ++c)
                color[c] = static_cast<float>(dome.texels[texel * 4 + static_cast<std::size_t>(c)]) / 255;
            const glm::vec3 n =
                shader::NtcrBendByTangents(shader::NtcrUnpackNormal(color, 1), vertex.normal, vertex.tangent);
            const glm::vec2 out = glm::normalize(glm::vec2(vertex.position));
            // Half a texel of 12 from the middle is off the diagonal at most: 5 degrees.
            CHECK(glm::dot(glm::normalize(glm::vec2(n)), out) >= 0.996f);
        }
    }
    const Scene mirrored = MakeTestScene("mirrored");
    REQUIRE(mirrored.instances.size() == 3);
    CHECK(mirrored.instances[1].flipped);
    CHECK(!mirrored.instances[2].flipped);
}

TEST_CASE("renderer scenes: the sample's images are what its texture sets decode to") {
    const Scene scene = MakeSampleScene();
    CheckScene(scene);
    REQUIRE(scene.textureSets.size() == 2);
    for (const std::string& warning : scene.warnings)
        FAIL_CHECK(warning);
    struct Slot {
        TextureSlot slot;
        int channels[4]; ///< of the image, in the order of the set
        double psnr;     ///< that the encoder reached, less some
    };
    const Slot slots[] = {{TextureSlot::BaseColor, {0, 1, 2, 3}, 35},
                          {TextureSlot::MetallicRoughness, {2, 1, -1, -1}, 35},
                          {TextureSlot::Normal, {0, 1, 2, -1}, 32},
                          {TextureSlot::Occlusion, {0, -1, -1, -1}, 31}};
    for (std::size_t material = 0; material < 2; ++material) {
        const int index = GetTexture(scene, material, TextureSlot::BaseColor).textureSet;
        REQUIRE(index >= 0);
        tool::TextureSet set = tool::LoadTextureSet(scene.textureSets[static_cast<std::size_t>(index)].path);
        const tool::DecodeData data = tool::LoadDecodeData(set);
        auto decoder = tool::MakeDecoder(data, {});
        REQUIRE(decoder.has_value());
        const Rect rect{64, 96, 64, 64};
        std::vector<float> outputs(64 * 64 * 16);
        REQUIRE((*decoder)->Decode(0, rect, {}, outputs).has_value());
        for (const Slot& slot : slots) {
            const MaterialTexture& texture = GetTexture(scene, material, slot.slot);
            REQUIRE(texture.textureSet == index);
            const SourceImage& image = scene.images[static_cast<std::size_t>(texture.image)];
            double sum = 0;
            for (std::size_t i = 0; i < 64 * 64; ++i) {
                const std::size_t x = 64 + i % 64, y = 96 + i / 64;
                for (int c = 0; c < texture.channels; ++c) {
                    const double own =
                        image.texels[(y * 256 + x) * 4 + static_cast<std::size_t>(slot.channels[c])] / 255.0;
                    // A mask's 0 and 1 are encoded beyond the range.
                    const auto channel = static_cast<std::size_t>(texture.firstChannel + c);
                    const float value = std::clamp(outputs[i * 16 + channel], 0.0f, 1.0f);
                    const double error = static_cast<double>(value) - own;
                    sum += error * error;
                }
            }
            const double psnr = -10 * std::log10(sum / (64 * 64 * texture.channels) + 1e-12);
            MESSAGE("measure: " << scene.materials[material].name << " slot " << static_cast<int>(slot.slot)
                                << ": " << psnr << " dB");
            CHECK(psnr >= slot.psnr);
        }
    }
    // Light above 1 stays above 1.
    const SourceImage& emission =
        scene.images[static_cast<std::size_t>(GetTexture(scene, 1, TextureSlot::Emissive).image)];
    CHECK(*std::max_element(emission.radiance.begin(), emission.radiance.end()) > 4.0f);
    CHECK(emission.radiance.size() == 256 * 256 * 3);
    CHECK(MakeSampleScene("/nowhere").textureSets.at(0).error.size() > 0);
}

TEST_CASE("renderer models: texture sets by materials.json and by name, missing and broken ones") {
    const std::string set = [] {
        const Scene sample = MakeSampleScene();
        std::ifstream file(sample.textureSets.at(0).path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    }();
    const ModelFolder folder;
    folder.WriteImage("a.png", 1, 1, {1, 2, 3, 4});
    ModelData data;
    const int position = data.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0}, 3);
    const auto load = [&](const std::string& occlusion, const std::string& materialDir = {}) {
        folder.Write(
            "model.glb",
            data.MakeGlb(R"("meshes":[{"primitives":[{"attributes":{"POSITION":)" + std::to_string(position) +
                         R"(}}]}],"nodes":[{"mesh":0}],"images":[{"uri":"a.png"}],"textures":[{"source":0}],)"
                         R"("materials":[{"name":"stone wall","pbrMetallicRoughness":{"baseColorTexture":)"
                         R"({"index":0},"metallicRoughnessTexture":{"index":0}},"normalTexture":{"index":0},)"
                         R"("occlusionTexture":{"index":0)" +
                         occlusion + R"(},"emissiveTexture":{"index":0}}])"));
        GltfSceneOptions options;
        if (!materialDir.empty())
            options.materialDir = folder.GetPath(materialDir);
        return LoadGltfScene(folder.GetPath("model.glb"), options);
    };
    CHECK(load("").textureSets.empty());

    folder.Write("stone_wall.ntc", set); // as convert-gltf names files
    Scene scene = load("");
    REQUIRE(scene.textureSets.size() == 1);
    CHECK(scene.textureSets[0].error.empty());
    CHECK(GetTexture(scene, 0, TextureSlot::BaseColor).firstChannel == 0);
    CHECK(GetTexture(scene, 0, TextureSlot::MetallicRoughness).firstChannel == 4);
    CHECK(GetTexture(scene, 0, TextureSlot::Occlusion).firstChannel == 11);
    CHECK(GetTexture(scene, 0, TextureSlot::Occlusion).channels == 1);
    CHECK(GetTexture(scene, 0, TextureSlot::Emissive).textureSet == -1); // the set has none
    CHECK(GetTexture(scene, 0, TextureSlot::Transmission).textureSet == -1);
    CHECK(scene.warnings.empty());

    // What is addressed differently cannot come from one lookup.
    scene = load(",\"texCoord\":1");
    CHECK(GetTexture(scene, 0, TextureSlot::Normal).textureSet == 0);
    CHECK(GetTexture(scene, 0, TextureSlot::Occlusion).textureSet == -1);
    REQUIRE(scene.warnings.size() == 1);
    CHECK(scene.warnings[0].find("addressed differently") != std::string::npos);

    folder.Write("stone_wall.ntc", set.substr(0, set.size() / 2));
    scene = load("");
    REQUIRE(scene.textureSets.size() == 1);
    CHECK(!scene.textureSets[0].error.empty());
    CHECK(GetTexture(scene, 0, TextureSlot::BaseColor).textureSet == -1);
    CHECK(scene.warnings.size() == 1);

    // A list wins over names. Its entries may be malformed, of another model, or name what is not there.
    const auto list = [&](const std::string& textures, const std::string& name = "stone wall") {
        folder.Write("sets/materials.json",
                     R"({"materials":[{"name":")" + name + R"(","textures":[)" + textures + "]}]}");
        return load("", "sets");
    };
    const auto entry = [](const std::string& name, const std::string& file, int first, int channels) {
        return R"({"name":")" + name + R"(","file":)" + file + R"(,"firstChannel":)" + std::to_string(first) +
               R"(,"channels":)" + std::to_string(channels) + "}";
    };
    folder.Write("sets/x.ntc", set);
    scene = list(entry("Normal", "\"x.ntc\"", 8, 3) + "," + entry("Occlusion", "null", 11, 1) + "," +
                 entry("Emissive", "\"x.ntc\"", 12, 3) + ",3," + entry("Normal", "\"x.ntc\"", 99, 3));
    CHECK(GetTexture(scene, 0, TextureSlot::Normal).firstChannel == 8);
    CHECK(GetTexture(scene, 0, TextureSlot::Occlusion).textureSet == -1);
    CHECK(GetTexture(scene, 0, TextureSlot::Emissive).textureSet == -1); // no such channels in the set
    CHECK(scene.warnings.size() == 2); // emission; the entry of channel 99. 3 has no file
    scene = list(entry("Normal", "\"y.ntc\"", 8, 3));
    CHECK(GetTexture(scene, 0, TextureSlot::Normal).textureSet == -1);
    CHECK(!scene.textureSets.at(0).error.empty());
    scene = list(entry("Normal", "\"/x.ntc\"", 8, 3));
    CHECK(scene.warnings.at(0) == "materials.json: /x.ntc: must be a relative path");
    scene = list(entry("Normal", "\"x.ntc\"", 8, 3), "of another model");
    CHECK(scene.textureSets.empty());
    folder.Write("sets/materials.json", "[");
    CHECK(load("", "sets").warnings.at(0).find("the list is ignored") != std::string::npos);
}
