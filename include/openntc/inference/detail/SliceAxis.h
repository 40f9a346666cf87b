// SPDX-License-Identifier: MIT
// Stability: internal
// The arithmetic of slices on one axis. The format defines it in binary32 with one rounding for each
// operation, and another rounding gives another slice; here it is worked out in integers, so that no compiler
// option (-ffast-math, contraction, x87) can change it. Source: format specification, "streaming" 3.2 and 4.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// A binary32 number >= 0 as mantissa * 2^-shift; the mantissa has at most 24 digits, or is 2^24.
struct RoundedNumber {
    std::uint64_t mantissa = 0;
    int shift = 0;
};

/// Rounds value * 2^-shift to 24 digits, ties to even. `isMore`: the number is a little larger than that, by
/// less than its last digit; the value must then have 26 digits or more.
constexpr RoundedNumber RoundToBinary32(std::uint64_t value, int shift, bool isMore) noexcept {
    const int drop = static_cast<int>(std::bit_width(value)) - 24;
    if (drop <= 0)
        return {value, shift};
    const std::uint64_t half = std::uint64_t{1} << (drop - 1);
    const std::uint64_t rest = value & (2 * half - 1);
    const std::uint64_t mantissa = value >> drop;
    const bool isUp = rest > half || (rest == half && (isMore || (mantissa & 1) != 0));
    return {mantissa + (isUp ? 1 : 0), shift - drop};
}

/// f32(f32(numerator / denominator) * latents): a position on an axis of `latents` pixels. numerator 0 …
/// 2^21 and at most twice the denominator; denominator 1 … 2^21; latents 1 … 65535. The shift is 7 … 44.
constexpr RoundedNumber GetLatentPosition(int numerator, int denominator, int latents) noexcept {
    if (numerator == 0)
        return {0, 24};
    const std::uint64_t divisor = static_cast<std::uint64_t>(denominator);
    const int digits = std::countl_zero(static_cast<std::uint64_t>(numerator));
    const std::uint64_t dividend = static_cast<std::uint64_t>(numerator) << digits;
    const std::uint64_t quotient = dividend / divisor; // 42 digits or more
    const RoundedNumber ratio = RoundToBinary32(quotient, digits, quotient * divisor != dividend);
    return RoundToBinary32(ratio.mantissa * static_cast<std::uint64_t>(latents), ratio.shift, false);
}

/// max(trunc(f32(position - 0.5)), 0). From 1/2 on the difference is exact; below, it is less than 1.
constexpr int GetCell(RoundedNumber position) noexcept {
    const std::uint64_t half = std::uint64_t{1} << (position.shift - 1);
    return position.mantissa < half ? 0 : static_cast<int>((position.mantissa - half) >> position.shift);
}

/// Latent pixels first … last of an axis, both inclusive.
struct LatentInterval {
    int first = 0;
    int last = 0;
};

/// What the texels [begin, end) of an axis of `size` texels need, by their outer edges.
constexpr LatentInterval GetEdgeInterval(int size, int latents, int begin, int end) noexcept {
    return {GetCell(GetLatentPosition(begin, size, latents)),
            std::min(GetCell(GetLatentPosition(end, size, latents)) + 1, latents - 1)};
}

/// The lower latent pixel of the two that a texel's centre lies between.
constexpr int GetFirstTap(int size, int latents, int texel) noexcept {
    return GetCell(GetLatentPosition(2 * texel + 1, 2 * size, latents));
}

/// texels * latents / size rounded up, in binary32 but never less than the exact number.
constexpr int GetScaledCeiling(int texels, int size, int latents) noexcept {
    const std::int64_t exact = (std::int64_t{texels} * latents + size - 1) / size;
    if (texels > 2 * std::int64_t{size})
        return static_cast<int>(exact); // beyond the grid: it is cut to `latents` anyway
    const RoundedNumber position = GetLatentPosition(texels, size, latents);
    const std::uint64_t one = std::uint64_t{1} << position.shift;
    return std::max(static_cast<int>(exact),
                    static_cast<int>((position.mantissa + one - 1) >> position.shift));
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
