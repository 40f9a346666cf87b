// SPDX-License-Identifier: MIT
// Stability: internal
// Forward and backward pass of the FP8 network (format specification: "FP8 (E4M3) path") in binary32: E4M3
// inputs and weights, results of layers rounded to binary16, the last layer as in Int8 networks. Latents are
// given and stay.
#pragma once

#include "openntc/encode/detail/PortableKernel.h"

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class Fp8Kernel : public PortableKernel {
public:
    using PortableKernel::PortableKernel;

    void Train(const KernelContext& context, TileTask* tiles, int count, GradientSums& sums) {
        for (int i = 0; i < count; ++i) {
            Forward(context, tiles[i]);
            Loss(context, tiles[i], sums);
            Backward(context, sums);
        }
    }
    const float* Infer(const KernelContext& context, TileTask* tiles, int) {
        Forward(context, tiles[0]);
        return outputs_.data();
    }

    /// Latents as the FP8 path decodes them: code x step + bias, each operation rounded to binary16; or
    /// codes, where they are blended first.
    static void RoundRow(const float* from, float* to, int count, const LatentQuantiser& quantiser) {
        const auto lowest = static_cast<float>(quantiser.lowestLevel),
                   highest = static_cast<float>(quantiser.highestLevel);
        const HalfLevels levels(quantiser);
        for (int i = 0; i < count; ++i) {
            const float code = std::clamp(Floor(from[i] * quantiser.scale + 0.5f), lowest, highest) - lowest;
            to[i] = quantiser.blended ? code : RoundToHalf(RoundToHalf(code * levels.step) + levels.bias);
        }
    }
    static void NoiseRow(const float* from, float* to, int count, const LatentQuantiser& quantiser,
                         std::uint32_t) {
        RoundRow(from, to, count, quantiser);
    }

private:
    void Forward(const KernelContext& context, const TileTask& tile) {
        Gather(tile);
        const PackedNetwork& packed = *context.packed;
        for (int l = 0; l < 3; ++l) {
            float* sums = gradient_.data();
            // The order of a decoder that emulates E4M3: products are exact, so that its sums are met bit for
            // bit.
            Multiply(packed.reals.data() + shape_.WeightOffset(l), packed.bias + NetworkShape::BiasOffset(l),
                     inputs_[l].data(), sums, shape_.LayerOutputs(l), shape_.LayerInputs(l));
            for (int o = 0; o < shape_.LayerOutputs(l); ++o) {
                float* values = inputs_[l + 1].data() + o * kTexels;
                Activate(sums + o * kTexels, values, slopes_[l].data() + o * kTexels);
                if (l < 2)
                    RoundHidden(values);
                else
                    QuantiseHidden(values);
            }
        }
        EvaluateOutputs(context);
    }
    static void Activate(const float* sums, float* values, float* slopes) {
        for (int t = 0; t < kTexels; ++t) {
            const float z = RoundToHalf(std::clamp(sums[t], -65504.0f, 65504.0f));
            const float open = RoundToHalf(RoundToHalf(z * kHalfThird) + 0.5f);
            const float gate = std::min(std::max(open, 0.0f), 1.0f);
            values[t] = RoundToHalf(std::min(z, 3.0f) * gate);
            const float middle = 2.0f * open - 0.5f;
            const float upper = open <= 1.5f ? 1.0f : 0.0f;
            const float slope = open >= 1.0f ? upper : middle;
            slopes[t] = open > 0.0f ? slope : 0.0f;
        }
    }
    static void RoundHidden(float* values) {
        for (int t = 0; t < kTexels; ++t)
            values[t] = RoundToE4M3(values[t]);
    }
    /// Steps of 0.0125, ties to even: adding and taking away 1.5 x 2^23 rounds to integers.
    static void QuantiseHidden(float* values) {
        constexpr float kMagic = 12582912.0f;
        for (int t = 0; t < kTexels; ++t) {
            const float raised = RoundToHalf(RoundToHalf(values[t] * 80.0f) - 113.0f) + kMagic;
            values[t] = std::min(raised - kMagic, 127.0f) + 113.0f;
        }
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
                constexpr auto kExact = &AxisTaps::exactFraction;
                Blend(tile.high, PlaceCorner(mip.highX, mip.highY, x, y, tile.high, kExact), hf, to + t);
                Blend(tile.low, PlaceCorner(mip.lowX, mip.lowY, x, y, tile.low, kExact), lf,
                      to + hf * kTexels + t);
                continue;
            }
            const Corner high = PlaceCorner(mip.highX, mip.highY, x, y, tile.high);
            const Corner low = PlaceCorner(mip.lowX, mip.lowY, x, y, tile.low);
            for (int c = 0; c < 4; ++c) {
                const float weight = RoundToHalf(high.weight[c]);
                for (int f = 0; f < hf; ++f) {
                    const float value =
                        tile.high.values[f * tile.high.rows * tile.high.pitch + high.offset[c]];
                    to[(c * hf + f) * kTexels + t] = RoundToInput(value * weight);
                }
            }
            for (int f = 0; f < lf; ++f) {
                const float* plane = tile.low.values + f * tile.low.rows * tile.low.pitch;
                float sum = 0.0f;
                for (int c = 0; c < 4; ++c)
                    sum = RoundToHalf(sum + RoundToHalf(plane[low.offset[c]] * RoundToHalf(low.weight[c])));
                to[(4 * hf + f) * kTexels + t] = RoundToE4M3(sum);
            }
        }
    }
    static void GatherWaves(const MipGeometry& mip, int x, int y, float* to) {
        for (int wave = 0; wave < 3; ++wave) {
            for (int phase = 0; phase < 2; ++phase) {
                to[(wave * 4 + phase * 2) * kTexels] = *mip.GetEightBitWaves(mip.wavesX, wave, phase, x);
                to[(wave * 4 + phase * 2 + 1) * kTexels] = *mip.GetEightBitWaves(mip.wavesY, wave, phase, y);
            }
        }
        to[12 * kTexels] = to[13 * kTexels] = mip.eightBitLod;
    }
    static void Blend(const LocalGrid& grid, const Corner& corner, int features, float* to) {
        for (int f = 0; f < features; ++f) {
            const float doubled = Sample(grid, corner, f) * (2.0f / 15.0f);
            to[f * kTexels] = RoundToInput(doubled - 1.0f);
        }
    }
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
