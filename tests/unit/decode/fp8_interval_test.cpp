// SPDX-License-Identifier: MIT
// The interval of possible FP8 results: emulated results lie in it, and so do sums in other orders.
#include "FP8Interval.h"
#include "ModeSets.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

namespace {

/// FP8 with sums from the last input to the first, bias last, in binary32, and the fused form of the activation: hardware
/// that differs in everything it may.
std::array<double, 16> DecodeOtherWay(const test::ModelSource& source, int mip, int x, int y) {
    std::vector<double> inputs = test::GetFP8ModelInputs(source, mip, x, y);
    std::vector<int> bytes;
    std::size_t biases = static_cast<std::size_t>(source.constants->networkScaleBiasOffset);
    for (std::size_t l = 0; l < 3; ++l) {
        const test::ModelLayer layer = test::GetModelLayers(source)[l];
        std::vector<double> next;
        for (std::size_t row = 0; row < 64; ++row) {
            double sum = 0;
            for (std::size_t i = layer.inputs; i-- > 0;)
                sum = test::ToBinary32(
                    sum + test::E4M3Value(source.weights[layer.weights + row * layer.inputs + i]) *
                              test::ToE4M3(inputs[i]));
            sum += test::HalfValue(test::LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
            const double z = test::ToHalf(test::ToBinary32(sum));
            const double gate = test::ToHalf(test::HalfValue(0x3555) * z + 0.5);
            const double y16 = test::ToHalf(std::min(z, 3.0) * std::clamp(gate, 0.0, 1.0));
            next.push_back(y16);
            if (l == 2)
                bytes.push_back(static_cast<int>(std::nearbyint(test::ToHalf(y16 * 80 - 113))));
        }
        inputs = next;
        biases += 128;
    }
    return test::EvaluateFP8OutputLayer(source, bytes);
}

} // namespace

TEST_CASE("emulated FP8 and other orders of summation lie in the derived interval, every network") {
    const test::FP8Interval interval(0x1p-24);
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        CAPTURE(version);
        const test::ModeSet set = test::MakeModeSet(version, 27, 22);
        const openntc::DecodeSource source = set.GetSource(openntc::DecodeWeights::FP8);
        const test::ModelSource model = {source.constants, source.latents, source.weights,
                                         source.networkVersion};
        std::vector<float> outputs(std::size_t{27 * 22 * 16});
        REQUIRE(openntc::DecodeReference(source, 0, {0, 0, 27, 22},
                                         {.math = openntc::DecodeMath::FP8, .convertToLinear = false},
                                         outputs));
        int outside = 0;
        int otherOutside = 0;
        int otherDifferent = 0;
        std::vector<double> widths;
        for (std::size_t i = 0; i < outputs.size(); i += 16) {
            const int x = static_cast<int>(i / 16 % 27);
            const int y = static_cast<int>(i / 16 / 27);
            const auto bounds = interval.Decode(model, 0, x, y);
            const auto other = DecodeOtherWay(model, 0, x, y);
            for (std::size_t c = 0; c < 16; ++c) {
                const double value = static_cast<double>(outputs[i + c]);
                outside += value < bounds[c].low || value > bounds[c].high;
                otherOutside += other[c] < bounds[c].low || other[c] > bounds[c].high;
                otherDifferent += other[c] != value;
                widths.push_back(bounds[c].high - bounds[c].low);
            }
        }
        std::sort(widths.begin(), widths.end());
        MESSAGE("network " << version << ": width of the interval, median " << widths[widths.size() / 2]
                           << ", p99 " << widths[widths.size() * 99 / 100] << ", largest " << widths.back()
                           << "; other order differs in " << otherDifferent << " of " << widths.size());
        CHECK(outside == 0);
        CHECK(otherOutside == 0);
        CHECK(otherDifferent > 0); // the other way is another way
    }
}
