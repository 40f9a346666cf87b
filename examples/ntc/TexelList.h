// SPDX-License-Identifier: MIT
// Lists of single texels: reading them from text, and decoding them in tiles.
#pragma once

#include "Decoder.h"

#include <array>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

class Progress;

struct Texel {
    int mip = 0;
    int x = 0;
    int y = 0;
};

/// Reads `mip x y` lines from a file or, for "-", standard input. Blank lines and everything after '#' are
/// ignored. Throws CommandError: BadInput if the list cannot be read or a line is not three integers, Usage
/// if a texel or mip lies outside the image, naming the line.
std::vector<Texel> ReadTexelList(const std::string& path, const TextureSetMetadata& metadata);

/// All 16 outputs of each texel, in order. Texels are inside the image. Throws CommandError with `subject`.
std::vector<std::array<float, 16>> DecodeTexels(Decoder& decoder, const TextureSetMetadata& metadata,
                                                std::span<const Texel> texels, const DecodeOptions& options,
                                                const std::string& subject, Progress* progress = nullptr);

} // namespace openntc::tool
