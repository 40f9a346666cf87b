// SPDX-License-Identifier: MIT
// A texture set repeated downwards, so that a pass that decodes a rectangle of a mip has enough to do.
#pragma once

#include "Decoder.h"

#include <cstddef>
#include <vector>

namespace openntc::report {

/// Mip 0 alone, `copies` below one another: constants (whose other mips are not there) and latents. Texels next to a seam
/// blend latents of both sides. Empty latents if those of one copy end within a word, or the height passes the format's.
struct RepeatedSet {
    NtcTextureSetConstants constants;
    std::vector<std::byte> latents;
};
RepeatedSet RepeatBelow(const tool::DecodeData& data, int copies);

} // namespace openntc::report
