// SPDX-License-Identifier: MIT
// Stability: internal
// BC1 to BC5 to exact numbers: every value of their palettes is an integer of units (BlockDecoder.h). By the
// text of Khronos Data Format 1.3, "S3TC" and "RGTC".
#pragma once

#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::bc::detail {

/// Units of one step of a byte: a multiple of 2 and 3 (BC1), 5 and 7 (BC4).
inline constexpr int kStepUnits = 210;

inline int GetWord16(const std::byte* bytes) noexcept {
    return static_cast<int>(bytes[0]) | static_cast<int>(bytes[1]) << 8;
}

/// RGB of a palette's four colours, of steps of kStepUnits. A color is 5, 6 and 5 bits, widened by repeating
/// them.
inline void ExpandColor565(int color, int (&rgb)[3]) noexcept {
    const int r = color >> 11 & 31;
    const int g = color >> 5 & 63;
    const int b = color & 31;
    rgb[0] = r << 3 | r >> 2;
    rgb[1] = g << 2 | g >> 4;
    rgb[2] = b << 3 | b >> 2;
}

/// The colours of BC1 (isBc1: three of them and transparent black where the first is not the larger one), BC2
/// and BC3. Alpha of `units` is written for BC1 only.
inline void DecodeColorBlock(const std::byte* block, bool isBc1, std::int32_t (&units)[64]) noexcept {
    const int first = GetWord16(block);
    const int second = GetWord16(block + 2);
    int ends[2][3];
    ExpandColor565(first, ends[0]);
    ExpandColor565(second, ends[1]);
    const bool hasFour = !isBc1 || first > second;
    for (int t = 0; t < 16; ++t) {
        const int index = static_cast<int>(block[4 + t / 4]) >> (2 * (t % 4)) & 3;
        for (int c = 0; c < 3; ++c) {
            const int a = ends[0][c];
            const int b = ends[1][c];
            const int four[4] = {kStepUnits * a, kStepUnits * b, kStepUnits / 3 * (2 * a + b),
                                 kStepUnits / 3 * (a + 2 * b)};
            const int three[4] = {kStepUnits * a, kStepUnits * b, kStepUnits / 2 * (a + b), 0};
            units[4 * t + c] = hasFour ? four[index] : three[index];
        }
        if (isBc1)
            units[4 * t + 3] = hasFour || index < 3 ? 255 * kStepUnits : 0;
    }
}

/// Channel `channel` of BC4, BC5 and BC3's alpha. Signed: -128 is -127, and which form it is say the numbers
/// as they are stored, so that (-127, -128) has eight values.
inline void DecodeChannelBlock(const std::byte* block, bool isSigned, int channel,
                               std::int32_t (&units)[64]) noexcept {
    int first = static_cast<int>(block[0]);
    int second = static_cast<int>(block[1]);
    if (isSigned) {
        first = first < 128 ? first : first - 256;
        second = second < 128 ? second : second - 256;
    }
    const bool hasEight = first > second;
    const int low = isSigned ? -127 : 0;
    first = first < low ? low : first;
    second = second < low ? low : second;
    std::uint64_t indices = 0;
    for (int i = 0; i < 6; ++i)
        indices |= static_cast<std::uint64_t>(block[2 + i]) << (8 * i);
    for (int t = 0; t < 16; ++t) {
        const int index = static_cast<int>(indices >> (3 * t) & 7);
        const int parts = hasEight ? 7 : 5;
        int value = kStepUnits / parts * ((parts + 1 - index) * first + (index - 1) * second);
        if (index < 2)
            value = kStepUnits * (index == 0 ? first : second);
        else if (!hasEight && index >= 6)
            value = kStepUnits * (index == 6 ? low : low + (isSigned ? 254 : 255));
        units[4 * t + channel] = value;
    }
}

} // namespace openntc::bc::detail

#include "openntc/core/RestoreMacros.h"
