// SPDX-License-Identifier: MIT
// What the models of all maths modes have in common: the inputs of the network, its activation and its layers.
#pragma once

#include "ModeModel.h"
#include "NumberFormats.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace openntc::models {

/// Where a texel falls in one grid: latent pixels and binary32 fractions (network 2.1).
struct ModelAxis {
    int first, second;
    double fraction, opposite;
};

inline ModelAxis GetModelAxis(int texel, int mipSize, unsigned full, unsigned start, unsigned size) {
    const double u = ToBinary32((texel + 0.5) / mipSize);
    const double position = ToBinary32(ToBinary32(ToBinary32(u * full) - start) - 0.5);
    const double cell = std::floor(position);
    const int last = static_cast<int>(size) - 1;
    const auto clamp = [last](double value) {
        return value < 0 ? 0 : value > last ? last : static_cast<int>(value);
    };
    const double fraction = ToBinary32(position - cell);
    return {clamp(cell), clamp(cell + 1), fraction, ToBinary32(1 - fraction)};
}

/// Codes of the four corners and their binary32 weights.
struct ModelSample {
    std::array<std::vector<int>, 4> codes;
    std::array<double, 4> weights;
};

inline ModelSample GetModelSample(const ModelSource& source, const NtcNeuralMipConstants& grid,
                                  const NtcLatentEncodingConstants& encoding, int x, int y, int mipWidth,
                                  int mipHeight) {
    const unsigned width = grid.sliceWidthHeight & 0xFFFF;
    const ModelAxis h =
        GetModelAxis(x, mipWidth, grid.imageWidthHeight & 0xFFFF, grid.sliceLeftTop & 0xFFFF, width);
    const ModelAxis v = GetModelAxis(y, mipHeight, grid.imageWidthHeight >> 16, grid.sliceLeftTop >> 16,
                                     grid.sliceWidthHeight >> 16);
    ModelSample sample;
    sample.weights = {h.opposite * v.opposite, h.fraction * v.opposite, h.opposite * v.fraction,
                      h.fraction * v.fraction};
    for (std::size_t corner = 0; corner < 4; ++corner) {
        const int px = (corner & 1) != 0 ? h.second : h.first;
        const int py = (corner & 2) != 0 ? v.second : v.first;
        const std::size_t pixel = static_cast<std::size_t>(py) * width + static_cast<std::size_t>(px);
        for (int k = 0; k < encoding.numFeatures; ++k) {
            const std::size_t bit =
                (pixel * static_cast<std::size_t>(encoding.numFeatures) + static_cast<std::size_t>(k)) *
                static_cast<std::size_t>(encoding.quantBits);
            const int byte = std::to_integer<int>(source.latents[grid.dataOffset + bit / 8]);
            sample.codes[corner].push_back(byte >> (bit % 8) & ((1 << encoding.quantBits) - 1));
        }
    }
    return sample;
}

inline double ModelWave(double t) {
    const double phase = t - std::floor(t);
    return std::fabs(4 * phase - 2) - 1;
}

/// The inputs of one texel, from functions for the latent value of a code, for a rounded operation, and for waves.
template <typename Latent, typename Round, typename Wave>
std::vector<double> GetModelInputs(const ModelSource& source, int mip, int x, int y, Latent latent,
                                   Round round, Wave wave) {
    const NtcTextureSetConstants& c = *source.constants;
    const NtcColorMipConstants& color = c.colorMips[mip];
    const int width = c.imageWidth >> mip > 1 ? c.imageWidth >> mip : 1;
    const int height = c.imageHeight >> mip > 1 ? c.imageHeight >> mip : 1;
    const std::size_t slots = static_cast<std::size_t>(4 * source.networkVersion);
    std::vector<double> inputs(4 * slots + 32, 0.0);

    const ModelSample high =
        GetModelSample(source, c.highResNeuralMips[color.neuralMip], c.highResEncoding, x, y, width, height);
    for (std::size_t corner = 0; corner < 4; ++corner) {
        for (std::size_t k = 0; k < high.codes[corner].size(); ++k)
            inputs[corner * slots + k] = round(latent(high.codes[corner][k], c.highResEncoding.quantBits) *
                                               round(ToBinary32(high.weights[corner])));
    }
    const ModelSample low =
        GetModelSample(source, c.lowResNeuralMips[color.neuralMip], c.lowResEncoding, x, y, width, height);
    for (std::size_t k = 0; k < low.codes[0].size(); ++k) {
        double sum = 0;
        for (std::size_t corner = 0; corner < 4; ++corner)
            sum = round(sum + round(latent(low.codes[corner][k], c.lowResEncoding.quantBits) *
                                    round(ToBinary32(low.weights[corner]))));
        inputs[4 * slots + k] = sum;
    }
    const double qx = x * static_cast<double>(color.positionScale);
    const double qy = y * static_cast<double>(color.positionScale);
    for (std::size_t j = 0; j < 3; ++j) {
        const double frequency = std::ldexp(1.0, static_cast<int>(j) - 3);
        double* const out = &inputs[4 * slots + 16 + 4 * j];
        out[0] = wave(ModelWave(qx * frequency));
        out[1] = wave(ModelWave(qy * frequency));
        out[2] = wave(ModelWave(qx * frequency + 0.25));
        out[3] = wave(ModelWave(qy * frequency + 0.25));
    }
    inputs[4 * slots + 28] = inputs[4 * slots + 29] = wave(static_cast<double>(color.positionLod));
    return inputs;
}

/// HGELU-clamp in binary16, as the specification's network 3.3 has it up to y.
inline double ModelActivationHalf(double z) {
    const double third = HalfValue(0x3555);
    double gate = ToHalf(ToHalf(third * z) + 0.5);
    gate = gate < 0 ? 0 : gate > 1 ? 1 : gate;
    return ToHalf((z < 3 ? z : 3) * gate);
}

/// The network's bytes from y (network 3.3, ties to even).
inline int ModelQuantizeHalf(double y) {
    return static_cast<int>(std::nearbyint(ToHalf(ToHalf(y * 80) - 113)));
}

inline int ModelInt8Weight(const ModelSource& source, const ModelLayer& layer, std::size_t row,
                           std::size_t i) {
    return LoadAt<std::int8_t>(source.weights, layer.weights + row * layer.inputs + i);
}

/// Bias of an Int8 row with the activation's offset taken out.
inline double GetUnfoldedBias(const ModelSource& source, std::size_t l, std::size_t row) {
    const ModelLayer layer = GetModelLayers(source)[l];
    const std::size_t at =
        static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 832 + 4 * (layer.firstRow + row);
    double bias = LoadAt<std::int32_t>(source.weights, at);
    for (std::size_t i = 0; l > 0 && i < layer.inputs; ++i)
        bias -= 113.0 * ModelInt8Weight(source, layer, row, i);
    return bias;
}
inline double GetInt8Scale(const ModelSource& source, std::size_t l, std::size_t row) {
    const std::size_t at = static_cast<std::size_t>(source.constants->networkScaleBiasOffset) +
                           4 * (GetModelLayers(source)[l].firstRow + row);
    return static_cast<double>(LoadAt<float>(source.weights, at));
}

/// Network input of a code in units of 1/127.5 (latents 6.2), from its real value.
inline double ModelLevel(int code, int bits) {
    const double levels = bits == 8 ? 127.5 : std::ldexp(1.0, bits - 1) + 0.5;
    return std::nearbyint((code + 1.5 - levels) * 127.5 / levels);
}
inline double ClampToOne(double e) {
    return e > 1 ? 1 : e < -1 ? -1 : e;
}

} // namespace openntc::models
