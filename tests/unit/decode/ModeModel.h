// SPDX-License-Identifier: MIT
// An independent model of the maths modes FP8, FP16 and FP32, written from the format specification and MathModes.h's
// definitions: plain loops over raw bytes in double, number formats by scaling and nearbyint. Shares no code with the
// shaders. Double holds every product and sum below exactly enough: rounding it to binary32 or binary16 once more gives
// the correctly rounded result, because 53 >= 2 * 24 + 2.
#pragma once

#include "openntc/InferenceConstants.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace test {

struct ModelSource {
    const openntc::NtcTextureSetConstants* constants;
    std::span<const std::byte> latents;
    std::span<const std::byte> weights;
    int networkVersion;
};

/// Nearest number with `precision` significant bits and no bits below 2^lowest, ties to even.
inline double RoundTo(double x, int precision, int lowest) {
    if (x == 0 || !std::isfinite(x))
        return x;
    int exponent = 0;
    std::frexp(x, &exponent);
    const int quantum = exponent - precision > lowest ? exponent - precision : lowest;
    return std::ldexp(std::nearbyint(std::ldexp(x, -quantum)), quantum);
}
inline double ToBinary32(double x) {
    return static_cast<double>(static_cast<float>(x));
}
inline double ToHalf(double x) {
    return RoundTo(x, 11, -24);
}
inline double ToE4M3(double x) {
    const double rounded = RoundTo(x, 4, -9);
    return rounded > 448 ? 448 : rounded < -448 ? -448 : rounded;
}
inline double E4M3Value(std::byte code) {
    const int bits = std::to_integer<int>(code);
    const int exponent = bits >> 3 & 15;
    const double magnitude =
        exponent == 0 ? std::ldexp(bits & 7, -9) : std::ldexp(8 + (bits & 7), exponent - 10);
    return (bits & 128) != 0 ? -magnitude : magnitude;
}
inline double HalfValue(std::uint16_t bits) {
    const int exponent = bits >> 10 & 31;
    const double magnitude =
        exponent == 0 ? std::ldexp(bits & 1023, -24) : std::ldexp(1024 + (bits & 1023), exponent - 25);
    return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

template <typename T>
T LoadAt(std::span<const std::byte> bytes, std::size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

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

inline ModelSample GetModelSample(const ModelSource& source, const openntc::NtcNeuralMipConstants& grid,
                                  const openntc::NtcLatentEncodingConstants& encoding, int x, int y,
                                  int mipWidth, int mipHeight) {
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
    const openntc::NtcTextureSetConstants& c = *source.constants;
    const openntc::NtcColorMipConstants& color = c.colorMips[mip];
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

struct ModelLayer {
    std::size_t weights, inputs, rows;
};

inline std::array<ModelLayer, 4> GetModelLayers(const ModelSource& source) {
    const openntc::NtcTextureSetConstants& c = *source.constants;
    const std::size_t inputs = static_cast<std::size_t>(32 + 16 * source.networkVersion);
    return {{{static_cast<std::size_t>(c.networkWeightOffset0), inputs, 64},
             {static_cast<std::size_t>(c.networkWeightOffset1), 64, 64},
             {static_cast<std::size_t>(c.networkWeightOffset2), 64, 64},
             {static_cast<std::size_t>(c.networkWeightOffset3), 64, 16}}};
}

inline int ModelInt8Weight(const ModelSource& source, const ModelLayer& layer, std::size_t row,
                           std::size_t i) {
    return LoadAt<std::int8_t>(source.weights, layer.weights + row * layer.inputs + i);
}

/// Inputs of the FP8 network (network 5), before their rounding to E4M3.
inline std::vector<double> GetFP8ModelInputs(const ModelSource& source, int mip, int x, int y) {
    const auto latent = [](int code, int bits) {
        const double levels = bits == 8 ? 127.5 : std::ldexp(1.0, bits - 1) + 0.5;
        const double step = ToBinary32(1 / levels);
        const double bias = ToBinary32((1.5 - levels) * step);
        return ToHalf(ToHalf(code * ToHalf(step)) + ToHalf(bias));
    };
    return GetModelInputs(source, mip, x, y, latent, ToHalf, ToHalf);
}

inline std::array<double, 16> EvaluateFP8OutputLayer(const ModelSource& source, std::span<const int> bytes) {
    const ModelLayer layer = GetModelLayers(source)[3];
    const std::size_t scales = static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 384;
    std::array<double, 16> outputs{};
    for (std::size_t row = 0; row < 16; ++row) {
        std::int64_t sum = LoadAt<std::int32_t>(source.weights, scales + 64 + 4 * row);
        for (std::size_t i = 0; i < 64; ++i)
            sum += ModelInt8Weight(source, layer, row, i) * bytes[i];
        const double scale = static_cast<double>(LoadAt<float>(source.weights, scales + 4 * row));
        outputs[row] = ToBinary32(ToBinary32(static_cast<double>(sum)) * scale);
    }
    return outputs;
}

/// FP8, to be equalled bit for bit.
inline std::array<double, 16> DecodeFP8Model(const ModelSource& source, int mip, int x, int y) {
    std::vector<double> inputs = GetFP8ModelInputs(source, mip, x, y);
    for (double& input : inputs)
        input = ToE4M3(input);
    std::vector<int> bytes;
    std::size_t biases = static_cast<std::size_t>(source.constants->networkScaleBiasOffset);
    for (std::size_t l = 0; l < 3; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<double> next;
        for (std::size_t row = 0; row < 64; ++row) {
            double sum = HalfValue(LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
            for (std::size_t i = 0; i < layer.inputs; ++i)
                sum = ToBinary32(sum + E4M3Value(source.weights[layer.weights + row * layer.inputs + i]) *
                                           inputs[i]);
            const double y16 = ModelActivationHalf(ToHalf(sum));
            next.push_back(ToE4M3(y16));
            if (l == 2)
                bytes.push_back(ModelQuantizeHalf(y16));
        }
        inputs = next;
        biases += 128;
    }
    return EvaluateFP8OutputLayer(source, bytes);
}

/// Bias of an Int8 row with the activation's offset taken out.
inline double GetUnfoldedBias(const ModelSource& source, std::size_t l, std::size_t row) {
    const ModelLayer layer = GetModelLayers(source)[l];
    const std::size_t at =
        static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 832 + 4 * (64 * l + row);
    double bias = LoadAt<std::int32_t>(source.weights, at);
    for (std::size_t i = 0; l > 0 && i < layer.inputs; ++i)
        bias -= 113.0 * ModelInt8Weight(source, layer, row, i);
    return bias;
}
inline double GetInt8Scale(const ModelSource& source, std::size_t l, std::size_t row) {
    const std::size_t at =
        static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 4 * (64 * l + row);
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

/// FP16, to be equalled bit for bit.
inline std::array<double, 16> DecodeFP16Model(const ModelSource& source, int mip, int x, int y) {
    std::vector<double> inputs = GetModelInputs(
        source, mip, x, y, [](int code, int bits) { return ModelLevel(code, bits) / 128; }, ToHalf,
        [](double e) { return ToHalf(ToBinary32(ClampToOne(e) * (127.5 / 128))); });
    for (std::size_t l = 0;; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<double> next;
        for (std::size_t row = 0; row < layer.rows; ++row) {
            double sum = 0;
            for (std::size_t block = 0; block < layer.inputs; block += 16) {
                std::array<double, 4> lanes{};
                for (std::size_t i = block; i < block + 16; ++i)
                    lanes[i % 4] =
                        ToHalf(lanes[i % 4] + ToHalf(ModelInt8Weight(source, layer, row, i) * inputs[i]));
                sum = ToHalf(sum + ToHalf(ToHalf(lanes[0] + lanes[1]) + ToHalf(lanes[2] + lanes[3])));
            }
            const double scale = GetInt8Scale(source, l, row);
            const double unit = l == 0 ? 128 : 80;
            const double product = ToHalf(ToBinary32(sum * ToBinary32(scale * unit)));
            const double shift = ToHalf(ToBinary32(ToBinary32(GetUnfoldedBias(source, l, row)) * scale));
            next.push_back(ToHalf(product + shift));
        }
        if (l == 3) {
            std::array<double, 16> outputs{};
            std::copy(next.begin(), next.end(), outputs.begin());
            return outputs;
        }
        for (double& z : next)
            z = z <= -1.5 ? 0 : ModelActivationHalf(z);
        inputs = next;
    }
}

/// FP32 in double, and how far a binary32 evaluation may be from it.
struct BoundedOutputs {
    std::array<double, 16> values;
    std::array<double, 16> bounds;
    std::array<double, 16> deviations; ///< standard deviation of the error if roundings were independent
};

/// The bound, with u = 2^-24 and first-order terms enlarged by 1 %:
/// - Inputs. A corner's weight has three roundings (1 - dx, 1 - dy, their product), the product with the latent one,
///   the blend three additions: |error| <= 7 u sum |v w|. A wave or level of detail: tri's subtractions and the product,
///   <= 4 u 127.5.
/// - Row. n products and n + 1 additions in any order: |error| <= (n + 2) u (sum |q X| + |B'|) + sum |q| |error of X|,
///   times S, plus u |z| for the last product and u |z| for rounding B'.
/// - Activation. |f'| <= 3/2. Rounded: c is 1/3 within u/2, then two roundings: gate within 2 u; y = z gate: 3 * 2 u + 3 u.
///   X = 80 y adds u 240: |error of X| <= 80 (3/2 |error of z| + 9 u) + 240 u.
/// It grows by sum |q| S, some 30, in every layer, which no real error does. So the same terms are also added up as
/// variances, as if roundings were independent: a yardstick for what to expect, not a bound.
inline BoundedOutputs DecodeFP32Model(const ModelSource& source, int mip, int x, int y) {
    constexpr double kUnit = 1.01 * 0x1p-24;
    const auto square = [](double value) { return value * value; };
    // The sum of the absolute terms is the sample of the absolute levels.
    const auto get = [&](auto level) {
        return GetModelInputs(
            source, mip, x, y, level, [](double value) { return value; },
            [](double e) { return 127.5 * ClampToOne(e); });
    };
    std::vector<double> inputs = get(ModelLevel);
    std::vector<double> errors = get([](int code, int bits) { return std::fabs(ModelLevel(code, bits)); });
    std::vector<double> variances;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const bool isLatent = i + 16 < errors.size();
        variances.push_back((isLatent ? 7 : 4) * square(kUnit * errors[i]));
        errors[i] = isLatent ? 7 * kUnit * errors[i] : 4 * kUnit * 127.5;
    }
    for (std::size_t l = 0;; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<double> next, nextErrors, nextVariances;
        for (std::size_t row = 0; row < layer.rows; ++row) {
            const double bias = GetUnfoldedBias(source, l, row);
            const double scale = GetInt8Scale(source, l, row);
            double sum = 0;
            double magnitude = std::fabs(bias);
            double error = 0;
            double variance = 0;
            for (std::size_t i = 0; i < layer.inputs; ++i) {
                const double q = ModelInt8Weight(source, layer, row, i);
                sum += q * inputs[i];
                magnitude += std::fabs(q * inputs[i]);
                error += std::fabs(q) * errors[i];
                variance += square(q) * variances[i] + square(kUnit * q * inputs[i]) + square(kUnit * sum);
            }
            sum += bias;
            error += static_cast<double>(layer.inputs + 2) * kUnit * magnitude;
            variance += square(kUnit * bias) + 2 * square(kUnit * sum);
            next.push_back(sum * scale);
            nextErrors.push_back(1.01 * (error * std::fabs(scale) + 2 * kUnit * std::fabs(sum * scale)));
            nextVariances.push_back(variance * square(scale));
        }
        if (l == 3) {
            BoundedOutputs result{};
            std::copy(next.begin(), next.end(), result.values.begin());
            std::copy(nextErrors.begin(), nextErrors.end(), result.bounds.begin());
            for (std::size_t i = 0; i < 16; ++i)
                result.deviations[i] = std::sqrt(nextVariances[i]);
            return result;
        }
        for (std::size_t i = 0; i < next.size(); ++i) {
            const double z = next[i];
            const double gate = z / 3 + 0.5;
            next[i] = 80 * (z < 3 ? z : 3) * (gate < 0 ? 0 : gate > 1 ? 1 : gate);
            nextErrors[i] = 80 * (1.5 * nextErrors[i] + 9 * kUnit) + 240 * kUnit;
            nextVariances[i] = square(80.0) * (square(1.5) * nextVariances[i] + 9 * square(kUnit * 3));
        }
        inputs = next;
        errors = nextErrors;
        variances = nextVariances;
    }
}

} // namespace test
