// SPDX-License-Identifier: MIT
// Stability: stable
// IEEE 754 binary16, by bit operations: the same result on every platform.
#pragma once

#include "openntc/core/FloatBits.h"

#include <bit>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Widens binary16 bits exactly. NaN payloads are kept in the high bits and signalling NaN becomes quiet.
constexpr float HalfToFloat(std::uint16_t half) noexcept {
    const std::uint32_t sign = static_cast<std::uint32_t>(half & 0x8000u) << 16;
    const std::uint32_t exponent = (half >> 10) & 0x1Fu;
    std::uint32_t mantissa = half & 0x3FFu;
    if (exponent == 31)
        return BitCast<float>(sign | 0x7F800000u | (mantissa << 13) | (mantissa != 0 ? 0x00400000u : 0u));
    if (exponent != 0)
        return BitCast<float>(sign | ((exponent + 112) << 23) | (mantissa << 13));
    if (mantissa == 0)
        return BitCast<float>(sign);
    const std::uint32_t shift =
        static_cast<std::uint32_t>(std::countl_zero(mantissa)) - 21; // leading one to bit 10
    mantissa = (mantissa << shift) & 0x3FFu;
    return BitCast<float>(sign | ((113 - shift) << 23) | (mantissa << 13));
}

/// Rounds to the nearest binary16, ties to even. Magnitudes of 65520 and above become infinity (the IEEE
/// rule); NaN stays NaN (quiet, with the top of its payload).
constexpr std::uint16_t FloatToHalf(float value) noexcept {
    const std::uint32_t bits = BitCast<std::uint32_t>(value);
    const std::uint32_t sign = (bits >> 16) & 0x8000u;
    const std::uint32_t magnitude = bits & 0x7FFFFFFFu;
    if (magnitude > 0x7F800000u)
        return static_cast<std::uint16_t>(sign | 0x7E00u | ((magnitude >> 13) & 0x3FFu));
    if (magnitude >= 0x477FF000u) // 65520 = halfway between the largest half and the next power of two
        return static_cast<std::uint16_t>(sign | 0x7C00u);
    if (magnitude >= 0x38800000u) { // normal: 2^-14 and above
        const std::uint32_t rebiased = magnitude - (112u << 23);
        const std::uint32_t rounded = rebiased + 0xFFFu + ((rebiased >> 13) & 1u);
        return static_cast<std::uint16_t>(sign | (rounded >> 13));
    }
    if (magnitude < 0x33000000u) // below 2^-25, half of the smallest subnormal: rounds to zero
        return static_cast<std::uint16_t>(sign);
    const std::uint32_t exponent = magnitude >> 23; // 102 … 112
    const std::uint32_t significand =
        (magnitude & 0x7FFFFFu) | 0x800000u;    // value = significand · 2^(exponent − 150)
    const std::uint32_t shift = 126 - exponent; // units of 2^-24
    const std::uint32_t truncated = significand >> shift;
    const std::uint32_t remainder = significand & ((1u << shift) - 1u);
    const std::uint32_t halfway = 1u << (shift - 1u);
    const std::uint32_t roundUp =
        remainder > halfway || (remainder == halfway && (truncated & 1u) != 0) ? 1u : 0u;
    return static_cast<std::uint16_t>(sign | (truncated + roundUp));
}

/// The same as a binary32 number, in a form that compilers vectorise: to nearest binary16, ties to even, for
/// |value| below 65520. Below 2^-14 multiples of 2^-24, by adding and taking away a number whose spacing that
/// is.
constexpr float RoundToHalf(float value) noexcept {
    const auto bits = BitCast<std::uint32_t>(value);
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    const std::uint32_t normal = (magnitude + 0xfffu + ((magnitude >> 13) & 1u)) & 0xffffe000u;
    const float raised = BitCast<float>(magnitude) + 0.5f;
    const auto subnormal = BitCast<std::uint32_t>(raised - 0.5f);
    const std::uint32_t rounded = magnitude < 0x38800000u ? subnormal : normal;
    return BitCast<float>(rounded | (bits & 0x80000000u));
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
