// SPDX-License-Identifier: MIT
// Rounding of binary32 numbers to binary16 and E4M3, in forms that compilers vectorise.
#pragma once

#include <bit>
#include <cstdint>

namespace openntc::encode::detail {

/// To nearest binary16, ties to even, for |value| below 65520. Below 2^-14 multiples of 2^-24, by adding and taking
/// away a number whose spacing that is.
inline float RoundToHalf(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    const std::uint32_t normal = (magnitude + 0xfffu + ((magnitude >> 13) & 1u)) & 0xffffe000u;
    const float raised = std::bit_cast<float>(magnitude) + 0.5f;
    const auto subnormal = std::bit_cast<std::uint32_t>(raised - 0.5f);
    const std::uint32_t rounded = magnitude < 0x38800000u ? subnormal : normal;
    return std::bit_cast<float>(rounded | (bits & 0x80000000u));
}

/// To nearest E4M3 (OCP 8-bit floating point specification), ties to even, saturating at 448; not for NaN. Below 2^-6
/// multiples of 2^-9.
inline float RoundToE4M3(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    std::uint32_t normal = (magnitude + 0x7ffffu + ((magnitude >> 20) & 1u)) & 0xfff00000u;
    normal = normal > 0x43e00000u ? 0x43e00000u : normal;
    const float raised = std::bit_cast<float>(magnitude) + 16384.0f;
    const auto subnormal = std::bit_cast<std::uint32_t>(raised - 16384.0f);
    const std::uint32_t rounded = magnitude < 0x3c800000u ? subnormal : normal;
    return std::bit_cast<float>(rounded | (bits & 0x80000000u));
}

} // namespace openntc::encode::detail
