// SPDX-License-Identifier: MIT
// Stability: internal
// Forward and backward pass of a tile of texels in plain C++ binary32. Loops run over texels or outputs with
// unit stride, so that compilers vectorise them for whatever the target offers.
#pragma once

#include "openntc/encode/detail/LatentStore.h"

#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class PortableKernel : public PlainWeightRows {
public:
    static constexpr int kTiles = 1;
    static constexpr int kTexels = kTileTexels;

    explicit PortableKernel(const NetworkShape& shape) : shape_(shape) {
        inputs_[0].Resize(static_cast<std::size_t>(shape.PaddedInputs()) * kTexels);
        for (int l = 1; l < kLayers; ++l) {
            inputs_[l].Resize(kHidden * kTexels);
            slopes_[l - 1].Resize(kHidden * kTexels);
        }
        outputs_.Resize(kOutputs * kTexels);
        const auto largest = static_cast<std::size_t>(std::max(shape.PaddedInputs(), kHidden) * kTexels);
        gradient_.Resize(largest);
        next_.Resize(largest);
    }

    void Begin() {}
    void End() {}

    void Train(const KernelContext& context, TileTask* tiles, int count, GradientSums& sums) {
        for (int i = 0; i < count; ++i) {
            Forward(context, tiles[i]);
            Loss(context, tiles[i], sums);
            Backward(context, sums);
            Scatter(tiles[i]);
        }
    }
    const float* Infer(const KernelContext& context, TileTask* tiles, int) {
        Forward(context, tiles[0]);
        return outputs_.data();
    }

    /// Working weights of inputs `input`, which is even, and `input` + 1 to the outputs of a column: integers
    /// q[2][16], real[o] of them in real units.
    static void PackRows(PackedNetwork& packed, const NetworkShape& shape, int layer, int column, int input,
                         const float (&q)[2][16], const float* real) {
        const int inputs = shape.LayerInputs(layer);
        float* to = packed.reals.data() + shape.WeightOffset(layer) + column * 16 * inputs + input;
        for (int o = 0; o < 16; ++o) {
            to[o * inputs] = q[0][o] * real[o];
            to[o * inputs + 1] = q[1][o] * real[o];
        }
    }

    static void TexelLosses(const KernelContext& context, const TileTask& tile, const float* outputs,
                            int stride, float* to, std::size_t pitch) {
        WriteTexelLosses(context, tile, outputs, stride, to, pitch);
    }
    static void AdamRow(float* values, float* first, float* second, const float* gradients, int count,
                        const AdamStep& step, float lowest, float highest) {
        for (int i = 0; i < count; ++i) {
            const float g = gradients[i];
            if (g == 0.0f)
                continue;
            first[i] += (1.0f - step.beta1) * (g - first[i]);
            second[i] += (1.0f - step.beta2) * (g * g - second[i]);
            const float change =
                step.rate * first[i] / (std::sqrt(second[i] * step.secondCorrection) + AdamStep::kEpsilon);
            const float updated = values[i] - change;
            values[i] = updated == updated ? std::clamp(updated, lowest, highest) : 0.0f;
        }
    }
    static void RoundRow(const float* from, float* to, int count, const LatentQuantiser& quantiser) {
        const auto lowest = static_cast<float>(quantiser.lowestLevel),
                   highest = static_cast<float>(quantiser.highestLevel);
        for (int i = 0; i < count; ++i)
            to[i] =
                std::clamp(Floor(from[i] * quantiser.scale + 0.5f), lowest, highest) * quantiser.levelInput;
    }
    static void NoiseRow(const float* from, float* to, int count, const LatentQuantiser& quantiser,
                         std::uint32_t seed) {
        for (int i = 0; i < count; ++i) {
            const float noise = ToUnit(Hash(seed + static_cast<std::uint32_t>(i))) - 0.5f;
            to[i] = (from[i] * quantiser.scale + noise) * quantiser.levelInput;
        }
    }

protected:
    /// Floor of values far below 2^31: a conversion and a comparison, which vectorise everywhere.
    static float Floor(float value) {
        const auto truncated = static_cast<float>(static_cast<std::int32_t>(value));
        return truncated > value ? truncated - 1.0f : truncated;
    }

    /// to[o][t] = start[o] + sum of matrix[o][i] * from[i][t] in the order of i; `start` may be null, for 0.
    static void Multiply(const float* matrix, const float* start, const float* from, float* to, int outputs,
                         int inputs) {
        constexpr int kRows = 4, kColumns = 32;
        for (int o = 0; o < outputs; o += kRows) {
            for (int t = 0; t < kTexels; t += kColumns) {
                float sum[kRows][kColumns] = {};
                for (int r = 0; r < kRows && start != nullptr; ++r)
                    std::fill_n(sum[r], kColumns, start[o + r]);
                for (int i = 0; i < inputs; ++i) {
                    const float* x = from + i * kTexels + t;
                    for (int r = 0; r < kRows; ++r) {
                        const float w = matrix[(o + r) * inputs + i];
                        for (int k = 0; k < kColumns; ++k)
                            sum[r][k] += w * x[k];
                    }
                }
                for (int r = 0; r < kRows; ++r)
                    std::memcpy(to + (o + r) * kTexels + t, sum[r], sizeof(sum[r]));
            }
        }
    }
    /// to[i][t] = sum of matrix[o][i] * from[o][t], for inputs below `wanted`.
    static void MultiplyTransposed(const float* matrix, const float* from, float* to, int outputs, int inputs,
                                   int wanted) {
        constexpr int kRows = 4, kColumns = 32;
        for (int i = 0; i < wanted; i += kRows) {
            for (int t = 0; t < kTexels; t += kColumns) {
                float sum[kRows][kColumns] = {};
                for (int o = 0; o < outputs; ++o) {
                    const float* z = from + o * kTexels + t;
                    for (int r = 0; r < kRows; ++r) {
                        const float w = matrix[o * inputs + i + r];
                        for (int k = 0; k < kColumns; ++k)
                            sum[r][k] += w * z[k];
                    }
                }
                for (int r = 0; r < kRows; ++r)
                    std::memcpy(to + (i + r) * kTexels + t, sum[r], sizeof(sum[r]));
            }
        }
    }
    /// Adds x[i][t] * z[o][t], summed over t, to the tiled weight gradients.
    static void AddWeightGradients(const float* x, const float* z, float* to, int outputs, int inputs) {
        constexpr int kLanes = 16;
        for (int i = 0; i < inputs; ++i) {
            for (int o = 0; o < outputs; o += 4) {
                float sum[4][kLanes] = {};
                for (int t = 0; t < kTexels; t += kLanes) {
                    for (int r = 0; r < 4; ++r) {
                        for (int k = 0; k < kLanes; ++k)
                            sum[r][k] += x[i * kTexels + t + k] * z[(o + r) * kTexels + t + k];
                    }
                }
                for (int r = 0; r < 4; ++r) {
                    float total = 0.0f;
                    for (float value : sum[r])
                        total += value;
                    to[WeightIndex(outputs, i, o + r)] += total;
                }
            }
        }
    }

    void Forward(const KernelContext& context, const TileTask& tile) {
        Gather(tile);
        const PackedNetwork& packed = *context.packed;
        for (int l = 0; l < 3; ++l) {
            float* sums = gradient_.data();
            Multiply(packed.integers.data() + shape_.WeightOffset(l), nullptr, inputs_[l].data(), sums,
                     shape_.LayerOutputs(l), shape_.LayerInputs(l));
            for (int o = 0; o < shape_.LayerOutputs(l); ++o) {
                const int row = NetworkShape::BiasOffset(l) + o;
                float* values = inputs_[l + 1].data() + o * kTexels;
                float* slopes = slopes_[l].data() + o * kTexels;
                if (shape_.blended)
                    ActivateBlended(sums + o * kTexels, packed.bias[row], packed.scale[row], values, slopes);
                else
                    Activate(sums + o * kTexels, packed.bias[row], packed.scale[row], values, slopes);
            }
        }
        EvaluateOutputs(context);
    }
    void EvaluateOutputs(const KernelContext& context) {
        const PackedNetwork& packed = *context.packed;
        Multiply(packed.integers.data() + shape_.WeightOffset(3), nullptr, inputs_[3].data(), outputs_.data(),
                 kOutputs, shape_.LayerInputs(3));
        for (int o = 0; o < kOutputs; ++o) {
            const int index = NetworkShape::BiasOffset(3) + o;
            const float bias = packed.bias[index], scale = packed.scale[index];
            float* row = outputs_.data() + o * kTexels;
            for (int t = 0; t < kTexels; ++t)
                row[t] = (row[t] + bias) * scale;
        }
    }
    /// HGELU-clamp and its derivative in units of the hidden quantiser's step.
    static void Activate(const float* sums, float bias, float scale, float* values, float* slopes) {
        for (int t = 0; t < kTexels; ++t) {
            const float u = (sums[t] + bias) * scale;
            const float open = u * (1.0f / 240.0f) + 0.5f;
            const float gate = std::min(std::max(open, 0.0f), 1.0f);
            values[t] = Floor(std::min(u, 240.0f) * gate + 0.5f);
            slopes[t] = GetSlope(open);
        }
    }
    /// The same in real units and the order of generation 3's operations: rounded before the offset is
    /// added, with its own third.
    static void ActivateBlended(const float* sums, float bias, float scale, float* values, float* slopes) {
        constexpr float kMagic = 12582912.0f; // 1.5 x 2^23: added and taken away it rounds, ties to even
        for (int t = 0; t < kTexels; ++t) {
            const float z = (sums[t] + bias) * scale;
            const float third = z * kBlendedThird;
            const float open = third + 0.5f;
            const float gate = std::min(std::max(open, 0.0f), 1.0f);
            const float y = std::min(z, 3.0f) * gate * kHiddenSteps;
            const float raised = y + kMagic;
            values[t] = raised - kMagic;
            slopes[t] = GetSlope(open);
        }
    }
    /// Derivative of the activation, by the gate before it is clamped.
    static float GetSlope(float open) {
        const float middle = 2.0f * open - 0.5f;
        const float upper = open <= 1.5f ? 1.0f : 0.0f;
        const float slope = open >= 1.0f ? upper : middle;
        return open > 0.0f ? slope : 0.0f;
    }

    void Loss(const KernelContext& context, const TileTask& tile, GradientSums& sums) {
        float* z = gradient_.data();
        std::memset(z, 0, sizeof(float) * kOutputs * kTexels);
        for (int c = 0; c < context.channels; ++c) {
            const int o = context.outputOf[c];
            float squares = 0.0f, total = 0.0f;
            for (int y = 0; y < tile.height; ++y) {
                for (int x = 0; x < tile.width; ++x) {
                    const int t = y * kTileWidth + x;
                    if (context.maskIndex >= 0 && c != context.maskIndex &&
                        Reference(tile, context.maskIndex, t) <= context.maskZero)
                        continue;
                    const float wanted = Reference(tile, c, t);
                    float error = outputs_.data()[o * kTexels + t] - wanted;
                    float weighed = error;
                    if (c == context.oneSided) {
                        error = MaskLoss::Clip(error, wanted);
                        weighed = MaskLoss::Weigh(error, wanted, context.maskPush);
                    }
                    const float gradient = weighed * context.gain[c];
                    squares += error * error;
                    total += gradient;
                    z[o * kTexels + t] = gradient;
                }
            }
            sums.loss[o][0] += squares * context.squaredRange[c];
            sums.biases[NetworkShape::BiasOffset(3) + o][0] += total;
        }
    }
    static float Reference(const TileTask& tile, int channel, int texel) {
        return static_cast<float>(tile.reference[channel * kTileTexels + texel]) * (1.0f / 65535.0f);
    }

    void Backward(const KernelContext& context, GradientSums& sums) {
        for (int l = 3; l >= 0; --l) {
            const int outputs = shape_.LayerOutputs(l), inputs = shape_.LayerInputs(l);
            AddWeightGradients(inputs_[l].data(), gradient_.data(),
                               sums.weights.data() + shape_.WeightOffset(l), outputs,
                               l == 0 ? shape_.Inputs() : inputs);
            if (l > 0)
                BackwardActivation(context, l, sums);
        }
        MultiplyTransposed(context.packed->reals.data(), gradient_.data(), next_.data(), kHidden,
                           shape_.LayerInputs(0), shape_.LatentInputs());
        std::swap(gradient_, next_);
    }
    /// From gradients of a layer's sums to those of the layer below.
    void BackwardActivation(const KernelContext& context, int layer, GradientSums& sums) {
        const int inputs = shape_.LayerInputs(layer);
        MultiplyTransposed(context.packed->reals.data() + shape_.WeightOffset(layer), gradient_.data(),
                           next_.data(), shape_.LayerOutputs(layer), inputs, inputs);
        std::swap(gradient_, next_);
        for (int i = 0; i < inputs; ++i) {
            float* z = gradient_.data() + i * kTexels;
            const float* slope = slopes_[layer - 1].data() + i * kTexels;
            float total = 0.0f;
            for (int t = 0; t < kTexels; ++t)
                z[t] *= slope[t];
            for (int t = 0; t < kTexels; ++t)
                total += z[t];
            sums.biases[NetworkShape::BiasOffset(layer - 1) + i][0] += total;
        }
    }

    struct Corner {
        float weight[4];
        int offset[4];
    };
    /// With the weights in binary32, of `fraction` or `exactFraction`.
    static Corner PlaceCorner(const AxisTaps& tapsX, const AxisTaps& tapsY, int x, int y,
                              const LocalGrid& grid,
                              std::vector<float> AxisTaps::*fractions = &AxisTaps::fraction) {
        const auto ix = static_cast<std::size_t>(x), iy = static_cast<std::size_t>(y);
        const float fx = (tapsX.*fractions)[ix], fy = (tapsY.*fractions)[iy], gx = 1.0f - fx, gy = 1.0f - fy;
        const int x0 = tapsX.first[ix] - grid.originX, x1 = tapsX.second[ix] - grid.originX;
        const int y0 = (tapsY.first[iy] - grid.originY) * grid.pitch,
                  y1 = (tapsY.second[iy] - grid.originY) * grid.pitch;
        return {{gx * gy, fx * gy, gx * fy, fx * fy}, {y0 + x0, y0 + x1, y1 + x0, y1 + x1}};
    }
    /// With the weights truncated to 1/256.
    static Corner MakeCorner(const AxisTaps& tapsX, const AxisTaps& tapsY, int x, int y,
                             const LocalGrid& grid) {
        Corner corner = PlaceCorner(tapsX, tapsY, x, y, grid);
        for (float& weight : corner.weight)
            weight = static_cast<float>(static_cast<int>(weight * 256.0f)) * (1.0f / 256.0f);
        return corner;
    }

    void Gather(const TileTask& tile) {
        const MipGeometry& mip = *tile.mip;
        const int hf = shape_.highFeatures, lf = shape_.lowFeatures;
        float* to = inputs_[0].data();
        for (int t = 0; t < kTexels; ++t) {
            const int x = tile.x + std::min(t % kTileWidth, tile.width - 1);
            const int y = tile.y + std::min(t / kTileWidth, tile.height - 1);
            GatherWaves(mip, x, y, to + shape_.LatentInputs() * kTexels + t);
            if (shape_.blended) {
                Blend(tile.high, PlaceCorner(mip.highX, mip.highY, x, y, tile.high), hf, to + t);
                Blend(tile.low, PlaceCorner(mip.lowX, mip.lowY, x, y, tile.low), lf, to + hf * kTexels + t);
                continue;
            }
            const Corner high = MakeCorner(mip.highX, mip.highY, x, y, tile.high);
            const Corner low = MakeCorner(mip.lowX, mip.lowY, x, y, tile.low);
            for (int c = 0; c < 4; ++c) {
                for (int f = 0; f < hf; ++f) {
                    const float value =
                        tile.high.values[f * tile.high.rows * tile.high.pitch + high.offset[c]];
                    to[(c * hf + f) * kTexels + t] = Floor(value * high.weight[c]);
                }
            }
            for (int f = 0; f < lf; ++f)
                to[(4 * hf + f) * kTexels + t] = Floor(Sample(tile.low, low, f));
        }
    }
    static void GatherWaves(const MipGeometry& mip, int x, int y, float* to) {
        for (int wave = 0; wave < 3; ++wave) {
            for (int phase = 0; phase < 2; ++phase) {
                to[(wave * 4 + phase * 2) * kTexels] = *mip.GetWaves(mip.wavesX, wave, phase, x);
                to[(wave * 4 + phase * 2 + 1) * kTexels] = *mip.GetWaves(mip.wavesY, wave, phase, y);
            }
        }
        to[12 * kTexels] = to[13 * kTexels] = mip.lodInput;
    }
    static float Sample(const LocalGrid& grid, const Corner& corner, int feature) {
        const float* plane = grid.values + feature * grid.rows * grid.pitch;
        float sum = 0.0f;
        for (int c = 0; c < 4; ++c)
            sum += plane[corner.offset[c]] * corner.weight[c];
        return sum;
    }
    static void Blend(const LocalGrid& grid, const Corner& corner, int features, float* to) {
        for (int f = 0; f < features; ++f)
            to[f * kTexels] = Floor(Sample(grid, corner, f)) - kBlendedOffset;
    }

    void Scatter(const TileTask& tile) {
        const MipGeometry& mip = *tile.mip;
        const int hf = shape_.highFeatures, lf = shape_.lowFeatures;
        const int highPlane = tile.high.rows * tile.high.pitch, lowPlane = tile.low.rows * tile.low.pitch;
        std::fill(tile.high.gradients, tile.high.gradients + hf * highPlane, 0.0f);
        std::fill(tile.low.gradients, tile.low.gradients + lf * lowPlane, 0.0f);
        for (int y = 0; y < tile.height; ++y) {
            for (int x = 0; x < tile.width; ++x) {
                const auto place = [&](const AxisTaps& tapsX, const AxisTaps& tapsY, const LocalGrid& grid) {
                    return shape_.blended ? PlaceCorner(tapsX, tapsY, tile.x + x, tile.y + y, grid)
                                          : MakeCorner(tapsX, tapsY, tile.x + x, tile.y + y, grid);
                };
                const Corner high = place(mip.highX, mip.highY, tile.high);
                const Corner low = place(mip.lowX, mip.lowY, tile.low);
                const float* g = gradient_.data() + y * kTileWidth + x;
                for (int c = 0; c < 4; ++c) {
                    const int firstHigh = shape_.blended ? 0 : c * hf;
                    for (int f = 0; f < hf; ++f)
                        tile.high.gradients[f * highPlane + high.offset[c]] +=
                            g[(firstHigh + f) * kTexels] * high.weight[c];
                    for (int f = 0; f < lf; ++f)
                        tile.low.gradients[f * lowPlane + low.offset[c]] +=
                            g[(shape_.HighInputs() + f) * kTexels] * low.weight[c];
                }
            }
        }
    }

    NetworkShape shape_;
    AlignedBuffer<float> inputs_[kLayers], slopes_[3], outputs_, gradient_, next_;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
