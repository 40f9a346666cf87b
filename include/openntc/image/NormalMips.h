// SPDX-License-Identifier: MIT
// Stability: experimental
// Mips of normal maps: averages of unit vectors are shorter than one, and are made unit vectors again.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::image {

/// Stored z of normals that are stored as x and y alone, in the hemisphere of +z. Stored values are (n + 1) /
/// 2.
inline std::vector<float> MakeNormalZ(std::span<const float> x, std::span<const float> y) {
    std::vector<float> z(x.size());
    for (std::size_t i = 0; i < z.size(); ++i) {
        const float nx = 2.0f * x[i] - 1.0f, ny = 2.0f * y[i] - 1.0f;
        z[i] = 0.5f + 0.5f * std::sqrt(std::max(1.0f - nx * nx - ny * ny, 0.0f));
    }
    return z;
}

/// Scales stored vectors to length 1. Vectors that cancelled each other out, shorter than half a step of 8
/// bits, become +z.
inline void NormalizeVectors(std::span<float> x, std::span<float> y, std::span<float> z) {
    constexpr float kShortest = 1.0f / 255.0f; // stored values span 2 units of length
    for (std::size_t i = 0; i < x.size(); ++i) {
        float n[3] = {2.0f * x[i] - 1.0f, 2.0f * y[i] - 1.0f, 2.0f * z[i] - 1.0f};
        const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (length < kShortest) {
            n[0] = n[1] = 0.0f;
            n[2] = 1.0f;
        } else {
            for (float& value : n)
                value /= length;
        }
        x[i] = 0.5f + 0.5f * n[0];
        y[i] = 0.5f + 0.5f * n[1];
        z[i] = 0.5f + 0.5f * n[2];
    }
}

} // namespace openntc::image

#include "openntc/core/RestoreMacros.h"
