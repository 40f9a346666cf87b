// SPDX-License-Identifier: MIT
// What a material's shader can do without: one list, each effect by itself, and the page that explains them. No device.
#include "renderer/gpu/MaterialPlan.h"
#include "renderer/scene/SampleScene.h"
#include "renderer/scene/TestScenes.h"

#include "openntc/core/FileStream.h"

#include <doctest/doctest.h>

#include <fstream>
#include <sstream>
#include <string>

using namespace openntc;
using namespace openntc::renderer;

namespace {

/// What else is on when an effect is.
EffectSet GetImplied(MaterialEffect effect) {
    if (effect == MaterialEffect::EmissiveTexture)
        return MakeBit(MaterialEffect::Emission);
    return effect == MaterialEffect::TransmissionTexture ? MakeBit(MaterialEffect::Transmission) : 0;
}

EffectSet GetFilterEffects() {
    return MakeBit(MaterialEffect::FilterAnyKernel) | MakeBit(MaterialEffect::FilterMips) |
           MakeBit(MaterialEffect::FilterAnisotropy);
}

/// Values of the filter's definitions; "-": not defined.
std::string ListFilterDefines(const MaterialPlan& plan) {
    std::string values;
    for (const char* const name : {"NTCR_KERNEL=", "NTC_STF_MOST_TAPS=", "NTCR_MIPS=", "NTCR_ISOTROPIC="}) {
        std::string value = "-";
        for (const std::string& define : plan.defines) {
            if (define.starts_with(name))
                value = define.substr(std::string(name).size());
        }
        values += (values.empty() ? "" : " ") + value;
    }
    return values;
}

} // namespace

TEST_CASE("renderer: an effect that is forced is on, with what it needs, and nothing else") {
    Scene scene;
    for (const bool isGlossiness : {false, true}) {
        Material bare;
        bare.specularGlossiness = isGlossiness;
        RenderOptions options;
        const MaterialPlan plain = PlanMaterial(scene, bare, {}, options, {});
        CHECK(plain.effects == (isGlossiness ? MakeBit(MaterialEffect::SpecularGlossiness) : 0));
        for (std::size_t i = 0; i < kMaterialEffectCount; ++i) {
            CAPTURE(std::string(kMaterialEffects[i].name));
            const auto effect = static_cast<MaterialEffect>(i);
            options.forcedEffects = MakeBit(effect);
            const MaterialPlan plan = PlanMaterial(scene, bare, {}, options, {});
            // Textures of the other workflow are never read, a decoder needs a texture set, a filter a texture.
            const bool isOther = effect == (isGlossiness ? MaterialEffect::MetallicRoughnessTexture
                                                         : MaterialEffect::SpecularGlossinessTexture) ||
                                 kMaterialEffects[i].name.starts_with("decoder") ||
                                 kMaterialEffects[i].name.starts_with("filter") ||
                                 !kMaterialEffects[i].canForce;
            const EffectSet ofFilter = GetFilterEffects();
            CHECK((plan.effects & ~ofFilter) ==
                  (isOther ? plain.effects : plain.effects | MakeBit(effect) | GetImplied(effect)));
            CHECK((plan.defines == plain.defines) == (isOther || effect == MaterialEffect::Alpha));
        }
    }
}

TEST_CASE("renderer: of the filters, the one that is asked for is compiled, and all of them only where that "
          "is forced") {
    Scene scene;
    SourceImage image;
    image.width = image.height = 2;
    image.texels.assign(16, 255);
    scene.images.push_back(image);
    Material material;
    material.textures[0].image = 0;
    const struct {
        TextureFilter filter;
        EffectSet effects;
        const char* defines; // NTCR_KERNEL, NTC_STF_MOST_TAPS, NTCR_MIPS, NTCR_ISOTROPIC
    } kFilters[] = {
        {TextureFilter::Nearest, 0, "0 2 0 1"},
        {TextureFilter::Bilinear, 0, "1 2 0 1"},
        {TextureFilter::Trilinear, MakeBit(MaterialEffect::FilterMips), "1 2 1 1"},
        {TextureFilter::Cubic, MakeBit(MaterialEffect::FilterMips), "2 4 1 1"},
        {TextureFilter::Mitchell, MakeBit(MaterialEffect::FilterMips), "4 4 1 1"},
        {TextureFilter::Gaussian, MakeBit(MaterialEffect::FilterMips), "5 4 1 1"},
        {TextureFilter::Anisotropic,
         MakeBit(MaterialEffect::FilterMips) | MakeBit(MaterialEffect::FilterAnisotropy), "1 2 1 -"},
    };
    RenderOptions options;
    for (const auto& row : kFilters) {
        CAPTURE(row.defines);
        options.filter = row.filter;
        options.forcedEffects = 0;
        const MaterialPlan plan = PlanMaterial(scene, material, {}, options, {});
        CHECK((plan.effects & GetFilterEffects()) == row.effects);
        CHECK(ListFilterDefines(plan) == row.defines);
        options.forcedEffects = GetFilterEffects();
        const MaterialPlan forced = PlanMaterial(scene, material, {}, options, {});
        CHECK((forced.effects & GetFilterEffects()) == GetFilterEffects());
        // What is called for is known; the rest are numbers.
        CHECK(ListFilterDefines(forced) == (row.effects == 0 ? "- - - -" : "- - 1 -"));
    }
}

TEST_CASE("renderer: a decoder does what the material calls for, and more only where that is forced") {
    const Scene scene = MakeTestScene("everything");
    REQUIRE(scene.textureSets.size() == 1);
    auto file = FileReader::Open(scene.textureSets[0].path.c_str());
    REQUIRE(file);
    const auto metadata = TextureSetMetadata::Load(*file);
    REQUIRE(metadata);
    const std::vector<LoadedSetInfo> sets = {{&*metadata}};
    RenderOptions options;
    options.mode = Mode::OnSample;
    const MaterialPlan plain = PlanMaterial(scene, scene.materials[0], sets, options, {});
    // It calls for everything of its workflow.
    for (const MaterialEffect effect :
         {MaterialEffect::BaseColorTexture, MaterialEffect::MetallicRoughnessTexture,
          MaterialEffect::NormalMap, MaterialEffect::Occlusion, MaterialEffect::Emission,
          MaterialEffect::EmissiveTexture, MaterialEffect::Transmission, MaterialEffect::TransmissionTexture,
          MaterialEffect::Alpha, MaterialEffect::AlphaMask})
        CHECK((plain.effects & MakeBit(effect)) != 0);
    CHECK((plain.effects & MakeBit(MaterialEffect::DecoderClamping)) == 0);
    const std::pair<MaterialEffect, const char*> kLeftOut[] = {
        {MaterialEffect::DecoderClamping, "NTC_CLAMP_TEXELS=0"},
        {MaterialEffect::DecoderSlices, "NTC_LATENT_SLICES=0"}};
    for (const auto& [effect, define] : kLeftOut) {
        options.forcedEffects = MakeBit(effect);
        const MaterialPlan forced = PlanMaterial(scene, scene.materials[0], sets, options, {});
        CHECK(plain.decoder.find(define) != std::string::npos);
        CHECK(forced.decoder.find(define) == std::string::npos);
        CHECK(forced.effects == (plain.effects | MakeBit(effect)));
    }
    // All that the sample's bricks have, where a material without emission reads fewer.
    Material material = scene.materials[0];
    material.emissiveFactor = glm::vec3(0.0f);
    options.forcedEffects = 0;
    const MaterialPlan fewer = PlanMaterial(scene, material, sets, options, {});
    options.forcedEffects = MakeBit(MaterialEffect::DecoderAllChannels);
    const MaterialPlan all = PlanMaterial(scene, material, sets, options, {});
    CHECK(fewer.multiplications < all.multiplications);
}

TEST_CASE("renderer: the page has a row for every effect") {
    std::ifstream file(OPENNTC_RENDERER_SOURCES "/docs/renderer.md");
    std::stringstream page;
    page << file.rdbuf();
    for (const MaterialEffectInfo& effect : kMaterialEffects) {
        CAPTURE(std::string(effect.name));
        CHECK(page.str().find("| `" + std::string(effect.name) + "` |") != std::string::npos);
    }
}
