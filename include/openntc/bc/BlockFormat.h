// SPDX-License-Identifier: MIT
// Stability: experimental
// Block-compressed formats: sizes, names, and the numbers that Vulkan, DXGI and files give them.
#pragma once

#include "openntc/bc/BlockFormats.h"
#include "openntc/format/Enums.h"

#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

/// A format that a block is stored in. Signed and unsigned forms are formats of their own; whether colours
/// are sRGB says the texture (GetVulkanFormat and GetDxgiFormat take it), not the block. Values equal
/// NTC_BC_*.
enum class BlockFormat : std::uint8_t {
    Bc1,         ///< RGB and one bit of alpha, 8 bytes
    Bc2,         ///< RGB and four bits of alpha
    Bc3,         ///< RGB, and alpha like Bc4Unsigned
    Bc4Unsigned, ///< R, 8 bytes
    Bc4Signed,
    Bc5Unsigned, ///< R and G, each like Bc4
    Bc5Signed,
    Bc6Unsigned, ///< RGB of half floats, 0 … 65504
    Bc6Signed,
    Bc7, ///< RGBA
};

inline constexpr int kBlockFormatCount = 10;
static_assert(static_cast<int>(BlockFormat::Bc3) == NTC_BC_BC3);
static_assert(static_cast<int>(BlockFormat::Bc6Unsigned) == NTC_BC_BC6_UNSIGNED);
static_assert(static_cast<int>(BlockFormat::Bc7) == NTC_BC_BC7);
inline constexpr int kBlockSize = 4; ///< texels of a side

/// 8 or 16.
constexpr std::size_t GetBytesPerBlock(BlockFormat format) noexcept {
    return format == BlockFormat::Bc1 || format == BlockFormat::Bc4Unsigned ||
                   format == BlockFormat::Bc4Signed
               ? 8
               : 16;
}

/// Blocks that cover `texels` of a side.
constexpr std::uint32_t CountBlocks(std::uint32_t texels) noexcept {
    return texels / 4 + (texels % 4 != 0 ? 1U : 0U);
}

/// Channels that a block keeps: 1 … 4. Bc1's alpha is one bit and counts.
constexpr int GetBlockChannels(BlockFormat format) noexcept {
    switch (format) {
    case BlockFormat::Bc4Unsigned:
    case BlockFormat::Bc4Signed:
        return 1;
    case BlockFormat::Bc5Unsigned:
    case BlockFormat::Bc5Signed:
        return 2;
    case BlockFormat::Bc6Unsigned:
    case BlockFormat::Bc6Signed:
        return 3;
    case BlockFormat::Bc1:
    case BlockFormat::Bc2:
    case BlockFormat::Bc3:
    case BlockFormat::Bc7:
        break;
    }
    return 4;
}

/// True if the format has an sRGB form (BC1 to BC3 and BC7).
constexpr bool HasSrgbForm(BlockFormat format) noexcept {
    return GetBlockChannels(format) == 4;
}

/// "bc1", "bc2", "bc3", "bc4", "bc4s", "bc5", "bc5s", "bc6", "bc6s", "bc7".
constexpr const char* BlockFormatToString(BlockFormat format) noexcept {
    constexpr const char* kNames[kBlockFormatCount] = {"bc1", "bc2",  "bc3", "bc4",  "bc4s",
                                                       "bc5", "bc5s", "bc6", "bc6s", "bc7"};
    return kNames[static_cast<std::size_t>(format)];
}

/// The value of VkFormat; `srgb` counts where HasSrgbForm. BC1 is the form with alpha.
constexpr std::uint32_t GetVulkanFormat(BlockFormat format, bool srgb) noexcept {
    constexpr std::uint32_t kLinear[kBlockFormatCount] = {133, 135, 137, 139, 140, 141, 142, 143, 144, 145};
    return kLinear[static_cast<std::size_t>(format)] + (srgb && HasSrgbForm(format) ? 1U : 0U);
}

/// The value of DXGI_FORMAT; `srgb` counts where HasSrgbForm.
constexpr std::uint32_t GetDxgiFormat(BlockFormat format, bool srgb) noexcept {
    constexpr std::uint32_t kLinear[kBlockFormatCount] = {71, 74, 77, 80, 81, 83, 84, 95, 96, 98};
    return kLinear[static_cast<std::size_t>(format)] + (srgb && HasSrgbForm(format) ? 1U : 0U);
}

/// The format that a texture set asks for (TextureInfo::bcFormat); unsigned forms. None: Bc7.
constexpr BlockFormat GetBlockFormat(BlockCompressedFormat format) noexcept {
    switch (format) {
    case BlockCompressedFormat::BC1:
        return BlockFormat::Bc1;
    case BlockCompressedFormat::BC2:
        return BlockFormat::Bc2;
    case BlockCompressedFormat::BC3:
        return BlockFormat::Bc3;
    case BlockCompressedFormat::BC4:
        return BlockFormat::Bc4Unsigned;
    case BlockCompressedFormat::BC5:
        return BlockFormat::Bc5Unsigned;
    case BlockCompressedFormat::BC6:
        return BlockFormat::Bc6Unsigned;
    case BlockCompressedFormat::BC7:
    case BlockCompressedFormat::None:
        break;
    }
    return BlockFormat::Bc7;
}

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
