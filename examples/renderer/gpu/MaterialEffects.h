// SPDX-License-Identifier: MIT
// The one list of what a material's shader can do without, for its plan, `--stats` and `--force-effects`. Names only:
// whoever runs the program includes this too.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace openntc::renderer {

// X(Name, "name", whether it can be on without being called for, leaving the picture as it is)
#define NTCR_EFFECT_TABLE(X)                                                                                 \
    X(BaseColorTexture, "baseColorTexture", true)                                                            \
    X(MetallicRoughnessTexture, "metallicRoughnessTexture", true)                                            \
    X(SpecularGlossiness, "specularGlossiness", false)                                                       \
    X(SpecularGlossinessTexture, "specularGlossinessTexture", true)                                          \
    X(NormalMap, "normalMap", true)                                                                          \
    X(Occlusion, "occlusion", true)                                                                          \
    X(Emission, "emission", true)                                                                            \
    X(EmissiveTexture, "emissiveTexture", true)                                                              \
    X(Transmission, "transmission", true)                                                                    \
    X(TransmissionTexture, "transmissionTexture", true)                                                      \
    X(Alpha, "alpha", true)                                                                                  \
    X(AlphaMask, "alphaMask", false)                                                                         \
    X(DecoderAllChannels, "decoderAllChannels", true)                                                        \
    X(DecoderClamping, "decoderClamping", true)                                                              \
    X(DecoderSlices, "decoderSlices", true)                                                                  \
    X(FilterAnyKernel, "filterAnyKernel", true)                                                              \
    X(FilterMips, "filterMips", true)                                                                        \
    X(FilterAnisotropy, "filterAnisotropy", true)

enum class MaterialEffect {
#define NTCR_EFFECT_NAME(name, text, canForce) name,
    NTCR_EFFECT_TABLE(NTCR_EFFECT_NAME)
#undef NTCR_EFFECT_NAME
};

struct MaterialEffectInfo {
    std::string_view name;
    bool canForce; ///< on without being called for, it leaves the picture as it is
};

/// In the order of MaterialEffect.
inline constexpr MaterialEffectInfo kMaterialEffects[] = {
#define NTCR_EFFECT_INFO(name, text, canForce) {text, canForce},
    NTCR_EFFECT_TABLE(NTCR_EFFECT_INFO)
#undef NTCR_EFFECT_INFO
};
inline constexpr std::size_t kMaterialEffectCount = sizeof kMaterialEffects / sizeof kMaterialEffects[0];

/// Effects as bits.
using EffectSet = std::uint32_t;
constexpr EffectSet MakeBit(MaterialEffect effect) {
    return EffectSet{1} << static_cast<unsigned>(effect);
}

/// All that can be forced.
constexpr EffectSet GetForceableEffects() {
    EffectSet all = 0;
    for (std::size_t i = 0; i < kMaterialEffectCount; ++i)
        all |= kMaterialEffects[i].canForce ? EffectSet{1} << i : 0;
    return all;
}

} // namespace openntc::renderer
