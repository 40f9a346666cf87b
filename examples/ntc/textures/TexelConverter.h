// SPDX-License-Identifier: MIT
// From network outputs to the texels of a file, or to those that a block encoder reads, and to blocks.
#pragma once

#include "textures/TextureFormat.h"

#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// One texture of a set, in one format.
class TexelConverter {
public:
    TexelConverter(const TextureSetMetadata& metadata, const Texture& texture, const TextureFormat& format);

    /// Appends texels (16 outputs each) row by row, channels interleaved, numbers little-endian. Integers are rounded to
    /// nearest without dither, NaN is 0; signed ones hold 2 v - 1 of textures of 0 … 1, and v of textures of floats.
    /// Channels that the texture does not have are 0, alpha 1.
    void Append(std::span<const float> outputs, std::vector<std::byte>& texels) const;

private:
    struct Channel {
        int output; // -1: the texture has none
        int source; // NTC_COLOR_SPACE_*
        int destination;
    };

    void AppendNumber(float value, std::vector<std::byte>& texels) const;

    TexelNumber number_;
    bool isCentred_; // signed numbers of 0 … 1
    std::vector<Channel> channels_;
};

/// `fast`, `normal`, `best`; false for others.
enum class BlockEffort : std::uint8_t { Fast, Normal, Best };
const char* GetName(BlockEffort effort);

/// Texels as Append gives them, `width` in a row.
struct TexelRows {
    std::span<const std::byte> texels;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};

/// Blocks that cover the rows; beyond their edge texels repeat. Alpha below 128 is transparent in BC1, where the format
/// has alpha. `subject` is named in errors. Throws CommandError(Failed) if the format has no encoder.
void EncodeTexelBlocks(const TextureFormat& format, BlockEffort effort, const TexelRows& rows,
                       const std::string& subject, std::vector<std::byte>& blocks);

} // namespace openntc::tool
