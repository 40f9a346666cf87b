// SPDX-License-Identifier: MIT
// Stability: internal
// Work that is shared by the texels of a tile: sampling positions and positional waves per column and per
// row, and the latents of the rows in use, unpacked once. Formulas: sections "Geometry of one sample",
// "Positional coordinates" and "Inputs" of the format specification.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/decode/fast/Platform.h"
#include "openntc/format/Limits.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::fast {

inline constexpr int kTileWidth = 256; ///< texel columns of a tile at most
inline constexpr int kTileHeight = 32; ///< texel rows of a tile at most
inline constexpr int kMaxLanes = 16;   ///< texels in the widest vector
/// Entries of a per-column array: kernels read whole vectors that start anywhere inside the tile.
inline constexpr int kColumnStride = kTileWidth + kMaxLanes;

/// One latent grid as the sampling of one colour mip needs it.
struct GridView {
    const std::byte* data = nullptr; ///< first latent of the slice
    int imageWidth = 0;
    int imageHeight = 0;
    int sliceLeft = 0;
    int sliceTop = 0;
    int sliceWidth = 0;
    int sliceHeight = 0;
    int features = 0;
    int bits = 0;
    int codeScale = 0; ///< code · codeScale + codeBias is the network input
    int codeBias = 0;
    bool isPerCorner = false; ///< the high-resolution grid of generation 1: an input for every corner
    bool isLatentMip = false; ///< of generations 2 and 3: layers of 16-bit texels, and borders wrap
};

/// One colour mip.
struct MipView {
    int width = 0;
    int height = 0;
    float positionScale = 0;
    std::uint32_t lodWord = 0; ///< the last input word: lod, lod, 0, 0
    GridView highRes;          ///< of generations 2 and 3 the finer latent mip
    GridView lowRes;
    bool truncates = false; ///< latents are truncated to bytes (generation 2), not floored
};

/// Largest integer not above `value`, as a binary32; any magnitude.
inline float FloorExact(float value) noexcept {
    if (!(value > -8388608.0f && value < 8388608.0f))
        return value; // already an integer (or not a number)
    const float truncated = static_cast<float>(static_cast<std::int32_t>(value));
    return truncated > value ? truncated - 1.0f : truncated;
}

/// Where a texel lands on one axis of a grid: between cell and cell + 1, `fraction` of the way.
struct AxisPosition {
    int cell = 0; ///< clamped to -1 … sliceSize - 1, outside of which both taps are the same border latent;
                  ///< of a latent mip -1 … size - 1
    float fraction = 0;
};

/// The two taps of a cell, relative to the slice.
struct AxisTaps {
    int first = 0;
    int second = 0;
};

inline AxisTaps GetTaps(const GridView& grid, int cell, int size, int sliceStart, int sliceSize) noexcept {
    if (!grid.isLatentMip)
        return {cell > 0 ? cell : 0, cell + 1 < sliceSize ? cell + 1 : sliceSize - 1};
    const auto place = [&](int index) {
        const int relative = index < sliceStart ? index - sliceStart + size : index - sliceStart;
        return relative < sliceSize ? relative : sliceSize - 1; // what a slice lacks is its last
    };
    return {place(cell < 0 ? size - 1 : cell), place(cell + 1 < size ? cell + 1 : 0)};
}
inline AxisTaps GetColumnTaps(const GridView& grid, int cell) noexcept {
    return GetTaps(grid, cell, grid.imageWidth, grid.sliceLeft, grid.sliceWidth);
}
inline AxisTaps GetRowTaps(const GridView& grid, int cell) noexcept {
    return GetTaps(grid, cell, grid.imageHeight, grid.sliceTop, grid.sliceHeight);
}

inline AxisPosition LocateOnAxis(int texel, int mipSize, int gridSize, int sliceStart,
                                 int sliceSize) noexcept {
    const float u = (static_cast<float>(texel) + 0.5f) / static_cast<float>(mipSize);
    const float scaled = MultiplyRounded(u, static_cast<float>(gridSize));
    const float shifted = scaled - static_cast<float>(sliceStart);
    const float position = shifted - 0.5f;
    const float floor = FloorExact(position);
    AxisPosition result;
    result.fraction = position - floor;
    const float limit = static_cast<float>(sliceSize - 1);
    result.cell = floor < -1.0f ? -1 : floor > limit ? sliceSize - 1 : static_cast<int>(floor);
    return result;
}

/// LocateOnAxis of a latent mip: texels outside of the colour mip wrap, and slices play no part.
inline AxisPosition LocateInLatentMip(int texel, int mipSize, int gridSize) noexcept {
    texel %= mipSize;
    return LocateOnAxis(texel < 0 ? texel + mipSize : texel, mipSize, gridSize, 0, gridSize);
}

inline AxisPosition LocateColumn(const GridView& grid, int texel, int mipWidth) noexcept {
    return grid.isLatentMip ? LocateInLatentMip(texel, mipWidth, grid.imageWidth)
                            : LocateOnAxis(texel, mipWidth, grid.imageWidth, grid.sliceLeft, grid.sliceWidth);
}
inline AxisPosition LocateRow(const GridView& grid, int texel, int mipHeight) noexcept {
    return grid.isLatentMip
               ? LocateInLatentMip(texel, mipHeight, grid.imageHeight)
               : LocateOnAxis(texel, mipHeight, grid.imageHeight, grid.sliceTop, grid.sliceHeight);
}

/// trunc(clamp(value · 127.5, -128, 127)) as the low byte; 0 for NaN.
inline std::uint32_t QuantizeWave(float value) noexcept {
    const float scaled = MultiplyRounded(value, 127.5f);
    const float clamped = scaled < -128.0f ? -128.0f : scaled > 127.0f ? 127.0f : scaled;
    return clamped == clamped ? static_cast<std::uint32_t>(static_cast<std::int32_t>(clamped)) & 0xFFu : 0u;
}

/// Triangle wave of period 1, from 1 at 0 to -1 at one half. Numbers without a fraction are at 0; infinities
/// and NaN are treated as such, as in the shader.
inline float TriangleWave(float t) noexcept {
    const float fraction = t > -8388608.0f && t < 8388608.0f ? t - FloorExact(t) : 0.0f;
    const float r = MultiplyRounded(fraction, 4.0f) - 2.0f;
    return (r < 0.0f ? -r : r) - 1.0f;
}

/// Sawtooth wave of period 1, from -1 at 0; numbers without a fraction as above.
inline float SawtoothWave(float t) noexcept {
    const float fraction = t > -8388608.0f && t < 8388608.0f ? t - FloorExact(t) : 0.0f;
    return MultiplyRounded(fraction, 2.0f) - 1.0f;
}

/// The frequency of the first of three waves; the others have twice and four times as much.
inline constexpr float kTriangleFrequency = 0.125f;
inline constexpr float kSawtoothFrequency = 1.0f;

/// The two bytes that one coordinate of a texel adds to the word of one wave: byte 0 and byte 2.
inline std::uint32_t MakeWaveBytes(const MipView& mip, int texel, int wave) noexcept {
    const float position = MultiplyRounded(static_cast<float>(texel), mip.positionScale);
    const auto factor = static_cast<float>(1 << wave);
    if (mip.highRes.isLatentMip) {
        const float t = MultiplyRounded(position, kSawtoothFrequency * factor);
        return QuantizeWave(SawtoothWave(t)) | QuantizeWave(SawtoothWave(t + 0.25f)) << 16;
    }
    const float t = MultiplyRounded(position, kTriangleFrequency * factor);
    return QuantizeWave(TriangleWave(t)) | QuantizeWave(TriangleWave(t + 0.25f)) << 16;
}

/// Texel columns of a tile on one grid. Neighbouring columns that share a cell share an entry of the latent
/// rows.
struct GridColumns {
    alignas(64) float fraction[kColumnStride];
    alignas(64) std::int32_t entry[kColumnStride]; ///< rises by at most 1 from column to column
    std::int32_t cell[kTileWidth];                 ///< of every entry
    int entryCount = 0;
};

struct TileColumns {
    GridColumns highRes;
    GridColumns lowRes;
    alignas(64) std::uint32_t waves[3][kColumnStride]; ///< bytes 0 and 2 of the three positional words
};

inline void PlanGridColumns(GridColumns& columns, const GridView& grid, int mipWidth, int left,
                            int width) noexcept {
    columns.entryCount = 0;
    for (int i = 0; i < width; ++i) {
        const AxisPosition p = LocateColumn(grid, left + i, mipWidth);
        columns.fraction[i] = p.fraction;
        if (columns.entryCount == 0 || columns.cell[columns.entryCount - 1] != p.cell)
            columns.cell[columns.entryCount++] = p.cell;
        columns.entry[i] = columns.entryCount - 1;
    }
    for (int i = width; i < width + kMaxLanes; ++i) {
        columns.fraction[i] = 0.0f;
        columns.entry[i] = columns.entryCount - 1;
    }
}

inline void PlanTileColumns(TileColumns& columns, const MipView& mip, int left, int width) noexcept {
    PlanGridColumns(columns.highRes, mip.highRes, mip.width, left, width);
    PlanGridColumns(columns.lowRes, mip.lowRes, mip.width, left, width);
    for (int i = 0; i < width; ++i) {
        for (int wave = 0; wave < 3; ++wave)
            columns.waves[wave][i] = MakeWaveBytes(mip, left + i, wave);
    }
    for (int wave = 0; wave < 3; ++wave)
        std::memset(columns.waves[wave] + width, 0, sizeof(std::uint32_t) * kMaxLanes);
}

/// One texel row of a tile.
struct TileRow {
    AxisPosition highRes;
    AxisPosition lowRes;
    std::uint32_t waves[3]; ///< bytes 1 and 3 of the three positional words
};

inline TileRow PlanTileRow(const MipView& mip, int y) noexcept {
    TileRow row;
    row.highRes = LocateRow(mip.highRes, y, mip.height);
    row.lowRes = LocateRow(mip.lowRes, y, mip.height);
    for (int wave = 0; wave < 3; ++wave)
        row.waves[wave] = MakeWaveBytes(mip, y, wave) << 8;
    return row;
}

/// The lod input word of a colour mip; generations 2 and 3 do not clamp it.
inline std::uint32_t MakeLodWord(float positionLod, bool isClamped) noexcept {
    if (isClamped)
        return QuantizeWave(positionLod) * 0x0101u;
    const float scaled = MultiplyRounded(positionLod, 127.5f);
    if (!(scaled > -2147483648.0f && scaled < 2147483648.0f))
        return 0;
    return (static_cast<std::uint32_t>(static_cast<std::int32_t>(scaled)) & 0xFFu) * 0x0101u;
}

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
