// SPDX-License-Identifier: MIT
// Images of halves for the tests of BC6H, from formulas and seeds.
#pragma once

#include "openntc/core/Half.h"

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace openntc_bc6 {

struct HalfImage {
    std::string name;
    bool isSigned = false;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    std::vector<std::uint16_t> halves; // RGB
};

template <typename F>
HalfImage MakeHalfImage(const char* name, bool isSigned, std::uint32_t size, F texel) {
    HalfImage image{name, isSigned, size, size, {}};
    for (std::uint32_t y = 0; y < size; ++y) {
        for (std::uint32_t x = 0; x < size; ++x) {
            float rgb[3];
            texel(static_cast<float>(x) / static_cast<float>(size - 1),
                  static_cast<float>(y) / static_cast<float>(size - 1), rgb);
            for (const float value : rgb)
                image.halves.push_back(openntc::FloatToHalf(value));
        }
    }
    return image;
}

/// Smooth, steep, patterned, and random ones; the signed ones last.
inline std::vector<HalfImage> MakeHalfImages(std::uint32_t size, std::uint32_t seed) {
    std::mt19937 engine(seed);
    const auto random = [&] { return static_cast<float>(engine() >> 8) / 16777216.0f; };
    const auto power = [](float exponent) { return std::exp2(exponent); };
    std::vector<HalfImage> images;
    images.push_back(MakeHalfImage("gradient", false, size, [&](float x, float y, float* rgb) {
        rgb[0] = power(16 * x - 8);
        rgb[1] = power(16 * y - 8);
        rgb[2] = power(8 * (x + y) - 8);
    }));
    images.push_back(MakeHalfImage("slow gradient", false, size, [&](float x, float y, float* rgb) {
        rgb[0] = power(x);
        rgb[1] = power(0.2f * y - 3);
        rgb[2] = 0.5f + 0.01f * x * y;
    }));
    images.push_back(MakeHalfImage("sun", false, size, [&](float x, float y, float* rgb) {
        const float distance = std::hypot(x - 0.55f, y - 0.35f);
        const float halo = 0.2f + 300 * std::exp(-20 * distance) + 20 * std::exp(-4 * distance);
        const float disc = distance < 0.035f ? 60000.0f : 0.0f;
        rgb[0] = disc + halo;
        rgb[1] = 0.95f * disc + 0.9f * halo;
        rgb[2] = 0.85f * disc + 0.7f * halo;
    }));
    images.push_back(MakeHalfImage("texture", false, size, [&](float x, float y, float* rgb) {
        // A lit, rough surface of two colours with sharp borders.
        const float light = power(3 * std::sin(5 * x + 1) + 2 * std::cos(4 * y));
        const bool other = std::sin(37 * x + 3 * std::sin(9 * y)) > 0.2f;
        const float rough = 0.7f + 0.6f * random();
        rgb[0] = light * (other ? 0.8f : 0.3f) * rough;
        rgb[1] = light * (other ? 0.3f : 0.35f) * rough;
        rgb[2] = light * (other ? 0.1f : 0.6f) * (0.9f + 0.2f * random());
    }));
    images.push_back(MakeHalfImage("noise", false, size, [&](float, float, float* rgb) {
        for (int c = 0; c < 3; ++c)
            rgb[c] = std::pow(10.0f, 6 * random() - 3);
    }));
    images.push_back(MakeHalfImage("signed gradient", true, size, [](float x, float y, float* rgb) {
        rgb[0] = 8 * (2 * x - 1) * (2 * x - 1) * (2 * x - 1);
        rgb[1] = 8 * (2 * y - 1) * (2 * y - 1) * (2 * y - 1);
        rgb[2] = 4 * (2 * x - 1) * (2 * y - 1);
    }));
    images.push_back(MakeHalfImage("normals", true, size, [&](float, float, float* rgb) {
        const float angle = 6.2831853f * random();
        rgb[2] = random();
        const float radius = std::sqrt(1 - rgb[2] * rgb[2]);
        rgb[0] = radius * std::cos(angle);
        rgb[1] = radius * std::sin(angle);
    }));
    images.push_back(MakeHalfImage("signed noise", true, size, [&](float, float, float* rgb) {
        for (int c = 0; c < 3; ++c)
            rgb[c] = (random() < 0.5f ? -1.0f : 1.0f) * std::pow(10.0f, 6 * random() - 3);
    }));
    return images;
}

/// What a half counts as by the encoder's rule, written with numbers instead of bits.
inline int CountHalf(std::uint16_t bits, bool isSigned) {
    const float value = openntc::HalfToFloat(bits);
    if (std::isnan(value))
        return 0;
    const float limited = std::fmin(std::fmax(value, isSigned ? -65504.0f : 0.0f), 65504.0f);
    const int size = openntc::FloatToHalf(std::fabs(limited));
    return limited < 0 ? -size : size;
}

/// A decoded half, whose sign and magnitude are an integer.
inline int CountDecoded(std::uint16_t bits) {
    const int size = bits & 0x7FFF;
    return (bits & 0x8000) != 0 ? -size : size;
}

} // namespace openntc_bc6
