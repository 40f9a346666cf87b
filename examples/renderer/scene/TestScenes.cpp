// SPDX-License-Identifier: MIT
#include "renderer/scene/TestScenes.h"

#include "renderer/scene/SampleScene.h"

#include "materials/Noise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace openntc::renderer {

namespace {

constexpr float kHalfTurn = 3.14159265f;

std::uint32_t Pack(std::uint32_t r, std::uint32_t g, std::uint32_t b, std::uint32_t a = 255) {
    return r | g << 8 | b << 16 | a << 24;
}

/// Blocks of hashed colours, light enough to tell shading from texture.
int AddBlocks(SceneBuilder& builder, int width, int height, std::uint32_t seed, int block = 8) {
    return builder.AddImage("blocks" + std::to_string(seed), width, height, [=](int x, int y) {
        const std::uint32_t hash = materials::Hash(static_cast<std::uint32_t>(x / block),
                                                   static_cast<std::uint32_t>(y / block), seed);
        return Pack(96 + (hash & 127), 96 + (hash >> 8 & 127), 96 + (hash >> 16 & 127));
    });
}

/// Letters' replacement: each quarter has its own grey, so that turns and mirrors show.
int AddQuarters(SceneBuilder& builder) {
    return builder.AddImage("quarters", 64, 64, [](int x, int y) {
        const int quarter = (x < 32 ? 0 : 1) + (y < 32 ? 0 : 2);
        constexpr std::uint32_t kColors[] = {0xFF4040C0u, 0xFF40C040u, 0xFFC04040u, 0xFF40C0C0u};
        const bool isBorder = x % 32 < 2 || y % 32 < 2;
        return isBorder ? Pack(230, 230, 230) : kColors[quarter];
    });
}

/// A normal map of a round dome: the same after quarter turns and mirrors of what it is laid on.
int AddDome(SceneBuilder& builder) {
    return builder.AddImage("dome", 64, 64, [](int x, int y) {
        const float u = (static_cast<float>(x) - 31.5f) / 32.0f, v = (static_cast<float>(y) - 31.5f) / 32.0f;
        const float r = std::sqrt(u * u + v * v);
        const float slope = r < 0.9f ? 1.5f * r : 0.0f, length = std::sqrt(1.0f + slope * slope);
        const float scale = r > 0.0f ? slope / (r * length) : 0.0f;
        const auto byte = [](float n) {
            return static_cast<std::uint32_t>(std::lround((0.5f + 0.5f * n) * 255.0f));
        };
        return Pack(byte(u * scale), byte(-v * scale), byte(1.0f / length)); // green up
    });
}

MaterialTexture& GetSlot(Material& material, TextureSlot slot) {
    return material.textures[static_cast<std::size_t>(slot)];
}

Material MakeMatte(int image) {
    Material material;
    material.name = "matte";
    material.metallicFactor = 0.0f;
    GetSlot(material, TextureSlot::BaseColor).image = image;
    return material;
}

/// Rows of roughness, columns of metallic 0 (three colours) and 1 (three colours): where both workflows
/// describe the same surface.
void AddSpheres(SceneBuilder& builder, bool specularGlossiness) {
    constexpr int kRows = 4, kColumns = 6;
    const glm::vec3 colors[] = {{0.9f, 0.2f, 0.1f}, {0.2f, 0.7f, 0.3f}, {0.3f, 0.4f, 0.9f}};
    const int blocks = AddBlocks(builder, 64, 64, 1);
    for (int row = 0; row < kRows; ++row) {
        for (int column = 0; column < kColumns; ++column) {
            const bool isMetal = column >= 3;
            const glm::vec3 color = colors[column % 3];
            const float roughness = (static_cast<float>(row) + 0.5f) / kRows;
            Material material;
            material.name = "sphere" + std::to_string(row * kColumns + column);
            material.specularGlossiness = specularGlossiness;
            material.metallicFactor = isMetal ? 1.0f : 0.0f;
            material.roughnessFactor = roughness;
            material.glossinessFactor = 1.0f - roughness;
            material.baseColorFactor = glm::vec4(color, 1.0f);
            const bool isDiffuse = !specularGlossiness || !isMetal;
            if (specularGlossiness) {
                material.baseColorFactor = isMetal ? glm::vec4(0, 0, 0, 1) : glm::vec4(color / 0.96f, 1.0f);
                material.specularFactor = isMetal ? color : glm::vec3(0.04f);
            }
            // The texture goes where the colour is: with alpha 1 the second workflow's leaves glossiness as
            // it is.
            GetSlot(material, isDiffuse ? TextureSlot::BaseColor : TextureSlot::SpecularGlossiness).image =
                blocks;
            const int sphere = builder.AddSphere(builder.AddMaterial(material));
            builder.AddAt(
                sphere,
                {1.1f * (static_cast<float>(column) - 2.5f), 1.1f * (1.5f - static_cast<float>(row)), 0},
                glm::vec3(0.5f));
        }
    }
    builder.AddCamera("front", {0, 0, 9}, {0, 0, 0});
}

/// Eight quads with one normal map, turned by quarters and mirrored: all must be equal.
void AddTurnedQuads(SceneBuilder& builder, bool hasTangents) {
    Material material = MakeMatte(AddBlocks(builder, 8, 8, 3));
    material.roughnessFactor = 0.5f;
    GetSlot(material, TextureSlot::Normal).image = AddDome(builder);
    const int index = builder.AddMaterial(material);
    for (int i = 0; i < 8; ++i) {
        const float c = i % 2 == 0 ? (i % 4 == 0 ? 1.0f : -1.0f) : 0.0f,
                    s = i % 2 == 1 ? (i % 4 == 1 ? 1.0f : -1.0f) : 0.0f;
        const float mirror = i < 4 ? 1.0f : -1.0f;
        // About the middle of the texture.
        const UvTransform transform{{c * mirror, -s, 0.5f - 0.5f * c * mirror + 0.5f * s},
                                    {s * mirror, c, 0.5f - 0.5f * s * mirror - 0.5f * c}};
        const int quad = builder.AddQuad(index, transform);
        builder.AddAt(quad, {1.1f * (static_cast<float>(i % 4) - 1.5f), i < 4 ? 0.55f : -0.55f, 0});
    }
    if (!hasTangents) {
        for (Vertex& vertex : builder.GetScene().vertices)
            vertex.tangent = glm::vec4(0.0f);
        for (Primitive& primitive : builder.GetScene().primitives)
            primitive.hasTangents = false;
    }
    builder.AddCamera("front", {0, 0, 5}, {0, 0, 0});
}

void AddEmission(SceneBuilder& builder) {
    const int blocks = AddBlocks(builder, 32, 32, 5);
    for (int i = 0; i < 5; ++i) {
        Material material = MakeMatte(-1);
        material.baseColorFactor = glm::vec4(0, 0, 0, 1);
        material.emissiveFactor = glm::vec3(1.0f, 0.6f, 0.3f) * static_cast<float>(1 << i); // 1 ... 16
        GetSlot(material, TextureSlot::Emissive).image = blocks;
        builder.AddAt(builder.AddQuad(builder.AddMaterial(material)),
                      {1.1f * static_cast<float>(i - 2), 0, 0});
    }
    builder.AddCamera("front", {0, 0, 7}, {0, 0, 0});
}

/// Cards with a disc in alpha: masks of four cutoffs, then three blended cards one behind the other.
void AddCards(SceneBuilder& builder) {
    const int disc = builder.AddImage("disc", 64, 64, [](int x, int y) {
        const float r = std::hypot(static_cast<float>(x) - 31.5f, static_cast<float>(y) - 31.5f) / 32.0f;
        return Pack(220, 180, 90, static_cast<std::uint32_t>(std::lround(255.0f * std::max(1.0f - r, 0.0f))));
    });
    for (int i = 0; i < 4; ++i) {
        Material material = MakeMatte(disc);
        material.alphaMode = AlphaMode::Mask;
        material.alphaCutoff = 0.2f * static_cast<float>(i + 1);
        material.doubleSided = true;
        builder.Add(builder.AddQuad(builder.AddMaterial(material)),
                    MakePlace({1.1f * (static_cast<float>(i) - 1.5f), 0.6f, 0}) *
                        MakeTurn(1, i % 2 == 0 ? 0.0f : kHalfTurn));
    }
    const glm::vec3 colors[] = {{1, 0.2f, 0.2f}, {0.2f, 1, 0.2f}, {0.2f, 0.2f, 1}};
    for (int i = 0; i < 3; ++i) {
        Material material = MakeMatte(-1);
        material.baseColorFactor = glm::vec4(colors[i], 0.5f);
        material.alphaMode = AlphaMode::Blend;
        const auto step = static_cast<float>(i);
        builder.AddAt(builder.AddQuad(builder.AddMaterial(material)),
                      {0.35f * (step - 1.0f), -0.6f - 0.1f * step, 0.3f * (1.0f - step)});
    }
    builder.AddCamera("front", {0, 0, 5}, {0, 0, 0});
}

/// Rows wrap v, columns wrap u, texture coordinates from -1 to 2.
void AddWraps(SceneBuilder& builder) {
    const int quarters = AddQuarters(builder);
    constexpr Wrap kWraps[] = {Wrap::Repeat, Wrap::Mirror, Wrap::Clamp};
    for (int i = 0; i < 9; ++i) {
        const int column = i % 3, row = i / 3;
        Material material = MakeMatte(quarters);
        GetSlot(material, TextureSlot::BaseColor).address.wrapS = kWraps[column];
        GetSlot(material, TextureSlot::BaseColor).address.wrapT = kWraps[row];
        const int quad = builder.AddQuad(builder.AddMaterial(material), {{3, 0, -1}, {0, 3, -1}});
        builder.AddAt(quad, {1.1f * static_cast<float>(column - 1), 1.1f * static_cast<float>(1 - row), 0});
    }
    builder.AddCamera("front", {0, 0, 6}, {0, 0, 0});
}

void AddSizes(SceneBuilder& builder) {
    const glm::ivec2 sizes[] = {{1, 1}, {37, 100}, {2, 64}, {256, 256}};
    for (int i = 0; i < 4; ++i) {
        const int image = AddBlocks(builder, sizes[i].x, sizes[i].y, 20 + static_cast<std::uint32_t>(i));
        builder.AddAt(builder.AddQuad(builder.AddMaterial(MakeMatte(image))),
                      {1.1f * (static_cast<float>(i) - 1.5f), 0, 0});
    }
    builder.AddCamera("front", {0, 0, 5}, {0, 0, 0});
}

void AddFloor(SceneBuilder& builder) {
    const int image = builder.AddImage("checks", 64, 64, [](int x, int y) {
        return (x / 32 + y / 32) % 2 == 0 ? Pack(225, 225, 225) : Pack(30, 30, 30);
    });
    const int quad = builder.AddQuad(builder.AddMaterial(MakeMatte(image)), {{4, 0, 0}, {0, 100, 0}}, 16);
    builder.Add(quad, MakeTurn(0, -0.5f * kHalfTurn) * MakePlace({0, 0, 0}, {8, 200, 1}));
    builder.AddCamera("front", {0, 0.8f, 99}, {0, 0, 60});
}

/// A lopsided surface, its mirror image by a negative scale, and the same by its vertices: the last two must
/// be equal.
void AddMirrored(SceneBuilder& builder) {
    Material material = MakeMatte(AddQuarters(builder));
    material.roughnessFactor = 0.3f;
    const int index = builder.AddMaterial(material);
    const auto add = [&](float side) {
        return builder.AddSurface(index, 24, 12, [side](float u, float v) {
            const float a = kHalfTurn * u, h = v - 0.5f, r = 0.3f + 0.2f * u;
            const glm::vec3 n = glm::vec3(-side * std::cos(a), 0.0f, std::sin(a));
            return SceneBuilder::Point{{n.x * r, -h, n.z * r}, n, {u, v}};
        });
    };
    const int right = add(1.0f), left = add(-1.0f);
    builder.AddAt(right, {-1.2f, 0, 0});
    builder.AddAt(right, {0, 0, 0}, {-1, 1, 1});
    builder.AddAt(left, {1.2f, 0, 0});
    builder.AddCamera("front", {0, 0, 4.5f}, {0, 0, 0});
}

/// A sphere as it is, without tangents, without normals (flat), without texture coordinates.
void AddBare(SceneBuilder& builder) {
    for (int i = 0; i < 4; ++i) {
        Material material = MakeMatte(AddQuarters(builder));
        GetSlot(material, TextureSlot::Normal).image = AddDome(builder);
        const std::size_t begin = builder.GetScene().vertices.size();
        const int sphere = builder.AddSphere(builder.AddMaterial(material), 4.0f, 24, 12);
        Primitive& primitive = builder.GetScene().primitives.back();
        for (std::size_t k = begin; k < builder.GetScene().vertices.size(); ++k) {
            Vertex& vertex = builder.GetScene().vertices[k];
            vertex.tangent = i >= 1 ? glm::vec4(0.0f) : vertex.tangent;
            vertex.normal = i >= 2 ? glm::vec3(0.0f) : vertex.normal;
            vertex.uv[0] = vertex.uv[1] = i >= 3 ? glm::vec2(0.0f) : vertex.uv[0];
        }
        primitive.hasTangents = i < 1;
        primitive.hasNormals = i < 2;
        builder.AddAt(sphere, {1.1f * (static_cast<float>(i) - 1.5f), 0, 0}, glm::vec3(0.5f));
    }
    builder.AddCamera("front", {0, 0, 5}, {0, 0, 0});
}

/// Left: texture coordinates transformed by the material; right: by the vertices. Above the first set of
/// coordinates, below the second. Columns must be equal in pairs.
void AddTransforms(SceneBuilder& builder) {
    const int quarters = AddQuarters(builder);
    const float c = std::cos(0.5f), s = std::sin(0.5f);
    const UvTransform transform{{2 * c, -3 * s, 0.1f}, {2 * s, 3 * c, 0.2f}};
    for (int i = 0; i < 4; ++i) {
        Material material = MakeMatte(quarters);
        const bool byMaterial = i % 2 == 0;
        TextureAddress& address = GetSlot(material, TextureSlot::BaseColor).address;
        address.uvSet = i / 2;
        if (byMaterial)
            address.transform = transform;
        const std::size_t begin = builder.GetScene().vertices.size();
        const int quad =
            builder.AddQuad(builder.AddMaterial(material), byMaterial ? UvTransform{} : transform);
        for (std::size_t k = begin; k < builder.GetScene().vertices.size(); ++k)
            builder.GetScene().vertices[k].uv[1 - address.uvSet] =
                glm::vec2(0.0f); // the other set is of no use
        builder.AddAt(quad, {byMaterial ? -0.55f : 0.55f, i < 2 ? 0.55f : -0.55f, 0});
    }
    builder.AddCamera("front", {0, 0, 4}, {0, 0, 0});
}

void AddTransmission(SceneBuilder& builder) {
    const int blocks = AddBlocks(builder, 64, 64, 9);
    const int share = builder.AddImage(
        "share", 64, 64, [](int x, int) { return Pack(static_cast<std::uint32_t>(x * 255 / 63), 0, 0); });
    for (int i = 0; i < 4; ++i) {
        Material material = MakeMatte(blocks);
        material.roughnessFactor = 0.2f + 0.2f * static_cast<float>(i);
        material.transmissionFactor = static_cast<float>(i) / 3.0f;
        GetSlot(material, TextureSlot::Transmission).image = share;
        GetSlot(material, TextureSlot::Occlusion).image = share;
        builder.AddAt(builder.AddSphere(builder.AddMaterial(material)),
                      {1.1f * (static_cast<float>(i) - 1.5f), 0, 0}, glm::vec3(0.5f));
    }
    builder.AddCamera("front", {0, 0, 5}, {0, 0, 0});
}

struct Maker {
    TestSceneInfo info;
    void (*add)(SceneBuilder&);
};

constexpr Maker kMakers[] = {
    {{"spheres", "metallic-roughness: roughness by rows, dielectrics left, metals right"},
     [](SceneBuilder& b) { AddSpheres(b, false); }},
    {{"spheres-glossiness", "the same surfaces as specular-glossiness: equal to \"spheres\""},
     [](SceneBuilder& b) { AddSpheres(b, true); }},
    {{"turned", "one normal map on turned and mirrored coordinates, with tangents: eight equal quads"},
     [](SceneBuilder& b) { AddTurnedQuads(b, true); }},
    {{"turned-derivatives", "the same without tangents: equal to \"turned\""},
     [](SceneBuilder& b) { AddTurnedQuads(b, false); }},
    {{"emission", "emission of 1 to 16"}, AddEmission},
    {{"cards", "masks of four cutoffs from both sides, three blended cards"}, AddCards},
    {{"wraps", "repeat, mirror and clamp along both axes"}, AddWraps},
    {{"sizes", "textures of 1 x 1, 37 x 100, 2 x 64 and 256 x 256"}, AddSizes},
    {{"floor", "a long floor at a grazing angle"}, AddFloor},
    {{"mirrored", "a negative determinant: the second equals the third"}, AddMirrored},
    {{"bare", "without tangents, normals, texture coordinates"}, AddBare},
    {{"transforms", "KHR_texture_transform left, the same by vertices right; first set above, second below"},
     AddTransforms},
    {{"transmission", "transmission and occlusion, from none to all"}, AddTransmission},
    {{"everything", "a texture set with every effect: mask, emission, transmission, occlusion, normal map"},
     AddEverything},
};

} // namespace

std::span<const TestSceneInfo> GetTestScenes() {
    static const std::vector<TestSceneInfo> kInfos = [] {
        std::vector<TestSceneInfo> infos;
        for (const Maker& maker : kMakers)
            infos.push_back(maker.info);
        return infos;
    }();
    return kInfos;
}

Scene MakeTestScene(std::string_view name) {
    SceneBuilder builder{std::string(name)};
    for (const Maker& maker : kMakers) {
        if (maker.info.name == name)
            maker.add(builder);
    }
    return builder.Take();
}

} // namespace openntc::renderer
