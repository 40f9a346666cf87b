// SPDX-License-Identifier: MIT
// From network outputs to the texels of a file, or to those that a block encoder reads.
#pragma once

#include "textures/TextureFormat.h"

#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstddef>
#include <cstdint>
#include <span>
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

} // namespace openntc::tool
