// SPDX-License-Identifier: MIT
// Stability: stable
// Sizes of mips and latent grids, and which latent image serves which colour mip. Writers compute with these;
// readers take what the file says. Source of all formulas: format specification, "latents".
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/format/Limits.h"
#include "openntc/format/NetworkDescription.h"
#include "openntc/texture_set/LatentShape.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

namespace detail {

/// Digits of a number >= 0 in binary: 0, 1, 2, 2, 3 for 0 … 4.
constexpr int GetBitWidth(int value) noexcept {
    return static_cast<int>(std::bit_width(static_cast<unsigned>(value)));
}

} // namespace detail

/// Size, channels and mips of a texture set.
struct TextureSetDesc {
    int width = 0; ///< texels of mip 0, 1 … kMaxImageDimension
    int height = 0;
    int channels = 0; ///< 1 … NTC_MAX_CHANNELS
    int mips = 1;     ///< 1 … NTC_MAX_MIPS

    friend constexpr bool operator==(const TextureSetDesc&, const TextureSetDesc&) noexcept = default;
};

/// Checks the ranges stated at the members. Errors: OutOfRange.
inline Expected<void> ValidateTextureSetDesc(const TextureSetDesc& desc) noexcept {
    if (desc.width < 1 || desc.width > kMaxImageDimension)
        return Fail(Status::OutOfRange, "width: %d: must be 1 … %d", desc.width, kMaxImageDimension);
    if (desc.height < 1 || desc.height > kMaxImageDimension)
        return Fail(Status::OutOfRange, "height: %d: must be 1 … %d", desc.height, kMaxImageDimension);
    if (desc.channels < 1 || desc.channels > NTC_MAX_CHANNELS)
        return Fail(Status::OutOfRange, "numChannels: %d: must be 1 … %d", desc.channels, NTC_MAX_CHANNELS);
    if (desc.mips < 1 || desc.mips > NTC_MAX_MIPS)
        return Fail(Status::OutOfRange, "numColorMips: %d: must be 1 … %d", desc.mips, NTC_MAX_MIPS);
    return {};
}

/// Texels per side of a mip: max(dimension >> mip, 1), mip 0 … 15.
constexpr int GetMipDimension(int dimension, int mip) noexcept {
    return std::max(dimension >> mip, 1);
}

/// Latent pixels per side of a grid: max((dimension / cell) >> 2n, 1). `cell` is gridSizeScale for the
/// high-res grid and twice that for the low-res grid; n = neuralMip 0 … 7.
constexpr int GetLatentGridDimension(int dimension, int cell, int neuralMip) noexcept {
    return std::max((dimension / cell) >> (2 * neuralMip), 1);
}

/// The latent image that serves a colour mip, in a set with that many latent images (>= 1).
constexpr int GetNeuralMipForColorMip(int mip, int gridSizeScale, int neuralMips) noexcept {
    const int log2Scale = detail::GetBitWidth(gridSizeScale - 1); // rounded up
    return std::min(neuralMips - 1, std::max(0, mip - log2Scale) / 2);
}

/// Latent images that an encoder makes, 1 … 8. The descriptor must be valid and gridSizeScale 2 … 8.
constexpr int GetNeuralMipCount(const TextureSetDesc& desc, int gridSizeScale) noexcept {
    const int coarsest = std::min(desc.width, desc.height) / (2 * gridSizeScale);
    const int unclamped = std::max(1, detail::GetBitWidth(coarsest) / 2); // (1 + floor(log2)) / 2
    return std::min(unclamped,
                    GetNeuralMipForColorMip(desc.mips - 1, gridSizeScale, NTC_MAX_NEURAL_MIPS) + 1);
}

/// (mip - 2 · neuralMip) / 3 in binary32: how far the colour mip is from its latent image. Divided in
/// binary64, so that a multiplication by the reciprocal in its place, as -ffast-math makes it, rounds to the
/// same binary32.
constexpr float GetPositionLod(int mip, int neuralMip) noexcept {
    return static_cast<float>(static_cast<double>(mip - 2 * neuralMip) / 3.0);
}

/// 2^(mip - 2 · neuralMip).
inline float GetPositionScale(int mip, int neuralMip) noexcept {
    return std::ldexp(1.0f, mip - 2 * neuralMip);
}

/// Generations 2 and 3: texels per side of latent mip `latentMip`, 0 … 7, a mip chain.
constexpr int GetLatentMipDimension(int dimension, int gridSizeScale, int latentMip) noexcept {
    return std::max((dimension / gridSizeScale) >> latentMip, 1);
}

/// Generations 2 and 3: the finer, always even, of the two latent mips that a colour mip reads, in a set with
/// that many latent mips (2 … 8) and gridSizeScale 1 … 6.
constexpr int GetLatentMipForColorMip(int mip, int gridSizeScale, int latentMips) noexcept {
    const int shared = gridSizeScale == 1 ? 2 : gridSizeScale <= 4 ? 3 : 4; // colour mips of latent mip 0
    return std::clamp((mip - shared + 2) & ~1, 0, latentMips - 2);
}

/// Generations 2 and 3: latent mips that an encoder makes, 2, 4, 6 or 8. The descriptor must be valid and
/// gridSizeScale 1 … 6.
constexpr int GetLatentMipCount(const TextureSetDesc& desc, int gridSizeScale) noexcept {
    const int chain = detail::GetBitWidth(std::min(desc.width, desc.height) / gridSizeScale);
    return std::min(std::max(2, chain & ~1),
                    GetLatentMipForColorMip(desc.mips - 1, gridSizeScale, NTC_MAX_NEURAL_MIPS) + 2);
}

/// Generations 2 and 3: positionScale of a colour mip that reads a latent mip and the one after it, both
/// sizes in texels.
constexpr float GetLatentPositionScale(int mipWidth, int mipHeight, int latentWidth,
                                       int latentHeight) noexcept {
    return 0.5f * std::max(static_cast<float>(latentWidth) / static_cast<float>(mipWidth),
                           static_cast<float>(latentHeight) / static_cast<float>(mipHeight));
}
/// And its positionLod, -1 … 1.
inline float GetLatentPositionLod(float positionScale) noexcept {
    return std::clamp(0.25f * std::log2(positionScale), -1.0f, 1.0f);
}

/// Bytes of a latent grid as the format packs it: whole 32-bit words, no row padding.
constexpr std::uint64_t GetLatentGridBytes(int width, int height, int features, int quantBits) noexcept {
    const std::uint64_t bits = static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) *
                               static_cast<std::uint64_t>(features * quantBits);
    return (bits + 31) / 32 * 4;
}

/// Generations 2 and 3: bytes of a latent mip in the buffer that decoders read, its layers one after the
/// other, then up to a multiple of 4.
constexpr std::uint64_t GetLatentMipBytes(int width, int height, int layers) noexcept {
    const std::uint64_t layer =
        std::uint64_t{2} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    return (layer * static_cast<std::uint64_t>(layers) + 3) / 4 * 4;
}

/// Size of a compressed set as LibNTC estimates it: latents and the Int8 weights of the network, for
/// NTC_NETWORK_UNKNOWN of the smallest fitting one; no FP8 weights, JSON or header, and no compression of the
/// latents. Errors: OutOfRange for an invalid descriptor or shape; InvalidArgument for the empty shape.
inline Expected<std::uint64_t>
EstimateCompressedTextureSetSize(const TextureSetDesc& desc, const LatentShape& shape,
                                 int networkVersion = NTC_NETWORK_UNKNOWN) noexcept {
    OPENNTC_CHECK(ValidateTextureSetDesc(desc));
    OPENNTC_CHECK(ValidateLatentShape(shape, networkVersion));
    if (shape.IsEmpty())
        return Fail(Status::InvalidArgument, "latentShape: empty: has no size");
    const int version = networkVersion == NTC_NETWORK_UNKNOWN
                            ? GetNetworkVersionForFeatures(shape.highResFeatures)
                            : networkVersion;
    std::uint64_t bytes = static_cast<std::uint64_t>(GetNetworkDescription(version).int8Bytes);
    if (GetGeneration(version) > 1) {
        for (int n = 0; n < GetLatentMipCount(desc, shape.gridSizeScale); ++n)
            bytes += GetLatentMipBytes(GetLatentMipDimension(desc.width, shape.gridSizeScale, n),
                                       GetLatentMipDimension(desc.height, shape.gridSizeScale, n),
                                       GetLatentLayers(shape));
        return bytes;
    }
    const int neuralMips = GetNeuralMipCount(desc, shape.gridSizeScale);
    for (int n = 0; n < neuralMips; ++n) {
        bytes += GetLatentGridBytes(GetLatentGridDimension(desc.width, shape.gridSizeScale, n),
                                    GetLatentGridDimension(desc.height, shape.gridSizeScale, n),
                                    shape.highResFeatures, shape.highResQuantBits);
        bytes += GetLatentGridBytes(GetLatentGridDimension(desc.width, 2 * shape.gridSizeScale, n),
                                    GetLatentGridDimension(desc.height, 2 * shape.gridSizeScale, n),
                                    shape.lowResFeatures, shape.lowResQuantBits);
    }
    return bytes;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
