// SPDX-License-Identifier: MIT
// Stability: internal
// BC6H to the bits of halves, by the text of Khronos Data Format 1.3, "BC6H".
#pragma once

#include "openntc/bc/detail/BptcTables.h"

#include "openntc/core/HideMacros.h"

namespace openntc::bc::detail {

/// Bits of an endpoint's number that follow each other in a block. A negative count: highest bit first.
struct Bc6Field {
    std::uint8_t component; ///< 4 channel + endpoint
    std::uint8_t lowBit;
    std::int8_t count; ///< 0: the list ends
};

struct Bc6Mode {
    std::uint8_t code, codeBits, regions, isTransformed, endpointBits;
    std::uint8_t deltaBits[3]; ///< of endpoints 1 … 3
    Bc6Field fields[30];
};

inline constexpr Bc6Mode kBc6Modes[14] = {
    // g2[4] b2[4] b3[4] r0[9:0] g0[9:0] b0[9:0] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1]
    // b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]
    {0,
     2,
     2,
     1,
     10,
     {5, 5, 5},
     {{6, 4, 1},
      {10, 4, 1},
      {11, 4, 1},
      {0, 0, 10},
      {4, 0, 10},
      {8, 0, 10},
      {1, 0, 5},
      {7, 4, 1},
      {6, 0, 4},
      {5, 0, 5},
      {11, 0, 1},
      {7, 0, 4},
      {9, 0, 5},
      {11, 1, 1},
      {10, 0, 4},
      {2, 0, 5},
      {11, 2, 1},
      {3, 0, 5},
      {11, 3, 1}}},
    // g2[5] g3[4] g3[5] r0[6:0] b3[0] b3[1] b2[4] g0[6:0] b2[5] b3[2] g2[4] b0[6:0] b3[3] b3[5] b3[4]
    // r1[5:0] g2[3:0] g1[5:0] g3[3:0] b1[5:0] b2[3:0] r2[5:0] r3[5:0]
    {1, 2, 2, 1, 7, {6, 6, 6}, {{6, 5, 1},  {7, 4, 1},  {7, 5, 1},  {0, 0, 7},  {11, 0, 1}, {11, 1, 1},
                                {10, 4, 1}, {4, 0, 7},  {10, 5, 1}, {11, 2, 1}, {6, 4, 1},  {8, 0, 7},
                                {11, 3, 1}, {11, 5, 1}, {11, 4, 1}, {1, 0, 6},  {6, 0, 4},  {5, 0, 6},
                                {7, 0, 4},  {9, 0, 6},  {10, 0, 4}, {2, 0, 6},  {3, 0, 6}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[4:0] r0[10] g2[3:0] g1[3:0] g0[10] b3[0] g3[3:0] b1[3:0] b0[10] b3[1]
    // b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]
    {2,
     5,
     2,
     1,
     11,
     {5, 4, 4},
     {{0, 0, 10},
      {4, 0, 10},
      {8, 0, 10},
      {1, 0, 5},
      {0, 10, 1},
      {6, 0, 4},
      {5, 0, 4},
      {4, 10, 1},
      {11, 0, 1},
      {7, 0, 4},
      {9, 0, 4},
      {8, 10, 1},
      {11, 1, 1},
      {10, 0, 4},
      {2, 0, 5},
      {11, 2, 1},
      {3, 0, 5},
      {11, 3, 1}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10] g3[4] g2[3:0] g1[4:0] g0[10] g3[3:0] b1[3:0] b0[10] b3[1]
    // b2[3:0] r2[3:0] b3[0] b3[2] r3[3:0] g2[4] b3[3]
    {6, 5, 2, 1, 11, {4, 5, 4}, {{0, 0, 10}, {4, 0, 10}, {8, 0, 10}, {1, 0, 4},  {0, 10, 1},
                                 {7, 4, 1},  {6, 0, 4},  {5, 0, 5},  {4, 10, 1}, {7, 0, 4},
                                 {9, 0, 4},  {8, 10, 1}, {11, 1, 1}, {10, 0, 4}, {2, 0, 4},
                                 {11, 0, 1}, {11, 2, 1}, {3, 0, 4},  {6, 4, 1},  {11, 3, 1}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10] b2[4] g2[3:0] g1[3:0] g0[10] b3[0] g3[3:0] b1[4:0] b0[10]
    // b2[3:0] r2[3:0] b3[1] b3[2] r3[3:0] b3[4] b3[3]
    {10, 5, 2, 1, 11, {4, 4, 5}, {{0, 0, 10}, {4, 0, 10}, {8, 0, 10}, {1, 0, 4},  {0, 10, 1},
                                  {10, 4, 1}, {6, 0, 4},  {5, 0, 4},  {4, 10, 1}, {11, 0, 1},
                                  {7, 0, 4},  {9, 0, 5},  {8, 10, 1}, {10, 0, 4}, {2, 0, 4},
                                  {11, 1, 1}, {11, 2, 1}, {3, 0, 4},  {11, 4, 1}, {11, 3, 1}}},
    // r0[8:0] b2[4] g0[8:0] g2[4] b0[8:0] b3[4] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0] g3[3:0] b1[4:0] b3[1]
    // b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]
    {14,
     5,
     2,
     1,
     9,
     {5, 5, 5},
     {{0, 0, 9},
      {10, 4, 1},
      {4, 0, 9},
      {6, 4, 1},
      {8, 0, 9},
      {11, 4, 1},
      {1, 0, 5},
      {7, 4, 1},
      {6, 0, 4},
      {5, 0, 5},
      {11, 0, 1},
      {7, 0, 4},
      {9, 0, 5},
      {11, 1, 1},
      {10, 0, 4},
      {2, 0, 5},
      {11, 2, 1},
      {3, 0, 5},
      {11, 3, 1}}},
    // r0[7:0] g3[4] b2[4] g0[7:0] b3[2] g2[4] b0[7:0] b3[3] b3[4] r1[5:0] g2[3:0] g1[4:0] b3[0] g3[3:0]
    // b1[4:0] b3[1] b2[3:0] r2[5:0] r3[5:0]
    {18,
     5,
     2,
     1,
     8,
     {6, 5, 5},
     {{0, 0, 8},
      {7, 4, 1},
      {10, 4, 1},
      {4, 0, 8},
      {11, 2, 1},
      {6, 4, 1},
      {8, 0, 8},
      {11, 3, 1},
      {11, 4, 1},
      {1, 0, 6},
      {6, 0, 4},
      {5, 0, 5},
      {11, 0, 1},
      {7, 0, 4},
      {9, 0, 5},
      {11, 1, 1},
      {10, 0, 4},
      {2, 0, 6},
      {3, 0, 6}}},
    // r0[7:0] b3[0] b2[4] g0[7:0] g2[5] g2[4] b0[7:0] g3[5] b3[4] r1[4:0] g3[4] g2[3:0] g1[5:0] g3[3:0]
    // b1[4:0] b3[1] b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]
    {22, 5, 2, 1, 8, {5, 6, 5}, {{0, 0, 8},  {11, 0, 1}, {10, 4, 1}, {4, 0, 8},  {6, 5, 1},  {6, 4, 1},
                                 {8, 0, 8},  {7, 5, 1},  {11, 4, 1}, {1, 0, 5},  {7, 4, 1},  {6, 0, 4},
                                 {5, 0, 6},  {7, 0, 4},  {9, 0, 5},  {11, 1, 1}, {10, 0, 4}, {2, 0, 5},
                                 {11, 2, 1}, {3, 0, 5},  {11, 3, 1}}},
    // r0[7:0] b3[1] b2[4] g0[7:0] b2[5] g2[4] b0[7:0] b3[5] b3[4] r1[4:0] g3[4] g2[3:0] g1[4:0] b3[0]
    // g3[3:0] b1[5:0] b2[3:0] r2[4:0] b3[2] r3[4:0] b3[3]
    {26, 5, 2, 1, 8, {5, 5, 6}, {{0, 0, 8},  {11, 1, 1}, {10, 4, 1}, {4, 0, 8}, {10, 5, 1}, {6, 4, 1},
                                 {8, 0, 8},  {11, 5, 1}, {11, 4, 1}, {1, 0, 5}, {7, 4, 1},  {6, 0, 4},
                                 {5, 0, 5},  {11, 0, 1}, {7, 0, 4},  {9, 0, 6}, {10, 0, 4}, {2, 0, 5},
                                 {11, 2, 1}, {3, 0, 5},  {11, 3, 1}}},
    // r0[5:0] g3[4] b3[0] b3[1] b2[4] g0[5:0] g2[5] b2[5] b3[2] g2[4] b0[5:0] g3[5] b3[3] b3[5] b3[4]
    // r1[5:0] g2[3:0] g1[5:0] g3[3:0] b1[5:0] b2[3:0] r2[5:0] r3[5:0]
    {30, 5, 2, 0, 6, {6, 6, 6}, {{0, 0, 6},  {7, 4, 1},  {11, 0, 1}, {11, 1, 1}, {10, 4, 1}, {4, 0, 6},
                                 {6, 5, 1},  {10, 5, 1}, {11, 2, 1}, {6, 4, 1},  {8, 0, 6},  {7, 5, 1},
                                 {11, 3, 1}, {11, 5, 1}, {11, 4, 1}, {1, 0, 6},  {6, 0, 4},  {5, 0, 6},
                                 {7, 0, 4},  {9, 0, 6},  {10, 0, 4}, {2, 0, 6},  {3, 0, 6}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[9:0] g1[9:0] b1[9:0]
    {3, 5, 1, 0, 10, {10, 10, 10}, {{0, 0, 10}, {4, 0, 10}, {8, 0, 10}, {1, 0, 10}, {5, 0, 10}, {9, 0, 10}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[8:0] r0[10] g1[8:0] g0[10] b1[8:0] b0[10]
    {7,
     5,
     1,
     1,
     11,
     {9, 9, 9},
     {{0, 0, 10},
      {4, 0, 10},
      {8, 0, 10},
      {1, 0, 9},
      {0, 10, 1},
      {5, 0, 9},
      {4, 10, 1},
      {9, 0, 9},
      {8, 10, 1}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[7:0] r0[10:11] g1[7:0] g0[10:11] b1[7:0] b0[10:11]
    {11,
     5,
     1,
     1,
     12,
     {8, 8, 8},
     {{0, 0, 10},
      {4, 0, 10},
      {8, 0, 10},
      {1, 0, 8},
      {0, 10, -2},
      {5, 0, 8},
      {4, 10, -2},
      {9, 0, 8},
      {8, 10, -2}}},
    // r0[9:0] g0[9:0] b0[9:0] r1[3:0] r0[10:15] g1[3:0] g0[10:15] b1[3:0] b0[10:15]
    {15,
     5,
     1,
     1,
     16,
     {4, 4, 4},
     {{0, 0, 10},
      {4, 0, 10},
      {8, 0, 10},
      {1, 0, 4},
      {0, 10, -6},
      {5, 0, 4},
      {4, 10, -6},
      {9, 0, 4},
      {8, 10, -6}}},
};

constexpr int SignExtend(int value, int bits) noexcept {
    const int sign = 1 << (bits - 1);
    return ((value & ((1 << bits) - 1)) ^ sign) - sign;
}

constexpr int UnquantizeBc6(int value, int bits, bool isSigned) noexcept {
    if (!isSigned) {
        if (bits >= 15 || value == 0)
            return value;
        return value == (1 << bits) - 1 ? 0xFFFF : ((value << 15) + 0x4000) >> (bits - 1);
    }
    if (bits >= 16 || value == 0)
        return value;
    const int magnitude = value < 0 ? -value : value;
    const int wide = magnitude >= (1 << (bits - 1)) - 1 ? 0x7FFF : ((magnitude << 15) + 0x4000) >> (bits - 1);
    return value < 0 ? -wide : wide;
}

/// endpoints[2 region + end][channel], as numbers of 16 bits. Deltas are relative to endpoint 0 and wrap.
inline void ReadBc6Endpoints(BlockBits& bits, const Bc6Mode& mode, bool isSigned,
                             int (&endpoints)[4][3]) noexcept {
    int numbers[12] = {};
    for (const Bc6Field& field : mode.fields) {
        const int count = field.count < 0 ? -field.count : field.count;
        for (int i = 0; i < count; ++i) {
            const int bit = field.count < 0 ? count - 1 - i : i;
            numbers[field.component] |= bits.Take(1) << (field.lowBit + bit);
        }
    }
    for (int c = 0; c < 3; ++c) {
        const int first = isSigned ? SignExtend(numbers[4 * c], mode.endpointBits) : numbers[4 * c];
        for (int e = 0; e < 2 * mode.regions; ++e) {
            int value = numbers[4 * c + e];
            if (e > 0 && mode.isTransformed != 0)
                value = (first + SignExtend(value, mode.deltaBits[c])) & ((1 << mode.endpointBits) - 1);
            if (isSigned)
                value = SignExtend(value, mode.endpointBits);
            endpoints[e][c] = UnquantizeBc6(value, mode.endpointBits, isSigned);
        }
    }
}

/// 16 texels of RGB, bits of halves. Reserved codes are black.
inline void DecodeBc6Block(const std::byte* block, bool isSigned, std::uint16_t (&texels)[48]) noexcept {
    const int code = static_cast<int>(block[0]) & 31;
    const Bc6Mode* mode = nullptr;
    for (const Bc6Mode& candidate : kBc6Modes) {
        if ((code & ((1 << candidate.codeBits) - 1)) == candidate.code)
            mode = &candidate;
    }
    if (mode == nullptr) {
        for (std::uint16_t& texel : texels)
            texel = 0;
        return;
    }
    BlockBits bits(block);
    bits.Take(mode->codeBits);
    int endpoints[4][3];
    ReadBc6Endpoints(bits, *mode, isSigned, endpoints);
    const int partition = mode->regions == 2 ? bits.Take(5) : 0;
    const int indexBits = mode->regions == 2 ? 3 : 4;
    for (int t = 0; t < 16; ++t) {
        const int index = bits.Take(indexBits - (IsAnchor(mode->regions, partition, t) ? 1 : 0));
        const int region = GetSubset(mode->regions, partition, t);
        for (int c = 0; c < 3; ++c) {
            const int value =
                Interpolate(endpoints[2 * region][c], endpoints[2 * region + 1][c], indexBits, index);
            const int half = isSigned ? ((value < 0 ? -value : value) * 31 >> 5) | (value < 0 ? 0x8000 : 0)
                                      : value * 31 >> 6;
            texels[3 * t + c] = static_cast<std::uint16_t>(half);
        }
    }
}

} // namespace openntc::bc::detail

#include "openntc/core/RestoreMacros.h"
