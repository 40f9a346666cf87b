// SPDX-License-Identifier: MIT
// FLIP (Andersson et al. 2020): how different two pictures look to somebody who flips between them.
#pragma once

#include <span>
#include <vector>

namespace openntc::tool {

struct FlipResult {
    double mean = 0.0, maximum = 0.0;
    std::vector<float> map; ///< 0 ... 1 per pixel
};

/// Both pictures are width x height pixels of three sRGB numbers, 0 ... 1 (others are clamped), seen from 0.7
/// m on a display 0.7 m wide with 3840 pixels. Pictures of the low dynamic range, that is: what a display
/// shows. `threads`: 0 is all; results do not depend on it.
FlipResult ComputeFlip(std::span<const float> reference, std::span<const float> test, int width, int height,
                       int threads = 0);

} // namespace openntc::tool
