// SPDX-License-Identifier: MIT
// The block encoders behind one function, which alone is compiled with them.
#pragma once

#include "textures/TextureFormat.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::bc {
enum class BlockQuality : std::uint8_t; // of the encoders, which are slow to compile
}

namespace openntc::tool {

enum class BlockEffort : std::uint8_t { Fast, Normal, Best };
/// `fast`, `normal`, `best`.
const char* GetName(BlockEffort effort);
bc::BlockQuality ToBlockQuality(BlockEffort effort);

/// Texels as TexelConverter gives them, `width` in a row.
struct TexelRows {
    std::span<const std::byte> texels;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};

/// Blocks that cover the rows; beyond their edge texels repeat. `threads`: 0 is all. `subject` is named in
/// errors. `hints`: of BC7, one a block as bc::GetBlockHint reads them, -1: search; empty: search all.
/// `alphaThreshold`: alpha at most this (-1: none) is transparent in BC1; without it 127 where the format has
/// alpha. Throws CommandError(Failed) if the format has no encoder.
void EncodeTexelBlocks(const TextureFormat& format, BlockEffort effort, const TexelRows& rows, int threads,
                       const std::string& subject, std::vector<std::byte>& blocks,
                       std::span<const std::int32_t> hints = {}, std::optional<int> alphaThreshold = {});

/// False for formats that EncodeTexelBlocks refuses.
bool HasBlockEncoder(bc::BlockFormat format);

/// Of a BC1 block with alpha: alpha below this is transparent.
inline constexpr int kBc1OpaqueAlpha = 128;

} // namespace openntc::tool
