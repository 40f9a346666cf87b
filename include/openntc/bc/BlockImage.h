// SPDX-License-Identifier: MIT
// Stability: experimental
// What block encoders read: an image in memory, and a rectangle of its blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

/// What the numbers of an image are.
enum class TexelType : std::uint8_t {
    Unsigned8, ///< 0 … 255
    Signed8,   ///< -128 … 127, of which -128 counts as -127
    Half,      ///< binary16 by its bits, for Bc6; NaN, infinities and signs as BlockEncoder's page says
};

/// An image in memory that is not owned. Texels row by row, channels interleaved, R first; channels that are
/// missing are 0, alpha is opaque.
struct BlockImage {
    std::span<const std::byte> bytes;
    std::uint32_t width = 0;  ///< texels, 1 or more
    std::uint32_t height = 0; ///< texels, 1 or more
    std::size_t rowBytes = 0; ///< from one row to the next; 0: rows follow each other
    int channels = 4;         ///< 1 … 4
    TexelType type = TexelType::Unsigned8;
};

/// A rectangle of blocks.
struct BlockRect {
    std::uint32_t left = 0;
    std::uint32_t top = 0;
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
