// SPDX-License-Identifier: MIT
#include "renderer/scene/SampleScene.h"

#include "renderer/scene/TextureSetLookup.h"

#include "materials/Materials.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

namespace openntc::renderer {

namespace {

constexpr int kImageSide = 256; // of the texture sets

/// Puts channels of `planes` together, one after another; missing ones are 255.
int AddPlanes(SceneBuilder& builder, const std::string& label,
              std::span<const materials::Image* const> planes, bool isColor) {
    std::vector<std::vector<std::uint8_t>> bytes;
    for (const materials::Image* plane : planes)
        bytes.push_back(plane == nullptr ? std::vector<std::uint8_t>()
                                         : materials::MakeBytes(*plane, isColor));
    return builder.AddImage(label, kImageSide, kImageSide, [&](int x, int y) {
        std::uint32_t rgba = 0xFFFFFFFFu;
        int channel = 0;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            const int count = planes[i] == nullptr ? 1 : planes[i]->channels;
            for (int c = 0; c < count; ++c, ++channel) {
                if (planes[i] == nullptr)
                    continue;
                const std::uint32_t byte =
                    bytes[i][static_cast<std::size_t>((y * kImageSide + x) * count + c)];
                rgba = (rgba & ~(0xFFu << (8 * channel))) | byte << (8 * channel);
            }
        }
        return rgba;
    });
}

/// A material of the generated images, and the texture set that was made of them.
int AddGenerated(SceneBuilder& builder, const std::string& name, const materials::MaterialImages& images,
                 const std::string& folder) {
    Material material;
    material.name = name;
    const auto set = [&](TextureSlot slot, const char* label,
                         std::initializer_list<const materials::Image*> planes, bool isColor) {
        const std::vector<const materials::Image*> list(planes);
        material.textures[static_cast<std::size_t>(slot)].image =
            AddPlanes(builder, name + "_" + label, list, isColor);
    };
    set(TextureSlot::BaseColor, "basecolor", {&images.color}, true);
    set(TextureSlot::MetallicRoughness, "metallicroughness", {nullptr, &images.roughness, &images.metalness},
        false);
    set(TextureSlot::Normal, "normal", {&images.normal}, false);
    set(TextureSlot::Occlusion, "occlusion", {&images.occlusion, &images.occlusion, &images.occlusion},
        false);
    if (!images.emission.texels.empty()) {
        set(TextureSlot::Emissive, "emission", {&images.emission}, true);
        builder.GetScene().images.back().radiance = images.emission.texels;
        material.emissiveFactor = glm::vec3(1.0f);
    }
    if (images.color.channels == 4) {
        material.alphaMode = AlphaMode::Mask;
        material.doubleSided = true;
    }
    const int index = builder.AddMaterial(std::move(material));
    AttachTextureSet((std::filesystem::path(folder) / (name + ".ntc")).string(),
                     builder.GetScene().materials[static_cast<std::size_t>(index)], builder.GetScene());
    return index;
}

} // namespace

Scene MakeSampleScene(const std::string& materialDir) {
    const std::string folder = materialDir.empty() ? OPENNTC_SAMPLE_DIR : materialDir;
    constexpr float kHalfPi = 1.57079633f;
    SceneBuilder builder("sample");
    const int bricks = AddGenerated(builder, "bricks", materials::MakeBricks(kImageSide), folder);
    const int grille = AddGenerated(builder, "grille", materials::MakeGrille(kImageSide), folder);
    const UvTransform four{{4, 0, 0}, {0, 4, 0}}, wide{{4, 0, 0}, {0, 1.5f, 0}}, twice{{2, 0, 0}, {0, 1, 0}};
    const int floor = builder.AddQuad(bricks, four, 8), wall = builder.AddQuad(bricks, wide, 8);
    const int sphere = builder.AddSphere(bricks, 4.0f);
    const int arch = builder.AddTorus(bricks, 1.35f, 0.28f, {6.0f, 1.0f});
    const int gate = builder.AddQuad(grille, twice), plate = builder.AddQuad(grille);
    const int brazier = builder.AddCylinder(grille, {3.0f, 0.75f});

    builder.Add(floor, MakePlace({1, 0, 1}) * MakeTurn(0, -kHalfPi) * MakePlace({0, 0, 0}, glm::vec3(8.0f)));
    builder.Add(wall, MakePlace({1, 1.5f, -3}, {8, 3, 1}));
    builder.Add(wall, MakePlace({-3, 1.5f, 1}) * MakeTurn(1, kHalfPi) * MakePlace({0, 0, 0}, {8, 3, 1}));
    builder.AddAt(arch, {0.6f, 0.0f, -2.2f});
    builder.Add(gate, MakePlace({0.6f, 0.5f, -2.2f}, {2.1f, 1.05f, 1}));
    builder.AddAt(sphere, {1.45f, 0.42f, 0.1f}, glm::vec3(0.42f));
    builder.AddAt(brazier, {-0.5f, 0.0f, 0.1f}, {0.6f, 0.95f, 0.6f});
    builder.Add(plate, MakePlace({-2.3f, 0.78f, -0.9f}) * MakeTurn(1, 1.1f) * MakeTurn(0, -0.35f) *
                           MakePlace({0, 0, 0}, glm::vec3(1.7f)));
    builder.AddCamera("courtyard", {2.1f, 1.75f, 3.3f}, {-0.25f, 0.6f, -0.9f});
    return builder.Take();
}

void AddEverything(SceneBuilder& builder) {
    const int grille = AddGenerated(builder, "grille", materials::MakeGrille(kImageSide), OPENNTC_SAMPLE_DIR);
    Material& material = builder.GetScene().materials[static_cast<std::size_t>(grille)];
    const auto at = [&material](TextureSlot slot) -> MaterialTexture& {
        return material.textures[static_cast<std::size_t>(slot)];
    };
    at(TextureSlot::Transmission) = at(TextureSlot::Occlusion); // a share between 0 and 1
    material.transmissionFactor = 0.5f;
    builder.AddAt(builder.AddQuad(grille), {-0.55f, 0, 0});
    builder.Add(builder.AddQuad(grille), MakePlace({0.55f, 0, 0}) * MakeTurn(1, 0.9f));
    builder.AddCamera("front", {0, 0, 2.2f}, {0, 0, 0});
}

} // namespace openntc::renderer
