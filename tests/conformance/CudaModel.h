// SPDX-License-Identifier: MIT
// LibNTC's CUDA decoder of generation 3 with Int8 weights (format specification, generations 10, network 10): binary16
// nearly everywhere. Which sums are rounded when is the tensor cores' business; here after every 16 products. And how far
// the exact decoders may be from it.
#pragma once

#include "models/NumberFormats.h"
#include "openntc/decode/DecodeTypes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace openntc_tests {

using openntc::models::LoadAt;
using openntc::models::ToHalf;

/// A layer in real numbers: z = bias + weights · x.
struct RealLayer {
    std::size_t inputs = 0, outputs = 0;
    std::vector<double> weights; ///< [output][input]
    std::vector<double> biases;
    double Get(std::size_t output, std::size_t input) const { return weights[output * inputs + input]; }
};

/// What one texel's evaluation went through.
struct CudaTexel {
    std::array<double, 48> bytes{};                ///< quantised inputs, -127 … 127
    std::array<std::vector<double>, 3> z;          ///< before the activations
    std::array<std::vector<double>, 4> magnitudes; ///< sum of |weight · input| of every output
    std::array<double, 16> outputs{};
};

class CudaModel {
public:
    explicit CudaModel(const openntc::DecodeSource& source)
        : source_(source), network_(openntc::GetNetworkDescription(source.networkVersion)) {
        for (std::size_t layer = 0; layer < 4; ++layer)
            layers_[layer] = MakeLayer(layer);
    }

    CudaTexel Decode(int mip, int x, int y) const {
        CudaTexel texel;
        texel.bytes = GetInputs(mip, x, y);
        std::vector<double> values;
        for (const double byte : texel.bytes)
            values.push_back(ToHalf(byte * ToHalf(1 / 127.5)));
        for (std::size_t layer = 0; layer < 4; ++layer) {
            std::vector<double> sums = Multiply(layers_[layer], values, texel.magnitudes[layer]);
            if (layer == 3) {
                std::copy(sums.begin(), sums.end(), texel.outputs.begin());
                break;
            }
            values.clear();
            for (const double z : sums) {
                const double gate = std::clamp(ToHalf(ToHalf(1.0 / 3) * z + 0.5), 0.0, 1.0);
                const double steps = ToHalf(ToHalf(std::min(z, 3.0) * gate) * 80);
                values.push_back(ToHalf(std::nearbyint(steps) * ToHalf(0.0125)));
            }
            texel.z[layer] = std::move(sums);
        }
        return texel;
    }

    /// How far outputs may be from the model's, to first order, if the texel's inputs differ by `inputs` (in 1/127.5) and
    /// every hidden value is quantised once more in another arithmetic: both are rounded to 1/80, and the arguments of
    /// the roundings differ by binary16's errors in weights, sums and the activation.
    std::array<double, 16> GetBounds(const CudaTexel& texel, const std::array<double, 48>& inputs) const {
        std::array<double, 16> bounds{};
        for (std::size_t output = 0; output < 16; ++output) {
            bounds[output] = GetSumError(texel, 3, output);
            std::vector<double> gradient(
                layers_[3].weights.begin() + static_cast<long>(output * layers_[3].inputs),
                layers_[3].weights.begin() + static_cast<long>((output + 1) * layers_[3].inputs));
            for (std::size_t layer = 3; layer-- > 0;) {
                const RealLayer& real = layers_[layer];
                std::vector<double> next(real.inputs, 0.0);
                for (std::size_t i = 0; i < real.outputs; ++i) {
                    const double slope = GetSlope(texel.z[layer][i]);
                    // In 1/80: two roundings, y and 80 y in binary16 (2^-10 and 2^-4 at most), and the sum.
                    const double step =
                        1.0 + 80 * 0x1p-10 + 0x1p-4 + 80 * slope * GetSumError(texel, layer, i);
                    bounds[output] += std::fabs(gradient[i]) * step / 80;
                    for (std::size_t k = 0; k < real.inputs; ++k)
                        next[k] += gradient[i] * slope * real.Get(i, k);
                }
                gradient = std::move(next);
            }
            for (std::size_t k = 0; k < 48; ++k)
                bounds[output] += std::fabs(gradient[k]) * inputs[k] / 127.5;
        }
        return bounds;
    }

private:
    RealLayer MakeLayer(std::size_t layer) const {
        RealLayer real;
        real.inputs = static_cast<std::size_t>(network_.inputs[layer]);
        real.outputs = static_cast<std::size_t>(network_.outputs[layer]);
        const auto at = [](int offset, std::size_t index, std::size_t size) {
            return static_cast<std::size_t>(offset) + index * size;
        };
        for (std::size_t row = 0; row < real.outputs; ++row) {
            const double scale = static_cast<double>(
                LoadAt<float>(source_.weights, at(network_.int8ScaleOffsets[layer], row, 4)));
            double sum = 0;
            for (std::size_t i = 0; i < real.inputs; ++i) {
                const double weight = LoadAt<std::int8_t>(
                    source_.weights, at(network_.weightOffsets[layer], row * real.inputs + i, 1));
                sum += weight;
                real.weights.push_back(ToHalf(weight * scale * (layer == 0 ? 127.5 : 80.0)));
            }
            const double bias =
                LoadAt<std::int32_t>(source_.weights, at(network_.int8BiasOffsets[layer], row, 4));
            real.biases.push_back(ToHalf((layer == 0 ? bias : bias - 113 * sum) * scale));
        }
        return real;
    }

    static std::vector<double> Multiply(const RealLayer& layer, const std::vector<double>& x,
                                        std::vector<double>& magnitudes) {
        std::vector<double> sums;
        for (std::size_t row = 0; row < layer.outputs; ++row) {
            double sum = layer.biases[row];
            double magnitude = std::fabs(sum);
            for (std::size_t i = 0; i < layer.inputs; ++i) {
                sum += layer.Get(row, i) * x[i];
                magnitude += std::fabs(layer.Get(row, i) * x[i]);
                if (i % 16 == 15)
                    sum = ToHalf(sum);
            }
            sums.push_back(sum);
            magnitudes.push_back(magnitude);
        }
        return sums;
    }

    /// Of a sum against the exact one: half an ulp of binary16 for every weight and every stored input, for the bias, and
    /// for the sum after every 16 products.
    double GetSumError(const CudaTexel& texel, std::size_t layer, std::size_t row) const {
        const double chunks = static_cast<double>(layers_[layer].inputs) / 16;
        return (2 + chunks + 1) * 0x1p-11 * texel.magnitudes[layer][row];
    }

    /// Of the activation, the larger of the one-sided ones.
    static double GetSlope(double z) { return z < -1.5 || z > 3 ? 0.0 : z > 1.5 ? 1.0 : 2 * z / 3 + 0.5; }

    static double Quantise(double x) {
        return std::clamp(std::floor(ToHalf(ToHalf(x * 127.5) - 0.5)), -127.0, 127.0);
    }

    /// Slots without a feature, and the last two, are quantised like all others: a 0 becomes -1.
    std::array<double, 48> GetInputs(int mip, int x, int y) const {
        const openntc::NtcTextureSetConstants& c = *source_.constants;
        const openntc::NtcColorMipConstants& color = c.colorMips[mip];
        std::array<double, 48> inputs{};
        Sample(c.highResNeuralMips[color.neuralMip], mip, x, y, inputs.data());
        Sample(c.lowResNeuralMips[color.neuralMip], mip, x, y, inputs.data() + 16);
        for (std::size_t wave = 0; wave < 3; ++wave) {
            const float scale = color.positionScale * static_cast<float>(1 << wave);
            const float column = static_cast<float>(x) * scale;
            const float row = static_cast<float>(y) * scale;
            const float positions[4] = {column, row, column + 0.25f, row + 0.25f};
            for (std::size_t i = 0; i < 4; ++i)
                inputs[32 + 4 * wave + i] =
                    ToHalf(static_cast<double>(2 * (positions[i] - std::floor(positions[i])) - 1));
        }
        inputs[44] = inputs[45] = ToHalf(static_cast<double>(color.positionLod));
        for (double& input : inputs)
            input = Quantise(input);
        return inputs;
    }

    void Sample(const openntc::NtcNeuralMipConstants& grid, int mip, int x, int y, double* features) const {
        const openntc::NtcTextureSetConstants& c = *source_.constants;
        const int width = static_cast<int>(grid.imageWidthHeight & 0xFFFFu);
        const int height = static_cast<int>(grid.imageWidthHeight >> 16);
        const auto locate = [](int texel, int mipSize, int size) {
            return (static_cast<float>(texel) + 0.5f) / static_cast<float>(mipSize) *
                       static_cast<float>(size) -
                   0.5f;
        };
        const float u = locate(x, std::max(c.imageWidth >> mip, 1), width);
        const float v = locate(y, std::max(c.imageHeight >> mip, 1), height);
        const float dx = u - std::floor(u);
        const float dy = v - std::floor(v);
        const float weights[4] = {(1 - dx) * (1 - dy), dx * (1 - dy), (1 - dx) * dy, dx * dy};
        const int columns[2] = {(static_cast<int>(std::floor(u)) + width) % width,
                                (static_cast<int>(std::floor(u)) + 1) % width};
        const int rows[2] = {(static_cast<int>(std::floor(v)) + height) % height,
                             (static_cast<int>(std::floor(v)) + 1) % height};
        for (int feature = 0; feature < c.highResEncoding.numFeatures; ++feature) {
            double sum = 0;
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const int texel = (feature / 4 * height + rows[corner / 2]) * width + columns[corner % 2];
                const auto codes = LoadAt<std::uint16_t>(
                    source_.latents, grid.dataOffset + 2 * static_cast<std::size_t>(texel));
                const double value = ToHalf((codes >> (4 * (feature % 4)) & 15) / 15.0);
                sum = ToHalf(sum + value * ToHalf(static_cast<double>(weights[corner])));
            }
            features[feature] = ToHalf(2 * sum - 1);
        }
    }

    openntc::DecodeSource source_;
    openntc::NetworkDescription network_;
    std::array<RealLayer, 4> layers_;
};

} // namespace openntc_tests
