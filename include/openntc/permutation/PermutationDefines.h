// SPDX-License-Identifier: MIT
// Stability: stable
// The name of a shader permutation: what it is compiled with, as a key to compare and as a list of
// definitions. Needs no texture set; PermutationKey.h makes keys from what a scene needs.
#pragma once

#include "openntc/EffectTable.h"
#include "openntc/InferenceConstants.h"
#include "openntc/LatentFetch.h"
#include "openntc/MathModes.h"
#include "openntc/WeightFetch.h"
#include "openntc/permutation/SceneNeeds.h"

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Which compiled values of an effect serve a wanted one; openntc/EffectTable.h says what each means.
enum class EffectRule : std::uint8_t { Superset, AtLeast, AtMost, Linearise, ColorSpaces };

/// One effect of the table that shaders share (openntc/EffectTable.h).
struct EffectInfo {
    const char* name;           ///< "OutputMask"
    const char* macro;          ///< "NTC_OUTPUT_MASK"
    std::uint32_t defaultValue; ///< of a shader that does not define the macro
    EffectRule rule;
};

#define OPENNTC_EFFECT_INFO(name, macro, fallback, rule)                                                     \
    EffectInfo{#name, #macro, fallback, EffectRule::rule},
/// All effects, by their number NTC_EFFECT_*.
inline constexpr EffectInfo kEffects[] = {NTC_EFFECT_TABLE(OPENNTC_EFFECT_INFO)};
#undef OPENNTC_EFFECT_INFO
static_assert(sizeof(kEffects) / sizeof(kEffects[0]) == NTC_EFFECT_COUNT);

/// Definitions separated by spaces, such as "NETWORK_VERSION=2 NTC_MATH=1 NTC_OUTPUT_MASK=0x7".
class DefineList {
public:
    std::string_view View() const noexcept { return {text_.data(), size_}; }
    const char* GetText() const noexcept { return text_.data(); } ///< ends with a zero

    void Add(const char* macro, std::uint32_t value, bool isHexadecimal) noexcept {
        const std::size_t room = text_.size() - size_;
        const int written = std::snprintf(text_.data() + size_, room, isHexadecimal ? "%s%s=0x%X" : "%s%s=%u",
                                          size_ == 0 ? "" : " ", macro, static_cast<unsigned>(value));
        if (written > 0 && static_cast<std::size_t>(written) < room)
            size_ += static_cast<std::size_t>(written);
    }

private:
    std::array<char, 768> text_{}; // every macro at its longest value takes less
    std::size_t size_ = 0;
};

/// The macro that turns the device's dot product of four signed bytes on.
constexpr const char* GetDotProductMacro(ShaderLanguage language) noexcept {
    return language == ShaderLanguage::Hlsl ? "NTC_DOT4_SM64" : "NTC_DOT4_SPIRV";
}

/// Which SPIR-V. Equal keys mean the same shader; the order is total and the same on every machine.
struct PermutationKey {
    ShaderLanguage language = ShaderLanguage::Glsl; ///< of the source, which the caller names
    int networkVersion = NTC_NETWORK_UNKNOWN;
    int math = NTC_MATH_INT8;                              ///< NTC_MATH_*
    int weightFetch = NTC_FETCH_DIRECT;                    ///< NTC_FETCH_*
    int latentFetch = NTC_LATENTS_BUFFER;                  ///< NTC_LATENTS_*, NTC_LATENT_FETCH
    int texelsPerInvocation = 1;                           ///< NTC_TEXELS_PER_INVOCATION
    bool wideWeightLoads = false;                          ///< NTC_WIDE_WEIGHT_LOADS
    bool floatDot = false;                                 ///< NTC_FLOAT_DOT
    bool integerDotProduct = false;                        ///< NTC_DOT4_SPIRV, in HLSL NTC_DOT4_SM64
    bool nativeFloat16 = false;                            ///< NTC_NATIVE_FLOAT16
    bool matrixLanes = false;                              ///< NTC_COOPMAT_LANES
    std::array<std::uint32_t, NTC_EFFECT_COUNT> effects{}; ///< by NTC_EFFECT_*

    friend constexpr bool operator==(const PermutationKey&, const PermutationKey&) noexcept = default;
    // Written out because libc++'s std::array has no such operator before version 17.
    friend constexpr std::strong_ordering operator<=>(const PermutationKey& a,
                                                      const PermutationKey& b) noexcept {
        const auto head = [](const PermutationKey& k) {
            return std::array<std::uint32_t, 11>{static_cast<std::uint32_t>(k.language),
                                                 static_cast<std::uint32_t>(k.networkVersion),
                                                 static_cast<std::uint32_t>(k.math),
                                                 static_cast<std::uint32_t>(k.weightFetch),
                                                 static_cast<std::uint32_t>(k.latentFetch),
                                                 static_cast<std::uint32_t>(k.texelsPerInvocation),
                                                 k.wideWeightLoads,
                                                 k.floatDot,
                                                 k.integerDotProduct,
                                                 k.nativeFloat16,
                                                 k.matrixLanes};
        };
        const auto first = head(a), second = head(b);
        for (std::size_t i = 0; i < first.size(); ++i) {
            if (first[i] != second[i])
                return first[i] <=> second[i];
        }
        for (std::size_t i = 0; i < a.effects.size(); ++i) {
            if (a.effects[i] != b.effects[i])
                return a.effects[i] <=> b.effects[i];
        }
        return std::strong_ordering::equal;
    }

    /// The definitions to compile with, and to ask FindShader() for: network version, maths mode, and what
    /// differs from the defaults. PermutationCover.h finds permutations that were compiled with others and do
    /// as well. Masks and colour spaces are hexadecimal (0x1F), the rest decimal: in openntc_add_shaders
    /// write them the same way.
    DefineList ToDefines() const noexcept {
        DefineList list;
        list.Add("NETWORK_VERSION", static_cast<std::uint32_t>(networkVersion), false);
        list.Add("NTC_MATH", static_cast<std::uint32_t>(math), false);
        if (integerDotProduct)
            list.Add(GetDotProductMacro(language), 1, false);
        if (nativeFloat16)
            list.Add("NTC_NATIVE_FLOAT16", 1, false);
        if (matrixLanes)
            list.Add("NTC_COOPMAT_LANES", 1, false);
        if (latentFetch != NTC_LATENTS_BUFFER)
            list.Add("NTC_LATENT_FETCH", static_cast<std::uint32_t>(latentFetch), false);
        if (weightFetch != NTC_FETCH_DIRECT)
            list.Add("NTC_WEIGHT_FETCH", static_cast<std::uint32_t>(weightFetch), false);
        if (weightFetch == NTC_FETCH_SUBGROUP)
            list.Add("NTC_SUBGROUP_DECODES_ONE_SET", 1, false);
        if (texelsPerInvocation != 1)
            list.Add("NTC_TEXELS_PER_INVOCATION", static_cast<std::uint32_t>(texelsPerInvocation), false);
        if (wideWeightLoads)
            list.Add("NTC_WIDE_WEIGHT_LOADS", 1, false);
        if (floatDot)
            list.Add("NTC_FLOAT_DOT", 1, false);
        for (std::size_t i = 0; i < effects.size(); ++i) {
            const bool isHexadecimal = i == NTC_EFFECT_OUTPUT_MASK || i == NTC_EFFECT_CHANNEL_COLOR_SPACES;
            const bool isRequired = i == NTC_EFFECT_CHANNEL_COLOR_SPACES &&
                                    effects[NTC_EFFECT_LINEARISE] == NTC_LINEARISE_CHANNELS;
            if (isRequired || effects[i] != kEffects[i].defaultValue)
                list.Add(kEffects[i].macro, effects[i], isHexadecimal);
        }
        return list;
    }
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
