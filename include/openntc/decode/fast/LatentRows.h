// SPDX-License-Identifier: MIT
// Stability: internal
// Latent rows unpacked for the columns of a tile, in the form that the kernels multiply: 16-bit pairs in
// 32-bit lanes.
#pragma once

#include "openntc/decode/fast/TilePlan.h"

#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::fast {

/// Reads the 1 … 4 bytes that hold four consecutive features. `element` is a multiple of 4, so that the codes
/// never leave their byte (1 and 2 bits) or their 2 or 4 bytes, and nothing past the last latent is touched.
inline std::uint32_t ReadFourCodes(const std::byte* data, std::size_t element, int bits) noexcept {
    const std::byte* bytes = data + element * static_cast<std::size_t>(bits) / 8;
    const std::uint32_t first = std::to_integer<std::uint32_t>(bytes[0]);
    if (bits == 1)
        return first >> (element & 4u);
    if (bits == 2)
        return first;
    if (bits == 4)
        return first | std::to_integer<std::uint32_t>(bytes[1]) << 8;
    return first | std::to_integer<std::uint32_t>(bytes[1]) << 8 |
           std::to_integer<std::uint32_t>(bytes[2]) << 16 | std::to_integer<std::uint32_t>(bytes[3]) << 24;
}

/// Network inputs of one latent pixel, -126 … 129; of a latent mip its codes.
struct LatentPixel {
    std::int32_t x = -1;
    std::int16_t values[kMaxFeatures];
};

/// Codes of a texel of a latent mip.
inline void UnpackLayers(LatentPixel& pixel, const GridView& grid, int x, int y) noexcept {
    pixel.x = x;
    const std::size_t row = static_cast<std::size_t>(grid.sliceWidth);
    const std::byte* texel =
        grid.data + 2 * (static_cast<std::size_t>(y) * row + static_cast<std::size_t>(x));
    for (int k = 0; k < grid.features; k += 4) {
        const std::uint32_t codes =
            std::to_integer<std::uint32_t>(texel[0]) | std::to_integer<std::uint32_t>(texel[1]) << 8;
        for (int i = 0; i < 4; ++i)
            pixel.values[k + i] = static_cast<std::int16_t>(codes >> (4 * i) & 15u);
        texel += 2 * row * static_cast<std::size_t>(grid.sliceHeight);
    }
}

inline void UnpackPixel(LatentPixel& pixel, const GridView& grid, int x, int y) noexcept {
    if (grid.isLatentMip)
        return UnpackLayers(pixel, grid, x, y);
    pixel.x = x;
    const std::size_t first = (static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.sliceWidth) +
                               static_cast<std::size_t>(x)) *
                              static_cast<std::size_t>(grid.features);
    const std::uint32_t mask = (1u << grid.bits) - 1u;
    for (int k = 0; k < grid.features; k += 4) {
        const std::uint32_t codes = ReadFourCodes(grid.data, first + static_cast<std::size_t>(k), grid.bits);
        for (int i = 0; i < 4; ++i) {
            const int code = static_cast<int>(codes >> (i * grid.bits) & mask);
            pixel.values[k + i] = static_cast<std::int16_t>(code * grid.codeScale + grid.codeBias);
        }
    }
}

inline std::uint32_t PackPair(int low, int high) noexcept {
    return (static_cast<std::uint32_t>(low) & 0xFFFFu) | static_cast<std::uint32_t>(high) << 16;
}

/// Calls visit(entry, left pixel, right pixel) for every entry of the columns on grid row y.
template <typename Visit>
inline void VisitLatentPairs(const GridView& grid, const GridColumns& columns, int y, Visit visit) noexcept {
    LatentPixel first;
    LatentPixel second;
    LatentPixel* left = &first;
    LatentPixel* right = &second;
    for (int entry = 0; entry < columns.entryCount; ++entry) {
        const AxisTaps taps = GetColumnTaps(grid, columns.cell[entry]);
        if (right->x == taps.first)
            std::swap(left, right);
        if (left->x != taps.first)
            UnpackPixel(*left, grid, taps.first, y);
        if (right->x != taps.second)
            UnpackPixel(*right, grid, taps.second, y);
        visit(entry, *left, *right);
    }
}

/// One row of a grid. Of an isPerCorner grid: per side (left and right corner, 8 apart) and per pair of
/// features, value · 16 of features 4j and 4j + 2 (even pairs) or 4j + 1 and 4j + 3 (odd pairs): with
/// weights · 16 the high half of a 16-bit product is (value · weight) >> 8. Of other grids: per feature, left
/// and right corner.
struct LatentRow {
    static constexpr int kSidePairs = kMaxFeatures / 2;
    int y = -1;
    alignas(64) std::uint32_t pairs[kMaxFeatures][kColumnStride];

    void Fill(const GridView& grid, const GridColumns& columns, int row) noexcept {
        y = row;
        if (grid.isPerCorner)
            FillSides(grid, columns);
        else
            VisitLatentPairs(grid, columns, row,
                             [&](int entry, const LatentPixel& left, const LatentPixel& right) {
                                 for (int k = 0; k < grid.features; ++k)
                                     pairs[k][entry] = PackPair(left.values[k], right.values[k]);
                             });
    }

private:
    void FillSides(const GridView& grid, const GridColumns& columns) noexcept {
        VisitLatentPairs(grid, columns, y, [&](int entry, const LatentPixel& left, const LatentPixel& right) {
            for (int k = 0; k < grid.features; k += 4) {
                for (int i = 0; i < 2; ++i) {
                    const int pair = k / 2 + i;
                    pairs[pair][entry] = PackPair(left.values[k + i] * 16, left.values[k + i + 2] * 16);
                    pairs[kSidePairs + pair][entry] =
                        PackPair(right.values[k + i] * 16, right.values[k + i + 2] * 16);
                }
            }
        });
    }
};

/// The two grid rows around a texel row. Going down the tile, the lower row becomes the upper one.
struct RowPair {
    LatentRow rows[2];
    const LatentRow* top = nullptr;
    const LatentRow* bottom = nullptr;

    void Clear() noexcept { rows[0].y = rows[1].y = -1; }

    void Select(const GridView& grid, const GridColumns& columns, int cell) noexcept {
        const auto [y0, y1] = GetRowTaps(grid, cell);
        const int topIndex = rows[0].y == y0 ? 0 : rows[1].y == y0 ? 1 : rows[0].y == y1 ? 1 : 0;
        if (rows[topIndex].y != y0)
            rows[topIndex].Fill(grid, columns, y0);
        top = &rows[topIndex];
        bottom = top;
        if (y1 != y0) {
            LatentRow& other = rows[1 - topIndex];
            if (other.y != y1)
                other.Fill(grid, columns, y1);
            bottom = &other;
        }
    }
};

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
