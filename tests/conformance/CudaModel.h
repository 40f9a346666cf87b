// SPDX-License-Identifier: MIT
// LibNTC's CUDA decoder of generation 3 with Int8 or FP8 weights (format specification, generations 10, network 10):
// binary16 nearly everywhere. Which sums are rounded when is the tensor cores' business; here after every 16 products. And
// how far the exact decoders may be from it.
#pragma once

#include "models/NumberFormats.h"
#include "openntc/decode/DecodeTypes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace openntc_tests {

using openntc::models::E4M3Value;
using openntc::models::HalfValue;
using openntc::models::LoadAt;
using openntc::models::ToE4M3;
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
    std::array<double, 48> inputs{};               ///< quantised: -127 … 127 in 1/127.5, or E4M3
    std::array<std::vector<double>, 3> z;          ///< before the activations
    std::array<std::vector<double>, 4> magnitudes; ///< sum of |weight · input| of every output
    std::array<double, 16> outputs{};
};

class CudaModel {
public:
    /// `wraps` false: latents are clamped to the grid, a mistake to compare with.
    explicit CudaModel(const openntc::DecodeSource& source, bool wraps = true)
        : source_(source), network_(openntc::GetNetworkDescription(source.networkVersion)),
          isFP8_(source.weightFormat == openntc::DecodeWeights::FP8), wraps_(wraps) {
        for (std::size_t layer = 0; layer < 4; ++layer)
            layers_[layer] = isFP8_ && layer < 3 ? MakeE4M3Layer(layer) : MakeInt8Layer(layer);
    }

    /// What one more unit of an input is: 1/127.5, or the spacing of E4M3 numbers.
    double GetInputStep(double input) const { return isFP8_ ? GetE4M3Spacing(input) : 1 / 127.5; }

    /// How far the contract's input may be from the model's, `own` and `input` being quantised.
    /// The model's latent, 2 sum - 1 in binary16, is off by 2^-12 each for codes, for the weights 2.5 times that, for four
    /// partial sums and (halved by the 2) for the result: 16 * 2^-12. Int8: the contract's two weights are multiples of 1/256,
    /// off by 2^-9 each, the latents beside each other by 1 at most: 255 * (2^-8 + 2^-9) = 1.5, and 127.5 times a number in
    /// binary16 another 2^-5 twice, so that two floors differ by 2 at most; of waves trunc(e) and floor(e - 1/2) do, too.
    /// FP8: the contract rounds to binary16 once, 2^-12; both are rounded to E4M3.
    double GetInputTolerance(double own, double input) const {
        return isFP8_ ? 17 * 0x1p-12 + (GetE4M3Spacing(own) + GetE4M3Spacing(input)) / 2
                      : 2 / 127.5 + 0x1p-11; // a byte / 127.5 is stored in binary16
    }

    CudaTexel Decode(int mip, int x, int y) const {
        CudaTexel texel;
        texel.inputs = GetInputs(mip, x, y);
        std::vector<double> values(texel.inputs.begin(), texel.inputs.end());
        for (std::size_t layer = 0; layer < 4; ++layer) {
            std::vector<double> sums = Multiply(layers_[layer], values, texel.magnitudes[layer]);
            if (layer == 3) {
                std::copy(sums.begin(), sums.end(), texel.outputs.begin());
                break;
            }
            values.clear();
            for (const double z : sums) {
                const double activated = Activate(z);
                values.push_back(RoundsToE4M3(layer)
                                     ? ToE4M3(activated)
                                     : ToHalf(std::nearbyint(ToHalf(activated * 80)) * ToHalf(0.0125)));
            }
            texel.z[layer] = std::move(sums);
        }
        return texel;
    }

    /// How far outputs may be from the model's, to first order, if the texel's inputs differ by `inputs` and every hidden
    /// value is quantised once more in another arithmetic: both are rounded to 1/80 or to E4M3, and the arguments of the
    /// roundings differ by binary16's errors in weights, sums and the activation.
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
                    bounds[output] +=
                        std::fabs(gradient[i]) *
                        GetHiddenError(layer, texel.z[layer][i], slope * GetSumError(texel, layer, i));
                    for (std::size_t k = 0; k < real.inputs; ++k)
                        next[k] += gradient[i] * slope * real.Get(i, k);
                }
                gradient = std::move(next);
            }
            for (std::size_t k = 0; k < 48; ++k)
                bounds[output] += std::fabs(gradient[k]) * inputs[k];
        }
        return bounds;
    }

private:
    bool RoundsToE4M3(std::size_t layer) const { return isFP8_ && layer < 2; }

    static double GetE4M3Spacing(double x) {
        int exponent = 0;
        std::frexp(x, &exponent);
        return x == 0 ? 0x1p-9 : std::max(0x1p-9, std::ldexp(1.0, exponent - 4));
    }

    static double Activate(double z) {
        return ToHalf(std::min(z, 3.0) * std::clamp(ToHalf(ToHalf(1.0 / 3) * z + 0.5), 0.0, 1.0));
    }

    /// Of a hidden value, `error` being that of its argument: two roundings, each by half a step, and y in binary16 (2^-10
    /// at most), of 1/80 also 80 y (2^-4 of a step).
    double GetHiddenError(std::size_t layer, double z, double error) const {
        error += 0x1p-10;
        return RoundsToE4M3(layer) ? GetE4M3Spacing(std::fabs(Activate(z)) + error) + error
                                   : (1.0 + 0x1p-4) / 80 + error;
    }

    static std::size_t At(int offset, std::size_t index, std::size_t size) {
        return static_cast<std::size_t>(offset) + index * size;
    }

    RealLayer MakeEmptyLayer(std::size_t layer) const {
        RealLayer real;
        real.inputs = static_cast<std::size_t>(network_.inputs[layer]);
        real.outputs = static_cast<std::size_t>(network_.outputs[layer]);
        return real;
    }

    RealLayer MakeE4M3Layer(std::size_t layer) const {
        RealLayer real = MakeEmptyLayer(layer);
        for (std::size_t row = 0; row < real.outputs; ++row) {
            for (std::size_t i = 0; i < real.inputs; ++i)
                real.weights.push_back(
                    E4M3Value(source_.weights[At(network_.weightOffsets[layer], row * real.inputs + i, 1)]));
            real.biases.push_back(HalfValue(
                LoadAt<std::uint16_t>(source_.weights, At(network_.fp8BiasOffsets[layer], row, 2))));
        }
        return real;
    }

    RealLayer MakeInt8Layer(std::size_t layer) const {
        RealLayer real = MakeEmptyLayer(layer);
        const int scales = isFP8_ ? network_.fp8ScaleOffset : network_.int8ScaleOffsets[layer];
        const int biases = isFP8_ ? network_.fp8BiasOffsets[layer] : network_.int8BiasOffsets[layer];
        for (std::size_t row = 0; row < real.outputs; ++row) {
            const double scale = static_cast<double>(LoadAt<float>(source_.weights, At(scales, row, 4)));
            double sum = 0;
            for (std::size_t i = 0; i < real.inputs; ++i) {
                const double weight = LoadAt<std::int8_t>(
                    source_.weights, At(network_.weightOffsets[layer], row * real.inputs + i, 1));
                sum += weight;
                real.weights.push_back(ToHalf(weight * scale * (layer == 0 ? 127.5 : 80.0)));
            }
            const double bias = LoadAt<std::int32_t>(source_.weights, At(biases, row, 4));
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

    double Quantise(double x) const {
        if (isFP8_)
            return ToE4M3(x);
        const double byte = std::clamp(std::floor(ToHalf(ToHalf(x * 127.5) - 0.5)), -127.0, 127.0);
        return ToHalf(byte * ToHalf(1 / 127.5));
    }

    /// Slots without a feature, and the last two, are quantised like all others: with Int8 a 0 becomes -1.
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
        const auto address = [this](float at, int size) {
            const int index = static_cast<int>(at);
            return wraps_ ? (index + size) % size : std::clamp(index, 0, size - 1);
        };
        const int columns[2] = {address(std::floor(u), width), address(std::floor(u) + 1, width)};
        const int rows[2] = {address(std::floor(v), height), address(std::floor(v) + 1, height)};
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
    bool isFP8_;
    bool wraps_;
    std::array<RealLayer, 4> layers_;
};

} // namespace openntc_tests
