// SPDX-License-Identifier: MIT
// Numbers in brackets are sections of the format specification's network document; "latents" names the other one.
// Doubles hold products of two binary32 numbers exactly, and since 53 >= 2 * 24 + 2 a sum, product or quotient of
// binary32 numbers rounded to double and then to binary32 is rounded correctly.
#include "Model.h"

#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace openntc::conformance {

namespace {

// Nearest number with `precision` significant bits and no bits below 2^lowest, ties to even.
double RoundTo(double x, int precision, int lowest) {
    if (x == 0 || !std::isfinite(x))
        return x;
    const auto getPower = [](int exponent) {
        return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
    };
    const int exponent = static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 52 & 0x7FF) - 1022;
    const int quantum = std::max(exponent - precision, lowest);
    return std::nearbyint(x * getPower(-quantum)) * getPower(quantum); // both products are exact
}

double WidenE4M3(unsigned code) {
    const int exponent = static_cast<int>(code >> 3 & 15);
    const int mantissa = static_cast<int>(code & 7);
    const double magnitude =
        exponent == 0 ? std::ldexp(mantissa, -9) : std::ldexp(8 + mantissa, exponent - 10);
    return (code & 128) != 0 ? -magnitude : magnitude;
}

int ToSignedByte(std::int64_t value) {
    const int low = static_cast<int>(value & 255);
    return low < 128 ? low : low - 256;
}

std::int32_t ToWrappedInt(std::int64_t value) {
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value)));
}

template <typename T>
T LoadAt(std::span<const std::byte> bytes, std::size_t at) {
    T value{};
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
}

std::size_t Index(int value) {
    return static_cast<std::size_t>(value);
}

// Position of a texel along one axis of a grid [2.1].
struct Axis {
    int first = 0;
    int second = 0;
    double fraction = 0;
    double opposite = 0;
};

Axis GetAxis(int texel, int mipSize, int gridSize, Mistake mistake) {
    const double u = RoundToBinary32((texel + 0.5) / mipSize);
    double position = RoundToBinary32(RoundToBinary32(u * gridSize) - 0.5);
    if (mistake == Mistake::Contraction)
        position = RoundToBinary32(u * gridSize - 0.5);
    if (mistake == Mistake::ReorderedCoordinates)
        position = RoundToBinary32(
            RoundToBinary32((texel + 0.5) * RoundToBinary32(static_cast<double>(gridSize) / mipSize)) - 0.5);
    const double cell = std::floor(position);
    const auto get = [&](double tap) {
        if (mistake == Mistake::WrappedTaps)
            return static_cast<int>(tap - std::floor(tap / gridSize) * gridSize);
        return static_cast<int>(std::clamp(tap, 0.0, static_cast<double>(gridSize - 1)));
    };
    const double fraction = RoundToBinary32(position - cell);
    return {get(cell), get(cell + 1), fraction, RoundToBinary32(1 - fraction)};
}

// Codes of the four corners, corner by corner, and their binary32 weights.
struct Sample {
    std::array<std::array<int, 16>, 4> codes{};
    std::array<double, 4> weights{};
};

struct Grid {
    const LatentGrid& grid;
    int features;
    int bits;
    int slots; // of the network: features and unused ones
};

int LoadCode(std::span<const std::byte> file, const Grid& grid, std::size_t element, Mistake mistake) {
    const std::size_t bit = element * Index(grid.bits);
    if (bit / 8 >= grid.grid.size)
        return 0;
    const int byte = std::to_integer<int>(file[static_cast<std::size_t>(grid.grid.offset) + bit / 8]);
    const int mask = (1 << grid.bits) - 1;
    const int shift = static_cast<int>(bit % 8);
    if (mistake == Mistake::WrongBitOrder)
        return byte >> (8 - grid.bits - shift) & mask;
    return byte >> shift & mask;
}

Sample GetSample(std::span<const std::byte> file, const Grid& grid, int x, int y, int mipWidth, int mipHeight,
                 Mistake mistake) {
    const Axis h = GetAxis(x, mipWidth, grid.grid.width, mistake);
    const Axis v = GetAxis(y, mipHeight, grid.grid.height, mistake);
    Sample sample;
    sample.weights = {RoundToBinary32(h.opposite * v.opposite), RoundToBinary32(h.fraction * v.opposite),
                      RoundToBinary32(h.opposite * v.fraction), RoundToBinary32(h.fraction * v.fraction)};
    const int count = mistake == Mistake::UnusedSlotsNotZeroed ? grid.slots : grid.features;
    for (int corner = 0; corner < 4; ++corner) {
        const int px = (corner & 1) != 0 ? h.second : h.first;
        const int py = (corner & 2) != 0 ? v.second : v.first;
        const std::size_t pixel = Index(py) * Index(grid.grid.width) + Index(px);
        for (int k = 0; k < count; ++k)
            sample.codes[Index(corner)][Index(k)] =
                LoadCode(file, grid, pixel * Index(grid.features) + Index(k), mistake);
    }
    if (mistake == Mistake::SwappedCorners)
        std::swap(sample.codes[1], sample.codes[2]);
    return sample;
}

double GetWave(double position, double frequency, double phase) {
    const double t = RoundToBinary32(position * frequency + phase);
    const double centred = RoundToBinary32(4 * RoundToBinary32(t - std::floor(t)) - 2);
    return RoundToBinary32(std::fabs(centred) - 1);
}

// Level of a code in units of 1/127.5 [latents 6.2].
int GetLevel(int code, int bits) {
    switch (bits) {
    case 1:
        return code * 85;
    case 2:
        return code * 51 - 51;
    case 4:
        return code * 15 - 105;
    default:
        return code - 126;
    }
}

double GetHalfLatent(int code, int bits) { // [latents 6.3]
    const double levels = bits == 8 ? 127.5 : std::ldexp(1.0, bits - 1) + 0.5;
    const double step = RoundToBinary32(1 / levels);
    const double bias = RoundToBinary32((1.5 - levels) * step);
    return RoundToHalf(RoundToHalf(code * RoundToHalf(step)) + RoundToHalf(bias));
}

class TexelDecoder {
public:
    TexelDecoder(const TextureSetMetadata& metadata, std::span<const std::byte> file, DecodeMath math,
                 Mistake mistake)
        : metadata_(metadata), file_(file), math_(math), mistake_(mistake),
          network_(GetNetworkDescription(metadata.GetNetworkVersion())),
          weights_(metadata.GetWeights().Get(math == DecodeMath::FP8 ? InferenceWeightType::GenericFP8
                                                                     : InferenceWeightType::GenericInt8)) {}

    std::array<double, 16> Decode(int mip, int x, int y) const {
        const std::vector<double> inputs = GetInputs(mip, x, y);
        switch (math_) {
        case DecodeMath::FP8:
            return EvaluateFP8(inputs);
        case DecodeMath::FP16:
            return EvaluateHalf(inputs);
        case DecodeMath::FP32:
            return EvaluateReal(inputs);
        default:
            return EvaluateInt8(inputs);
        }
    }

private:
    bool Makes(Mistake mistake) const { return mistake_ == mistake; }
    bool IsInt8() const { return math_ == DecodeMath::Int8 || math_ == DecodeMath::Int8Half; }

    // [3.1], [5] and the definitions of the maths modes.
    double WeightLatent(int code, int bits, double weight) const {
        switch (math_) {
        case DecodeMath::FP8:
            return RoundToHalf(GetHalfLatent(code, bits) * RoundToHalf(weight));
        case DecodeMath::FP16:
            return RoundToHalf(GetLevel(code, bits) / 128.0 * RoundToHalf(weight));
        case DecodeMath::FP32:
            return RoundToBinary32(GetLevel(code, bits) * weight);
        default:
            break;
        }
        const double parts = 256 * weight;
        int level = GetLevel(code, bits);
        if (Makes(Mistake::SaturatedLatents))
            level = std::min(level, 127);
        return level * (Makes(Mistake::RoundedWeights) ? std::nearbyint(parts) : std::trunc(parts));
    }

    double FinishLatent(double value) const {
        if (math_ == DecodeMath::FP8)
            return ToE4M3(value);
        if (!IsInt8())
            return value;
        const double shifted = value / 256;
        return ToSignedByte(static_cast<std::int64_t>(Makes(Mistake::TruncatedShift) ? std::trunc(shifted)
                                                                                     : std::floor(shifted)));
    }

    double AddLatents(double sum, double value) const {
        return math_ == DecodeMath::FP32                               ? RoundToBinary32(sum + value)
               : math_ == DecodeMath::FP16 || math_ == DecodeMath::FP8 ? RoundToHalf(sum + value)
                                                                       : sum + value;
    }

    double FinishWave(double e, bool isLod) const {
        if (math_ == DecodeMath::FP8)
            return ToE4M3(RoundToHalf(e));
        if (!IsInt8()) {
            if (isLod && !Makes(Mistake::MissingLodClamp))
                e = std::clamp(e, -1.0, 1.0);
            return math_ == DecodeMath::FP32 ? RoundToBinary32(e * 127.5)
                                             : RoundToHalf(RoundToBinary32(e * (127.5 / 128)));
        }
        double scaled = RoundToBinary32(e * 127.5);
        if (!Makes(Mistake::MissingLodClamp))
            scaled = std::clamp(scaled, -128.0, 127.0);
        return ToSignedByte(static_cast<std::int64_t>(Makes(Mistake::RoundedWaves) ? std::nearbyint(scaled)
                                                                                   : std::trunc(scaled)));
    }

    double ToE4M3(double x) const {
        if (Makes(Mistake::FP8SubnormalsFlushed) && std::fabs(x) < 0x1p-6)
            return 0;
        if (Makes(Mistake::FP8SaturationMissing) && std::fabs(x) >= 464)
            return std::numeric_limits<double>::quiet_NaN();
        return RoundToE4M3(x);
    }

    std::vector<double> GetInputs(int mip, int x, int y) const {
        const ColorMip& color = metadata_.GetColorMips()[Index(mip)];
        const TextureSetDesc& desc = metadata_.GetDesc();
        const LatentShape& shape = metadata_.GetLatentShape();
        const int width = std::max(desc.width >> mip, 1);
        const int height = std::max(desc.height >> mip, 1);
        const std::span<const LatentImage> images = metadata_.GetLatentImages();
        std::size_t image = Index(color.neuralMip);
        if (Makes(Mistake::FormulaLatentImage))
            image = std::min<std::size_t>(Index(std::max(mip - 2, 0)) / 2, images.size() - 1);
        const std::size_t slots = Index(network_.highResSlots);
        std::vector<double> inputs(4 * slots + 32, 0.0);

        const Grid high{images[image].highRes, shape.highResFeatures, shape.highResQuantBits,
                        network_.highResSlots};
        const Sample corners = GetSample(file_, high, x, y, width, height, mistake_);
        const int used = Makes(Mistake::UnusedSlotsNotZeroed) ? high.slots : high.features;
        for (std::size_t corner = 0; corner < 4; ++corner) {
            for (std::size_t k = 0; k < Index(used); ++k)
                inputs[corner * slots + k] =
                    FinishLatent(WeightLatent(corners.codes[corner][k], high.bits, corners.weights[corner]));
        }
        const Grid low{images[image].lowRes, shape.lowResFeatures, shape.lowResQuantBits, 16};
        const Sample blend = GetSample(file_, low, x, y, width, height, mistake_);
        const int lowUsed = Makes(Mistake::UnusedSlotsNotZeroed) ? low.slots : low.features;
        for (std::size_t k = 0; k < Index(lowUsed); ++k) {
            double sum = 0;
            for (std::size_t corner = 0; corner < 4; ++corner) {
                const double value = WeightLatent(blend.codes[corner][k], low.bits, blend.weights[corner]);
                sum = Makes(Mistake::SeparateLowResShifts) && IsInt8() ? sum + 256 * std::floor(value / 256)
                                                                       : AddLatents(sum, value);
            }
            inputs[4 * slots + k] = FinishLatent(sum);
        }
        const double half = Makes(Mistake::HalfTexelWaves) ? 0.5 : 0;
        const double scale = static_cast<double>(color.positionScale);
        const double qx = RoundToBinary32((x + half) * scale); // [2.2]
        const double qy = RoundToBinary32((y + half) * scale);
        for (std::size_t wave = 0; wave < 3; ++wave) {
            const double frequency = std::ldexp(1.0, static_cast<int>(wave) - 3);
            double* const out = &inputs[4 * slots + 16 + 4 * wave];
            out[0] = FinishWave(GetWave(qx, frequency, 0), false);
            out[1] = FinishWave(GetWave(qy, frequency, 0), false);
            out[2] = FinishWave(GetWave(qx, frequency, 0.25), false);
            out[3] = FinishWave(GetWave(qy, frequency, 0.25), false);
        }
        inputs[4 * slots + 28] = inputs[4 * slots + 29] =
            FinishWave(static_cast<double>(color.positionLod), true);
        return inputs;
    }

    int GetWeight(std::size_t layer, std::size_t row, std::size_t input) const {
        return LoadAt<std::int8_t>(weights_, Index(network_.weightOffsets[layer]) +
                                                 row * Index(network_.inputs[layer]) + input);
    }

    std::int32_t GetBias(std::size_t layer, std::size_t row) const {
        const int start =
            math_ == DecodeMath::FP8 ? network_.fp8BiasOffsets[3] : network_.int8BiasOffsets[layer];
        return LoadAt<std::int32_t>(weights_, Index(start) + 4 * row);
    }

    double GetScale(std::size_t layer, std::size_t row) const {
        const int start =
            math_ == DecodeMath::FP8 ? network_.fp8ScaleOffset : network_.int8ScaleOffsets[layer];
        return static_cast<double>(LoadAt<float>(weights_, Index(start) + 4 * row));
    }

    // Bias with the activation's offset of -113 taken out, wrapping.
    double GetUnfoldedBias(std::size_t layer, std::size_t row) const {
        std::int64_t bias = GetBias(layer, row);
        for (std::size_t i = 0; layer > 0 && i < Index(network_.inputs[layer]); ++i)
            bias -= 113 * GetWeight(layer, row, i);
        return ToWrappedInt(bias);
    }

    double EvaluateRow(std::size_t layer, std::size_t row, const std::vector<double>& inputs) const { // [3.2]
        std::int64_t sum = GetBias(layer, row);
        for (std::size_t i = 0; i < inputs.size(); ++i)
            sum += GetWeight(layer, row, i) * static_cast<std::int64_t>(inputs[i]);
        double accumulated = ToWrappedInt(sum);
        if (Makes(Mistake::NarrowAccumulator))
            accumulated = static_cast<double>(std::clamp<std::int64_t>(sum, -(1 << 24), 1 << 24));
        return RoundToBinary32(RoundToBinary32(accumulated) * GetScale(layer, row));
    }

    // HGELU-clamp [3.5], in binary16 or binary32. Infinities and NaN are settled by comparison first.
    double Activate(double z, bool half) const {
        if (Makes(Mistake::HalfInfinity) && half && std::isinf(z) && z < 0)
            return std::numeric_limits<double>::quiet_NaN();
        if (!(z > -1.5))
            return 0;
        if (z >= 3)
            return 3;
        const double third =
            half ? WidenHalf(0x3555) : static_cast<double>(std::bit_cast<float>(0x3eaaaaabu));
        const auto round = [half](double x) { return half ? RoundToHalf(x) : RoundToBinary32(x); };
        double gate = round(round(third * z) + 0.5);
        if (Makes(Mistake::Contraction))
            gate = round(std::fma(third, z, 0.5));
        return round(z * std::clamp(gate, 0.0, 1.0));
    }

    int Requantise(double y, bool half) const {
        if (std::isnan(y))
            return 0; // what conversion to integer makes of NaN under the rules of D3D
        const auto round = [half](double x) { return half ? RoundToHalf(x) : RoundToBinary32(x); };
        const double offset = Makes(Mistake::Offset112) ? -112 : -113;
        double t = round(round(y * 80) + offset);
        if (Makes(Mistake::Contraction))
            t = round(std::fma(y, 80, offset));
        if (Makes(Mistake::TruncatedRequantisation))
            return ToSignedByte(static_cast<int>(std::trunc(t)));
        if (Makes(Mistake::HalfAwayTies))
            return ToSignedByte(static_cast<int>(std::round(t)));
        return ToSignedByte(static_cast<int>(std::nearbyint(t)));
    }

    std::array<double, 16> EvaluateOutputs(const std::vector<double>& inputs, std::size_t layer) const {
        std::array<double, 16> outputs{};
        for (std::size_t row = 0; row < 16; ++row) {
            const double z = EvaluateRow(layer, row, inputs);
            const bool rounds = math_ == DecodeMath::Int8Half && !Makes(Mistake::UnroundedHalfOutputs);
            outputs[row] = rounds ? RoundToHalf(z) : z;
        }
        return outputs;
    }

    std::array<double, 16> EvaluateInt8(std::vector<double> inputs) const {
        const bool half = math_ == DecodeMath::Int8Half;
        for (std::size_t layer = 0; layer < 3; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < 64; ++row) {
                const double z = EvaluateRow(layer, row, inputs);
                next.push_back(Requantise(Activate(half ? RoundToHalf(z) : z, half), half));
            }
            inputs = std::move(next);
        }
        return EvaluateOutputs(inputs, 3);
    }

    std::array<double, 16> EvaluateFP8(std::vector<double> inputs) const { // [5]
        std::vector<double> bytes;
        for (std::size_t layer = 0; layer < 3; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < 64; ++row) {
                const std::size_t biases = Index(network_.fp8BiasOffsets[layer]);
                double sum = WidenHalf(LoadAt<std::uint16_t>(weights_, biases + 2 * row));
                const std::size_t at = Index(network_.weightOffsets[layer]) + row * inputs.size();
                for (std::size_t i = 0; i < inputs.size(); ++i)
                    sum = RoundToBinary32(sum +
                                          WidenE4M3(std::to_integer<unsigned>(weights_[at + i])) * inputs[i]);
                const double y = Activate(RoundToHalf(sum), true);
                next.push_back(ToE4M3(y));
                if (layer == 2)
                    bytes.push_back(Requantise(y, true));
            }
            inputs = std::move(next);
        }
        return EvaluateOutputs(bytes, 3);
    }

    std::array<double, 16> EvaluateReal(std::vector<double> inputs) const {
        for (std::size_t layer = 0;; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < Index(network_.outputs[layer]); ++row) {
                double sum = 0;
                for (std::size_t i = 0; i < inputs.size(); ++i) {
                    const double q = GetWeight(layer, row, i);
                    sum = Makes(Mistake::Contraction) ? RoundToBinary32(std::fma(q, inputs[i], sum))
                                                      : RoundToBinary32(sum + RoundToBinary32(q * inputs[i]));
                }
                sum = RoundToBinary32(sum + RoundToBinary32(GetUnfoldedBias(layer, row)));
                const double z = RoundToBinary32(sum * GetScale(layer, row));
                next.push_back(layer == 3 ? z : RoundToBinary32(80 * Activate(z, false)));
            }
            if (layer == 3)
                return ToArray(next);
            inputs = std::move(next);
        }
    }

    std::array<double, 16> EvaluateHalf(std::vector<double> inputs) const {
        for (std::size_t layer = 0;; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < Index(network_.outputs[layer]); ++row) {
                double sum = 0;
                for (std::size_t block = 0; block < inputs.size(); block += 16) {
                    std::array<double, 4> lanes{};
                    for (std::size_t i = block; i < block + 16; ++i)
                        lanes[i % 4] =
                            RoundToHalf(lanes[i % 4] + RoundToHalf(GetWeight(layer, row, i) * inputs[i]));
                    sum = RoundToHalf(sum + RoundToHalf(RoundToHalf(lanes[0] + lanes[1]) +
                                                        RoundToHalf(lanes[2] + lanes[3])));
                }
                const double scale = GetScale(layer, row);
                const double unit = layer == 0 ? 128 : 80;
                const double product = RoundToHalf(RoundToBinary32(sum * RoundToBinary32(scale * unit)));
                const double shift =
                    RoundToHalf(RoundToBinary32(RoundToBinary32(GetUnfoldedBias(layer, row)) * scale));
                const double z = RoundToHalf(product + shift);
                next.push_back(layer == 3 ? z : Activate(z, true));
            }
            if (layer == 3)
                return ToArray(next);
            inputs = std::move(next);
        }
    }

    static std::array<double, 16> ToArray(const std::vector<double>& values) {
        std::array<double, 16> outputs{};
        std::copy_n(values.begin(), 16, outputs.begin());
        return outputs;
    }

    const TextureSetMetadata& metadata_;
    std::span<const std::byte> file_;
    DecodeMath math_;
    Mistake mistake_;
    NetworkDescription network_;
    std::span<const std::byte> weights_;
};

} // namespace

double WidenHalf(unsigned code) {
    const int exponent = static_cast<int>(code >> 10 & 31);
    const int mantissa = static_cast<int>(code & 1023);
    const double magnitude =
        exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
    return (code & 0x8000) != 0 ? -magnitude : magnitude;
}

double RoundToBinary32(double x) {
    return static_cast<double>(static_cast<float>(x));
}

double RoundToHalf(double x) {
    const double rounded = RoundTo(x, 11, -24);
    return std::fabs(rounded) < 65520 ? rounded : std::isnan(x) ? x : std::copysign(HUGE_VAL, x);
}

double RoundToE4M3(double x) {
    return std::clamp(RoundTo(x, 4, -9), -448.0, 448.0);
}

double ConvertToLinear(double stored, ColorSpace colorSpace) {
    if (colorSpace == ColorSpace::sRGB)
        return stored <= 0.04045 ? stored / 12.92 : std::pow((stored + 0.055) / 1.055, 2.4);
    if (colorSpace == ColorSpace::HLG) {
        const double h = std::fabs(stored);
        const double e = h < 0.5 ? 4 * h * h : std::exp((h - 0.55991073) / 0.17883277) + 0.28466892;
        return stored < 0 ? -e : e;
    }
    return stored;
}

std::array<float, 16> Model::Decode(DecodeMath math, bool linear, int mip, int x, int y,
                                    Mistake mistake) const {
    const std::array<double, 16> stored = TexelDecoder(metadata_, file_, math, mistake).Decode(mip, x, y);
    std::array<float, 16> outputs{};
    for (std::size_t c = 0; c < 16; ++c) {
        double value = stored[c];
        if (linear) {
            const ColorSpace space =
                static_cast<ColorSpace>(metadata_.GetWeights().channelColorSpaces >> (2 * c) & 3u);
            value = ConvertToLinear(
                mistake == Mistake::HlgWithoutSign && space == ColorSpace::HLG ? std::fabs(value) : value,
                space);
            if (mistake == Mistake::SrgbTwice && space == ColorSpace::sRGB)
                value = ConvertToLinear(value, space);
        }
        outputs[c] = static_cast<float>(value);
    }
    return outputs;
}

} // namespace openntc::conformance
