// SPDX-License-Identifier: MIT
// glTF scenes: nodes, cameras, materials, images, and FlightHelmet where it is there.
#include "TestModel.h"

#include "renderer/scene/Cameras.h"
#include "renderer/scene/Tangents.h"
#include "support/Files.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>
#include <string>
#include <vector>

using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

/// A quad and its JSON: a mesh with material 0 if `hasMaterial`.
struct Quad {
    ModelData data;
    std::string mesh;

    explicit Quad(bool hasMaterial = false) {
        const int position = data.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 3);
        const int uv = data.AddFloats({0, 1, 1, 1, 0, 0, 1, 0}, 2);
        mesh = R"("meshes":[{"primitives":[{"mode":5,"attributes":{"POSITION":)" + std::to_string(position) +
               R"(,"TEXCOORD_0":)" + std::to_string(uv) + "}" + (hasMaterial ? R"(,"material":0)" : "") +
               "}]}]";
    }
    std::string Make(const std::string& json) const { return data.MakeGlb(mesh + "," + json); }
};

bool IsNear(glm::vec4 a, glm::vec4 b, float tolerance = 1e-5f) {
    return glm::length(a - b) <= tolerance;
}

const Material& LoadMaterial(const ModelFolder& folder, Scene& scene, const std::string& material,
                             const std::string& more = "") {
    folder.Write("m.glb", Quad(true).Make(R"("nodes":[{"mesh":0}],"materials":[)" + material + "]" + more));
    scene = LoadGltfScene(folder.GetPath("m.glb"));
    return scene.materials.at(0);
}

} // namespace

TEST_CASE("renderer models: nested nodes, as matrices and as translation, rotation and scale") {
    const std::string half = std::to_string(std::sqrt(0.5));
    const Scene scene = LoadModel(
        Quad().Make(R"("nodes":[{"children":[1,2],"translation":[1,2,3],"scale":[2,2,2]},)"
                    R"({"mesh":0,"rotation":[0,0,)" +
                    half + "," + half +
                    R"(]},)"
                    R"({"matrix":[-1,0,0,0,0,1,0,0,0,0,1,0,5,0,0,1],"children":[3]},{"mesh":0},{"mesh":0}],)"
                    R"("scenes":[{"nodes":[4]},{"nodes":[0]}],"scene":1)"));
    REQUIRE(scene.instances.size() == 2);
    // Rotated by 90° about z, scaled, moved: x goes to y.
    CHECK(IsNear(scene.instances[0].toWorld * glm::vec4(1, 0, 0, 1), glm::vec4(1, 4, 3, 1)));
    CHECK(!scene.instances[0].flipped);
    CHECK(IsNear(scene.instances[1].toWorld * glm::vec4(1, 0, 0, 1), glm::vec4(1 + 2 * 4, 2, 3, 1)));
    CHECK(scene.instances[1].flipped);
    GltfSceneOptions options;
    options.scene = 0;
    const std::string two = Quad().Make(R"("nodes":[{"mesh":0},{"mesh":0,"translation":[1,1,1]}],)"
                                        R"("scenes":[{"nodes":[1]},{"nodes":[0,1]}],"scene":1)");
    CHECK(LoadModel(two, options).instances.size() == 1);
    CHECK(LoadModel(two).instances.size() == 2);
    options.scene = 2;
    CHECK_THROWS_WITH(LoadModel(two, options), "scenes: 2: there are 2");
    // Without scenes, nodes that are no one's child.
    CHECK(LoadModel(Quad().Make(R"("nodes":[{"mesh":0},{"children":[0]}])")).instances.size() == 1);
    CHECK(LoadModel(Quad().Make(R"("nodes":[{}])")).warnings.back() == "the scene draws nothing");
}

TEST_CASE("renderer models: hostile nodes, cameras and materials") {
    struct Case {
        const char *json, *error;
    };
    const Case cases[] = {
        {R"("nodes":[{"children":[0]}],"scenes":[{"nodes":[0]}])",
         "nodes[0]: reached twice: nodes are trees"},
        {R"("nodes":[{"children":[1]},{"children":[0]}],"scenes":[{"nodes":[0]}])",
         "nodes[0]: reached twice"},
        {R"("nodes":[{"mesh":0},{"children":[0]},{"children":[0]}])", "nodes[0]: reached twice"},
        {R"("nodes":[{"mesh":1}])", "nodes[0].mesh: must be an index below the 1 meshes"},
        {R"("nodes":[{"children":[9]}])", "nodes[0].children: must be indices below the 1 nodes"},
        {R"("nodes":[{"children":3}])", "nodes[0].children: must be an array"},
        {R"("nodes":[3])", "nodes[0]: must be an object"},
        {R"("nodes":[{"scale":[1,2]}])", "nodes[0].scale: must be 3 numbers"},
        {R"("nodes":[{"scale":[1,"a",2]}])", "nodes[0].scale: must be a number"},
        {R"("nodes":[{"scale":[1e200,1,1]}])", "nodes[0].scale: 1e+200: too large for binary32"},
        {R"("nodes":[{"scale":[1e30,1,1],"children":[1]},{"scale":[1e30,1,1]}])",
         "nodes[1]: its transform is too large for binary32"},
        {R"("nodes":[{"scale":[1e30,1,1],"mesh":0}])", "nodes[0]: its mesh reaches beyond 1e+18"},
        {R"("nodes":[{"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}])",
         "nodes[0].matrix: the last row must be 0 0 0 1"},
        {R"("nodes":[{"camera":0}],"cameras":[{"type":"wide"}])",
         "cameras[0].type: wide: perspective or orthographic"},
        {R"("nodes":[{"camera":0}],"cameras":[{"type":"perspective","perspective":{"yfov":0,"znear":1}}])",
         "cameras[0].perspective.yfov: 0: 0.001 to 3.14"},
        {R"("nodes":[{"camera":0}],"cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":1,"zfar":1}}])",
         "cameras[0].perspective.zfar: 1: "},
        {R"("nodes":[{"camera":0}],"cameras":[{"type":"perspective"}])",
         "cameras[0].perspective: yfov and znear are"},
        {R"("nodes":[{"camera":0}],"cameras":[{"type":"orthographic","orthographic":{"xmag":1,"zfar":1,"znear":0}}])",
         "cameras[0].orthographic.ymag: missing"},
        {R"("nodes":[],"materials":[{"pbrMetallicRoughness":{"roughnessFactor":2}}])",
         "materials[0].pbrMetallicRoughness.roughnessFactor: 2: 0 to 1"},
        {R"("nodes":[],"materials":[{"alphaMode":"GLOW"}])",
         "materials[0].alphaMode: GLOW: OPAQUE, MASK or BLEND"},
        {R"("nodes":[],"materials":[{"emissiveFactor":[1]}])",
         "materials[0].emissiveFactor: must be 3 numbers"},
        {R"("nodes":[],"materials":[{"doubleSided":1}])", "materials[0].doubleSided: must be true or false"},
        {R"("nodes":[],"materials":[3])", "materials[0]: must be an object"},
        {R"("extensionsRequired":["KHR_draco_mesh_compression"],"nodes":[])",
         "extensionsRequired: KHR_draco_mesh_compression: not drawn"},
    };
    for (const Case& hostile : cases) {
        const std::string error = GetModelError(Quad().Make(hostile.json));
        CHECK_MESSAGE(error.compare(0, std::string(hostile.error).size(), hostile.error) == 0,
                      error << " | " << hostile.error);
    }
    // Ten thousand nodes deep: no recursion.
    std::string nodes = R"("nodes":[)";
    for (int i = 0; i < 10000; ++i)
        nodes += "{\"children\":[" + std::to_string(i + 1) + "]},";
    CHECK(LoadModel(Quad().Make(nodes + R"({"mesh":0}],"scenes":[{"nodes":[0]}])")).instances.size() == 1);
}

TEST_CASE("renderer models: cameras keep where they stand and lose the scale of their parents") {
    const Scene scene = LoadModel(Quad().Make(
        R"("nodes":[{"mesh":0,"scale":[-3,2,5],"rotation":[0,0.5,0,0.5],"children":[1,2]},)"
        R"({"camera":0,"name":"eye","translation":[1,1,1]},{"camera":1}],"cameras":[)"
        R"({"type":"perspective","perspective":{"yfov":0.5,"znear":0.1,"zfar":10,"aspectRatio":1.5}},)"
        R"({"name":"plan","type":"orthographic","orthographic":{"xmag":-2,"ymag":1,"zfar":9,"znear":0}}])"));
    REQUIRE(scene.cameras.size() == 2);
    const Camera &eye = scene.cameras[0], &plan = scene.cameras[1];
    CHECK(eye.name == "eye");
    CHECK(eye.yfov == 0.5f);
    CHECK(eye.aspect == 1.5f);
    CHECK(eye.zfar == 10.0f);
    CHECK(plan.name == "plan");
    CHECK(!plan.perspective);
    CHECK(plan.xmag == 2.0f);
    for (const Camera& camera : scene.cameras) {
        const glm::mat3 turn(camera.toWorld);
        CHECK(std::fabs(glm::determinant(turn) - 1) <= 1e-5f);
        CHECK(glm::length(turn * glm::transpose(turn) * glm::vec3(1, 2, 3) - glm::vec3(1, 2, 3)) <= 1e-4f);
    }
    // Turned by 90° about y after the scale: (-3, 2, 5) becomes (5, 2, 3).
    CHECK(IsNear(eye.toWorld[3], glm::vec4(5, 2, 3, 1)));
    CHECK(IsNear(eye.toWorld[2], glm::vec4(1, 0, 0, 0))); // +z of the camera is the world's +x
}

TEST_CASE("renderer models: factors, extensions, addressing and images of materials") {
    const ModelFolder folder;
    folder.WriteImage("rgba.png", 2, 1, {1, 2, 3, 4, 250, 251, 252, 253});
    folder.WriteImage("gray16.png", 1, 2, {65535, 32896}, 1, 16);
    Scene scene;
    const std::string images =
        R"(,"images":[{"uri":"rgba.png"},{"uri":"gray16.png"},{"uri":"none.png"}],)"
        R"("samplers":[{"wrapS":33071,"wrapT":33648}],)"
        R"("textures":[{"source":0,"sampler":0},{"source":1},{"source":2},{"source":0}])";
    const Material& m = LoadMaterial(
        folder, scene,
        R"({"name":"all","pbrMetallicRoughness":{"baseColorFactor":[0.1,0.2,0.3,0.4],"metallicFactor":0.5,)"
        R"("roughnessFactor":0.6,"baseColorTexture":{"index":0,"texCoord":1,"extensions":{"KHR_texture_transform":)"
        R"({"offset":[0.1,0.2],"rotation":0.5,"scale":[2,3],"texCoord":0}}},"metallicRoughnessTexture":{"index":1}},)"
        R"("normalTexture":{"index":3,"scale":0.7,"texCoord":1},"occlusionTexture":{"index":1,"strength":0.3},)"
        R"("emissiveTexture":{"index":2},"emissiveFactor":[1,0.5,0],"alphaMode":"MASK","alphaCutoff":0.2,)"
        R"("doubleSided":true,"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":16},)"
        R"("KHR_materials_transmission":{"transmissionFactor":0.8}}})",
        images);
    CHECK(m.name == "all");
    CHECK(!m.specularGlossiness);
    CHECK(m.baseColorFactor == glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
    CHECK(m.metallicFactor == 0.5f);
    CHECK(m.roughnessFactor == 0.6f);
    CHECK(m.normalScale == 0.7f);
    CHECK(m.occlusionStrength == 0.3f);
    CHECK(m.emissiveFactor == glm::vec3(16, 8, 0));
    CHECK(m.transmissionFactor == 0.8f);
    CHECK(m.alphaMode == AlphaMode::Mask);
    CHECK(m.alphaCutoff == 0.2f);
    CHECK(m.doubleSided);
    const auto slot = [](const Material& material, TextureSlot s) {
        return material.textures[static_cast<std::size_t>(s)];
    };
    const MaterialTexture base = slot(m, TextureSlot::BaseColor);
    CHECK(base.address.uvSet == 0); // the extension's wins
    CHECK(base.address.wrapS == Wrap::Clamp);
    CHECK(base.address.wrapT == Wrap::Mirror);
    const glm::vec3 uv(0.25f, 0.75f, 1);
    CHECK(std::fabs(glm::dot(base.address.transform.row0, uv) + 0.539916f) <= 1e-6f);
    CHECK(std::fabs(glm::dot(base.address.transform.row1, uv) - 2.414274f) <= 1e-6f);
    CHECK(slot(m, TextureSlot::Normal).address.uvSet == 1);
    CHECK(slot(m, TextureSlot::Normal).image == base.image); // one image, decoded once
    CHECK(slot(m, TextureSlot::Transmission).image == -1);
    REQUIRE(scene.images.size() == 3);
    const SourceImage& rgba = scene.images[static_cast<std::size_t>(base.image)];
    CHECK(rgba.texels == std::vector<std::uint8_t>{1, 2, 3, 4, 250, 251, 252, 253});
    const SourceImage& gray = scene.images[static_cast<std::size_t>(slot(m, TextureSlot::Occlusion).image)];
    CHECK((gray.width == 1 && gray.height == 2));
    CHECK(gray.texels == std::vector<std::uint8_t>{255, 255, 255, 255, 128, 128, 128, 255});
    const SourceImage& none = scene.images[static_cast<std::size_t>(slot(m, TextureSlot::Emissive).image)];
    CHECK(!none.error.empty());
    CHECK(none.texels.size() == 4);
    CHECK(scene.warnings.size() == 1);

    const Material& gloss = LoadMaterial(
        folder, scene,
        R"({"pbrMetallicRoughness":{"metallicFactor":0},"extensions":{"KHR_materials_pbrSpecularGlossiness":)"
        R"({"diffuseFactor":[0.5,0.6,0.7,0.8],"specularFactor":[0.1,0.2,0.3],"glossinessFactor":0.9,)"
        R"("diffuseTexture":{"index":0},"specularGlossinessTexture":{"index":3}}}})",
        images);
    CHECK(gloss.specularGlossiness);
    CHECK(gloss.baseColorFactor == glm::vec4(0.5f, 0.6f, 0.7f, 0.8f));
    CHECK(gloss.specularFactor == glm::vec3(0.1f, 0.2f, 0.3f));
    CHECK(gloss.glossinessFactor == 0.9f);
    CHECK(slot(gloss, TextureSlot::BaseColor).image >= 0);
    CHECK(slot(gloss, TextureSlot::SpecularGlossiness).image >= 0);
    const Material& third =
        LoadMaterial(folder, scene, R"({"normalTexture":{"index":0,"texCoord":2}})", images);
    CHECK(slot(third, TextureSlot::Normal).image == -1);
    CHECK(scene.warnings.at(0) == "materials[0].normalTexture.texCoord: 2: 0 and 1 are drawn");
}

TEST_CASE("renderer models: tangents are computed where they are missing, and ignored without normals") {
    const auto load = [](bool hasNormals, bool hasTangents, const std::string& transform) {
        ModelData data;
        const int position = data.AddFloats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 3);
        const int uv = data.AddFloats({0, 1, 1, 1, 0, 0, 1, 0}, 2);
        const int normal = data.AddFloats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3);
        const int tangent = data.AddFloats({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, 4);
        return LoadModel(data.MakeGlb(
            R"("meshes":[{"primitives":[{"mode":5,"material":0,"attributes":{"POSITION":)" +
            std::to_string(position) + ",\"TEXCOORD_0\":" + std::to_string(uv) +
            (hasNormals ? ",\"NORMAL\":" + std::to_string(normal) : std::string()) +
            (hasTangents ? ",\"TANGENT\":" + std::to_string(tangent) : std::string()) +
            R"(}}]}],"nodes":[{"mesh":0}],"images":[{"uri":"none.png"}],"textures":[{"source":0}],)"
            R"("materials":[{"normalTexture":{"index":0)" +
            transform + "}}]"));
    };
    // u to the right and v downwards, as images have them: the tangent is +x, and up is up.
    CHECK(load(true, false, "").vertices[0].tangent == glm::vec4(1, 0, 0, 1));
    CHECK(load(true, true, "").vertices[0].tangent == glm::vec4(0, 1, 0, -1));
    CHECK(load(false, true, "").vertices[0].tangent == glm::vec4(0));
    CHECK(!load(false, true, "").primitives[0].hasTangents);
    // A quarter turn of the texture turns its frame; a negative scale mirrors it.
    const std::string turned = R"(,"extensions":{"KHR_texture_transform":{"rotation":1.5707963267948966}})";
    const std::string mirrored = R"(,"extensions":{"KHR_texture_transform":{"scale":[-1,1]}})";
    const glm::vec4 turn = load(true, false, turned).vertices[0].tangent;
    CHECK(IsNear(turn, glm::vec4(0, 1, 0, 1)));
    CHECK(IsNear(load(true, false, mirrored).vertices[0].tangent, glm::vec4(-1, 0, 0, -1)));
}

TEST_CASE("renderer tangents: mirrored halves are split, what touches in a point alone too") {
    // Two quads side by side, the right one with mirrored u; the two vertices between them are shared.
    std::vector<Vertex> vertices(6);
    for (int i = 0; i < 6; ++i) {
        const float x = static_cast<float>(i % 3) - 1, y = static_cast<float>(i / 3);
        vertices[static_cast<std::size_t>(i)].position = {x, y, 0};
        vertices[static_cast<std::size_t>(i)].normal = {0, 0, 1};
        vertices[static_cast<std::size_t>(i)].uv[0] = {1 - std::fabs(x), 1 - y};
    }
    std::vector<std::uint32_t> triangles = {0, 1, 3, 1, 4, 3, 1, 2, 4, 2, 5, 4};
    MakeTangents(vertices, triangles, {});
    CHECK(vertices.size() == 8);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
        const Vertex& v = vertices[triangles[i]];
        const bool isLeft = i < 6;
        CHECK(IsNear(v.tangent, isLeft ? glm::vec4(1, 0, 0, 1) : glm::vec4(-1, 0, 0, -1)));
        CHECK(v.normal == glm::vec3(0, 0, 1));
        // The bitangent is up on both sides: lit from above, both halves are equally bright.
        CHECK(IsNear(glm::vec4(glm::cross(v.normal, glm::vec3(v.tangent)) * v.tangent.w, 0),
                     glm::vec4(0, 1, 0, 0)));
    }
    // Degenerate triangles get a frame of a neighbour, or any; nothing is NaN.
    std::vector<Vertex> flat(5, vertices[0]);
    flat[1].position.x = flat[1].uv[0].x = 1;
    flat[2].position.y = flat[2].uv[0].y = 1;
    flat[3].position = {5, 5, 5};
    flat[4].position = {6, 5, 5};
    std::vector<std::uint32_t> odd = {0, 1, 2, 0, 1, 1, 3, 4, 3};
    MakeTangents(flat, odd, {});
    for (const std::uint32_t index : odd) {
        CHECK(std::isfinite(flat[index].tangent.x));
        CHECK(std::fabs(glm::length(glm::vec3(flat[index].tangent)) - 1) <= 1e-5f);
    }
}

TEST_CASE("renderer models: FlightHelmet, and its own tangents") {
    const std::filesystem::path path =
        GetConformanceFolder().parent_path() / "assets/FlightHelmet/FlightHelmet.gltf";
    if (!std::filesystem::exists(path)) {
        MESSAGE("SKIP: no " << path.string());
        return;
    }
    GltfSceneOptions options;
    options.readImages = false;
    const Scene scene = LoadGltfScene(path.string(), options);
    CHECK(scene.primitives.size() == 6);
    CHECK(scene.instances.size() == 6);
    CHECK(scene.materials.size() == 6);
    CHECK(scene.images.size() == 15);
    CHECK(scene.warnings.empty());
    std::size_t blended = 0, turned = 0;
    double cosines = 0.0;
    for (const Primitive& primitive : scene.primitives) {
        const Material& material = scene.materials[static_cast<std::size_t>(primitive.material)];
        blended += material.alphaMode == AlphaMode::Blend ? 1 : 0;
        CHECK(primitive.hasTangents);
        // Computed again, they are those of the file but where triangles were quads or had no area.
        std::vector<Vertex> vertices = scene.vertices;
        const auto begin = scene.indices.begin() + primitive.firstIndex;
        std::vector<std::uint32_t> triangles(begin, begin + primitive.indexCount);
        MakeTangents(vertices, triangles,
                     material.textures[static_cast<std::size_t>(TextureSlot::Normal)].address);
        for (std::size_t i = 0; i < triangles.size(); ++i) {
            const glm::vec4 own = vertices[triangles[i]].tangent,
                            stored = scene.vertices[*(begin + static_cast<std::ptrdiff_t>(i))].tangent;
            turned += own.w != stored.w ? 1 : 0;
            cosines += static_cast<double>(glm::dot(glm::vec3(own), glm::normalize(glm::vec3(stored))));
        }
    }
    CHECK(blended == 1);
    MESSAGE("measure: FlightHelmet: " << turned << " of " << scene.indices.size()
                                      << " corners have another side than the file's, mean cosine "
                                      << cosines / static_cast<double>(scene.indices.size()));
    CHECK(turned <= 30); // triangles without area
    CHECK(cosines / static_cast<double>(scene.indices.size()) >= 0.998);
}
