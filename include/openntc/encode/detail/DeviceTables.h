// SPDX-License-Identifier: MIT
// Stability: internal
// What does not change over a training, as the passes of a device read it.
#pragma once

#include "openntc/encode/TrainingDevice.h"
#include "openntc/encode/detail/LatentRefiner.h"
#include "openntc/encode/detail/TrainingSet.h"

#include <algorithm>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Tables of one set, and where latents are: grid after grid, high-resolution ones first, planes as in
/// LatentPlanes.
struct DeviceTables {
    NtcTrainConstants constants{};
    std::vector<NtcTrainMip> mips;
    std::vector<std::uint32_t> taps;  ///< pairs, see passes/TrainTexels.comp
    std::vector<std::uint32_t> tiles; ///< pairs: mip, x | y << 16
    /// Texels that read a pixel: begin | end << 16, which may lie beyond the mip where latents wrap around.
    std::vector<std::uint32_t> ranges;
    std::uint64_t latents = 0;

    /// Gradients are kept in binary16: the largest channel's has this slope, a mask's at most 65 times that.
    static constexpr float kGain = 256.0f;

    static NtcTrainQuantiser MakeQuantiser(const LatentQuantiser& q) {
        return {
            q.scale,   q.levelInput, static_cast<float>(q.lowestLevel), static_cast<float>(q.highestLevel),
            q.minimum, q.maximum};
    }

    /// `smallestScale`: of each output's row.
    static DeviceTables Make(const TrainingSet& set, const KernelContext& context, const float* smallestScale,
                             std::span<const MipGeometry> mips, std::span<const LatentPlanes> high,
                             std::span<const LatentPlanes> low) {
        DeviceTables tables;
        tables.FillConstants(context, smallestScale, high[0], low[0]);
        std::vector<std::uint32_t> bases[2];
        for (int side = 0; side < 2; ++side) {
            for (const LatentPlanes& grid : side == 0 ? high : low) {
                bases[side].push_back(static_cast<std::uint32_t>(tables.latents));
                tables.latents += grid.values.size();
            }
        }
        for (const MipGeometry& mip : mips) {
            const auto n = static_cast<std::size_t>(mip.neuralMip);
            NtcTrainMip& to = tables.mips.emplace_back();
            to.width = mip.width;
            to.height = mip.height;
            to.neuralMip = static_cast<std::uint32_t>(mip.neuralMip);
            to.firstTile =
                static_cast<std::uint32_t>(set.GetFirstTile(static_cast<int>(tables.mips.size()) - 1));
            to.high = tables.AddGrid(high[n], bases[0][n], mip.highX, mip.highY);
            to.low = tables.AddGrid(low[n], bases[1][n], mip.lowX, mip.lowY);
            to.lodInput = static_cast<std::int32_t>(mip.lodInput);
            for (int i = 0; i < 96; ++i)
                to.waves[i] = static_cast<std::int32_t>(mip.waves[i / 32][i / 16 % 2][i % 16]);
            to.positionScale = mip.positionScale;
        }
        for (int tile = 0; tile < set.GetFirstTile(set.GetMipCount()); ++tile) {
            const TileRecord& record = set.GetTile(tile);
            tables.tiles.push_back(static_cast<std::uint32_t>(record.mip));
            tables.tiles.push_back(static_cast<std::uint32_t>(record.x) | static_cast<std::uint32_t>(record.y)
                                                                              << 16);
        }
        return tables;
    }

private:
    void FillConstants(const KernelContext& context, const float* smallestScale, const LatentPlanes& high,
                       const LatentPlanes& low) {
        constants.high = MakeQuantiser(high.quantiser);
        constants.low = MakeQuantiser(low.quantiser);
        constants.highFeatures = high.features;
        constants.lowFeatures = low.features;
        constants.channels = context.channels;
        constants.maskIndex = context.maskIndex;
        constants.oneSided = context.oneSided;
        std::fill(std::begin(constants.channelOf), std::end(constants.channelOf), -1);
        const float largest = *std::max_element(context.gain, context.gain + std::max(context.channels, 1));
        for (int c = 0; c < context.channels; ++c) {
            const int o = context.outputOf[c];
            constants.channelOf[o] = c;
            constants.gain[o] = context.gain[c] / largest * kGain;
            constants.squaredRange[o] = context.squaredRange[c];
        }
        std::copy_n(smallestScale, kOutputs, constants.smallestScale);
    }

    /// `wraps`: around `pixels`.
    std::uint32_t AddTaps(const AxisTaps& axis, bool wraps, int pixels) {
        const std::size_t first = taps.size() / 2;
        const auto place = [&](std::int32_t at) {
            return static_cast<std::uint32_t>(wraps ? WrapLatent(at, pixels) : at);
        };
        for (std::size_t i = 0; i < axis.first.size(); ++i) {
            taps.push_back(place(axis.first[i]) | place(axis.second[i]) << 16);
            taps.push_back(wraps ? static_cast<std::uint32_t>(axis.fraction[i] * 256.0f) | // whole
                                       static_cast<std::uint32_t>(axis.first[i] + 1) << 16
                                 : BitCast<std::uint32_t>(axis.fraction[i]));
        }
        return static_cast<std::uint32_t>(first);
    }
    NtcTrainGrid AddGrid(const LatentPlanes& grid, std::uint32_t base, const AxisTaps& x, const AxisTaps& y) {
        NtcTrainGrid to{};
        to.base = base;
        to.width = static_cast<std::uint32_t>(grid.size.width);
        to.height = static_cast<std::uint32_t>(grid.size.height);
        to.plane = static_cast<std::uint32_t>(grid.PlaneSize());
        to.tapsX = AddTaps(x, grid.wraps, grid.size.width);
        to.tapsY = AddTaps(y, grid.wraps, grid.size.height);
        to.rangesX = AddRanges(x, grid.wraps, grid.size.width);
        to.rangesY = AddRanges(y, grid.wraps, grid.size.height);
        return to;
    }
    std::uint32_t AddRanges(const AxisTaps& axis, bool wraps, int pixels) {
        const std::size_t first = ranges.size();
        const AxisFootprints footprints =
            wraps ? AxisFootprints::MakeWrapped(axis, pixels) : AxisFootprints::Make(axis, pixels);
        for (std::size_t i = 0; i < footprints.begin.size(); ++i)
            ranges.push_back(static_cast<std::uint32_t>(footprints.begin[i]) |
                             static_cast<std::uint32_t>(footprints.end[i]) << 16);
        return static_cast<std::uint32_t>(first);
    }
};

/// What a training on a device asks for beside its tables.
struct DeviceNeeds {
    NetworkShape network;
    std::uint64_t batchTiles = 0; ///< of the steps of a submission
    std::uint64_t groups = 0;     ///< workgroups of a batch
    std::uint64_t slots = 0;      ///< of TrainingBuffer::Losses
    std::uint64_t references = 0; ///< bytes

    TrainingPlan MakePlan(const DeviceTables& tables) const {
        TrainingPlan plan;
        plan.generation = network.blended ? 3 : 1;
        plan.inputs = network.PaddedInputs();
        const auto weights = static_cast<std::uint64_t>(network.WeightCount());
        const auto set = [&](TrainingBuffer buffer, std::uint64_t bytes) {
            plan.bytes[static_cast<std::size_t>(buffer)] =
                std::max<std::uint64_t>((bytes + 15) / 16 * 16, 16);
        };
        constexpr std::uint64_t kWord = 4;
        set(TrainingBuffer::Constants, sizeof(NtcTrainConstants));
        set(TrainingBuffer::Mips, tables.mips.size() * sizeof(NtcTrainMip));
        set(TrainingBuffer::Taps, tables.taps.size() * kWord);
        set(TrainingBuffer::Tiles, tables.tiles.size() * kWord);
        set(TrainingBuffer::References, references);
        set(TrainingBuffer::Batch, batchTiles * kWord);
        set(TrainingBuffer::Weights, weights * 2);
        set(TrainingBuffer::Rows, std::uint64_t{3} * NTC_TRAIN_ROWS * kWord);
        for (const TrainingBuffer buffer : {TrainingBuffer::Latents, TrainingBuffer::LatentGradients,
                                            TrainingBuffer::FirstMoments, TrainingBuffer::SecondMoments})
            set(buffer, tables.latents * kWord);
        set(TrainingBuffer::Partials, groups * (weights + NTC_TRAIN_TAIL) * kWord);
        set(TrainingBuffer::Network, 3 * (weights + NTC_TRAIN_ROWS) * kWord);
        set(TrainingBuffer::Losses, slots * kOutputs * kWord);
        set(TrainingBuffer::Ranges, tables.ranges.size() * kWord);
        for (const TrainingBuffer buffer : {TrainingBuffer::Kept, TrainingBuffer::Tried})
            set(buffer, tables.tiles.size() / 2 * kTileTexels * kWord);
        return plan;
    }
};

/// Working weights of the network as the passes read them.
struct DeviceNetwork {
    std::vector<std::uint32_t> weights; ///< binary16 pairs, tiles of 16 x 16, in each [output][input]
    std::vector<float> rows;            ///< scales, biases, largest weights

    static DeviceNetwork Make(const NetworkState& network) {
        DeviceNetwork device;
        for (int layer = 0; layer < kNetworkLayers; ++layer)
            device.AddTiles(network, layer);
        device.rows.insert(device.rows.end(), network.packed.scale,
                           network.packed.scale + NetworkShape::kBiases);
        device.rows.insert(device.rows.end(), network.packed.bias,
                           network.packed.bias + NetworkShape::kBiases);
        for (int row = 0; row < NetworkShape::kBiases; ++row) {
            const int layer = std::min(row / kHidden, 3);
            const float unit = layer == 0 ? kInputUnit : kHiddenUnit;
            const float real =
                network.packed.scale[row] / (layer < 3 ? network.GetShape().HiddenScale() * unit : unit);
            device.rows.push_back(real * 127.5f);
        }
        return device;
    }

private:
    void AddTiles(const NetworkState& network, int layer) {
        const NetworkShape& shape = network.GetShape();
        const int inputs = shape.LayerInputs(layer), outputs = shape.LayerOutputs(layer);
        const auto half = [&](int output, int input) {
            const auto at = static_cast<std::size_t>(shape.WeightOffset(layer) + output * inputs + input);
            return static_cast<std::uint32_t>(FloatToHalf(network.packed.integers[at]));
        };
        for (int tile = 0; tile < inputs / 16; ++tile) {
            for (int output = 0; output < outputs; ++output) {
                for (int input = 16 * tile; input < 16 * (tile + 1); input += 2)
                    weights.push_back(half(output, input) | half(output, input + 1) << 16);
            }
        }
    }
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
