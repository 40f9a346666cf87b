// SPDX-License-Identifier: MIT
// Stability: internal
// Questions about binary32 numbers from files, answered by their bits: they keep their meaning under
// -ffast-math, where compilers take NaN and infinities for impossible.
#pragma once

#include <bit>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// std::bit_cast, which libc++ has from version 14 on: the bytes of `value` as another type of the same size.
template <typename To, typename From>
constexpr To BitCast(const From& value) noexcept {
#if defined(__cpp_lib_bit_cast)
    return std::bit_cast<To>(value);
#else
    return __builtin_bit_cast(To, value);
#endif
}

/// The bits without the sign; in the order of the magnitudes, infinity and NaN behind all numbers.
constexpr std::uint32_t GetMagnitudeBits(float value) noexcept {
    return BitCast<std::uint32_t>(value) & 0x7FFFFFFFu;
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
