// SPDX-License-Identifier: MIT
// What the textures of a set need without neural compression: as plain texels and in block compression.
#pragma once

#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstdint>
#include <string>

namespace openntc::tool {

/// The block format to compare a texture with: the file's hint, or by its channels BC4 (one), BC5 (two), BC7 (three and
/// four) and BC6 (floats). None: no format holds it (UINT32, FLOAT32).
BlockCompressedFormat ChooseBlockFormat(const Texture& texture);

struct TextureBytes {
    std::uint64_t raw = 0;
    std::uint64_t blocks = 0; ///< raw where no block format holds it

    TextureBytes& operator+=(const TextureBytes& other) {
        raw += other.raw;
        blocks += other.blocks;
        return *this;
    }
};

/// Of one mip. Block compression takes whole blocks of 4 x 4, and one texture for every four channels.
TextureBytes GetTextureBytes(const Texture& texture, int width, int height);

/// Of all textures of a mip, and of all mips.
TextureBytes GetMipBytes(const TextureSetMetadata& metadata, int mip);
TextureBytes GetSetBytes(const TextureSetMetadata& metadata);

/// For people: `640 bytes`, `52.1 KiB`, `3.40 MiB`.
std::string FormatBytes(std::uint64_t bytes);

} // namespace openntc::tool
