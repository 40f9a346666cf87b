// SPDX-License-Identifier: MIT
// Stability: stable
// What every CPU decoder takes: a texture set in the form that shaders read, and the check that makes it safe
// to index.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Expected.h"
#include "openntc/core/FloatBits.h"
#include "openntc/core/Rect.h"
#include "openntc/format/LatentQuantization.h"
#include "openntc/format/NetworkDescription.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Arithmetic of the network; values equal those of NTC_MATH (MathModes.h defines each). FP8 needs FP8
/// weights, the others Int8 weights.
enum class DecodeMath {
    Int8 = 1, ///< the exact contract
    Int8Half, ///< binary16 between the integer layers
    FP8,      ///< E4M3 emulated in binary32
    FP16,     ///< binary16, nothing quantised but the weights
    FP32,     ///< the same in binary32: the accuracy reference
};

/// Which weight buffer and constants a source has: those that MakeInferenceData makes for GenericInt8 or
/// GenericFP8.
enum class DecodeWeights { Int8, FP8 };

/// The weights that a maths mode reads.
constexpr DecodeWeights GetDecodeWeights(DecodeMath math) noexcept {
    return math == DecodeMath::FP8 ? DecodeWeights::FP8 : DecodeWeights::Int8;
}

/// A texture set as decoders read it: views, the caller keeps the memory alive.
struct DecodeSource {
    const NtcTextureSetConstants* constants = nullptr;
    std::span<const std::byte> latents; ///< the latent range that the constants were made for
    std::span<const std::byte> weights; ///< generic Int8 or FP8 weight buffer
    int networkVersion = NTC_NETWORK_UNKNOWN;
    DecodeWeights weightFormat = DecodeWeights::Int8;
};

struct DecodeOptions {
    DecodeMath math = DecodeMath::Int8;
    bool convertToLinear = false; ///< every channel from its storage colour space to linear
};

/// Largest width and height of a texture set.
inline constexpr int kMaxDecodeSize = kMaxImageDimension;
/// Texel coordinates may lie this far outside.
inline constexpr int kMaxDecodeTexel = 1 << 22;

namespace detail {

/// maxFeatures: of the grid in generation 1; of generations 2 and 3, whose latents have 4 bits and no scale,
/// 0.
inline Expected<void> ValidateEncoding(const NtcLatentEncodingConstants& encoding, const char* grid,
                                       int maxFeatures, DecodeWeights weightFormat) {
    const bool isGrid = maxFeatures != 0;
    maxFeatures = isGrid ? maxFeatures : kMaxFeatures;
    if (encoding.numFeatures < kFeatureStep || encoding.numFeatures > maxFeatures ||
        encoding.numFeatures % kFeatureStep != 0)
        return Fail(Status::OutOfRange, "%s features: %d: must be a multiple of %d from %d to %d", grid,
                    encoding.numFeatures, kFeatureStep, kFeatureStep, maxFeatures);
    const int bits = encoding.quantBits;
    if (!IsQuantBits(bits) || (!isGrid && bits != kLayeredLatentBits))
        return Fail(Status::OutOfRange, "%s quantBits: %d: must be %s", grid, bits,
                    isGrid ? "1, 2, 4 or 8" : "4 in generations 2 and 3");
    const int log = 5 - std::countr_zero(static_cast<unsigned>(bits));
    if (encoding.logElementsPerUint != log || encoding.addressMask != (1u << log) - 1u ||
        encoding.dataMask != (1u << bits) - 1u)
        return Fail(Status::InvalidArgument, "%s encoding: shift %d, masks %u and %u: do not fit %d bits",
                    grid, encoding.logElementsPerUint, encoding.addressMask, encoding.dataMask, bits);
    if (!isGrid) {
        if (encoding.quantizedScale != 0 || encoding.quantizedBias != 0)
            return Fail(Status::InvalidArgument, "%s encoding: scale %d, bias %d: must be 0 and 0", grid,
                        encoding.quantizedScale, encoding.quantizedBias);
        return {};
    }
    const LatentQuantization quantization = GetLatentQuantization(bits);
    if (weightFormat == DecodeWeights::FP8) {
        if (encoding.quantizedScale != BitCast<std::int32_t>(quantization.step) ||
            encoding.quantizedBias != BitCast<std::int32_t>(quantization.bias))
            return Fail(Status::InvalidArgument,
                        "%s encoding: scale 0x%08x, bias 0x%08x: not those of FP8 weights and %d bits", grid,
                        static_cast<unsigned>(encoding.quantizedScale),
                        static_cast<unsigned>(encoding.quantizedBias), bits);
        return {};
    }
    if (encoding.quantizedScale != quantization.int8Scale || encoding.quantizedBias != quantization.int8Bias)
        return Fail(Status::InvalidArgument, "%s encoding: scale %d, bias %d: Int8 weights need %d and %d",
                    grid, encoding.quantizedScale, encoding.quantizedBias, quantization.int8Scale,
                    quantization.int8Bias);
    return {};
}

/// A slice lies inside its grid; one that wraps (generations 2 and 3) begins inside.
inline Expected<void> ValidateSlice(const NtcNeuralMipConstants& grid, bool wraps, const char* name,
                                    int image) {
    const unsigned left = grid.sliceLeftTop & 0xFFFFu;
    const unsigned top = grid.sliceLeftTop >> 16;
    const unsigned width = grid.sliceWidthHeight & 0xFFFFu;
    const unsigned height = grid.sliceWidthHeight >> 16;
    const unsigned gridWidth = grid.imageWidthHeight & 0xFFFFu;
    const unsigned gridHeight = grid.imageWidthHeight >> 16;
    const bool isInside =
        wraps ? left < gridWidth && top < gridHeight && width <= gridWidth && height <= gridHeight
              : left + width <= gridWidth && top + height <= gridHeight;
    if (!isInside)
        return Fail(Status::OutOfRange,
                    "latent image %d %s slice: %u,%u,%u,%u: must lie inside the grid (%ux%u)", image, name,
                    left, top, width, height, gridWidth, gridHeight);
    return {};
}

inline Expected<void> ValidateGrid(const NtcNeuralMipConstants& grid,
                                   const NtcLatentEncodingConstants& encoding, bool wraps, const char* name,
                                   int image, std::size_t latentBytes) {
    const std::uint64_t width = grid.sliceWidthHeight & 0xFFFFu;
    const std::uint64_t height = grid.sliceWidthHeight >> 16;
    if (width == 0 || height == 0)
        return {}; // absent
    OPENNTC_CHECK(ValidateSlice(grid, wraps, name, image));
    if (grid.dataOffset % 4 != 0)
        return Fail(Status::OutOfRange, "latent image %d %s offset: %u: must be a multiple of 4", image, name,
                    grid.dataOffset);
    const std::uint64_t elements =
        width * height * static_cast<std::uint64_t>(encoding.numFeatures); // < 2^36
    if (elements > UINT32_MAX)
        return Fail(Status::OutOfRange, "latent image %d %s latents: %llu: at most 4294967295", image, name,
                    static_cast<unsigned long long>(elements));
    const std::uint64_t perWord = std::uint64_t{1} << encoding.logElementsPerUint;
    const std::uint64_t end = grid.dataOffset + (elements + perWord - 1) / perWord * 4;
    if (end > latentBytes)
        return Fail(Status::OutOfRange, "latent image %d %s end: %llu: the latents have %llu bytes", image,
                    name, static_cast<unsigned long long>(end), static_cast<unsigned long long>(latentBytes));
    return {};
}

} // namespace detail

/// Checks that everything a decoder may index lies inside the spans and that no arithmetic leaves its defined
/// range. Latent images may be absent (slice size zero): texels of mips that need them cannot be decoded,
/// nothing more. Errors: InvalidArgument (null constants, inconsistent encodings, constants made for other
/// weights than weightFormat says), OutOfRange.
inline Expected<void> ValidateDecodeSource(const DecodeSource& source) {
    if (source.constants == nullptr)
        return Fail(Status::InvalidArgument, "constants: null: must point to texture-set constants");
    const NtcTextureSetConstants& c = *source.constants;
    if (!IsKnownNetwork(source.networkVersion))
        return Fail(Status::OutOfRange, "networkVersion: %d: must be 1 to 6", source.networkVersion);
    const NetworkDescription network = GetNetworkDescription(source.networkVersion);
    const bool wraps = network.generation != 1;
    if (source.latents.size() > UINT32_MAX || source.weights.size() > UINT32_MAX)
        return Fail(Status::OutOfRange, "latents, weights: %zu and %zu bytes: must be below 2^32",
                    source.latents.size(), source.weights.size());
    if (c.imageWidth < 1 || c.imageWidth > kMaxDecodeSize || c.imageHeight < 1 ||
        c.imageHeight > kMaxDecodeSize)
        return Fail(Status::OutOfRange, "image size: %dx%d: each side must be 1 to %d", c.imageWidth,
                    c.imageHeight, kMaxDecodeSize);
    if (c.imageMips < 1 || c.imageMips > NTC_MAX_MIPS)
        return Fail(Status::OutOfRange, "imageMips: %d: must be 1 to %d", c.imageMips, NTC_MAX_MIPS);
    OPENNTC_CHECK(
        detail::ValidateEncoding(c.highResEncoding, "high-res", network.highResSlots, source.weightFormat));
    OPENNTC_CHECK(
        detail::ValidateEncoding(c.lowResEncoding, "low-res", wraps ? 0 : kMaxFeatures, source.weightFormat));
    if (wraps && c.highResEncoding.numFeatures != c.lowResEncoding.numFeatures)
        return Fail(Status::InvalidArgument, "low-res features: %d: must be the %d of the finer latent mip",
                    c.lowResEncoding.numFeatures, c.highResEncoding.numFeatures);
    for (int image = 0; image < NTC_MAX_NEURAL_MIPS; ++image) {
        OPENNTC_CHECK(detail::ValidateGrid(c.highResNeuralMips[image], c.highResEncoding, wraps, "high-res",
                                           image, source.latents.size()));
        OPENNTC_CHECK(detail::ValidateGrid(c.lowResNeuralMips[image], c.lowResEncoding, wraps, "low-res",
                                           image, source.latents.size()));
    }
    for (int mip = 0; mip < c.imageMips; ++mip) {
        if (c.colorMips[mip].neuralMip >= NTC_MAX_NEURAL_MIPS)
            return Fail(Status::OutOfRange, "colour mip %d neuralMip: %d: must be below %d", mip,
                        c.colorMips[mip].neuralMip, NTC_MAX_NEURAL_MIPS);
    }
    const std::int32_t offsets[5] = {c.networkWeightOffset0, c.networkWeightOffset1, c.networkWeightOffset2,
                                     c.networkWeightOffset3, c.networkScaleBiasOffset};
    const bool isFP8 = source.weightFormat == DecodeWeights::FP8;
    std::int64_t end = 0;
    for (std::size_t i = 0; i < kNetworkLayers + 1; ++i) {
        const int size = i < kNetworkLayers ? network.inputs[i] * network.outputs[i]
                                            : (isFP8 ? network.fp8Bytes : network.int8Bytes) -
                                                  network.weightBytes; // scales and biases
        // In order and without overlap, which also tells weights of another network version.
        if (offsets[i] < end || offsets[i] % 4 != 0)
            return Fail(Status::OutOfRange, "network offset %zu: %d: must be a multiple of 4 from %lld on", i,
                        offsets[i], static_cast<long long>(end));
        end = std::int64_t{offsets[i]} + size;
        if (end > static_cast<std::int64_t>(source.weights.size()))
            return Fail(Status::OutOfRange,
                        "network offset %zu: %d: %d bytes must lie inside the weights (%llu bytes)", i,
                        offsets[i], size, static_cast<unsigned long long>(source.weights.size()));
    }
    return {};
}

namespace detail {

/// Checks that the source has the weights that the maths mode reads.
inline Expected<void> ValidateDecodeMath(DecodeMath math, DecodeWeights weightFormat) {
    if (math < DecodeMath::Int8 || math > DecodeMath::FP32)
        return Fail(Status::InvalidArgument, "math: %d: not a maths mode", static_cast<int>(math));
    if (GetDecodeWeights(math) != weightFormat)
        return Fail(Status::InvalidArgument, "math: needs %s weights: the source has %s weights",
                    math == DecodeMath::FP8 ? "FP8" : "Int8", math == DecodeMath::FP8 ? "Int8" : "FP8");
    return {};
}

/// Checks the arguments that all decoders share besides the source; `outputs` is the number of floats to
/// write to.
inline Expected<void> ValidateDecodeRequest(const NtcTextureSetConstants& c, int mip, const Rect& rect,
                                            std::size_t outputs) {
    if (mip < 0 || mip >= c.imageMips)
        return Fail(Status::OutOfRange, "mip: %d: must be 0 to %d", mip, c.imageMips - 1);
    if (rect.width < 1 || rect.height < 1 || rect.left < -kMaxDecodeTexel || rect.top < -kMaxDecodeTexel ||
        std::int64_t{rect.left} + rect.width > kMaxDecodeTexel ||
        std::int64_t{rect.top} + rect.height > kMaxDecodeTexel)
        return Fail(Status::OutOfRange, "rectangle: %d,%d,%d,%d: must not be empty nor leave +-%d", rect.left,
                    rect.top, rect.width, rect.height, kMaxDecodeTexel);
    const std::uint64_t needed =
        static_cast<std::uint64_t>(rect.width) * static_cast<std::uint64_t>(rect.height) * NTC_MAX_CHANNELS;
    if (outputs < needed)
        return Fail(Status::OutOfRange, "outputs: %llu floats: %llu are needed",
                    static_cast<unsigned long long>(outputs), static_cast<unsigned long long>(needed));
    const int image = c.colorMips[mip].neuralMip;
    if (image < 0 || image >= NTC_MAX_NEURAL_MIPS ||
        (c.highResNeuralMips[image].sliceWidthHeight & 0xFFFFu) == 0 ||
        (c.highResNeuralMips[image].sliceWidthHeight >> 16) == 0 ||
        (c.lowResNeuralMips[image].sliceWidthHeight & 0xFFFFu) == 0 ||
        (c.lowResNeuralMips[image].sliceWidthHeight >> 16) == 0)
        return Fail(Status::Unsupported, "mip: %d: its latent image %d is not among these latents", mip,
                    image);
    return {};
}

} // namespace detail

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
