// SPDX-License-Identifier: MIT
// Stability: internal
// BC7 to bytes, by the text of Khronos Data Format 1.3, "BC7".
#pragma once

#include "openntc/bc/detail/BptcTables.h"

#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::bc::detail {

struct Bc7Mode {
    std::uint8_t subsets, partitionBits, rotationBits, selectorBits, colorBits, alphaBits;
    std::uint8_t endpointPBits, subsetPBits, indexBits, secondIndexBits;
};

inline constexpr Bc7Mode kBc7Modes[8] = {
    {3, 4, 0, 0, 4, 0, 1, 0, 3, 0}, {2, 6, 0, 0, 6, 0, 0, 1, 3, 0}, {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
    {2, 6, 0, 0, 7, 0, 1, 0, 2, 0}, {1, 0, 2, 1, 5, 6, 0, 0, 2, 3}, {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
    {1, 0, 0, 0, 7, 7, 1, 0, 4, 0}, {2, 6, 0, 0, 5, 5, 1, 0, 2, 0},
};

/// endpoints[2 subset + end][channel], widened to 8 bits.
inline void ReadBc7Endpoints(BlockBits& bits, const Bc7Mode& mode, int (&endpoints)[6][4]) noexcept {
    const int ends = 2 * mode.subsets;
    for (int c = 0; c < 4; ++c) {
        const int width = c < 3 ? mode.colorBits : mode.alphaBits;
        for (int e = 0; e < ends; ++e)
            endpoints[e][c] = bits.Take(width);
    }
    int pBits[6] = {};
    for (int e = 0; e < ends; ++e) {
        if (mode.endpointPBits != 0)
            pBits[e] = bits.Take(1);
        else if (mode.subsetPBits != 0)
            pBits[e] = e % 2 == 0 ? bits.Take(1) : pBits[e - 1];
    }
    const bool hasPBits = mode.endpointPBits != 0 || mode.subsetPBits != 0;
    for (int e = 0; e < ends; ++e) {
        for (int c = 0; c < 4; ++c) {
            int width = c < 3 ? mode.colorBits : mode.alphaBits;
            if (width == 0) {
                endpoints[e][c] = 255;
                continue;
            }
            int value = endpoints[e][c];
            if (hasPBits) {
                value = value << 1 | pBits[e];
                ++width;
            }
            value <<= 8 - width;
            endpoints[e][c] = value | value >> width;
        }
    }
}

/// 16 texels of RGBA. The reserved code, a first byte of 0, is transparent black.
inline void DecodeBc7Block(const std::byte* block, std::uint8_t (&texels)[64]) noexcept {
    BlockBits bits(block);
    int number = 0;
    while (number < 8 && bits.Take(1) == 0)
        ++number;
    if (number == 8) {
        for (std::uint8_t& texel : texels)
            texel = 0;
        return;
    }
    const Bc7Mode& mode = kBc7Modes[number];
    const int partition = bits.Take(mode.partitionBits);
    const int rotation = bits.Take(mode.rotationBits);
    const int selector = bits.Take(mode.selectorBits);
    int endpoints[6][4];
    ReadBc7Endpoints(bits, mode, endpoints);
    int indices[2][16] = {};
    for (int t = 0; t < 16; ++t)
        indices[0][t] = bits.Take(mode.indexBits - (IsAnchor(mode.subsets, partition, t) ? 1 : 0));
    if (mode.secondIndexBits != 0) {
        for (int t = 0; t < 16; ++t)
            indices[1][t] = bits.Take(mode.secondIndexBits - (t == 0 ? 1 : 0));
    }
    const int colorPlane = mode.secondIndexBits != 0 && selector != 0 ? 1 : 0;
    const int alphaPlane = mode.secondIndexBits != 0 ? 1 - colorPlane : 0;
    const int planeBits[2] = {mode.indexBits, mode.secondIndexBits};
    for (int t = 0; t < 16; ++t) {
        const int subset = GetSubset(mode.subsets, partition, t);
        for (int c = 0; c < 4; ++c) {
            const int plane = c < 3 ? colorPlane : alphaPlane;
            texels[4 * t + c] = static_cast<std::uint8_t>(Interpolate(
                endpoints[2 * subset][c], endpoints[2 * subset + 1][c], planeBits[plane], indices[plane][t]));
        }
        if (rotation != 0)
            std::swap(texels[4 * t + 3], texels[4 * t + rotation - 1]);
    }
}

} // namespace openntc::bc::detail

#include "openntc/core/RestoreMacros.h"
