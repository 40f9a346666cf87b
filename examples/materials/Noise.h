// SPDX-License-Identifier: MIT
// Seamless noise: lattices that repeat, so that textures tile.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace materials {

inline std::uint32_t Hash(std::uint32_t x, std::uint32_t y, std::uint32_t seed) {
    std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ seed * 0xcb1ab31fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    h = (h ^ (h >> 12)) * 0x297a2d39u;
    return h ^ (h >> 15);
}

/// Uniform in 0 ... 1 for an integer position.
inline float Random(int x, int y, std::uint32_t seed) {
    return static_cast<float>(Hash(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), seed) >> 8) /
           16777215.0f;
}

inline int Wrap(int value, int period) {
    const int r = value % period;
    return r < 0 ? r + period : r;
}

inline float Mix(float a, float b, float t) {
    return a + (b - a) * t;
}

inline float Smooth(float low, float high, float value) {
    const float t = std::clamp((value - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

/// Gradient-free lattice noise, 0 ... 1, of `period` cells over the unit square.
inline float ValueNoise(float u, float v, int period, std::uint32_t seed) {
    const float x = u * static_cast<float>(period), y = v * static_cast<float>(period);
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    float tx = x - static_cast<float>(x0), ty = y - static_cast<float>(y0);
    tx = tx * tx * (3.0f - 2.0f * tx);
    ty = ty * ty * (3.0f - 2.0f * ty);
    const auto corner = [&](int dx, int dy) {
        return Random(Wrap(x0 + dx, period), Wrap(y0 + dy, period), seed);
    };
    return Mix(Mix(corner(0, 0), corner(1, 0), tx), Mix(corner(0, 1), corner(1, 1), tx), ty);
}

/// Sum of octaves, 0 ... 1.
inline float Fractal(float u, float v, int period, int octaves, std::uint32_t seed) {
    float sum = 0.0f, weight = 0.5f, total = 0.0f;
    for (int i = 0; i < octaves; ++i) {
        sum += weight * ValueNoise(u, v, period << i, seed + static_cast<std::uint32_t>(i));
        total += weight;
        weight *= 0.55f;
    }
    return sum / total;
}

} // namespace materials
