// SPDX-License-Identifier: MIT
// Questions about binary32 numbers from files, answered by their bits: they keep their meaning under
// -ffast-math, where compilers take NaN and infinities for impossible.
#pragma once

#include <bit>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// The bits without the sign; in the order of the magnitudes, infinity and NaN behind all numbers.
constexpr std::uint32_t GetMagnitudeBits(float value) noexcept {
    return std::bit_cast<std::uint32_t>(value) & 0x7FFFFFFFu;
}

/// Neither infinite nor NaN.
constexpr bool IsFinite(float value) noexcept {
    return GetMagnitudeBits(value) < 0x7F800000u;
}

/// |value| <= limit; false for NaN. `limit`: 0 or more, finite.
constexpr bool IsMagnitudeAtMost(float value, float limit) noexcept {
    return GetMagnitudeBits(value) <= GetMagnitudeBits(limit);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
