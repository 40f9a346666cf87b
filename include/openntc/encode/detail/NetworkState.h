// SPDX-License-Identifier: MIT
// Stability: internal
// Master weights of the network, their optimiser and their quantisation.
#pragma once

#include "openntc/core/E4M3.h"
#include "openntc/core/FloatBits.h"
#include "openntc/core/Half.h"
#include "openntc/encode/detail/TrainNetwork.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Adam's constants of one step.
struct AdamStep {
    float rate = 0.0f;             ///< learning rate / (1 - beta1^t)
    float secondCorrection = 1.0f; ///< 1 / (1 - beta2^t)
    float beta1 = 0.9f, beta2 = 0.999f;
    static constexpr float kEpsilon = 1e-15f; ///< gradients are scaled so that this only guards against 0 / 0

    static AdamStep Make(float learningRate, double t, float beta2) {
        AdamStep step;
        step.beta2 = beta2;
        step.rate = static_cast<float>(static_cast<double>(learningRate) /
                                       (1.0 - std::pow(static_cast<double>(step.beta1), t)));
        step.secondCorrection = static_cast<float>(1.0 / (1.0 - std::pow(static_cast<double>(beta2), t)));
        return step;
    }
};

inline std::uint16_t ToBfloat16(float value) {
    const auto bits = BitCast<std::uint32_t>(value);
    return static_cast<std::uint16_t>((bits + 0x7fffu + (bits >> 16 & 1u)) >> 16);
}

/// Rows of sixteen weights in plain C++.
struct PlainWeightRows {
    /// Gradients of sixteen weights from `at` on: those of the slices in their order, times `unit`.
    static void SumRow(std::span<const GradientSums> slices, std::size_t at, float unit, float* to) {
        float sums[16] = {};
        for (const GradientSums& slice : slices) {
            for (std::size_t o = 0; o < 16; ++o)
                sums[o] += slice.weights[at + o];
        }
        for (std::size_t o = 0; o < 16; ++o)
            to[o] = sums[o] * unit;
    }
    /// The same of sixteen biases from `row` on, each the sum of its lanes.
    static void SumBiases(std::span<const GradientSums> slices, int row, float* to) {
        for (int o = 0; o < 16; ++o) {
            float gradient = 0.0f;
            for (const GradientSums& slice : slices) {
                float sum = 0.0f;
                for (float value : slice.biases[row + o])
                    sum += value;
                gradient += sum;
            }
            to[o] = gradient;
        }
    }
    /// The largest magnitudes so far, with those of sixteen weights.
    static void RaiseLimits(const float* from, float* limit) {
        for (std::size_t o = 0; o < 16; ++o)
            limit[o] = std::max(limit[o], std::fabs(from[o]));
    }
    /// Sixteen weights over their rows' scales, to -127 ... 127, rounded when they are quantised.
    static void QuantiseRow(const float* from, const float* inverse, bool quantise, float* q) {
        for (std::size_t o = 0; o < 16; ++o)
            q[o] = from[o] * inverse[o];
        for (std::size_t o = 0; quantise && o < 16; ++o) {
            const float raised = std::clamp(q[o] + std::copysign(0.5f, q[o]), -127.0f, 127.0f);
            q[o] = static_cast<float>(static_cast<int>(raised));
        }
    }
    /// Sixteen weights to E4M3.
    static void RoundEightBitRow(const float* from, float* q) {
        for (std::size_t o = 0; o < 16; ++o)
            q[o] = RoundToE4M3(from[o]);
    }
};

class NetworkState {
public:
    explicit NetworkState(const NetworkShape& shape) : shape_(shape) {
        const auto count = static_cast<std::size_t>(shape.WeightCount());
        weights.Resize(count);
        first.Resize(count);
        second.Resize(count);
        packed.integers.Resize(count);
        packed.reals.Resize(count);
        packed.forward.Resize(count);
        packed.backward.Resize(PackedNetwork::BackwardSize(shape));
        packed.columns.Resize(count);
        packed.rows.Resize(count);
    }

    const NetworkShape& GetShape() const { return shape_; }

    /// Columns of 16 outputs over all layers: units of parallel work. Those of tapered layers may be empty.
    static constexpr int kColumns = 4 + 4 + 4 + 1;

    /// Adds the slices' gradients in their order, steps the optimiser and packs the working weights of one
    /// column.
    template <typename Kernel>
    void UpdateColumn(int column, std::span<const GradientSums> slices, const AdamStep& step, bool quantise) {
        const int layer = column / 4, tile = column % 4;
        const int outputs = shape_.LayerOutputs(layer);
        const int inputs = shape_.LayerInputs(layer);
        if (tile * 16 >= outputs)
            return;
        const float unit = layer == 0 ? kInputUnit : kHiddenUnit;
        for (int i = 0; i < inputs; ++i) {
            if (layer == 0 && i >= shape_.Inputs())
                break;
            const int index = shape_.WeightOffset(layer) + WeightIndex(outputs, i, tile * 16);
            const auto at = static_cast<std::size_t>(index);
            float gradient[16];
            Kernel::SumRow(slices, at, unit, gradient);
            Kernel::AdamRow(&weights[at], &first[at], &second[at], gradient, 16, step, -kLargestWeight,
                            kLargestWeight);
        }
        const int row = NetworkShape::BiasOffset(layer) + tile * 16;
        float gradient[16];
        Kernel::SumBiases(slices, row, gradient);
        Kernel::AdamRow(biases + row, firstBias + row, secondBias + row, gradient, 16, step, -kLargestWeight,
                        kLargestWeight);
        PackColumn<Kernel>(column, quantise);
    }

    /// Working weights of one column: per row (output) integers -127 ... 127 and a scale, or, before
    /// quantisation starts, the same scaling without rounding.
    template <typename Kernel>
    void PackColumn(int column, bool quantise) {
        const int layer = column / 4, tile = column % 4;
        const int outputs = shape_.LayerOutputs(layer);
        if (tile * 16 >= outputs)
            return;
        if (eightBitFloat && layer < 3) {
            PackFp8Column<Kernel>(layer, tile);
            return;
        }
        const int inputs = shape_.LayerInputs(layer);
        const float unit = layer == 0 ? kInputUnit : kHiddenUnit;
        float limit[16];
        for (float& value : limit)
            value = kSmallestLimit;
        const auto base = static_cast<std::size_t>(shape_.WeightOffset(layer));
        for (int i = 0; i < inputs; ++i) {
            const auto at = base + static_cast<std::size_t>(WeightIndex(outputs, i, tile * 16));
            Kernel::RaiseLimits(weights.data() + at, limit);
        }
        if (layer == 3) {
            for (int o = 0; o < 16; ++o)
                limit[o] = std::max(limit[o], smallestScale[o] * 127.5f / unit);
        }
        float inverse[16], real[16];
        for (int o = 0; o < 16; ++o) {
            inverse[o] = 127.5f / limit[o];
            real[o] = limit[o] / 127.5f;
            const int row = NetworkShape::BiasOffset(layer) + tile * 16 + o;
            const float scale = real[o] * unit;
            packed.scale[row] = layer < 3 ? scale * shape_.HiddenScale() : scale;
            // The decoder's biases are integers; sums stay below 2^24 so that binary32 holds them exactly.
            const float bias = std::clamp(biases[row] / scale, -kLargestBias, kLargestBias);
            packed.bias[row] = quantise ? std::round(bias) : bias;
        }
        for (int i = 0; i < inputs; i += 2) {
            float q[2][16];
            for (int k = 0; k < 2; ++k) {
                const auto at = base + static_cast<std::size_t>(WeightIndex(outputs, i + k, tile * 16));
                Kernel::QuantiseRow(weights.data() + at, inverse, quantise, q[k]);
            }
            PackPair<Kernel>(layer, tile, i, q, real);
        }
    }

    static constexpr float kLargestWeight = 1000.0f;
    static constexpr float kSmallestLimit = 1e-12f;
    static constexpr float kLargestBias = 8388608.0f; ///< 2^23: leaves as much again for the weighted sum

    AlignedBuffer<float> weights, first, second; ///< tiles, see WeightIndex; real units
    float biases[NetworkShape::kBiases] = {}, firstBias[NetworkShape::kBiases] = {},
          secondBias[NetworkShape::kBiases] = {};
    /// Row scales of the last layer stay above these, for channels whose offset would need a huge integer
    /// bias.
    float smallestScale[kOutputs] = {};
    PackedNetwork packed;
    /// Working weights are those of an FP8 network: of layers 0 - 2 numbers of E4M3 in the place of integers,
    /// and `packed.bias` in real units.
    bool eightBitFloat = false;

private:
    template <typename Kernel>
    void PackFp8Column(int layer, int tile) {
        const int outputs = shape_.LayerOutputs(layer), inputs = shape_.LayerInputs(layer);
        float real[16];
        for (int o = 0; o < 16; ++o) {
            real[o] = 1.0f;
            const int row = NetworkShape::BiasOffset(layer) + tile * 16 + o;
            packed.bias[row] = RoundToHalf(std::clamp(biases[row], -kLargestHalf, kLargestHalf));
        }
        for (int i = 0; i < inputs; i += 2) {
            float q[2][16];
            for (int k = 0; k < 2; ++k) {
                const int index = shape_.WeightOffset(layer) + WeightIndex(outputs, i + k, tile * 16);
                Kernel::RoundEightBitRow(weights.data() + index, q[k]);
            }
            PackPair<Kernel>(layer, tile, i, q, real);
        }
    }
    /// Working weights of inputs `input` and `input` + 1: see Kernel::PackRows.
    template <typename Kernel>
    void PackPair(int layer, int tile, int input, const float (&q)[2][16], const float* real) {
        const int inputs = shape_.LayerInputs(layer);
        float* integers = packed.integers.data() + shape_.WeightOffset(layer) + tile * 16 * inputs + input;
        for (int o = 0; o < 16; ++o) {
            integers[o * inputs] = q[0][o];
            integers[o * inputs + 1] = q[1][o];
        }
        Kernel::PackRows(packed, shape_, layer, tile, input, q, real);
    }

    static constexpr float kLargestHalf = 65504.0f;
    NetworkShape shape_;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
