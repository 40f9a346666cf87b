// SPDX-License-Identifier: MIT
// Stability: internal
// Which latents a colour texel reads, with which weights: the decoder's arithmetic, tabulated per axis for
// the trainer.
#pragma once

#include "openntc/core/E4M3.h"
#include "openntc/core/Half.h"
#include "openntc/texture_set/MipChain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

inline constexpr int kTileWidth = 16; ///< colour texels; one SIMD row of the trainer
inline constexpr int kTileHeight = 8;
inline constexpr int kTileTexels = kTileWidth * kTileHeight;

/// Bilinear taps of every texel along one axis of one grid.
struct AxisTaps {
    std::vector<std::int32_t> first;  ///< index of the first tap: clamped, or -1 where it wraps around
    std::vector<std::int32_t> second; ///< of the second tap: clamped, or the number of latents where it wraps
    std::vector<float> fraction;      ///< weight of the second tap, before products are truncated to 1/256
    /// The same where taps wrap, as FP8 networks take it; `fraction` is then rounded to 1/256.
    std::vector<float> exactFraction;
};

/// Taps of an axis of `texels` colour texels on `latents` latent pixels, in the decoder's order of binary32
/// operations (format specification: "Geometry of one sample"). `wraps`: as generation 3 samples.
inline AxisTaps MakeAxisTaps(int texels, int latents, bool wraps = false) {
    AxisTaps taps;
    const auto count = static_cast<std::size_t>(texels);
    taps.first.resize(count);
    taps.second.resize(count);
    taps.fraction.resize(count);
    for (int i = 0; i < texels; ++i) {
        const float u = (static_cast<float>(i) + 0.5f) / static_cast<float>(texels);
        const float scaled = u * static_cast<float>(latents);
        const float position = scaled - 0.5f;
        const float base = std::floor(position);
        const auto index = static_cast<std::size_t>(i);
        if (wraps) {
            taps.first[index] = static_cast<int>(base);
            taps.second[index] = static_cast<int>(base) + 1;
            taps.exactFraction.push_back(position - base);
            taps.fraction[index] = std::floor(taps.exactFraction.back() * 256.0f + 0.5f) * (1.0f / 256.0f);
            continue;
        }
        taps.first[index] = std::clamp(static_cast<int>(base), 0, latents - 1);
        taps.second[index] = std::clamp(static_cast<int>(base) + 1, 0, latents - 1);
        taps.fraction[index] = position - base;
    }
    return taps;
}

/// One latent grid of one neural mip.
struct GridSize {
    int width = 0, height = 0;
};

/// Positional inputs of generation 3 along one axis, which do not repeat: [wave][phase 0 or 1/4][coordinate],
/// with `count` coordinates, whole sixteens.
struct AxisWaves {
    int count = 0;
    std::vector<float> integers;  ///< -127 ... 127
    std::vector<float> eightBits; ///< -1 ... 1 in E4M3, of FP8 networks
};

/// One colour mip as the trainer sees it.
struct MipGeometry {
    int width = 0, height = 0;
    int neuralMip = 0; ///< generation 3: pair of latent mips
    float positionLod = 0.0f, positionScale = 1.0f;
    AxisTaps highX, highY, lowX, lowY;
    AxisWaves wavesX, wavesY; ///< of generation 3
    /// Positional inputs as integers -127 ... 127: [wave][phase 0 or 1/4][coordinate mod 16].
    float waves[3][2][16] = {};
    float lodInput = 0.0f;              ///< integer input of both lod slots
    float eightBitWaves[3][2][16] = {}; ///< the same waves as the FP8 network takes them, -1 ... 1
    float eightBitLod = 0.0f;

    /// Integer inputs from a coordinate on, of as many as sixteen from a multiple of 16.
    const float* GetWaves(const AxisWaves& axis, int wave, int phase, int texel) const {
        return axis.count == 0 ? waves[wave][phase] + (texel & 15)
                               : axis.integers.data() + (wave * 2 + phase) * axis.count + texel;
    }
    const float* GetEightBitWaves(const AxisWaves& axis, int wave, int phase, int texel) const {
        return axis.count == 0 ? eightBitWaves[wave][phase] + (texel & 15)
                               : axis.eightBits.data() + (wave * 2 + phase) * axis.count + texel;
    }
};

/// The decoder's positional wave.
inline float GetWave(float t) {
    const float r = (t - std::floor(t)) * 4.0f;
    return std::fabs(r - 2.0f) - 1.0f;
}

/// The same, truncated to the integer input of Int8 networks.
inline float WaveInput(float t) {
    return std::trunc(std::clamp(GetWave(t) * 127.5f, -128.0f, 127.0f));
}

/// An input of FP8 networks.
inline float RoundToInput(float value) {
    return RoundToE4M3(RoundToHalf(value));
}

inline MipGeometry MakeMipGeometry(int setWidth, int setHeight, int mip, int neuralMip, GridSize high,
                                   GridSize low) {
    MipGeometry geometry;
    geometry.width = GetMipDimension(setWidth, mip);
    geometry.height = GetMipDimension(setHeight, mip);
    geometry.neuralMip = neuralMip;
    geometry.positionLod = GetPositionLod(mip, neuralMip);
    geometry.positionScale = GetPositionScale(mip, neuralMip);
    geometry.highX = MakeAxisTaps(geometry.width, high.width);
    geometry.highY = MakeAxisTaps(geometry.height, high.height);
    geometry.lowX = MakeAxisTaps(geometry.width, low.width);
    geometry.lowY = MakeAxisTaps(geometry.height, low.height);
    for (int wave = 0; wave < 3; ++wave) {
        const float frequency = std::ldexp(1.0f, wave - 3);
        for (int i = 0; i < 16; ++i) {
            // All periods divide 8 texels (positionScale is at least 1), so sixteen values repeat exactly.
            const float t = static_cast<float>(i) * geometry.positionScale * frequency;
            geometry.waves[wave][0][i] = WaveInput(t);
            geometry.waves[wave][1][i] = WaveInput(t + 0.25f);
            geometry.eightBitWaves[wave][0][i] = RoundToInput(GetWave(t));
            geometry.eightBitWaves[wave][1][i] = RoundToInput(GetWave(t + 0.25f));
        }
    }
    geometry.lodInput = std::trunc(std::clamp(geometry.positionLod * 127.5f, -128.0f, 127.0f));
    geometry.eightBitLod = RoundToInput(geometry.positionLod);
    return geometry;
}

inline AxisWaves MakeAxisWaves(int texels, float positionScale) {
    AxisWaves axis;
    axis.count = (texels + 15) / 16 * 16;
    for (int wave = 0; wave < 3; ++wave) {
        for (const float phase : {0.0f, 0.25f}) {
            for (int i = 0; i < axis.count; ++i) {
                const float scaled = static_cast<float>(i) * positionScale;
                const float t = std::ldexp(scaled, wave) + phase;
                const float value = 2.0f * (t - std::floor(t)) - 1.0f;
                axis.eightBits.push_back(RoundToInput(value));
                axis.integers.push_back(std::trunc(value * 127.5f));
            }
        }
    }
    return axis;
}

/// A colour mip of generation 3, which reads latent mips 2 `pair` and 2 `pair` + 1 of sizes `even` and `odd`.
inline MipGeometry MakeBlendedMipGeometry(int width, int height, int pair, GridSize even, GridSize odd) {
    MipGeometry geometry;
    geometry.width = width;
    geometry.height = height;
    geometry.neuralMip = pair;
    geometry.positionScale = GetLatentPositionScale(width, height, even.width, even.height);
    geometry.positionLod = GetLatentPositionLod(geometry.positionScale);
    geometry.highX = MakeAxisTaps(width, even.width, true);
    geometry.highY = MakeAxisTaps(height, even.height, true);
    geometry.lowX = MakeAxisTaps(width, odd.width, true);
    geometry.lowY = MakeAxisTaps(height, odd.height, true);
    geometry.wavesX = MakeAxisWaves(width, geometry.positionScale);
    geometry.wavesY = MakeAxisWaves(height, geometry.positionScale);
    geometry.lodInput = std::trunc(geometry.positionLod * 127.5f);
    geometry.eightBitLod = RoundToInput(geometry.positionLod);
    return geometry;
}

/// Constants of one latent quantisation depth (format specification: "Quantisation parameters").
struct LatentQuantiser {
    int bits = 0;
    float scale = 0.0f;      ///< real latent value times this = level
    int lowestLevel = 0;     ///< signed level of code 0
    int highestLevel = 0;    ///< signed level of the highest code
    float levelInput = 0.0f; ///< integer network input per level: 85, 51, 15, 1; generation 3: 17
    float minimum = 0.0f;    ///< of the representable real values
    float maximum = 0.0f;
    float start = 0.0f;   ///< about which values begin
    bool blended = false; ///< generation 3: codes, before kBlendedOffset is taken from the input
};

inline LatentQuantiser MakeLatentQuantiser(int bits) {
    const LatentQuantization format = GetLatentQuantization(bits);
    LatentQuantiser q;
    q.bits = bits;
    q.scale = format.levels;
    q.lowestLevel = format.lowestLevel;
    q.highestLevel = format.GetHighestLevel();
    q.levelInput = static_cast<float>(format.int8Scale);
    q.minimum = static_cast<float>(q.lowestLevel) / q.scale;
    q.maximum = static_cast<float>(q.highestLevel) / q.scale;
    return q;
}

/// Codes of generation 1 as FP8 networks decode them, each operation rounded to binary16: code x step + bias.
struct HalfLevels {
    float step, bias;
    explicit HalfLevels(const LatentQuantiser& q)
        : step(RoundToHalf(1.0f / q.scale)),
          bias(RoundToHalf(static_cast<float>(q.lowestLevel) * (1.0f / q.scale))) {}
};

/// Codes 0 ... 15 of values 0 ... 1.
inline LatentQuantiser MakeBlendedQuantiser() {
    LatentQuantiser q;
    q.bits = kLayeredLatentBits;
    q.highestLevel = (1 << q.bits) - 1;
    q.scale = static_cast<float>(q.highestLevel);
    q.levelInput = 255.0f / q.scale;
    q.maximum = 1.0f;
    q.start = 0.5f;
    q.blended = true;
    return q;
}

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
