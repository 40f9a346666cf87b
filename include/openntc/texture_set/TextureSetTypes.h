// SPDX-License-Identifier: MIT
// Stability: stable
// What a texture set consists of: textures, latent images, colour mips.
#pragma once

#include "openntc/format/Enums.h"
#include "openntc/format/Limits.h"

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Bytes [offset, offset + size) of a stream, absolute.
struct StreamRange {
    std::uint64_t offset = 0;
    std::uint64_t size = 0;

    friend constexpr bool operator==(const StreamRange&, const StreamRange&) noexcept = default;
};

/// The range that means "everything".
inline constexpr StreamRange kEntireStream = {0, ~std::uint64_t{0}};

/// Colour mips, or latent images or mips, first … last, both inclusive.
struct MipRange {
    int first = 0;
    int last = 0;

    friend constexpr bool operator==(const MipRange&, const MipRange&) noexcept = default;
};

/// Bytes of a stream that hold data as it is, or as a GDeflate stream (container/GDeflate.h).
struct StoredData {
    StreamRange range;       ///< absolute; at least `bytes` unless compressed
    std::uint64_t bytes = 0; ///< of the data itself, uncompressed, at least
    bool isCompressed = false;
    std::uint32_t crc32 = 0; ///< of all uncompressed bytes; 0: not given
};

/// How often BC7 blocks of a texture use one (mode, partition), as counted at encoding time.
struct BlockCompressionMode {
    std::uint8_t mode = 0;       ///< below kBlockModes
    std::uint8_t partition = 0;  ///< below kBlockPartitions
    std::uint16_t frequency = 0; ///< of 65535
};

/// Modes and partitions of the BC7 blocks of one mip (generation 3), see BlockModes.h.
struct BlockModeBuffer {
    int mip = 0;
    StoredData data;
};

/// One texture: a run of channels, and how it should be stored once decoded. Views point into the metadata
/// object.
struct Texture {
    std::string_view name; ///< UTF-8
    /// A file whose range is empty or leaves the set yields (0, 0), a texture without channels, as in LibNTC.
    int firstChannel = 0;
    int numChannels = 0;
    ChannelFormat channelFormat = ChannelFormat::UNORM8;
    ColorSpace rgbColorSpace = ColorSpace::Linear; ///< of the decoded texture, not of the network's outputs
    ColorSpace alphaColorSpace = ColorSpace::Linear;
    BlockCompressedFormat bcFormat = BlockCompressedFormat::None;
    int bcQuality = 255;                           ///< 0 … 255
    std::span<const BlockCompressionMode> bcModes; ///< most frequent first; empty if not stored
    std::span<const BlockModeBuffer> blockModes;   ///< generation 3: of some mips; empty if not stored
};

/// One grid of latents.
struct LatentGrid {
    int width = 0; ///< latent pixels, 1 … kMaxLatentDimension
    int height = 0;
    std::uint64_t offset = 0; ///< bytes, absolute in the stream
    /// Bytes stored: at least the packed bits. Shaders read whole 32-bit words: a buffer that receives a
    /// range of latents must be rounded up to a multiple of 4 bytes (files of LibNTC always are).
    std::uint64_t size = 0;
};

/// One latent image ("neural mip") of generation 1: two grids that serve one or more colour mips.
struct LatentImage {
    LatentGrid highRes;
    LatentGrid lowRes;
};

/// One latent mip of generations 2 and 3: layers of one size, of four latents to a texel of 16 bits, the
/// first in the lowest four. A colour mip is served by its latent mip and the next one.
struct LatentMip {
    int width = 0; ///< latent texels, 1 … kMaxLatentDimension
    int height = 0;
    int layers = 0;                                       ///< 1 … kMaxLatentLayers
    std::array<StoredData, kMaxLatentLayers> layerData{}; ///< [y][x] of each layer; the rest is unused

    /// Bytes of one layer.
    constexpr std::uint64_t GetLayerBytes() const noexcept {
        return std::uint64_t{2} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
    }
};

/// One mip of the decoded textures.
struct ColorMip {
    int width = 0; ///< texels: max(width of mip 0 >> mip, 1)
    int height = 0;
    int neuralMip =
        0; ///< the latent image that serves it; in generations 2 and 3 the finer of two latent mips
    float positionLod = 0.0f;
    float positionScale = 1.0f;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
