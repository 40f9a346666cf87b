// SPDX-License-Identifier: MIT
// Stability: internal
// 64-bit arithmetic on numbers that come from files: it says when a result does not fit instead of wrapping.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "openntc/core/HideMacros.h"

namespace openntc {

constexpr std::optional<std::uint64_t> CheckedAdd(std::uint64_t a, std::uint64_t b) noexcept {
    if (a > std::numeric_limits<std::uint64_t>::max() - b)
        return std::nullopt;
    return a + b;
}

/// Rounds up to a multiple of `alignment` (a power of two).
constexpr std::optional<std::uint64_t> CheckedAlignUp(std::uint64_t value, std::uint64_t alignment) noexcept {
    const std::optional<std::uint64_t> sum = CheckedAdd(value, alignment - 1);
    if (!sum)
        return std::nullopt;
    return *sum & ~(alignment - 1);
}

/// True if [offset, offset + size) lies inside [0, limit), whatever the magnitudes.
constexpr bool IsRangeInside(std::uint64_t offset, std::uint64_t size, std::uint64_t limit) noexcept {
    return offset <= limit && size <= limit - offset;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
