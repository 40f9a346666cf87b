// SPDX-License-Identifier: MIT
// The interval of possible FP8 results: emulated results lie in it, and so do sums in other orders.
#include "ModeSets.h"
#include "models/FP8Interval.h"
#include "models/NumberFormats.h"

#include "openntc/core/Crc32.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/texture_set/LatentShape.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

namespace models = openntc::models;

namespace {

/// FP8 with sums from the last input to the first, bias last, in binary32, and the fused form of the activation: hardware
/// that differs in everything it may.
std::array<double, 16> DecodeOtherWay(const models::ModelSource& source, int mip, int x, int y) {
    std::vector<double> inputs = models::GetFP8ModelInputs(source, mip, x, y);
    std::vector<int> bytes;
    for (std::size_t l = 0; l < 3; ++l) {
        const models::ModelLayer layer = models::GetModelLayers(source)[l];
        const std::size_t biases =
            static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 2 * layer.firstRow;
        std::vector<double> next;
        for (std::size_t row = 0; row < layer.rows; ++row) {
            double sum = 0;
            for (std::size_t i = layer.inputs; i-- > 0;)
                sum = models::ToBinary32(
                    sum + models::E4M3Value(source.weights[layer.weights + row * layer.inputs + i]) *
                              models::ToE4M3(inputs[i]));
            sum += models::HalfValue(models::LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
            const double z = models::ToHalf(models::ToBinary32(sum));
            const double gate = models::ToHalf(models::HalfValue(0x3555) * z + 0.5);
            const double y16 = models::ToHalf(std::min(z, 3.0) * std::clamp(gate, 0.0, 1.0));
            next.push_back(y16);
            if (l == 2)
                bytes.push_back(static_cast<int>(std::nearbyint(models::ToHalf(y16 * 80 - 113))));
        }
        inputs = next;
    }
    return models::EvaluateFP8OutputLayer(source, bytes);
}

} // namespace

TEST_CASE("emulated FP8 and other orders of summation lie in the derived interval, every network") {
    const models::FP8Interval interval;
    const models::FP8Interval hulls({.branches = 1});
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_GENERATION_3; ++version) {
        CAPTURE(version);
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, 27, 22);
        const openntc::DecodeSource source = set.GetSource(openntc::DecodeWeights::FP8);
        const models::ModelSource model = {source.constants, source.latents, source.weights,
                                           source.networkVersion};
        std::vector<float> outputs(std::size_t{27 * 22 * 16});
        REQUIRE(openntc::DecodeReference(source, 0, {0, 0, 27, 22},
                                         {.math = openntc::DecodeMath::FP8, .convertToLinear = false},
                                         outputs));
        int outside = 0;
        int otherOutside = 0;
        int otherDifferent = 0;
        int wider = 0; // than without following networks one by one
        std::vector<double> widths;
        for (std::size_t i = 0; i < outputs.size(); i += 16) {
            const int x = static_cast<int>(i / 16 % 27);
            const int y = static_cast<int>(i / 16 / 27);
            const auto bounds = interval.Decode(model, 0, x, y);
            const auto hull = i % 128 == 0 ? hulls.Decode(model, 0, x, y) : bounds;
            const auto other = DecodeOtherWay(model, 0, x, y);
            for (std::size_t c = 0; c < 16; ++c) {
                const double value = static_cast<double>(outputs[i + c]);
                outside += value < bounds[c].low || value > bounds[c].high;
                otherOutside += other[c] < bounds[c].low || other[c] > bounds[c].high;
                otherDifferent += other[c] != value;
                wider += bounds[c].low < hull[c].low || bounds[c].high > hull[c].high;
                widths.push_back(bounds[c].high - bounds[c].low);
            }
        }
        std::sort(widths.begin(), widths.end());
        MESSAGE("network " << version << ": width of the interval, median " << widths[widths.size() / 2]
                           << ", p99 " << widths[widths.size() * 99 / 100] << ", largest " << widths.back()
                           << "; other order differs in " << otherDifferent << " of " << widths.size());
        CHECK(outside == 0);
        CHECK(otherOutside == 0);
        CHECK(wider == 0);
        CHECK(otherDifferent > 0); // the other way is another way
    }
}

// Recorded on an NVIDIA H100 (driver 580.159.04), cooperative vectors, by bench_gpu --size 256: the first row of texels of
// its synthesised sets. That driver widens E4M3 weights to halves, does not round activations to E4M3, and keeps sums as
// halves between blocks of 16 inputs.
TEST_CASE("the assumptions for an H100 leave one result, the one that it returned") {
    const models::FP8Interval interval({.halfInputs = true, .block = 16, .contraction = false});
    constexpr std::uint32_t kRecorded[] = {0xa54328de, 0x864d2b6a, 0xeb59bc51, 0x6eca632b};
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        CAPTURE(version);
        openntc::SynthesisDesc synthesis;
        synthesis.seed = 1;
        synthesis.desc = {256, 256, 16, 1};
        synthesis.networkVersion = version;
        synthesis.shape = openntc::PickLatentShape(4.0f, version)->shape;
        synthesis.withFP8 = true;
        openntc::MemoryStream stream;
        REQUIRE(openntc::SynthesizeTextureSet(stream, synthesis));
        const std::span<const std::byte> bytes = stream.GetBytes();
        const decode_test::ModeSet set({bytes.begin(), bytes.end()});
        const openntc::DecodeSource source = set.GetSource(openntc::DecodeWeights::FP8);
        std::vector<float> values;
        int open = 0;
        for (int x = 0; x < 256; ++x) {
            for (const models::Interval& bound : interval.Decode(
                     {source.constants, source.latents, source.weights, source.networkVersion}, 0, x, 0)) {
                open += bound.low != bound.high;
                values.push_back(static_cast<float>(bound.low));
            }
        }
        CHECK(open == 0);
        CHECK(openntc::Crc32(std::as_bytes(std::span(values))) == kRecorded[version - 1]);
    }
}
