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
};

/// One colour mip.
struct MipView {
    int width = 0;
    int height = 0;
    float positionScale = 0;
    std::uint32_t lodWord = 0; ///< the last input word: lod, lod, 0, 0
    GridView highRes;
    GridView lowRes;
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
    int cell = 0; ///< clamped to -1 … sliceSize - 1, outside of which both taps are the same border latent
    float fraction = 0;
};

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

/// The two bytes that one coordinate adds to the word of one wave: byte 0 and byte 2.
inline std::uint32_t MakeWaveBytes(float position, float frequency) noexcept {
    const float t = MultiplyRounded(position, frequency);
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

inline constexpr float kWaveFrequencies[3] = {0.125f, 0.25f, 0.5f};

inline void PlanGridColumns(GridColumns& columns, const GridView& grid, int mipWidth, int left,
                            int width) noexcept {
    columns.entryCount = 0;
    for (int i = 0; i < width; ++i) {
        const AxisPosition p =
            LocateOnAxis(left + i, mipWidth, grid.imageWidth, grid.sliceLeft, grid.sliceWidth);
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
        const float position = MultiplyRounded(static_cast<float>(left + i), mip.positionScale);
        for (int wave = 0; wave < 3; ++wave)
            columns.waves[wave][i] = MakeWaveBytes(position, kWaveFrequencies[wave]);
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
    const GridView& high = mip.highRes;
    const GridView& low = mip.lowRes;
    row.highRes = LocateOnAxis(y, mip.height, high.imageHeight, high.sliceTop, high.sliceHeight);
    row.lowRes = LocateOnAxis(y, mip.height, low.imageHeight, low.sliceTop, low.sliceHeight);
    const float position = MultiplyRounded(static_cast<float>(y), mip.positionScale);
    for (int wave = 0; wave < 3; ++wave)
        row.waves[wave] = MakeWaveBytes(position, kWaveFrequencies[wave]) << 8;
    return row;
}

/// The lod input word of a colour mip.
inline std::uint32_t MakeLodWord(float positionLod) noexcept {
    return QuantizeWave(positionLod) * 0x0101u;
}

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
