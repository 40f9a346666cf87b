// SPDX-License-Identifier: MIT
// The network by the independent model. Numbers in brackets are sections of the format specification's network document.
#include "ModelSet.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <limits>

namespace openntc::conformance {

namespace {

class Evaluator {
public:
    Evaluator(const ModelNetwork& network, int generation, DecodeMath math, Mistake mistake)
        : network_(network), generation_(generation), math_(math), mistake_(mistake) {}

    std::array<double, 16> Evaluate(std::vector<double> inputs) const {
        switch (math_) {
        case DecodeMath::FP8:
            return EvaluateFP8(std::move(inputs));
        case DecodeMath::FP16:
            return EvaluateHalf(std::move(inputs));
        case DecodeMath::FP32:
            return EvaluateReal(std::move(inputs));
        default:
            return EvaluateInt8(std::move(inputs));
        }
    }

private:
    bool Makes(Mistake mistake) const { return mistake_ == mistake; }

    std::size_t GetRows(std::size_t layer) const {
        if (generation_ == 3)
            return 64 - 16 * layer;
        return layer == 3 ? 16 : 64;
    }

    // Binary16 between the layers of Int8 networks: a maths mode, and what generation 2 has anyway.
    bool HasHalfEpilogue() const {
        if (math_ == DecodeMath::Int8Half)
            return true;
        return math_ == DecodeMath::Int8 &&
               (generation_ == 2 ? !Makes(Mistake::FloatEpilogueOfGeneration2)
                                 : generation_ == 3 && Makes(Mistake::HalfEpilogueOfGeneration3));
    }

    int GetWeight(std::size_t layer, std::size_t row, std::size_t input, std::size_t columns) const {
        if (Makes(Mistake::ColumnMajorWeights))
            return network_[layer].GetWeight(input * GetRows(layer) + row);
        const int weight = network_[layer].GetWeight(row * columns + input);
        if (Makes(Mistake::ClippedWeights))
            return std::max(weight, -127);
        return Makes(Mistake::UnsignedWeights) ? weight & 255 : weight;
    }
    double GetScale(std::size_t layer, std::size_t row) const {
        return static_cast<double>(network_[layer].scales[Makes(Mistake::LayerScale) ? 0 : row]);
    }
    std::int32_t GetBias(std::size_t layer, std::size_t row) const {
        return Makes(Mistake::MissingBiases) ? 0 : network_[layer].biases[row];
    }
    // Bias with the activation's offset of -113 taken out, wrapping.
    double GetUnfoldedBias(std::size_t layer, std::size_t row, std::size_t columns) const {
        std::int64_t bias = GetBias(layer, row);
        for (std::size_t i = 0; layer > 0 && i < columns; ++i)
            bias -= 113 * GetWeight(layer, row, i, columns);
        return ToWrappedInt(bias);
    }

    double EvaluateRow(std::size_t layer, std::size_t row, const std::vector<double>& inputs) const { // [3.2]
        std::int64_t sum = GetBias(layer, row);
        std::int64_t pair = 0;
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const std::int64_t input = static_cast<std::int64_t>(inputs[i]);
            const std::int64_t weight = GetWeight(layer, row, i, inputs.size());
            if (!Makes(Mistake::SaturatedPairs)) {
                sum += weight * input;
                continue;
            }
            // Unsigned times signed bytes with an offset of 128, in pairs of 16 bits.
            pair += weight * (input + 128);
            if (i % 2 == 1) {
                sum += std::clamp<std::int64_t>(pair, -32768, 32767);
                pair = 0;
            }
            sum -= 128 * weight;
        }
        double accumulated = ToWrappedInt(sum);
        if (Makes(Mistake::NarrowAccumulator))
            accumulated = static_cast<double>(std::clamp<std::int64_t>(sum, -(1 << 24), 1 << 24));
        if (Makes(Mistake::SaturatedAccumulator))
            accumulated = static_cast<double>(std::clamp<std::int64_t>(
                sum, std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max()));
        if (Makes(Mistake::ShortAccumulator))
            accumulated = static_cast<std::int16_t>(static_cast<std::uint64_t>(sum) & 0xFFFF);
        double real = RoundToBinary32(accumulated);
        if (Makes(Mistake::TruncatedSum) && std::fabs(real) > std::fabs(accumulated))
            real = static_cast<double>(std::nextafterf(static_cast<float>(real), 0.0f));
        return RoundToBinary32(real * GetScale(layer, row));
    }

    // HGELU-clamp [3.5], in binary16 or binary32. Infinities and NaN are settled by comparison first.
    double Activate(double z, bool half) const {
        if (Makes(Mistake::HalfInfinity) && half && std::isinf(z) && z < 0)
            return std::numeric_limits<double>::quiet_NaN();
        if (!(z > -1.5))
            return 0;
        if (z >= 3)
            return Makes(Mistake::UnclampedActivation) ? std::min(z, 1000.0) : 3;
        const double third =
            half ? WidenHalf(0x3555)
                 : static_cast<double>(std::bit_cast<float>(
                       generation_ == 3 && !Makes(Mistake::ExactThird) ? 0x3eaaaa9fu : 0x3eaaaaabu));
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
        if (generation_ == 3 && !half && !Makes(Mistake::OffsetBeforeRounding)) {
            const double steps = round(y * 80);
            const double whole = Makes(Mistake::TruncatedRequantisation) ? std::trunc(steps)
                                 : Makes(Mistake::HalfAwayTies)          ? std::round(steps)
                                                                         : std::nearbyint(steps);
            return ToSignedByte(static_cast<std::int64_t>(whole + offset));
        }
        double t = round(round(y * 80) + offset);
        if (Makes(Mistake::Contraction))
            t = round(std::fma(y, 80, offset));
        if (Makes(Mistake::TruncatedRequantisation))
            return ToSignedByte(static_cast<std::int64_t>(std::trunc(t)));
        if (Makes(Mistake::HalfAwayTies))
            return ToSignedByte(static_cast<std::int64_t>(std::round(t)));
        return ToSignedByte(static_cast<std::int64_t>(std::nearbyint(t)));
    }

    std::array<double, 16> EvaluateOutputs(const std::vector<double>& inputs) const {
        std::array<double, 16> outputs{};
        for (std::size_t row = 0; row < 16; ++row) {
            const double z = EvaluateRow(3, row, inputs);
            outputs[row] = z;
            if (Makes(Mistake::ActivatedOutputs))
                outputs[row] = Activate(z, HasHalfEpilogue());
            else if (HasHalfEpilogue() && Makes(Mistake::TruncatedHalfOutputs))
                outputs[row] = CutToHalf(z);
            else if ((HasHalfEpilogue() && !Makes(Mistake::UnroundedHalfOutputs)) ||
                     (math_ == DecodeMath::Int8 && Makes(Mistake::HalfOutputsInFloatMode)))
                outputs[row] = RoundToHalf(z);
        }
        return outputs;
    }

    std::array<double, 16> EvaluateInt8(std::vector<double> inputs) const {
        const bool half = HasHalfEpilogue();
        for (std::size_t layer = 0; layer < 3; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < GetRows(layer); ++row) {
                const double z = EvaluateRow(layer, row, inputs);
                next.push_back(Requantise(Activate(half ? RoundToHalf(z) : z, half), half));
            }
            inputs = std::move(next);
        }
        return EvaluateOutputs(inputs);
    }

    double GetE4M3Weight(unsigned code) const {
        if (Makes(Mistake::E4M3WeightsFlushed) && (code & 0x78) == 0)
            return 0;
        if (Makes(Mistake::E5M2Weights)) // the upper half of a binary16 number
            return (code & 0x7C) == 0x7C ? 0 : WidenHalf(code << 8);
        return WidenE4M3(code);
    }

    std::array<double, 16> EvaluateFP8(std::vector<double> inputs) const { // [5]
        std::vector<double> bytes;
        for (std::size_t layer = 0; layer < 3; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < GetRows(layer); ++row) {
                double sum = Makes(Mistake::MissingBiases) ? 0 : WidenHalf(network_[layer].halfBiases[row]);
                for (std::size_t i = 0; i < inputs.size(); ++i)
                    sum = RoundToBinary32(
                        sum + GetE4M3Weight(network_[layer].weights[row * inputs.size() + i]) * inputs[i]);
                const double y = Activate(RoundToHalf(sum), true);
                next.push_back(RoundToE4M3With(mistake_, y));
                if (layer == 2)
                    bytes.push_back(Requantise(Makes(Mistake::FP8HiddenE4M3) ? RoundToE4M3(y) : y, true));
            }
            inputs = std::move(next);
        }
        return EvaluateOutputs(bytes);
    }

    std::array<double, 16> EvaluateReal(std::vector<double> inputs) const {
        for (std::size_t layer = 0;; ++layer) {
            std::vector<double> next;
            for (std::size_t row = 0; row < GetRows(layer); ++row) {
                double sum = 0;
                for (std::size_t i = 0; i < inputs.size(); ++i) {
                    const double q = GetWeight(layer, row, i, inputs.size());
                    sum = Makes(Mistake::Contraction) ? RoundToBinary32(std::fma(q, inputs[i], sum))
                                                      : RoundToBinary32(sum + RoundToBinary32(q * inputs[i]));
                }
                sum = RoundToBinary32(sum + RoundToBinary32(GetUnfoldedBias(layer, row, inputs.size())));
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
            for (std::size_t row = 0; row < GetRows(layer); ++row) {
                double sum = 0;
                for (std::size_t block = 0; block < inputs.size(); block += 16) {
                    std::array<double, 4> lanes{};
                    for (std::size_t i = block; i < block + 16; ++i)
                        lanes[i % 4] = RoundToHalf(
                            lanes[i % 4] + RoundToHalf(GetWeight(layer, row, i, inputs.size()) * inputs[i]));
                    sum = RoundToHalf(sum + RoundToHalf(RoundToHalf(lanes[0] + lanes[1]) +
                                                        RoundToHalf(lanes[2] + lanes[3])));
                }
                const double scale = GetScale(layer, row);
                const double unit = layer == 0 ? 128 : 80;
                const double product = RoundToHalf(RoundToBinary32(sum * RoundToBinary32(scale * unit)));
                const double bias = RoundToBinary32(GetUnfoldedBias(layer, row, inputs.size()));
                const double z = RoundToHalf(product + RoundToHalf(RoundToBinary32(bias * scale)));
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

    const ModelNetwork& network_;
    int generation_;
    DecodeMath math_;
    Mistake mistake_;
};

} // namespace

std::array<double, 16> EvaluateModel(const ModelSet& set, const ModelRequest& request, Mistake mistake) {
    const std::optional<ModelNetwork>& network = request.math == DecodeMath::FP8 ? set.fp8 : set.int8;
    if (!network)
        std::abort(); // a caller's error: the set has no such weights
    return Evaluator(*network, set.generation, request.math, mistake)
        .Evaluate(GetModelInputs(set, request, mistake));
}

} // namespace openntc::conformance
