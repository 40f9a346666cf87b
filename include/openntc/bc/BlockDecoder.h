// SPDX-License-Identifier: MIT
// Stability: experimental
// Decoders of all block formats, by their public definitions: what an encoder's blocks are judged by. One
// thread, no tricks. GPUs decode BC6H and BC7 to the same bits; for BC1 to BC5 each has a rounding of its
// own.
#pragma once

#include "openntc/bc/BlockFormat.h"
#include "openntc/bc/detail/Bc6Decoder.h"
#include "openntc/bc/detail/Bc7Decoder.h"
#include "openntc/bc/detail/ColorDecoder.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Half.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

/// What stands for 1 in DecodeBlockExact's numbers.
constexpr std::int32_t GetExactOne(BlockFormat format) noexcept {
    const bool isSigned = format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
    return (isSigned ? 127 : 255) * detail::kStepUnits;
}

/// A block of 8 or 16 bytes to 16 texels of RGBA, row by row, all but Bc6 without any rounding: integers of
/// which GetExactOne(format) is 1 (one step of a byte is 210). Channels that the format lacks are 0, alpha 1.
/// Bc1: three colours and transparent black where the first endpoint is not the larger one. Bc7's reserved
/// code is transparent black. Signed: -128 is -1. Bc6 decodes to nothing here: all 0.
inline void DecodeBlockExact(BlockFormat format, const std::byte* block,
                             std::int32_t (&texels)[64]) noexcept {
    const std::int32_t one = GetExactOne(format);
    for (int i = 0; i < 64; ++i)
        texels[i] = i % 4 == 3 ? one : 0;
    switch (format) {
    case BlockFormat::Bc1:
        detail::DecodeColorBlock(block, true, texels);
        return;
    case BlockFormat::Bc2:
        detail::DecodeColorBlock(block + 8, false, texels);
        for (int t = 0; t < 16; ++t)
            texels[4 * t + 3] =
                17 * detail::kStepUnits * (static_cast<int>(block[t / 2]) >> (4 * (t % 2)) & 15);
        return;
    case BlockFormat::Bc3:
        detail::DecodeColorBlock(block + 8, false, texels);
        detail::DecodeChannelBlock(block, false, 3, texels);
        return;
    case BlockFormat::Bc4Unsigned:
    case BlockFormat::Bc4Signed:
        detail::DecodeChannelBlock(block, format == BlockFormat::Bc4Signed, 0, texels);
        return;
    case BlockFormat::Bc5Unsigned:
    case BlockFormat::Bc5Signed:
        detail::DecodeChannelBlock(block, format == BlockFormat::Bc5Signed, 0, texels);
        detail::DecodeChannelBlock(block + 8, format == BlockFormat::Bc5Signed, 1, texels);
        return;
    case BlockFormat::Bc7: {
        std::uint8_t bytes[64];
        detail::DecodeBc7Block(block, bytes);
        for (int i = 0; i < 64; ++i)
            texels[i] = detail::kStepUnits * bytes[i];
        return;
    }
    case BlockFormat::Bc6Unsigned:
    case BlockFormat::Bc6Signed:
        for (std::int32_t& texel : texels)
            texel = 0;
        return;
    }
}

/// The same in bytes, rounded to nearest, halves up; signed formats in two's complement, -127 … 127. Bc6:
/// all 0.
inline void DecodeBlockBytes(BlockFormat format, const std::byte* block,
                             std::uint8_t (&texels)[64]) noexcept {
    std::int32_t exact[64];
    DecodeBlockExact(format, block, exact);
    constexpr int kBias = 128; // keeps numerators positive
    for (int i = 0; i < 64; ++i)
        texels[i] = static_cast<std::uint8_t>(
            (exact[i] + kBias * detail::kStepUnits + detail::kStepUnits / 2) / detail::kStepUnits - kBias);
}

/// Bc6 to the bits of 16 texels of RGBA halves, alpha 1. Reserved codes are opaque black. Other formats:
/// all 0.
inline void DecodeBlockHalves(BlockFormat format, const std::byte* block,
                              std::uint16_t (&texels)[64]) noexcept {
    std::uint16_t rgb[48] = {};
    const bool isBc6 = format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
    if (isBc6)
        detail::DecodeBc6Block(block, format == BlockFormat::Bc6Signed, rgb);
    for (int t = 0; t < 16; ++t) {
        for (int c = 0; c < 3; ++c)
            texels[4 * t + c] = rgb[3 * t + c];
        texels[4 * t + 3] = isBc6 ? 0x3C00 : 0;
    }
}

/// Every format to floats, each the one nearest to the exact number.
inline void DecodeBlockFloats(BlockFormat format, const std::byte* block, float (&texels)[64]) noexcept {
    if (format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed) {
        std::uint16_t halves[64];
        DecodeBlockHalves(format, block, halves);
        for (int i = 0; i < 64; ++i)
            texels[i] = HalfToFloat(halves[i]);
        return;
    }
    std::int32_t exact[64];
    DecodeBlockExact(format, block, exact);
    for (int i = 0; i < 64; ++i) // both numbers are below 2^24: one rounding
        texels[i] = static_cast<float>(exact[i]) / static_cast<float>(GetExactOne(format));
}

namespace detail {

template <typename T, typename F>
Expected<void> DecodeImage(BlockFormat format, std::span<const std::byte> blocks, std::uint32_t width,
                           std::uint32_t height, std::span<T> texels, F decode) noexcept {
    if (static_cast<unsigned>(format) >= static_cast<unsigned>(kBlockFormatCount))
        return Fail(Status::OutOfRange, "format: %u: 0 ... %d", static_cast<unsigned>(format),
                    kBlockFormatCount - 1);
    const std::size_t blockBytes = GetBytesPerBlock(format);
    const std::uint64_t columns = CountBlocks(width);
    const std::uint64_t wanted = columns * CountBlocks(height);
    if (blocks.size() / blockBytes < wanted)
        return Fail(Status::OutOfRange, "blocks: %zu bytes: %llu blocks of %zu are needed", blocks.size(),
                    static_cast<unsigned long long>(wanted), blockBytes);
    const std::uint64_t count = std::uint64_t{width} * height;
    if (texels.size() / 4 < count)
        return Fail(Status::OutOfRange, "texels: %zu numbers: 4 * %u * %u are needed", texels.size(), width,
                    height);
    for (std::uint64_t i = 0; i < wanted; ++i) {
        T block[64];
        decode(format, blocks.data() + i * blockBytes, block);
        const std::uint64_t left = 4 * (i % columns);
        const std::uint64_t top = 4 * (i / columns);
        for (std::uint64_t t = 0; t < 16; ++t) {
            const std::uint64_t x = left + t % 4;
            const std::uint64_t y = top + t / 4;
            for (std::uint64_t c = 0; c < 4 && x < width && y < height; ++c)
                texels[static_cast<std::size_t>((y * width + x) * 4 + c)] = block[4 * t + c];
        }
    }
    return {};
}

} // namespace detail

/// An image of width x height texels, blocks row by row, to RGBA row by row. Errors: OutOfRange if there are
/// not enough blocks or too little room.
inline Expected<void> DecodeBlocksToBytes(BlockFormat format, std::span<const std::byte> blocks,
                                          std::uint32_t width, std::uint32_t height,
                                          std::span<std::uint8_t> texels) noexcept {
    return detail::DecodeImage(format, blocks, width, height, texels, DecodeBlockBytes);
}

/// The same for Bc6, to bits of halves.
inline Expected<void> DecodeBlocksToHalves(BlockFormat format, std::span<const std::byte> blocks,
                                           std::uint32_t width, std::uint32_t height,
                                           std::span<std::uint16_t> texels) noexcept {
    return detail::DecodeImage(format, blocks, width, height, texels, DecodeBlockHalves);
}

/// The same for every format, to floats.
inline Expected<void> DecodeBlocksToFloats(BlockFormat format, std::span<const std::byte> blocks,
                                           std::uint32_t width, std::uint32_t height,
                                           std::span<float> texels) noexcept {
    return detail::DecodeImage(format, blocks, width, height, texels, DecodeBlockFloats);
}

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
