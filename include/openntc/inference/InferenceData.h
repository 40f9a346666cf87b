// SPDX-License-Identifier: MIT
// Stability: stable
// The constants that shaders need, and permutation of network outputs.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Expected.h"
#include "openntc/core/FloatBits.h"
#include "openntc/texture_set/InferenceWeights.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Where one of the 16 outputs comes from after ShuffleInferenceOutputs.
struct ShuffleSource {
    enum class Kind : std::uint8_t {
        Undefined, ///< nobody reads it: 0, not in the valid-channel mask
        Channel,   ///< the present output `channel`
        Constant,  ///< the number `constant`, in a Linear channel
    };
    Kind kind = Kind::Undefined;
    int channel = 0;       ///< 0 … 15
    float constant = 0.0f; ///< |constant| < 32768, resolution 2^-16

    static constexpr ShuffleSource Undefined() noexcept { return {}; }
    static constexpr ShuffleSource Channel(int channel) noexcept { return {Kind::Channel, channel, 0.0f}; }
    static constexpr ShuffleSource Constant(float value) noexcept { return {Kind::Constant, 0, value}; }
};

/// Makes a copy of the weights whose output c is sources[c]; works on shuffled weights again (permutations
/// compose). Textures in the metadata keep their channel numbers. Source: format specification, "channel
/// shuffle and mask". Errors: OutOfRange for a channel outside 0 … 15 or a constant that is not finite or too
/// large; InvalidArgument for an unknown kind; OutOfMemory.
Expected<InferenceWeights> ShuffleInferenceOutputs(const InferenceWeights& weights,
                                                   std::span<const ShuffleSource, NTC_MAX_CHANNELS> sources,
                                                   Allocator& allocator = GetDefaultAllocator()) noexcept;

/// Fills the texture-set constants for a buffer of latents that holds the bytes `latentRange` of the stream.
/// Latent images that are not wholly inside the range are absent (slice size 0): sampling their mips fails
/// cleanly. Weights given separately are those of `metadata` after ShuffleInferenceOutputs. Errors:
/// Unsupported if the weights have no `weightType` form (cooperative-vector forms never, yet);
/// InvalidArgument if the range starts off the 4-byte grid of the latents or `shuffled` has another network
/// version; OutOfRange if a present image starts 4 GiB or more after the start of the range.
Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata,
                                                   StreamRange latentRange,
                                                   InferenceWeightType weightType) noexcept;
Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata,
                                                   StreamRange latentRange, InferenceWeightType weightType,
                                                   const InferenceWeights& shuffled) noexcept;

/// Fills the constants, for sets of every generation, for a buffer that ReadLatents fills for these mips (and
/// all others that the same latents serve). Errors: those above; OutOfRange for mips that the set does not
/// have.
Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata, int firstMip,
                                                   int numMips, InferenceWeightType weightType) noexcept;
Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata, int firstMip,
                                                   int numMips, InferenceWeightType weightType,
                                                   const InferenceWeights& shuffled) noexcept;

/// The constants that shaders of LibNTC 0.8 and 0.9 read, which sample latents from textures. Errors:
/// Unsupported if the weights have no `weightType` form, or for a set of generation 1.
Expected<NtcTextureSetConstants2> MakeTextureConstants(const TextureSetMetadata& metadata,
                                                       InferenceWeightType weightType) noexcept;

namespace detail {

/// Replaces the output layer of one weight buffer.
inline void ShuffleOutputLayer(std::span<const std::byte> source, std::span<std::byte> destination,
                               std::span<const ShuffleSource, NTC_MAX_CHANNELS> sources,
                               const NetworkDescription& network, int scaleOffset, int biasOffset) noexcept {
    const int weightOffset = network.weightOffsets[3];
    const auto rowBytes = static_cast<std::size_t>(network.inputs[3]);
    const std::size_t weights = static_cast<std::size_t>(weightOffset);
    const std::size_t scales = static_cast<std::size_t>(scaleOffset);
    const std::size_t biases = static_cast<std::size_t>(biasOffset);
    for (std::size_t row = 0; row < NTC_MAX_CHANNELS; ++row) {
        std::byte* rowWeights = destination.data() + weights + row * rowBytes;
        std::byte* rowScale = destination.data() + scales + row * 4;
        std::byte* rowBias = destination.data() + biases + row * 4;
        if (sources[row].kind == ShuffleSource::Kind::Channel) {
            const std::size_t from = static_cast<std::size_t>(sources[row].channel);
            std::memcpy(rowWeights, source.data() + weights + from * rowBytes, rowBytes);
            std::memcpy(rowScale, source.data() + scales + from * 4, 4);
            std::memcpy(rowBias, source.data() + biases + from * 4, 4);
        } else {
            const bool isConstant = sources[row].kind == ShuffleSource::Kind::Constant;
            std::memset(rowWeights, 0, rowBytes);
            StoreScalar(rowScale, kConstantRowScale);
            StoreScalar(rowBias, isConstant ? RoundToInt32(sources[row].constant * 65536.0f) : 0);
        }
    }
}

inline Expected<void> CheckShuffleSources(std::span<const ShuffleSource, NTC_MAX_CHANNELS> sources) noexcept {
    for (std::size_t i = 0; i < sources.size(); ++i) {
        const ShuffleSource& source = sources[i];
        switch (source.kind) {
        case ShuffleSource::Kind::Undefined:
            continue;
        case ShuffleSource::Kind::Channel:
            if (source.channel < 0 || source.channel >= NTC_MAX_CHANNELS)
                return Fail(Status::OutOfRange, "sources[%zu].channel: %d: must be 0 … %d", i, source.channel,
                            NTC_MAX_CHANNELS - 1);
            continue;
        case ShuffleSource::Kind::Constant:
            if (!IsMagnitudeAtMost(source.constant, 0x1.FFFFFEp14f))
                return Fail(Status::OutOfRange, "sources[%zu].constant: %g: magnitude must be below 32768", i,
                            static_cast<double>(source.constant));
            continue;
        }
        return Fail(Status::InvalidArgument, "sources[%zu].kind: %d: not a kind", i,
                    static_cast<int>(source.kind));
    }
    return {};
}

} // namespace detail

inline Expected<InferenceWeights>
ShuffleInferenceOutputs(const InferenceWeights& weights,
                        std::span<const ShuffleSource, NTC_MAX_CHANNELS> sources,
                        Allocator& allocator) noexcept {
    OPENNTC_CHECK(detail::CheckShuffleSources(sources));
    if (!IsKnownNetwork(weights.networkVersion))
        return Fail(Status::InvalidArgument, "weights.networkVersion: %d: must be 1 … %d",
                    weights.networkVersion, NTC_NETWORK_GENERATION_3);
    OPENNTC_ASSIGN(InferenceWeights result, weights.Clone(allocator));
    const NetworkDescription network = GetNetworkDescription(weights.networkVersion);
    if (!weights.int8.empty())
        detail::ShuffleOutputLayer(weights.int8.AsSpan(), result.int8.AsSpan(), sources, network,
                                   network.int8ScaleOffsets[3], network.int8BiasOffsets[3]);
    if (!weights.fp8.empty())
        detail::ShuffleOutputLayer(weights.fp8.AsSpan(), result.fp8.AsSpan(), sources, network,
                                   network.fp8ScaleOffset, network.fp8BiasOffsets[3]);
    result.validChannelMask = 0;
    result.channelColorSpaces = 0;
    for (std::size_t i = 0; i < sources.size(); ++i) {
        if (sources[i].kind == ShuffleSource::Kind::Channel) {
            const unsigned from = static_cast<unsigned>(sources[i].channel);
            result.validChannelMask |= ((weights.validChannelMask >> from) & 1u) << i;
            result.channelColorSpaces |= ((weights.channelColorSpaces >> (2 * from)) & 3u) << (2 * i);
        } else if (sources[i].kind == ShuffleSource::Kind::Constant) {
            result.validChannelMask |= 1u << i;
        }
    }
    return result;
}

namespace detail {

constexpr NtcLatentEncodingConstants MakeLatentEncoding(int features, int quantBits, bool isFP8) noexcept {
    const LatentQuantization quantization = GetLatentQuantization(quantBits);
    NtcLatentEncodingConstants c{};
    c.numFeatures = features;
    c.quantBits = quantBits;
    c.logElementsPerUint = 6 - GetBitWidth(quantBits);
    c.addressMask = (1u << c.logElementsPerUint) - 1u;
    c.dataMask = (1u << quantBits) - 1u;
    c.quantizedScale = isFP8 ? BitCast<std::int32_t>(quantization.step) : quantization.int8Scale;
    c.quantizedBias = isFP8 ? BitCast<std::int32_t>(quantization.bias) : quantization.int8Bias;
    return c;
}

/// A whole grid at its place in the latent buffer. Sides fit 16 bits: the metadata has been checked.
inline Expected<NtcNeuralMipConstants> MakeNeuralMip(const LatentGrid& grid,
                                                     std::uint64_t rangeOffset) noexcept {
    const std::uint64_t offset = grid.offset - rangeOffset;
    if (offset > 0xFFFFFFFFu)
        return Fail(
            Status::OutOfRange, "latentRange.offset: %llu: latents at %llu are 4 GiB or more behind it",
            static_cast<unsigned long long>(rangeOffset), static_cast<unsigned long long>(grid.offset));
    if (offset % 4 != 0)
        return Fail(Status::InvalidArgument,
                    "latentRange.offset: %llu: latents at %llu must be a multiple of 4 bytes behind it",
                    static_cast<unsigned long long>(rangeOffset),
                    static_cast<unsigned long long>(grid.offset));
    NtcNeuralMipConstants c{};
    c.dataOffset = static_cast<std::uint32_t>(offset);
    c.imageWidthHeight = static_cast<std::uint32_t>(grid.width) | static_cast<std::uint32_t>(grid.height)
                                                                      << 16;
    c.sliceWidthHeight = c.imageWidthHeight;
    return c;
}

inline bool IsGridInside(const LatentGrid& grid, StreamRange range) noexcept {
    return grid.offset >= range.offset && IsRangeInside(grid.offset - range.offset, grid.size, range.size);
}

/// Checks that weights of a form can be used with a set. What cooperative matrices use is made from the
/// generic weights, and constants are the same.
inline Expected<InferenceWeightType> CheckWeights(const TextureSetMetadata& metadata,
                                                  InferenceWeightType weightType,
                                                  const InferenceWeights& weights) noexcept {
    if (weightType == InferenceWeightType::CoopVecInt8 || weightType == InferenceWeightType::CoopVecFP8)
        return Fail(Status::Unsupported, "weightType: %s: pass the CoopVecWeights instead",
                    InferenceWeightTypeToString(weightType));
    if (weightType == InferenceWeightType::CoopMatInt8)
        weightType = InferenceWeightType::GenericInt8;
    if (weights.Get(weightType).empty())
        return Fail(Status::Unsupported, "weightType: %s: the set has no such weights",
                    InferenceWeightTypeToString(weightType));
    if (weights.networkVersion != metadata.GetNetworkVersion())
        return Fail(Status::InvalidArgument, "weights: of a %s network: the set has a %s one",
                    GetNetworkName(weights.networkVersion), GetNetworkName(metadata.GetNetworkVersion()));
    return weightType;
}

/// Everything but what latents are and where they lie.
inline NtcTextureSetConstants MakeCommonConstants(const TextureSetMetadata& metadata,
                                                  const InferenceWeights& weights) noexcept {
    NtcTextureSetConstants c{};
    const std::span<const ColorMip> mips = metadata.GetColorMips();
    for (std::size_t i = 0; i < mips.size(); ++i)
        c.colorMips[i] = {mips[i].neuralMip, mips[i].positionLod, mips[i].positionScale, 0};
    const NetworkDescription network = GetNetworkDescription(metadata.GetNetworkVersion());
    c.networkWeightOffset0 = network.weightOffsets[0];
    c.networkWeightOffset1 = network.weightOffsets[1];
    c.networkWeightOffset2 = network.weightOffsets[2];
    c.networkWeightOffset3 = network.weightOffsets[3];
    c.networkScaleBiasOffset = network.weightBytes;
    const TextureSetDesc& desc = metadata.GetDesc();
    c.imageWidth = desc.width;
    c.imageHeight = desc.height;
    c.imageMips = desc.mips;
    c.validChannelMask = weights.validChannelMask;
    c.channelColorSpaces = weights.channelColorSpaces;
    return c;
}

/// Generations 2 and 3: inputs are made of filtered codes.
inline void SetLayeredEncoding(const TextureSetMetadata& metadata, NtcTextureSetConstants& c) noexcept {
    c.highResEncoding =
        MakeLatentEncoding(metadata.GetLatentShape().highResFeatures, kLayeredLatentBits, false);
    c.highResEncoding.quantizedScale = 0;
    c.highResEncoding.quantizedBias = 0;
    c.lowResEncoding = c.highResEncoding;
}

/// Generations 2 and 3: latent mips `images` one after the other from offset 0 on.
inline Expected<void> AddLatentMips(const TextureSetMetadata& metadata, MipRange images,
                                    NtcTextureSetConstants& c) noexcept {
    SetLayeredEncoding(metadata, c);
    std::uint64_t offset = 0;
    for (int i = images.first; i <= images.last; ++i) {
        const LatentMip& mip = metadata.GetLatentMips()[static_cast<std::size_t>(i)];
        const std::uint64_t bytes = GetLatentMipBytes(mip.width, mip.height, mip.layers);
        OPENNTC_ASSIGN(const NtcNeuralMipConstants place,
                       MakeNeuralMip({mip.width, mip.height, offset, bytes}, 0));
        c.highResNeuralMips[i] = place;
        if (i > images.first)
            c.lowResNeuralMips[i - 1] = place;
        offset += bytes;
    }
    return {};
}

} // namespace detail

inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata,
                                                          StreamRange latentRange,
                                                          InferenceWeightType weightType,
                                                          const InferenceWeights& shuffled) noexcept {
    OPENNTC_ASSIGN(const InferenceWeightType type, detail::CheckWeights(metadata, weightType, shuffled));
    if (metadata.GetGeneration() != 1)
        return Fail(
            Status::Unsupported,
            "latentRange: of a set of generation %d: pass the mips, and latents that ReadLatents made",
            metadata.GetGeneration());
    const bool isFP8 = type == InferenceWeightType::GenericFP8;
    const LatentShape& shape = metadata.GetLatentShape();
    NtcTextureSetConstants c = detail::MakeCommonConstants(metadata, shuffled);
    c.highResEncoding = detail::MakeLatentEncoding(shape.highResFeatures, shape.highResQuantBits, isFP8);
    c.lowResEncoding = detail::MakeLatentEncoding(shape.lowResFeatures, shape.lowResQuantBits, isFP8);
    const std::span<const LatentImage> images = metadata.GetLatentImages();
    for (std::size_t i = 0; i < images.size(); ++i) {
        if (!detail::IsGridInside(images[i].highRes, latentRange) ||
            !detail::IsGridInside(images[i].lowRes, latentRange))
            continue;
        OPENNTC_ASSIGN(c.highResNeuralMips[i], detail::MakeNeuralMip(images[i].highRes, latentRange.offset));
        OPENNTC_ASSIGN(c.lowResNeuralMips[i], detail::MakeNeuralMip(images[i].lowRes, latentRange.offset));
    }
    return c;
}

inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata,
                                                          StreamRange latentRange,
                                                          InferenceWeightType weightType) noexcept {
    return MakeInferenceData(metadata, latentRange, weightType, metadata.GetWeights());
}

inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata, int firstMip,
                                                          int numMips, InferenceWeightType weightType,
                                                          const InferenceWeights& shuffled) noexcept {
    OPENNTC_ASSIGN(const StreamRange range, metadata.GetStreamRangeForLatents(firstMip, numMips));
    if (metadata.GetGeneration() == 1)
        return MakeInferenceData(metadata, range, weightType, shuffled);
    OPENNTC_CHECK(detail::CheckWeights(metadata, weightType, shuffled));
    NtcTextureSetConstants c = detail::MakeCommonConstants(metadata, shuffled);
    OPENNTC_CHECK(detail::AddLatentMips(metadata, metadata.GetLatentsOfMips(firstMip, numMips), c));
    return c;
}

inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata, int firstMip,
                                                          int numMips,
                                                          InferenceWeightType weightType) noexcept {
    return MakeInferenceData(metadata, firstMip, numMips, weightType, metadata.GetWeights());
}

inline Expected<NtcTextureSetConstants2> MakeTextureConstants(const TextureSetMetadata& metadata,
                                                              InferenceWeightType weightType) noexcept {
    if (metadata.GetGeneration() == 1)
        return Fail(Status::Unsupported, "generation: 1: its latents are in no textures");
    const InferenceWeights& weights = metadata.GetWeights();
    OPENNTC_ASSIGN(const InferenceWeightType type, detail::CheckWeights(metadata, weightType, weights));
    const bool isFP8 = type == InferenceWeightType::GenericFP8;
    const NetworkDescription network = GetNetworkDescription(metadata.GetNetworkVersion());
    const auto& biases = isFP8 ? network.fp8BiasOffsets : network.int8BiasOffsets;
    const std::array<int, kNetworkLayers> fp8Scales = {0, 0, 0, network.fp8ScaleOffset};
    const auto& scales = isFP8 ? fp8Scales : network.int8ScaleOffsets;
    const NtcTextureSetConstants common = detail::MakeCommonConstants(metadata, weights);
    NtcTextureSetConstants2 c{};
    std::copy(std::begin(common.colorMips), std::end(common.colorMips), c.colorMips);
    c.networkWeightOffset0 = network.weightOffsets[0];
    c.networkWeightOffset1 = network.weightOffsets[1];
    c.networkWeightOffset2 = network.weightOffsets[2];
    c.networkWeightOffset3 = network.weightOffsets[3];
    c.networkBiasOffset0 = biases[0];
    c.networkBiasOffset1 = biases[1];
    c.networkBiasOffset2 = biases[2];
    c.networkBiasOffset3 = biases[3];
    c.networkScaleOffset0 = scales[0];
    c.networkScaleOffset1 = scales[1];
    c.networkScaleOffset2 = scales[2];
    c.networkScaleOffset3 = scales[3];
    c.imageWidth = common.imageWidth;
    c.imageHeight = common.imageHeight;
    c.imageMips = common.imageMips;
    c.validChannelMask = common.validChannelMask;
    c.channelColorSpaces = common.channelColorSpaces;
    return c;
}

/// The part of the constants that shaders with NTC_SINGLE_MIP read, for push constants. InvalidArgument if
/// another latent image than the first serves mip 0.
inline Expected<NtcSingleMipConstants>
MakeSingleMipConstants(const NtcTextureSetConstants& constants) noexcept {
    if (constants.colorMips[0].neuralMip != 0)
        return Fail(Status::InvalidArgument, "constants: mip 0 is served by latent image %d: must be 0",
                    constants.colorMips[0].neuralMip);
    NtcSingleMipConstants c{};
    c.highResEncoding = constants.highResEncoding;
    c.lowResEncoding = constants.lowResEncoding;
    c.highResNeuralMips[0] = constants.highResNeuralMips[0];
    c.lowResNeuralMips[0] = constants.lowResNeuralMips[0];
    c.colorMips[0] = constants.colorMips[0];
    c.networkWeightOffset0 = constants.networkWeightOffset0;
    c.networkWeightOffset1 = constants.networkWeightOffset1;
    c.networkWeightOffset2 = constants.networkWeightOffset2;
    c.networkWeightOffset3 = constants.networkWeightOffset3;
    c.imageWidth = constants.imageWidth;
    c.imageHeight = constants.imageHeight;
    c.imageMips = constants.imageMips;
    c.networkScaleBiasOffset = constants.networkScaleBiasOffset;
    c.validChannelMask = constants.validChannelMask;
    c.channelColorSpaces = constants.channelColorSpaces;
    return c;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
