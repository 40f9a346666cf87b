// SPDX-License-Identifier: MIT
// Stability: experimental
// Finding the cheapest compiled permutation that does what a scene needs, where not exactly that one was
// compiled.
//
//   auto permutation = MakePermutation(metadata, needs);                        // PermutationKey.h
//   auto shader = blob.FindCovering("material.frag", permutation->key);         // ShaderBlob.h, or
//   auto same = app_shaders::FindCoveringShader("material.frag", permutation->key); // OUTPUT HEADER
//
// A covering permutation gives the same bits of every texel and channel that the scene reads, and may do
// more: evaluate other channels, convert at run time, clamp. Language, network version, maths mode, texels
// per invocation, a uniform buffer of weights, latents in a buffer or a texture and the form of cooperative
// matrices are the same. Of what only
// makes reading weights faster (dot products, native halves, wide loads, subgroups, dot products in binary32)
// it has nothing that the key lacks, because a device may lack it too, and perhaps less. Effects follow the
// rules of openntc/EffectTable.h.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/permutation/PermutationDefines.h"
#include "openntc/permutation/ShaderLookup.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A compiled permutation that covers a key.
struct CoveringShader {
    std::span<const std::uint32_t> words;
    std::string_view defines; ///< what it was compiled with, as the index has it
    PermutationKey key;       ///< the same as a key: bindings may depend on it (NTC_SINGLE_MIP, for example)
};

namespace detail {

/// Bits 2c and 2c + 1 for every bit c of `mask`.
constexpr std::uint32_t DoubleBits(std::uint32_t mask) noexcept {
    std::uint32_t bits = 0;
    for (unsigned c = 0; c < NTC_MAX_CHANNELS; ++c)
        bits |= (mask >> c & 1u) * 3u << 2 * c;
    return bits;
}

constexpr bool CoversEffect(std::size_t effect, const PermutationKey& compiled,
                            const PermutationKey& wanted) noexcept {
    const std::uint32_t has = compiled.effects[effect];
    const std::uint32_t needs = wanted.effects[effect];
    switch (kEffects[effect].rule) {
    case EffectRule::Superset:
        return (needs & ~has) == 0;
    case EffectRule::AtLeast:
        return has >= needs;
    case EffectRule::AtMost:
        return has <= needs;
    case EffectRule::Linearise:
        return has == NTC_LINEARISE_RUNTIME || has == needs || needs == NTC_LINEARISE_NONE;
    case EffectRule::ColorSpaces: {
        if (compiled.effects[NTC_EFFECT_LINEARISE] != NTC_LINEARISE_CHANNELS ||
            wanted.effects[NTC_EFFECT_LINEARISE] != NTC_LINEARISE_CHANNELS)
            return true;
        // The shader checks every channel that it evaluates, and the key knows those that the scene reads.
        const std::uint32_t mask = compiled.effects[NTC_EFFECT_OUTPUT_MASK];
        return mask == wanted.effects[NTC_EFFECT_OUTPUT_MASK] && ((has ^ needs) & DoubleBits(mask)) == 0;
    }
    }
    return false;
}

/// Values of macros that definitions may name instead of writing numbers.
struct NamedValue {
    std::string_view name;
    std::uint32_t value;
};
#define OPENNTC_NAMED_VALUE(name)                                                                            \
    NamedValue {                                                                                             \
#name, name                                                                                          \
    }
inline constexpr NamedValue kNamedValues[] = {
    OPENNTC_NAMED_VALUE(NTC_NETWORK_SMALL),
    OPENNTC_NAMED_VALUE(NTC_NETWORK_MEDIUM),
    OPENNTC_NAMED_VALUE(NTC_NETWORK_LARGE),
    OPENNTC_NAMED_VALUE(NTC_NETWORK_XLARGE),
    OPENNTC_NAMED_VALUE(NTC_NETWORK_GENERATION_2),
    OPENNTC_NAMED_VALUE(NTC_NETWORK_GENERATION_3),
    OPENNTC_NAMED_VALUE(NTC_MATH_INT8),
    OPENNTC_NAMED_VALUE(NTC_MATH_INT8_HALF),
    OPENNTC_NAMED_VALUE(NTC_MATH_FP8),
    OPENNTC_NAMED_VALUE(NTC_MATH_FP16),
    OPENNTC_NAMED_VALUE(NTC_MATH_FP32),
    OPENNTC_NAMED_VALUE(NTC_MATH_COOPVEC_INT8),
    OPENNTC_NAMED_VALUE(NTC_MATH_COOPVEC_FP8),
    OPENNTC_NAMED_VALUE(NTC_MATH_COOPMAT_INT8),
    OPENNTC_NAMED_VALUE(NTC_MATH_COOPMAT_INT8_HALF),
    OPENNTC_NAMED_VALUE(NTC_FETCH_DIRECT),
    OPENNTC_NAMED_VALUE(NTC_FETCH_UNIFORM),
    OPENNTC_NAMED_VALUE(NTC_FETCH_SUBGROUP),
    OPENNTC_NAMED_VALUE(NTC_LATENTS_BUFFER),
    OPENNTC_NAMED_VALUE(NTC_LATENTS_TEXTURE),
    OPENNTC_NAMED_VALUE(NTC_LINEARISE_NONE),
    OPENNTC_NAMED_VALUE(NTC_LINEARISE_RUNTIME),
    OPENNTC_NAMED_VALUE(NTC_LINEARISE_CHANNELS),
};
#undef OPENNTC_NAMED_VALUE

/// 12, 0x1F or a name of kNamedValues; false for anything else.
constexpr bool ReadDefineValue(std::string_view text, std::uint32_t& value) noexcept {
    for (const NamedValue& named : kNamedValues) {
        if (named.name == text) {
            value = named.value;
            return true;
        }
    }
    const bool isHexadecimal = text.starts_with("0x") || text.starts_with("0X");
    const std::uint32_t base = isHexadecimal ? 16 : 10;
    std::uint64_t number = 0;
    if (isHexadecimal)
        text.remove_prefix(2);
    if (text.empty())
        return false;
    for (const char c : text) {
        const char lower = static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c);
        const std::uint32_t digit = c >= '0' && c <= '9' ? static_cast<std::uint32_t>(c - '0')
                                    : lower >= 'a' && lower <= 'f'
                                        ? static_cast<std::uint32_t>(lower - 'a' + 10)
                                        : 16;
        if (digit >= base)
            return false;
        number = number * base + digit;
        if (number > 0xFFFFFFFFu)
            return false;
    }
    value = static_cast<std::uint32_t>(number);
    return true;
}

/// Where ReadDefines puts a definition.
enum class DefineKind : std::uint8_t { Key, Own, Damaged };

/// Stores one definition, "NAME=VALUE", in the key. Own: it is none of the key's.
constexpr DefineKind ReadDefine(std::string_view word, PermutationKey& key) noexcept {
    const std::size_t equals = word.find('=');
    const std::string_view name = word.substr(0, equals);
    std::uint32_t value = 1; // of a name alone
    const bool isRead = equals == std::string_view::npos || ReadDefineValue(word.substr(equals + 1), value);
    const auto store = [&](auto& field, auto converted) {
        field = converted;
        return isRead ? DefineKind::Key : DefineKind::Damaged;
    };
    // These count when defined, whatever the value.
    if (name == "NTC_SUBGROUP_DECODES_ONE_SET")
        return DefineKind::Key; // goes with NTC_WEIGHT_FETCH
    if (name == "NTC_NATIVE_FLOAT16" || name == GetDotProductMacro(key.language)) {
        (name == "NTC_NATIVE_FLOAT16" ? key.nativeFloat16 : key.integerDotProduct) = true;
        return DefineKind::Key;
    }
    if (name == "NETWORK_VERSION")
        return store(key.networkVersion, static_cast<int>(value));
    if (name == "NTC_MATH")
        return store(key.math, static_cast<int>(value));
    if (name == "NTC_WEIGHT_FETCH")
        return store(key.weightFetch, static_cast<int>(value));
    if (name == "NTC_LATENT_FETCH")
        return store(key.latentFetch, static_cast<int>(value));
    if (name == "NTC_TEXELS_PER_INVOCATION")
        return store(key.texelsPerInvocation, static_cast<int>(value));
    if (name == "NTC_WIDE_WEIGHT_LOADS")
        return store(key.wideWeightLoads, value != 0);
    if (name == "NTC_COOPMAT_LANES")
        return store(key.matrixLanes, value != 0);
    if (name == "NTC_FLOAT_DOT")
        return store(key.floatDot, value != 0);
    for (std::size_t i = 0; i < NTC_EFFECT_COUNT; ++i) {
        if (name == kEffects[i].macro)
            return store(key.effects[i], value);
    }
    return DefineKind::Own;
}

} // namespace detail

/// Does a shader compiled with `compiled` give a scene whose key is `wanted` the same bits of all that it
/// reads?
constexpr bool Covers(const PermutationKey& compiled, const PermutationKey& wanted) noexcept {
    const auto isAtMost = [](bool has, bool may) { return !has || may; };
    if (compiled.language != wanted.language || compiled.networkVersion != wanted.networkVersion ||
        compiled.math != wanted.math || compiled.texelsPerInvocation != wanted.texelsPerInvocation ||
        compiled.latentFetch != wanted.latentFetch || compiled.matrixLanes != wanted.matrixLanes)
        return false;
    if (compiled.weightFetch != wanted.weightFetch &&
        !(compiled.weightFetch == NTC_FETCH_DIRECT && wanted.weightFetch == NTC_FETCH_SUBGROUP))
        return false;
    if (!isAtMost(compiled.integerDotProduct, wanted.integerDotProduct) ||
        !isAtMost(compiled.nativeFloat16, wanted.nativeFloat16) ||
        !isAtMost(compiled.wideWeightLoads, wanted.wideWeightLoads) ||
        !isAtMost(compiled.floatDot, wanted.floatDot))
        return false;
    for (std::size_t i = 0; i < NTC_EFFECT_COUNT; ++i) {
        if (!detail::CoversEffect(i, compiled, wanted))
            return false;
    }
    return true;
}

/// What a covering permutation costs beside others: first what the weights are read without (subgroups, dot
/// products and native halves, wide loads, dot products in binary32), then outputs evaluated, then the other
/// effects. An order, not a time. The exact permutation is the cheapest.
constexpr std::uint32_t GetCoverCost(const PermutationKey& compiled, const PermutationKey& wanted) noexcept {
    std::uint32_t missing = compiled.weightFetch != wanted.weightFetch ? 16 : 0;
    missing += compiled.integerDotProduct != wanted.integerDotProduct ? 8 : 0;
    missing += compiled.nativeFloat16 != wanted.nativeFloat16 ? 4 : 0;
    missing += compiled.wideWeightLoads != wanted.wideWeightLoads ? 2 : 0;
    missing += compiled.floatDot != wanted.floatDot ? 1 : 0;
    const auto& effects = compiled.effects;
    std::uint32_t rest = effects[NTC_EFFECT_LINEARISE] == NTC_LINEARISE_RUNTIME    ? 8u
                         : effects[NTC_EFFECT_LINEARISE] == NTC_LINEARISE_CHANNELS ? 4u
                                                                                   : 0u;
    rest += effects[NTC_EFFECT_LATENT_SLICES] != 0 ? 1u : 0u;
    rest += effects[NTC_EFFECT_CLAMP_TEXELS] != 0 ? 1u : 0u;
    rest += effects[NTC_EFFECT_SINGLE_MIP] == 0 ? 1u : 0u;
    for (std::size_t i = NTC_EFFECT_TILE_FALLBACK; i <= NTC_EFFECT_TILE_RATES; ++i)
        rest += effects[i] != 0 ? 1u : 0u;
    const int outputs = std::popcount(effects[NTC_EFFECT_OUTPUT_MASK]);
    return missing << 16 | static_cast<std::uint32_t>(outputs) << 8 | rest;
}

/// The key of what `defines` compile. Macros that are not the key's must be `ownDefines`, all of them and no
/// others; false if they are not, and for values that are neither numbers nor names such as NTC_MATH_FP8.
constexpr bool ReadDefines(std::string_view defines, std::string_view ownDefines, ShaderLanguage language,
                           PermutationKey& key) noexcept {
    key = {};
    key.language = language;
    for (std::size_t i = 0; i < NTC_EFFECT_COUNT; ++i)
        key.effects[i] = kEffects[i].defaultValue;
    if (CountMissingWords(defines, ownDefines) != 0)
        return false;
    for (std::string_view word = TakeShaderWord(defines); !word.empty(); word = TakeShaderWord(defines)) {
        const detail::DefineKind kind = detail::ReadDefine(word, key);
        if (kind == detail::DefineKind::Damaged ||
            (kind == detail::DefineKind::Own && CountMissingWords(ownDefines, word) != 0))
            return false;
    }
    return true;
}

/// A place in an index of permutations, and its key.
struct CoverMatch {
    std::size_t index;
    PermutationKey key;
};

/// The cheapest of the `count` permutations of `source` that covers `wanted` and has exactly `ownDefines`
/// besides; of several equally cheap ones the first. `getKey(i)` gives their names, in order from 0, perhaps
/// twice; `leftOut` lists the defines that had no compiler. Errors: ShaderUnavailable, naming permutations
/// that would do.
template <typename GetKey>
Expected<CoverMatch> FindCover(std::string_view source, const PermutationKey& wanted,
                               std::string_view ownDefines, std::string_view leftOut, std::size_t count,
                               const GetKey& getKey) noexcept {
    CoverMatch best{count, {}};
    std::uint32_t bestCost = 0;
    bool hasSource = false;
    for (std::size_t i = 0; i < count; ++i) {
        const ShaderKey name = getKey(i);
        PermutationKey key;
        if (name.source != source)
            continue;
        hasSource = true;
        if (!ReadDefines(name.defines, ownDefines, wanted.language, key) || !Covers(key, wanted))
            continue;
        const std::uint32_t cost = GetCoverCost(key, wanted);
        if (best.index == count || cost < bestCost) {
            best = {i, key};
            bestCost = cost;
        }
    }
    if (best.index != count)
        return best;
    const DefineList defines = wanted.ToDefines();
    if (!hasSource || detail::IsLeftOut(leftOut, defines.View()))
        return FailMissingShader({source, defines.View()}, leftOut, count, getKey);
    PermutationKey all; // without any effect reduced, and the weights read in the plainest way
    all.language = wanted.language;
    all.networkVersion = wanted.networkVersion;
    all.math = wanted.math;
    all.texelsPerInvocation = wanted.texelsPerInvocation;
    all.matrixLanes = wanted.matrixLanes;
    all.weightFetch = wanted.weightFetch == NTC_FETCH_SUBGROUP ? NTC_FETCH_DIRECT : wanted.weightFetch;
    for (std::size_t i = 0; i < NTC_EFFECT_COUNT; ++i)
        all.effects[i] = kEffects[i].defaultValue;
    const int ownLength = detail::GetPrintLength(ownDefines);
    return Fail(
        Status::ShaderUnavailable,
        "shader: %.*s: none of %zu permutations covers the scene: add %s%s%.*s, or, for every scene, %s",
        detail::GetPrintLength(source), source.data(), count, defines.GetText(), ownLength != 0 ? " " : "",
        ownLength, ownDefines.data(), all.ToDefines().GetText());
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
