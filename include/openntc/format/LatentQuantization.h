// SPDX-License-Identifier: MIT
// Stability: stable
// How codes of latents become network inputs. Source: format specification, "quantisation parameters".
#pragma once

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// One depth of quantisation. A code stands for the level code + lowestLevel, of `levels` levels to a real
/// value of 1.
struct LatentQuantization {
    int quantBits;   ///< 1, 2, 4 or 8
    int codes;       ///< codes in use: 2^quantBits, but 254 of 8 bits
    int lowestLevel; ///< level of code 0
    float levels;    ///< levels per 1.0: 1.5, 2.5, 8.5, 127.5
    std::int32_t
        int8Scale; ///< code · int8Scale + int8Bias is the input of Int8 networks, in units of 1/127.5
    std::int32_t int8Bias;
    float step; ///< code · step + bias is the input of FP8 networks, both rounded to binary32
    float bias;

    constexpr int GetHighestLevel() const noexcept { return lowestLevel + codes - 1; }
};

constexpr bool IsQuantBits(int bits) noexcept {
    return bits == 1 || bits == 2 || bits == 4 || bits == 8;
}

/// Of a depth that satisfies IsQuantBits.
constexpr LatentQuantization GetLatentQuantization(int quantBits) noexcept {
    LatentQuantization q{};
    q.quantBits = quantBits;
    q.codes = quantBits == 8 ? 254 : 1 << quantBits;
    q.lowestLevel = quantBits == 8 ? -126 : 1 - (1 << (quantBits - 1));
    q.levels = 1.5f - static_cast<float>(q.lowestLevel);
    q.int8Scale = static_cast<std::int32_t>(127.5f / q.levels);
    q.int8Bias = q.int8Scale * q.lowestLevel;
    q.step = 1.0f / q.levels;
    q.bias = static_cast<float>(q.lowestLevel) * q.step;
    return q;
}

static_assert(GetLatentQuantization(1).int8Scale == 85 && GetLatentQuantization(1).int8Bias == 0);
static_assert(GetLatentQuantization(2).int8Scale == 51 && GetLatentQuantization(2).int8Bias == -51);
static_assert(GetLatentQuantization(4).int8Scale == 15 && GetLatentQuantization(4).int8Bias == -105);
static_assert(GetLatentQuantization(8).int8Scale == 1 && GetLatentQuantization(8).int8Bias == -126);

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
