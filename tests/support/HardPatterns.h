// SPDX-License-Identifier: MIT
// Values of texels that are hard to encode, by position and channel.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace patterns {

// Integers only: a library's sine would differ between machines.
inline float Noise(int x, int y, int c) {
    auto h = static_cast<std::uint32_t>(x * 73856093) ^ static_cast<std::uint32_t>(y * 19349663) ^
             static_cast<std::uint32_t>((c + 1) * 83492791);
    h = (h ^ h >> 15) * 0x2c1b3c6du;
    h = (h ^ h >> 12) * 0x297a2d39u;
    return static_cast<float>((h ^ h >> 15) >> 16) / 65535.0f;
}

inline float Ramp(int x, int y, int c) {
    const int phase = (x * (c + 2) + y * 3) % 64;
    return static_cast<float>(phase < 32 ? phase : 64 - phase) / 32.0f;
}

/// 1e-5 ... 65504 in equal steps of the exponent: neighbours differ by factors.
inline float HugeRange(int x, int y, int c) {
    return std::min(1e-5f * std::exp2(Ramp(x, y, c) * 32.7f), 65504.0f);
}

inline float Disc(int x, int y, int) {
    const int distance = (x - 12) * (x - 12) + (y - 12) * (y - 12);
    return distance < 50 ? 1.0f : distance > 80 ? 0.0f : 0.5f;
}

} // namespace patterns
