// SPDX-License-Identifier: MIT
// Stability: internal
// The latents in training: values, gradients and moments of every grid, and the copies that tiles work on.
#pragma once

#include "openntc/encode/detail/NetworkState.h"
#include "openntc/encode/detail/Random.h"

#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// How stored real latents become network inputs in one step.
enum class LatentMode { Noise, Round };

/// A coordinate on an axis of `count` latents that wraps around.
inline int WrapLatent(int at, int count) {
    const int rest = at % count;
    return rest < 0 ? rest + count : rest;
}

/// One grid: planes [feature][y][x].
struct LatentPlanes {
    GridSize size;
    bool wraps = false; ///< copies reach beyond its edges, to the other side
    int features = 0;
    LatentQuantiser quantiser;
    AlignedBuffer<float> values, gradients, first, second;

    std::size_t PlaneSize() const {
        return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    }
    void Create(GridSize gridSize, int featureCount, const LatentQuantiser& latentQuantiser) {
        size = gridSize;
        features = featureCount;
        quantiser = latentQuantiser;
        wraps = quantiser.blended;
        const std::size_t count = PlaneSize() * static_cast<std::size_t>(featureCount);
        values.Resize(count);
        gradients.Resize(count);
        first.Resize(count);
        second.Resize(count);
    }
    float* Row(AlignedBuffer<float>& buffer, int feature, int y, int x) const {
        return buffer.data() + static_cast<std::size_t>(feature) * PlaneSize() +
               static_cast<std::size_t>(y) * static_cast<std::size_t>(size.width) + x;
    }

    /// Fills `grid`.values with the integer-scaled inputs of its rectangle. Kernel: supplies the row loops.
    template <typename Kernel>
    void CopyOut(LocalGrid& grid, LatentMode mode, std::uint32_t seed) {
        const bool inside = IsInside(grid);
        for (int f = 0; f < features; ++f) {
            for (int y = 0; y < grid.rows; ++y) {
                float* to = grid.values + (f * grid.rows + y) * grid.pitch;
                const auto rowSeed = seed + static_cast<std::uint32_t>((f * grid.rows + y) * grid.pitch);
                if (inside)
                    CopyRow<Kernel>(Row(values, f, grid.originY + y, grid.originX), to, grid.width, mode,
                                    rowSeed);
                else
                    CopyWrapped<Kernel>(grid, f, y, to, mode, rowSeed);
            }
        }
    }
    /// Adds a tile's gradients in rows [begin, end).
    void AddGradients(const LocalGrid& grid, int begin, int end) {
        VisitRuns(grid, begin, end, [&](int f, int row, int column, int y, int x, int count) {
            const float* from = grid.gradients + (f * grid.rows + row) * grid.pitch + column;
            float* to = Row(gradients, f, y, x);
            for (int i = 0; i < count; ++i)
                to[i] += from[i];
        });
    }
    /// Steps the latents of a tile's rectangle, rows [begin, end). Latents without gradient keep their
    /// moments; a latent that several tiles of a batch share is stepped once, since stepping clears its
    /// gradient.
    template <typename Kernel>
    void Update(const LocalGrid& grid, int begin, int end, const AdamStep& step) {
        VisitRuns(grid, begin, end, [&](int f, int, int, int y, int x, int count) {
            float* gradient = Row(gradients, f, y, x);
            Kernel::AdamRow(Row(values, f, y, x), Row(first, f, y, x), Row(second, f, y, x), gradient, count,
                            step, quantiser.minimum, quantiser.maximum);
            std::fill(gradient, gradient + count, 0.0f);
        });
    }

private:
    bool IsInside(const LocalGrid& grid) const {
        return !wraps || (grid.originX >= 0 && grid.originY >= 0 && grid.originX + grid.width <= size.width &&
                          grid.originY + grid.rows <= size.height);
    }
    template <typename Kernel>
    void CopyRow(const float* from, float* to, int count, LatentMode mode, std::uint32_t seed) const {
        if (mode == LatentMode::Round)
            Kernel::RoundRow(from, to, count, quantiser);
        else
            Kernel::NoiseRow(from, to, count, quantiser, seed);
    }
    /// Row `y` of a copy that lies partly beyond the grid's edges.
    template <typename Kernel>
    void CopyWrapped(const LocalGrid& grid, int feature, int y, float* to, LatentMode mode,
                     std::uint32_t seed) {
        const float* from = Row(values, feature, WrapLatent(grid.originY + y, size.height), 0);
        constexpr int kChunk = 64;
        alignas(64) float chunk[kChunk];
        for (int x = 0; x < grid.width; x += kChunk) {
            const int count = std::min(kChunk, grid.width - x);
            for (int i = 0; i < count; ++i)
                chunk[i] = from[WrapLatent(grid.originX + x + i, size.width)];
            CopyRow<Kernel>(chunk, to + x, count, mode, seed + static_cast<std::uint32_t>(x));
        }
    }
    /// Calls visit(feature, row, column, y, x, count) for every run of latents of a copy in the grid's rows
    /// [begin, end): where it begins in the copy, where in the grid, and its length.
    template <typename Visit>
    void VisitRuns(const LocalGrid& grid, int begin, int end, const Visit& visit) const {
        if (!wraps) {
            const int top = std::max(begin, grid.originY), bottom = std::min(end, grid.originY + grid.rows);
            for (int f = 0; f < features; ++f) {
                for (int y = top; y < bottom; ++y)
                    visit(f, y - grid.originY, 0, y, grid.originX, grid.width);
            }
            return;
        }
        for (int f = 0; f < features; ++f) {
            for (int row = 0; row < grid.rows; ++row) {
                const int y = WrapLatent(grid.originY + row, size.height);
                if (y < begin || y >= end)
                    continue;
                for (int column = 0, count = 0; column < grid.width; column += count) {
                    const int x = WrapLatent(grid.originX + column, size.width);
                    count = std::min(grid.width - column, size.width - x);
                    visit(f, row, column, y, x, count);
                }
            }
        }
    }
};

/// Rectangle of the latents of `grid` that texels [x, x + w) x [y, y + h) read.
inline void PlaceLocalGrid(LocalGrid& local, const AxisTaps& tapsX, const AxisTaps& tapsY, int x, int y,
                           int w, int h) {
    const auto x0 = static_cast<std::size_t>(x), x1 = static_cast<std::size_t>(x + w - 1);
    const auto y0 = static_cast<std::size_t>(y), y1 = static_cast<std::size_t>(y + h - 1);
    local.originX = tapsX.first[x0];
    local.originY = tapsY.first[y0];
    local.width = tapsX.second[x1] - local.originX + 1;
    local.rows = tapsY.second[y1] - local.originY + 1;
    local.pitch = (local.width + 15) / 16 * 16;
}

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
