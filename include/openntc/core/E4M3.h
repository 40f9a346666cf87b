// SPDX-License-Identifier: MIT
// Stability: stable
// The 8-bit float E4M3 in its OCP "FN" form: 1 sign, 4 exponent (bias 7) and 3 mantissa bits; largest finite
// value 448 (0x7E), NaN 0x7F and 0xFF, no infinities, subnormals k · 2^-9. Source: OCP 8-bit Floating Point
// Specification 1.0.
#pragma once

#include "openntc/core/FloatBits.h"

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Widens E4M3 bits exactly; 0x7F and 0xFF give quiet NaN of that sign.
constexpr float E4M3ToFloat(std::uint8_t bits) noexcept {
    const std::uint32_t sign = static_cast<std::uint32_t>(bits & 0x80u) << 24;
    const std::uint32_t exponent = (bits >> 3) & 0xFu;
    const std::uint32_t mantissa = bits & 0x7u;
    if (exponent == 15 && mantissa == 7)
        return BitCast<float>(sign | 0x7FC00000u);
    if (exponent != 0)
        return BitCast<float>(sign | ((exponent + 120) << 23) | (mantissa << 20));
    const float magnitude = static_cast<float>(mantissa) * 0.001953125f; // 2^-9
    return sign != 0 ? -magnitude : magnitude;
}

/// Rounds to the nearest E4M3 value, ties to even. Overflow rule: saturation, as the format's encoder does —
/// everything that would round beyond 448, infinities included, becomes ±448 (0x7E, 0xFE). NaN becomes 0x7F
/// with its sign.
constexpr std::uint8_t FloatToE4M3(float value) noexcept {
    const std::uint32_t bits = BitCast<std::uint32_t>(value);
    const std::uint32_t sign = (bits >> 24) & 0x80u;
    const std::uint32_t magnitude = bits & 0x7FFFFFFFu;
    if (magnitude > 0x7F800000u)
        return static_cast<std::uint8_t>(sign | 0x7Fu);
    if (magnitude >= 0x43E00000u) // 448
        return static_cast<std::uint8_t>(sign | 0x7Eu);
    if (magnitude >= 0x3C800000u) { // normal: 2^-6 and above
        const std::uint32_t rebiased = magnitude - (120u << 23);
        const std::uint32_t rounded = rebiased + 0x7FFFFu + ((rebiased >> 20) & 1u);
        return static_cast<std::uint8_t>(sign | (rounded >> 20));
    }
    if (magnitude < 0x3A800000u) // below 2^-10, half of the smallest subnormal: rounds to zero
        return static_cast<std::uint8_t>(sign);
    const std::uint32_t exponent = magnitude >> 23; // 117 … 120
    const std::uint32_t significand =
        (magnitude & 0x7FFFFFu) | 0x800000u;    // value = significand · 2^(exponent − 150)
    const std::uint32_t shift = 141 - exponent; // units of 2^-9
    const std::uint32_t truncated = significand >> shift;
    const std::uint32_t remainder = significand & ((1u << shift) - 1u);
    const std::uint32_t halfway = 1u << (shift - 1u);
    const std::uint32_t roundUp =
        remainder > halfway || (remainder == halfway && (truncated & 1u) != 0) ? 1u : 0u;
    return static_cast<std::uint8_t>(sign | (truncated + roundUp));
}

/// The same as a binary32 number, in a form that compilers vectorise; not for NaN. Below 2^-6
/// multiples of 2^-9.
constexpr float RoundToE4M3(float value) noexcept {
    const auto bits = BitCast<std::uint32_t>(value);
    const std::uint32_t magnitude = bits & 0x7fffffffu;
    std::uint32_t normal = (magnitude + 0x7ffffu + ((magnitude >> 20) & 1u)) & 0xfff00000u;
    normal = normal > 0x43e00000u ? 0x43e00000u : normal;
    const float raised = BitCast<float>(magnitude) + 16384.0f;
    const auto subnormal = BitCast<std::uint32_t>(raised - 16384.0f);
    const std::uint32_t rounded = magnitude < 0x3c800000u ? subnormal : normal;
    return BitCast<float>(rounded | (bits & 0x80000000u));
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
