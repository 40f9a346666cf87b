// SPDX-License-Identifier: MIT
// Stability: internal
// Codes of rounded latents chosen jointly: coordinate descent on the exact loss of the integer decoder.
//
// Rounding chooses every latent's code alone; the errors of codes that one texel reads can cancel. A move
// changes one feature of every second latent pixel along both axes by one level. Of such a class of pixels a
// texel reads at most one, so that one forward pass over the whole image tells for each pixel of the class,
// exactly, whether the move lowers the loss of the texels that read it; only then it is kept. The loss never
// rises.
#pragma once

#include "openntc/encode/detail/Trainer.h"

#include <atomic>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// One level up or down for one feature of a class of latent pixels.
struct LatentMove {
    bool low = false;       ///< low-resolution grid
    int feature = 0;        ///< of that grid
    int oddX = 0, oddY = 0; ///< the class: pixels with x mod 2 = oddX and y mod 2 = oddY
    float levels = 0.0f;    ///< -1 or 1
    int turn = 0;           ///< sweeps before this one

    /// Moves of one sweep over all features, classes and both directions.
    static int CountOfSweep(const NetworkShape& shape) {
        return 8 * (shape.highFeatures + shape.lowFeatures);
    }
    /// `index`: of all moves, sweep after sweep.
    static LatentMove Get(const NetworkShape& shape, std::uint64_t pass) {
        const auto sweep = static_cast<std::uint64_t>(CountOfSweep(shape));
        const auto index = static_cast<int>(pass % sweep);
        LatentMove move;
        move.turn = static_cast<int>(pass / sweep);
        move.low = index / 8 >= shape.highFeatures;
        move.feature = move.low ? index / 8 - shape.highFeatures : index / 8;
        move.oddX = index >> 1 & 1;
        move.oddY = index >> 2 & 1;
        move.levels = (index & 1) != 0 ? 1.0f : -1.0f;
        return move;
    }
};

/// The pixels of a class along one axis of `count` latents. Where the axis wraps around, an odd number of
/// pixels has no two classes without neighbours: one pixel stays as it is, in every sweep another.
struct AxisClass {
    int count = 0, odd = 0, turn = 0;
    bool wraps = false;

    /// Pixels that may move, of both classes.
    int GetMovable() const { return wraps && count > 1 ? count & ~1 : count; }
    /// Of the class.
    int GetCount() const { return (GetMovable() - odd + 1) / 2; }
    /// Its pixels in an order of their own.
    int GetPixel(int index) const { return wraps ? (2 * index + odd + turn) % count : 2 * index + odd; }
    /// True for a coordinate, which may lie beyond the edges of an axis that wraps.
    bool Has(int at) const {
        if (!wraps)
            return ((at ^ odd) & 1) == 0;
        const int rotated = WrapLatent(at - turn, count);
        return rotated < GetMovable() && (rotated & 1) == odd;
    }
};

/// Texels [begin, end) along one axis that read a latent pixel, for every pixel of the axis. Along clamped
/// edges both taps of a texel are the same pixel. Where latents wrap around, so do texels: `end` may lie
/// beyond their number.
struct AxisFootprints {
    std::vector<std::int32_t> begin, end;

    static AxisFootprints MakeWrapped(const AxisTaps& taps, int latents) {
        AxisFootprints footprints = Make(taps, latents);
        const auto texels = static_cast<std::int32_t>(taps.first.size());
        const auto before = static_cast<std::int32_t>(
            std::count_if(taps.first.begin(), taps.first.end(), [](int tap) { return tap < 0; }));
        const auto beyond = static_cast<std::int32_t>(
            std::count_if(taps.second.begin(), taps.second.end(), [&](int tap) { return tap >= latents; }));
        std::int32_t& firstBegin = footprints.begin.front();
        std::int32_t& firstEnd = footprints.end.front();
        std::int32_t& lastEnd = footprints.end.back();
        if (before > 0) // texels at the beginning also read the last pixel, whose own are at the end
            lastEnd = std::min(texels + before, footprints.begin.back() + texels);
        if (beyond > 0 && latents > 1) {
            firstBegin = texels - beyond;
            firstEnd = std::min(firstEnd + texels, firstBegin + texels);
        }
        return footprints;
    }
    static AxisFootprints Make(const AxisTaps& taps, int latents) {
        AxisFootprints footprints;
        const std::size_t texels = taps.first.size();
        std::size_t begin = 0, end = 0;
        for (int pixel = 0; pixel < latents; ++pixel) {
            while (begin < texels && taps.second[begin] < pixel)
                ++begin;
            while (end < texels && taps.first[end] <= pixel)
                ++end;
            footprints.begin.push_back(static_cast<std::int32_t>(begin));
            footprints.end.push_back(static_cast<std::int32_t>(std::max(begin, end)));
        }
        return footprints;
    }
};

/// Refines the latents of a trainer. Latents must be frozen. The result does not depend on the number of
/// threads.
template <typename Kernel>
class LatentRefiner {
public:
    /// `trainer` outlives the refiner.
    explicit LatentRefiner(Trainer<Kernel>& trainer) : trainer_(trainer) {
        const auto& mips = trainer.GetMips();
        for (const MipGeometry& mip : mips) {
            const auto n = static_cast<std::size_t>(mip.neuralMip);
            const GridSize high = trainer.GetHighGrids()[n].size, low = trainer.GetLowGrids()[n].size;
            Losses& losses = losses_.emplace_back();
            losses.pitch = Pad(mip.width, kTileWidth);
            const auto make =
                trainer.GetNetwork().GetShape().blended ? AxisFootprints::MakeWrapped : AxisFootprints::Make;
            losses.footprints[0] = {make(mip.highX, high.width), make(mip.highY, high.height)};
            losses.footprints[1] = {make(mip.lowX, low.width), make(mip.lowY, low.height)};
            const std::size_t texels = losses.pitch * Pad(mip.height, kTileHeight);
            losses.kept.Resize(texels);
            losses.tried.Resize(texels);
        }
    }

    /// Measures the network as it is. Needed after every training step, before moves. `maskPush`: of
    /// MaskLoss.
    void Measure(float maskPush) {
        context_ = trainer_.GetContext();
        context_.maskPush = maskPush;
        trainer_.PackNetwork();
        Infer([](TileTask&) {});
        for (Losses& losses : losses_)
            std::swap(losses.kept, losses.tried);
    }

    /// Tries a move of every pixel of its class and keeps it where it lowers the loss. Returns how many were
    /// kept.
    std::uint64_t Try(const LatentMove& move) {
        Infer([&](TileTask& task) { Apply(move, task); });
        std::atomic<std::uint64_t> kept = 0;
        auto& grids = move.low ? trainer_.GetLowGrids() : trainer_.GetHighGrids();
        for (std::size_t n = 0; n < grids.size(); ++n) {
            const AxisClass axis = GetClassY(move, grids[n]);
            const int rows = axis.GetCount();
            trainer_.GetTeam().Run((rows + kRowsPerJob - 1) / kRowsPerJob, [&](int job, int) {
                const int begin = job * kRowsPerJob, end = std::min(begin + kRowsPerJob, rows);
                std::uint64_t count = 0;
                for (int row = begin; row < end; ++row)
                    count += DecideRow(move, static_cast<int>(n), grids[n], axis.GetPixel(row));
                kept += count;
            });
        }
        return kept;
    }

    /// The loss of all texels, in units of KernelContext::gain.
    double GetLoss() const {
        double total = 0.0;
        for (std::size_t m = 0; m < losses_.size(); ++m) {
            const MipGeometry& mip = trainer_.GetMips()[m];
            for (int y = 0; y < mip.height; ++y) {
                const float* row = losses_[m].kept.data() + static_cast<std::size_t>(y) * losses_[m].pitch;
                for (int x = 0; x < mip.width; ++x)
                    total += static_cast<double>(row[x]);
            }
        }
        return total;
    }

private:
    static constexpr int kRowsPerJob = 4;

    /// Of the texels of one mip, in rows of `pitch`, padded to whole tiles.
    struct Losses {
        std::size_t pitch = 0;
        AlignedBuffer<float> kept, tried;
        struct {
            AxisFootprints x, y;
        } footprints[2]; ///< of pixels of the high- and the low-resolution grid
    };

    static std::size_t Pad(int count, int unit) {
        const int padded = (count + unit - 1) / unit * unit;
        return static_cast<std::size_t>(padded);
    }

    /// Losses of all texels to `tried`, after change(task) of each tile's copy of its latents.
    template <typename Change>
    void Infer(const Change& change) {
        const TrainingSet& set = trainer_.GetSet();
        trainer_.InferTiles(0, set.GetFirstTile(set.GetMipCount()), change,
                            [&](int, int tile, const TileTask& task, const float* outputs) {
                                Losses& losses = losses_[static_cast<std::size_t>(set.GetTile(tile).mip)];
                                const auto at = static_cast<std::size_t>(task.y) * losses.pitch +
                                                static_cast<std::size_t>(task.x);
                                Kernel::TexelLosses(context_, task, outputs, Kernel::kTexels,
                                                    losses.tried.data() + at, losses.pitch);
                            });
    }

    void Apply(const LatentMove& move, TileTask& task) const {
        const auto n = static_cast<std::size_t>(task.mip->neuralMip);
        LocalGrid& grid = move.low ? task.low : task.high;
        const LatentPlanes& planes = (move.low ? trainer_.GetLowGrids() : trainer_.GetHighGrids())[n];
        const AxisClass columns = GetClassX(move, planes), rows = GetClassY(move, planes);
        const LatentQuantiser& q = planes.quantiser;
        const float lowest = static_cast<float>(q.lowestLevel) * q.levelInput,
                    highest = static_cast<float>(q.highestLevel) * q.levelInput,
                    change = move.levels * q.levelInput;
        for (int y = 0; y < grid.rows; ++y) {
            if (!rows.Has(grid.originY + y))
                continue;
            float* row = grid.values + (move.feature * grid.rows + y) * grid.pitch;
            for (int x = 0; x < grid.width; ++x) {
                if (columns.Has(grid.originX + x))
                    row[x] = std::clamp(row[x] + change, lowest, highest);
            }
        }
    }

    static AxisClass GetClassX(const LatentMove& move, const LatentPlanes& grid) {
        return {grid.size.width, move.oddX, move.turn, grid.wraps};
    }
    static AxisClass GetClassY(const LatentMove& move, const LatentPlanes& grid) {
        return {grid.size.height, move.oddY, move.turn, grid.wraps};
    }

    /// The pixels of the class in row `y` of a grid. Every texel belongs to one of them at most.
    std::uint64_t DecideRow(const LatentMove& move, int neuralMip, LatentPlanes& grid, int y) {
        const LatentQuantiser& q = grid.quantiser;
        float* values = grid.Row(grid.values, move.feature, y, 0);
        std::uint64_t kept = 0;
        const AxisClass columns = GetClassX(move, grid);
        for (int index = 0; index < columns.GetCount(); ++index) {
            const int x = columns.GetPixel(index);
            double change = 0.0;
            VisitRows(move.low, neuralMip, x, y, [&](const float* from, const float* to, int count) {
                float sum = 0.0f;
                for (int i = 0; i < count; ++i)
                    sum += to[i] - from[i];
                change += static_cast<double>(sum);
            });
            if (!(change < 0.0)) // nor when a move ends at the range's end and changes nothing
                continue;
            VisitRows(move.low, neuralMip, x, y,
                      [](float* from, const float* to, int count) { std::copy(to, to + count, from); });
            const float level = std::floor(values[x] * q.scale + 0.5f) + move.levels;
            values[x] =
                std::clamp(level, static_cast<float>(q.lowestLevel), static_cast<float>(q.highestLevel)) /
                q.scale;
            ++kept;
        }
        return kept;
    }
    /// Calls visit(kept, tried, count) for every row of texels that reads a latent pixel, in all mips.
    template <typename Visit>
    void VisitRows(bool low, int neuralMip, int x, int y, const Visit& visit) {
        const auto ix = static_cast<std::size_t>(x), iy = static_cast<std::size_t>(y);
        for (std::size_t m = 0; m < losses_.size(); ++m) {
            if (trainer_.GetMips()[m].neuralMip != neuralMip)
                continue;
            Losses& losses = losses_[m];
            const auto& footprints = losses.footprints[low ? 1 : 0];
            const MipGeometry& mip = trainer_.GetMips()[m];
            const int left = footprints.x.begin[ix], right = footprints.x.end[ix];
            for (int row = footprints.y.begin[iy]; row < footprints.y.end[iy]; ++row) {
                const int y0 = row < mip.height ? row : row - mip.height;
                float* kept = losses.kept.data() + static_cast<std::size_t>(y0) * losses.pitch;
                float* tried = losses.tried.data() + static_cast<std::size_t>(y0) * losses.pitch;
                visit(kept + left, tried + left, std::min(right, mip.width) - left);
                if (right > mip.width)
                    visit(kept, tried, right - mip.width);
            }
        }
    }

    Trainer<Kernel>& trainer_;
    KernelContext context_;
    std::vector<Losses> losses_;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
