// SPDX-License-Identifier: MIT
// Stability: internal
// Texels of an image to the lanes of a batch. Beyond the image the nearest texel of its edge counts; no other
// memory is read.
#pragma once

#include "openntc/bc/BlockImage.h"
#include "openntc/bc/detail/BlockBatch.h"

#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::bc::detail {

/// An image whose rows and texels are known in bytes.
struct GatherSource {
    const BlockImage* image;
    std::size_t rowBytes;
    std::size_t texelBytes;
};

inline const std::byte* FindTexel(const GatherSource& source, std::uint32_t x, std::uint32_t y) noexcept {
    const BlockImage& image = *source.image;
    const std::size_t column = x < image.width ? x : image.width - 1;
    const std::size_t row = y < image.height ? y : image.height - 1;
    return image.bytes.data() + row * source.rowBytes + column * source.texelBytes;
}

/// One texel to four numbers, `lanes` apart.
inline void GatherTexel(const BlockImage& image, const std::byte* from, std::int32_t* to,
                        std::size_t lanes) noexcept {
    const std::int32_t opaque = image.type == TexelType::Half        ? 0x3C00
                                : image.type == TexelType::Unsigned8 ? 255
                                                                     : 127;
    for (int c = 0; c < 4; ++c) {
        std::int32_t value = c == 3 ? opaque : 0;
        if (c < image.channels) {
            if (image.type == TexelType::Half) {
                std::uint16_t bits;
                std::memcpy(&bits, from + 2 * c, 2);
                value = static_cast<std::int16_t>(bits);
            } else if (image.type == TexelType::Signed8) {
                value = static_cast<std::int8_t>(from[c]);
                value = value < -127 ? -127 : value;
            } else {
                value = static_cast<std::uint8_t>(from[c]);
            }
        }
        to[static_cast<std::size_t>(c) * lanes] = value;
    }
}

/// The texels of a block to lane `lane` of texels[].
inline void GatherTexels(const GatherSource& source, std::uint32_t blockX, std::uint32_t blockY,
                         BlockBatch& batch, std::size_t lane, std::size_t lanes) noexcept {
    for (std::uint32_t t = 0; t < 16; ++t)
        GatherTexel(*source.image, FindTexel(source, 4 * blockX + t % 4, 4 * blockY + t / 4),
                    batch.texels + 4 * t * lanes + lane, lanes);
}

/// The same to packed[], for formats of 8 bits a channel.
inline void GatherPacked(const GatherSource& source, std::uint32_t blockX, std::uint32_t blockY,
                         BlockBatch& batch, std::size_t lane, std::size_t lanes) noexcept {
    const BlockImage& image = *source.image;
    const std::uint32_t x = 4 * blockX;
    const std::uint32_t y = 4 * blockY;
    if (source.texelBytes == 4 && image.width - x >= 4 && image.height - y >= 4) {
        for (std::uint32_t row = 0; row < 4; ++row) {
            std::uint32_t words[4];
            std::memcpy(words, FindTexel(source, x, y + row), sizeof words);
            for (std::uint32_t column = 0; column < 4; ++column)
                batch.packed[(4 * row + column) * lanes + lane] = words[column];
        }
        return;
    }
    const std::uint32_t opaque = image.type == TexelType::Signed8 ? 0x7F000000U : 0xFF000000U;
    for (std::uint32_t t = 0; t < 16; ++t) {
        const std::byte* from = FindTexel(source, x + t % 4, y + t / 4);
        std::uint32_t word = image.channels < 4 ? opaque : 0;
        for (int c = 0; c < image.channels; ++c)
            word |= static_cast<std::uint32_t>(from[c]) << (8 * c);
        batch.packed[t * lanes + lane] = word;
    }
}

} // namespace openntc::bc::detail

#include "openntc/core/RestoreMacros.h"
