// SPDX-License-Identifier: MIT
// Formats of texels and blocks in DDS and KTX2 files, and which one a texture of a set gets.
#pragma once

#include "openntc/bc/BlockFormat.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace openntc::tool {

/// How a number is stored.
enum class TexelNumber : std::uint8_t { Unorm8, Snorm8, Unorm16, Half, Float };

/// Of one file.
struct TextureFormat {
    std::optional<bc::BlockFormat> block;     ///< empty: texels as they are
    TexelNumber number = TexelNumber::Unorm8; ///< of a channel of a texel, or of what the block encoder reads
    int channels = 4;                         ///< stored in a texel, 1, 2 or 4, or read by the block encoder
    bool srgb = false;                        ///< colours are sRGB, and the format says so
    bool hasAlpha = true;

    friend bool operator==(const TextureFormat&, const TextureFormat&) = default;
};

/// `r8`, `rgba16f`, `bc7`.
std::string GetName(const TextureFormat& format);
/// The value of VkFormat.
std::uint32_t GetVulkanFormat(const TextureFormat& format);
/// The value of DXGI_FORMAT.
std::uint32_t GetDxgiFormat(const TextureFormat& format);

/// Bytes of a channel before block compression: 1, 2 or 4.
int GetNumberBytes(TexelNumber number);
/// Bytes of a texel or block in the file.
std::uint32_t GetUnitBytes(const TextureFormat& format);
/// Texels of a side that one unit covers: 1 or 4.
std::uint32_t GetUnitTexels(const TextureFormat& format);

/// What is asked for: a block format, none, or what each texture's metadata say.
struct BlockChoice {
    bool isAuto = true;
    std::optional<bc::BlockFormat> block; ///< unless isAuto

    bool operator==(const BlockChoice&) const = default;
};

/// A texture's format in a file, and how it differs from what the texture declares.
struct ChosenFormat {
    TextureFormat format;
    std::vector<std::string> losses; ///< for people: channels left out, colours made linear, values clamped
};

/// sRGB or linear follows the space that the texture declares (linear if `linear`). Where the format has no sRGB form,
/// colours are made linear: BC4, BC5, UNORM16, floats. Textures of one and two sRGB channels of 8 bits become RGBA8, and
/// HLG becomes linear half floats. Empty if no format holds the texture: UINT32, more than four channels.
std::optional<ChosenFormat> ChooseFormat(const Texture& texture, const BlockChoice& choice, bool linear);

/// The block format with this name (`bc1` … `bc7`, `bc4s`, `bc5s`, `bc6s`, `bc6h`), if there is one.
std::optional<bc::BlockFormat> FindBlockFormat(const std::string& name);

} // namespace openntc::tool
