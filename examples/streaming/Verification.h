// SPDX-License-Identifier: MIT
// Pixels against the C++ decoder: what a pixel says it was decoded to, and what the reference decoder makes
// of the same texel of the whole set, which is put together in memory for that.
#pragma once

#include "Landscape.h"

#include <cstdint>
#include <span>

namespace openntc::landscape {

struct Check {
    std::uint64_t texels = 0;
    std::uint64_t wrong = 0; ///< in any bit of the 16 outputs, or not a texel of the set
};

/// Checks every `step`-th pixel that hit a field and was decoded.
Check CheckPixels(const Landscape& landscape, std::span<const LandscapePixel> pixels, std::size_t step);

} // namespace openntc::landscape
