// SPDX-License-Identifier: MIT
// Stability: stable
// From what a scene needs of a texture set to the shader permutation that does just that.
//
//   SceneNeeds needs;
//   needs.textures = names;                                                    // "Albedo", "Normal"
//   auto permutation = MakePermutation(metadata, needs); // or a Status that says what is wrong
//   auto spirv = app_shaders::FindShader("my.comp", permutation->key.ToDefines().View());
#pragma once

#include "openntc/core/FloatBits.h"
#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/inference/CooperativeVectors.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/permutation/PermutationDefines.h"
#include "openntc/permutation/SceneNeeds.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What one effect does in a permutation, and why.
struct EffectReport {
    std::uint32_t value = 0;
    bool isReduced = false;  ///< the shader does less than the default one
    const char* reason = ""; ///< one sentence
};

/// A key, and what it means for the texture set that it was made for.
struct Permutation {
    PermutationKey key;
    InferenceWeightType weightType = InferenceWeightType::GenericInt8; ///< the weights to upload
    std::array<EffectReport, NTC_EFFECT_COUNT> effects{};
    int multiplications = 0;            ///< of weights, per texel
    int allMultiplications = 0;         ///< the same when all 16 outputs are evaluated
    int colorConversions = 0;           ///< sRGB or HLG decodings per texel
    std::uint32_t constantChannels = 0; ///< channels asked for that are constants and not evaluated
    std::array<float, NTC_MAX_CHANNELS> constants{}; ///< their values, as stored
};

/// Outputs of the network that do not depend on its inputs.
struct ConstantOutputs {
    std::uint32_t mask = 0;                       ///< bit c: output c is constant
    std::array<float, NTC_MAX_CHANNELS> values{}; ///< as stored
};

/// Finds the outputs whose row of Int8 weights is all zero; their value is bias · scale in binary32, which is
/// what every maths mode gives up to its own rounding of the result. Without Int8 weights none is found.
inline ConstantOutputs FindConstantOutputs(const InferenceWeights& weights) noexcept {
    ConstantOutputs result;
    if (weights.int8.empty() || !IsKnownNetwork(weights.networkVersion))
        return result;
    const NetworkDescription network = GetNetworkDescription(weights.networkVersion);
    const std::size_t inputs = static_cast<std::size_t>(network.inputs[3]);
    const std::byte* data = weights.int8.data();
    for (std::size_t row = 0; row < NTC_MAX_CHANNELS; ++row) {
        const std::byte* rowWeights = data + network.weightOffsets[3] + row * inputs;
        bool isZero = true;
        for (std::size_t i = 0; i < inputs; ++i)
            isZero = isZero && rowWeights[i] == std::byte{0};
        if (!isZero)
            continue;
        std::uint32_t bias = 0;
        std::memcpy(&bias, data + network.int8BiasOffsets[3] + 4 * row, 4);
        std::uint32_t scaleBits = 0;
        std::memcpy(&scaleBits, data + network.int8ScaleOffsets[3] + 4 * row, 4);
        const float scale = BitCast<float>(scaleBits);
        result.mask |= 1u << row;
        result.values[row] = static_cast<float>(static_cast<std::int32_t>(bias)) * scale;
    }
    return result;
}

namespace detail {

inline Expected<std::uint32_t> GetNeededChannels(const TextureSetMetadata& metadata,
                                                 const InferenceWeights& weights,
                                                 const SceneNeeds& needs) noexcept {
    if ((needs.channels & ~weights.validChannelMask) != 0)
        return Fail(Status::OutOfRange, "channels: 0x%X: must be among the set's, 0x%X", needs.channels,
                    weights.validChannelMask);
    std::uint32_t mask = needs.channels;
    for (const std::string_view name : needs.textures) {
        bool isFound = false;
        for (const Texture& texture : metadata.GetTextures()) {
            if (texture.name != name)
                continue;
            isFound = true;
            for (int c = texture.firstChannel; c < texture.firstChannel + texture.numChannels; ++c)
                mask |= 1u << c;
        }
        if (!isFound)
            return Fail(Status::InvalidArgument, "textures: \"%.*s\": the set has no such texture",
                        static_cast<int>(name.size()), name.data());
    }
    if (needs.channels == 0 && needs.textures.empty())
        mask = weights.validChannelMask;
    if (mask == 0)
        return Fail(Status::InvalidArgument, "textures, channels: none: at least one channel must be read");
    return mask;
}

/// The maths mode and the weights that it reads.
struct MathChoice {
    int math;
    InferenceWeightType weights;
    bool matrixLanes = false; ///< cooperative matrices: the lanes' form
};

inline bool IsMatrixMath(int math) noexcept {
    return math == NTC_MATH_COOPMAT_INT8 || math == NTC_MATH_COOPMAT_INT8_HALF;
}

inline Expected<MathChoice> ChooseMath(const InferenceWeights& weights, const SceneNeeds& needs) noexcept {
    const bool hasInt8 = !weights.int8.empty();
    const bool hasFP8 = !weights.fp8.empty();
    // The last layer of the FP8 network is an Int8 one. HLSL has no cooperative vectors and matrices.
    const bool isCooperative = needs.language == ShaderLanguage::Glsl;
    const CoopVecDevice vectors = {
        isCooperative && (needs.device.cooperativeVectorInt8 || needs.device.cooperativeVectorFP8),
        isCooperative && needs.device.cooperativeVectorInt8,
        isCooperative && needs.device.cooperativeVectorFP8};
    const bool canInt8 = hasInt8 && vectors.hasInt8;
    const bool canFP8 = hasFP8 && vectors.hasInt8 && vectors.hasE4M3;
    const bool canMatrices =
        isCooperative && hasInt8 && needs.decodesOnMatrices && needs.device.cooperativeMatrixInt8;
    const bool canLanes = canMatrices && needs.device.cooperativeMatrixLanes &&
                          FitsCoopMatLanes(weights.networkVersion, weights.int8.AsSpan());
    if (needs.preference == MathPreference::Fastest && canLanes)
        return MathChoice{NTC_MATH_COOPMAT_INT8, InferenceWeightType::CoopMatInt8, true};
    const MathChoice emulatedFP8 = {NTC_MATH_FP8, InferenceWeightType::GenericFP8};
    switch (needs.preference) {
    case MathPreference::Fastest:
    case MathPreference::FP8First:
    case MathPreference::Exact:
        switch (PickWeightType(needs.preference == MathPreference::Exact ? CoopVecDevice{} : vectors, hasInt8,
                               hasFP8,
                               needs.preference == MathPreference::FP8First ? CoopVecOrder::FP8First
                                                                            : CoopVecOrder::Int8First)) {
        case InferenceWeightType::CoopVecFP8:
            return MathChoice{NTC_MATH_COOPVEC_FP8, InferenceWeightType::CoopVecFP8};
        case InferenceWeightType::CoopVecInt8:
            return MathChoice{NTC_MATH_COOPVEC_INT8, InferenceWeightType::CoopVecInt8};
        case InferenceWeightType::GenericInt8:
            return MathChoice{NTC_MATH_INT8, InferenceWeightType::GenericInt8};
        case InferenceWeightType::GenericFP8:
            return emulatedFP8;
        case InferenceWeightType::CoopMatInt8: // never picked by PickWeightType
        case InferenceWeightType::Unknown:
            break;
        }
        return Fail(Status::Unsupported, "weights: none: needs Int8 or FP8 weights");
    case MathPreference::Specific:
        break;
    default:
        return Fail(Status::InvalidArgument, "preference: %d: not a preference",
                    static_cast<int>(needs.preference));
    }
    switch (needs.math) {
    case NTC_MATH_INT8:
    case NTC_MATH_INT8_HALF:
    case NTC_MATH_FP16:
    case NTC_MATH_FP32:
        if (!hasInt8)
            return Fail(Status::Unsupported, "math: %d: the set has no Int8 weights", needs.math);
        return MathChoice{needs.math, InferenceWeightType::GenericInt8};
    case NTC_MATH_FP8:
        if (!hasFP8)
            return Fail(Status::Unsupported, "math: %d: the set has no FP8 weights", needs.math);
        return emulatedFP8;
    case NTC_MATH_COOPVEC_INT8:
        if (!canInt8)
            return Fail(Status::Unsupported, "math: %d: needs Int8 weights, cooperativeVectorInt8 and GLSL",
                        needs.math);
        return MathChoice{needs.math, InferenceWeightType::CoopVecInt8};
    case NTC_MATH_COOPVEC_FP8:
        if (!canFP8)
            return Fail(Status::Unsupported,
                        "math: %d: needs FP8 weights, cooperativeVectorFP8, cooperativeVectorInt8 and GLSL",
                        needs.math);
        return MathChoice{needs.math, InferenceWeightType::CoopVecFP8};
    case NTC_MATH_COOPMAT_INT8:
    case NTC_MATH_COOPMAT_INT8_HALF:
        if (!canMatrices)
            return Fail(
                Status::Unsupported,
                "math: %d: needs Int8 weights, cooperativeMatrixInt8, GLSL and a pass that decodes on "
                "matrices",
                needs.math);
        return MathChoice{needs.math, InferenceWeightType::CoopMatInt8, canLanes};
    default:
        return Fail(Status::OutOfRange, "math: %d: not a maths mode", needs.math);
    }
}

/// Colour spaces of the channels in `mask` that are sRGB or HLG; 0 elsewhere.
inline std::uint32_t SelectColorSpaces(std::uint32_t colorSpaces, std::uint32_t mask) noexcept {
    std::uint32_t result = 0;
    for (unsigned c = 0; c < NTC_MAX_CHANNELS; ++c) {
        if ((mask >> c & 1u) != 0)
            result |= colorSpaces & 3u << 2 * c;
    }
    return result;
}

inline int CountConversions(std::uint32_t colorSpaces) noexcept {
    int count = 0;
    for (unsigned c = 0; c < NTC_MAX_CHANNELS; ++c) {
        const std::uint32_t space = colorSpaces >> 2 * c & 3u;
        count += space == NTC_COLOR_SPACE_SRGB || space == NTC_COLOR_SPACE_HLG ? 1 : 0;
    }
    return count;
}

/// How weights are read, by the kind of device; the defaults of openntc/WeightFetch.h, which says what was
/// measured.
inline void ChooseWeightFetch(const SceneNeeds& needs, PermutationKey& key) noexcept {
    if (key.math != NTC_MATH_INT8 && key.math != NTC_MATH_INT8_HALF)
        return; // the other forms are for these modes
    if (needs.device.isCpu) {
        if (!needs.device.subgroupShuffle || !needs.oneSetPerSubgroup ||
            needs.language != ShaderLanguage::Glsl)
            return;
        key.weightFetch = NTC_FETCH_SUBGROUP;
        key.floatDot = true;
        key.wideWeightLoads = needs.alignedWeights;
        key.integerDotProduct = false; // nothing would use it
        key.texelsPerInvocation = needs.decodesBlocks ? 2 : 1;
    } else if (needs.device.integerDotProduct) {
        key.wideWeightLoads = needs.alignedWeights;
        if (needs.decodesBlocks && key.math == NTC_MATH_INT8)
            key.texelsPerInvocation = 2;
    }
}

/// How latents are read, as the engine has bound them.
inline Expected<int> ChooseLatentFetch(const InferenceWeights& weights, const SceneNeeds& needs) noexcept {
    if (!needs.latentTextures)
        return NTC_LATENTS_BUFFER;
    if (IsNetworkVersion(weights.networkVersion))
        return Fail(Status::Unsupported, "latentTextures: of a set of generation 1: only those of 2 and 3");
    if (needs.tiles.used || !needs.wholeLatents)
        return Fail(Status::InvalidArgument,
                    "latentTextures: with slices or tiles: a texture has whole latents");
    return NTC_LATENTS_TEXTURE;
}

/// True if the constants' mip 0 is served by latent image 0, as NTC_SINGLE_MIP takes for granted.
inline bool IsFirstMipSimple(const TextureSetMetadata& metadata) noexcept {
    return metadata.GetColorMips()[0].neuralMip == 0;
}

} // namespace detail

/// Picks the permutation for a texture set whose outputs are `weights` (the metadata's own, or shuffled ones;
/// textures named in the needs keep the channels that the metadata gives them). A request for linear light
/// makes a shader with code for exactly the channels that need it; without one the shader has no such code.
/// Errors: InvalidArgument for a texture that the set lacks, a request that reads nothing, a filter,
/// preference or language that does not exist, latents that are slices of a texture; OutOfRange for channels
/// that no texture covers and numbers that are no maths mode; Unsupported for a maths mode without its
/// weights, device feature or language, and for latents of generation 1 in a texture.
inline Expected<Permutation> MakePermutation(const TextureSetMetadata& metadata,
                                             const InferenceWeights& weights,
                                             const SceneNeeds& needs) noexcept {
    if (needs.filter != Filter::Point)
        return Fail(Status::InvalidArgument, "filter: %d: not a filter", static_cast<int>(needs.filter));
    if (needs.language != ShaderLanguage::Glsl && needs.language != ShaderLanguage::Hlsl)
        return Fail(Status::InvalidArgument, "language: %d: not a language",
                    static_cast<int>(needs.language));
    if (!IsKnownNetwork(weights.networkVersion))
        return Fail(Status::InvalidArgument, "weights.networkVersion: %d: must be 1 … 6",
                    weights.networkVersion);
    OPENNTC_ASSIGN(const std::uint32_t needed, detail::GetNeededChannels(metadata, weights, needs));
    OPENNTC_ASSIGN(const detail::MathChoice choice, detail::ChooseMath(weights, needs));

    Permutation result;
    std::uint32_t mask = needed;
    if (needs.foldConstants) {
        const ConstantOutputs constants = FindConstantOutputs(weights);
        result.constantChannels = constants.mask & needed;
        result.constants = constants.values;
        mask &= ~constants.mask;
        if (mask == 0) { // a shader reads something: the lowest channel stays
            mask = needed & (~needed + 1u);
            result.constantChannels &= ~mask;
        }
    }
    PermutationKey& key = result.key;
    key.language = needs.language;
    key.networkVersion = weights.networkVersion;
    key.math = choice.math;
    result.weightType = choice.weights;
    key.integerDotProduct = needs.device.integerDotProduct && choice.math != NTC_MATH_COOPVEC_INT8 &&
                            choice.math != NTC_MATH_COOPVEC_FP8 && !detail::IsMatrixMath(choice.math);
    key.matrixLanes = choice.matrixLanes;
    key.nativeFloat16 = choice.math == NTC_MATH_FP16 && needs.device.float16;
    detail::ChooseWeightFetch(needs, key);
    OPENNTC_ASSIGN(key.latentFetch, detail::ChooseLatentFetch(weights, needs));

    const auto set = [&](int effect, std::uint32_t value, bool isReduced, const char* reason) {
        key.effects[static_cast<std::size_t>(effect)] = value;
        result.effects[static_cast<std::size_t>(effect)] = {value, isReduced, reason};
    };
    const int outputs = std::popcount(mask);
    set(NTC_EFFECT_OUTPUT_MASK, mask, mask != 0xFFFFu,
        mask == 0xFFFFu                ? "All 16 outputs are read."
        : result.constantChannels != 0 ? "Outputs that nobody reads or that are constants are not evaluated."
                                       : "Outputs that nobody reads are not evaluated.");
    const std::uint32_t spaces =
        needs.linear ? detail::SelectColorSpaces(weights.channelColorSpaces, mask) : 0u;
    result.colorConversions = detail::CountConversions(spaces);
    if (result.colorConversions != 0) {
        set(NTC_EFFECT_LINEARISE, NTC_LINEARISE_CHANNELS, true,
            "Linear light: code for the channels read that are sRGB or HLG.");
        set(NTC_EFFECT_CHANNEL_COLOR_SPACES, spaces, false, "The channels that need it.");
    } else if (needs.linear) {
        // The shader's caller asks for linear light, which a shader without the code would refuse.
        set(NTC_EFFECT_LINEARISE, NTC_LINEARISE_CHANNELS, true,
            "Linear light, but every channel read is linear as stored.");
        set(NTC_EFFECT_CHANNEL_COLOR_SPACES, 0, false, "None needs it.");
    } else {
        set(NTC_EFFECT_LINEARISE, NTC_LINEARISE_NONE, true, "Values are read as stored.");
        set(NTC_EFFECT_CHANNEL_COLOR_SPACES, 0, false, "Nothing is converted.");
    }
    const bool isTiled = needs.tiles.used;
    const bool isOneMip = metadata.GetDesc().mips == 1 || needs.firstMipOnly;
    const bool isSingle = !isTiled && isOneMip && detail::IsFirstMipSimple(metadata);
    set(NTC_EFFECT_SINGLE_MIP, isSingle ? 1 : 0, isSingle,
        isTiled    ? "Tiles are slices of several mips."
        : isSingle ? "Only mip 0 exists or is sampled."
        : isOneMip ? "Only mip 0 is sampled, but another latent image than the first serves it."
                   : "Several mips are sampled.");
    const bool isWhole = needs.wholeLatents && !isTiled;
    set(NTC_EFFECT_LATENT_SLICES, isWhole ? 0 : 1, isWhole,
        isWhole ? "Latent images are whole." : "Latent images may be slices.");
    set(NTC_EFFECT_CLAMP_TEXELS, needs.texelsInside ? 0 : 1, needs.texelsInside,
        needs.texelsInside ? "The shader asks for texels inside the mip only."
                           : "Texels may lie outside the mip.");
    const auto setTiles = [&](int effect, bool isNeeded, const char* used, const char* unused) {
        const char* const reason = !isTiled ? "No tiles are read." : isNeeded ? used : unused;
        set(effect, !isTiled || isNeeded ? 1 : 0, isTiled && !isNeeded, reason);
    };
    setTiles(NTC_EFFECT_TILE_FALLBACK, needs.tiles.fallback, "Coarser mips stand for missing tiles.",
             "What is not resident is not used.");
    setTiles(NTC_EFFECT_TILE_REQUESTS, needs.tiles.requests, "Missing tiles are requested.",
             "Nothing is requested.");
    setTiles(NTC_EFFECT_TILE_STAMPS, needs.tiles.stamps, "Slots that are read are stamped.",
             "No slot is stamped.");
    setTiles(NTC_EFFECT_TILE_FEEDBACK, needs.tiles.feedback, "Feedback is recorded.",
             "No feedback is recorded.");
    setTiles(NTC_EFFECT_TILE_RATES, needs.tiles.rates, "Rates may be below 1.", "Rates are 1.");

    const NetworkDescription network = GetNetworkDescription(weights.networkVersion);
    const int hidden = network.weightOffsets[3]; // one byte a weight
    result.multiplications = hidden + network.inputs[3] * outputs;
    result.allMultiplications = hidden + network.inputs[3] * NTC_MAX_CHANNELS;
    return result;
}

inline Expected<Permutation> MakePermutation(const TextureSetMetadata& metadata,
                                             const SceneNeeds& needs) noexcept {
    return MakePermutation(metadata, metadata.GetWeights(), needs);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
