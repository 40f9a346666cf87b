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

/// One grid: planes [feature][y][x].
struct LatentPlanes {
    GridSize size;
    int features = 0;
    LatentQuantiser quantiser;
    AlignedBuffer<float> values, gradients, first, second;

    std::size_t PlaneSize() const {
        return static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
    }
    void Create(GridSize gridSize, int featureCount, int bits) {
        size = gridSize;
        features = featureCount;
        quantiser = MakeLatentQuantiser(bits);
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
        for (int f = 0; f < features; ++f) {
            for (int y = 0; y < grid.rows; ++y) {
                const float* from = Row(values, f, grid.originY + y, grid.originX);
                float* to = grid.values + (f * grid.rows + y) * grid.pitch;
                if (mode == LatentMode::Round)
                    Kernel::RoundRow(from, to, grid.width, quantiser);
                else
                    Kernel::NoiseRow(from, to, grid.width, quantiser,
                                     seed + static_cast<std::uint32_t>((f * grid.rows + y) * grid.pitch));
            }
        }
    }
    /// Adds a tile's gradients in rows [begin, end).
    void AddGradients(const LocalGrid& grid, int begin, int end) {
        const int top = std::max(begin, grid.originY), bottom = std::min(end, grid.originY + grid.rows);
        for (int f = 0; f < features; ++f) {
            for (int y = top; y < bottom; ++y) {
                const float* from = grid.gradients + (f * grid.rows + y - grid.originY) * grid.pitch;
                float* to = Row(gradients, f, y, grid.originX);
                for (int x = 0; x < grid.width; ++x)
                    to[x] += from[x];
            }
        }
    }
    /// Steps the latents of a tile's rectangle, rows [begin, end). Latents without gradient keep their
    /// moments; a latent that several tiles of a batch share is stepped once, since stepping clears its
    /// gradient.
    template <typename Kernel>
    void Update(const LocalGrid& grid, int begin, int end, const AdamStep& step) {
        const int top = std::max(begin, grid.originY), bottom = std::min(end, grid.originY + grid.rows);
        for (int f = 0; f < features; ++f) {
            for (int y = top; y < bottom; ++y) {
                float* gradient = Row(gradients, f, y, grid.originX);
                Kernel::AdamRow(Row(values, f, y, grid.originX), Row(first, f, y, grid.originX),
                                Row(second, f, y, grid.originX), gradient, grid.width, step,
                                quantiser.minimum, quantiser.maximum);
                std::fill(gradient, gradient + grid.width, 0.0f);
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
