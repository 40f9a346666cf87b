// SPDX-License-Identifier: MIT
// From what a material uses, and from the mode, to the permutation of its shaders and to what is bound: nothing that the
// material does not call for. Needs no device.
#pragma once

#include "renderer/gpu/RenderOptions.h"
#include "renderer/scene/Scene.h"
#include "renderer/shaders/Constants.h"

#include "openntc/permutation/PermutationKey.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace openntc::renderer {

/// Where a slot's texels come from; values equal NTCR_X_SOURCE of shaders/MaterialTexels.glsl.
enum class TexelSource { None = 0, Image = 1, Decoded = 2, Set = 3 };

/// Whether the first three channels of a slot (an index in Material::textures) are sRGB colours.
bool HoldsColors(std::size_t slot);

struct SlotPlan {
    TexelSource source = TexelSource::None;
    int lookup = -1;
    int image = -1; ///< Image: index in Scene::images
    int set = -1;   ///< Decoded and Set: index in Scene::textureSets
    int firstChannel = 0;
    int channels = 0;
    bool isLinear = false;                ///< stored as floats in linear light
    std::optional<bc::BlockFormat> block; ///< Decoded: stored in it; none: as texels
    bool isNeutral = false;               ///< Image: a texel that changes nothing, of --force-effects
    bool weighsAlpha = false;             ///< Image: mips of colours are averages weighed by alpha
    float keptCoverage = 0.0f;            ///< Image: Material::keptCoverage
};

struct MaterialPlan {
    std::array<SlotPlan, kTextureSlotCount> slots;
    std::vector<shader::NtcrLookup> lookups;
    std::vector<int> lookupSets;          ///< whose textures a lookup reads; -1: of images alone
    int set = -1;                         ///< that is decoded in the shader; -1: none
    std::vector<std::string> defines;     ///< of Shade.glsl
    std::vector<std::string> maskDefines; ///< of Visibility.frag, for AlphaMode::Mask
    std::array<SlotPlan, kTextureSlotCount> maskSlots;
    bool isPlanned = false;
    EffectSet effects = 0;   ///< that are on
    std::string decoder;     ///< why the decoder is what it is: key as definitions; empty without one
    int multiplications = 0; ///< of weights, per decoded texel
};

/// Whether any slot's texture is decoded from a texture set before it is read.
bool HasDecoded(const std::array<SlotPlan, kTextureSlotCount>& slots);

/// A texture set that is usable.
struct LoadedSetInfo {
    const TextureSetMetadata* metadata = nullptr; ///< null: the file could not be used
};

/// The plan of one material. `sets` runs parallel to Scene::textureSets. `device`: what it has, for the decoder's
/// permutation. Throws CommandError(BadInput) for a maths mode that the set's weights do not serve.
MaterialPlan PlanMaterial(const Scene& scene, const Material& material,
                          const std::vector<LoadedSetInfo>& sets, const RenderOptions& options,
                          const DeviceFeatures& device);

/// The sampler of a lookup.
shader::NtcStfSampler MakeSampler(TextureFilter filter, const TextureAddress& address);

} // namespace openntc::renderer
