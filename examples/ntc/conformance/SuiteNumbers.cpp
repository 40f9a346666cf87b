// SPDX-License-Identifier: MIT
// Weights, biases, scales, outputs, positions and colours at their ends.
#include "SuiteBuilder.h"

#include "openntc/format/NetworkDescription.h"

#include <cstring>
#include <limits>

namespace openntc::conformance {

namespace {

void AddPlainCases(SuiteBuilder& builder) {
    builder.SelectSet("plain");
    builder.AddMistakeCase({Mistake::ShortAccumulator, Mistake::SaturatedPairs, Mistake::UnsignedWeights,
                            Mistake::ColumnMajorWeights, Mistake::LayerScale, Mistake::MissingBiases},
                           DecodeMath::Int8, "sums of products, biases and scales", false, 6);
    builder.AddMistakeCase({Mistake::SwappedChannels, Mistake::ReversedColors, Mistake::RotatedChannels,
                            Mistake::ActivatedOutputs, Mistake::ClampedOutputs,
                            Mistake::HalfOutputsInFloatMode},
                           DecodeMath::Int8, "outputs: their order, their range, their format", false, 6);
    builder.AddMistakeCase({Mistake::NextMip}, DecodeMath::Int8, "which mip a texel is of");
    builder.AddMistakeCase({Mistake::FlippedRows, Mistake::TransposedTexels}, DecodeMath::Int8,
                           "where in its mip a texel is");
    builder.AddMistakeCase({Mistake::TruncatedE4M3, Mistake::E4M3TiesAway, Mistake::FP8HiddenE4M3},
                           DecodeMath::FP8, "conversion to E4M3, and what is not converted", false, 10);
    builder.SelectSet("overflow");
    builder.AddMistakeCase({Mistake::UnclampedActivation}, DecodeMath::Int8, "activations beyond 3");
}

// Sums at both ends of int32 and beyond 24 bits in every layer, with scales that make them numbers near 1.
void AddSums(SuiteBuilder& builder) {
    EditableSet set = SynthesizeEditableSet(Describe(900, 12, 10, 2, kPlainShape));
    constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
    constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
    for (std::size_t layer = 0; layer < 4; ++layer) {
        for (std::size_t row = 0; row < (layer == 3 ? 16u : 64u); row += 8) {
            const std::int32_t some = static_cast<std::int32_t>(row * 37);
            set.SetInt8Bias(layer, row, kMax - some);
            set.SetInt8Scale(layer, row, 0x1p-31f);
            set.SetInt8Bias(layer, row + 1, kMin + some);
            set.SetInt8Scale(layer, row + 1, -0x1p-31f);
            set.SetInt8Bias(layer, row + 2, (1 << 24) + 4001 + some);
            set.SetInt8Scale(layer, row + 2, 0x1p-24f);
            set.SetInt8Bias(layer, row + 3, -(1 << 27) - 4001 - some);
            set.SetInt8Scale(layer, row + 3, 0x1.8p-27f);
        }
        set.SetInt8Bias(layer, 0, kMax);
        set.SetInt8Bias(layer, 1, kMin);
    }
    builder.AddSet("sum-ends", WriteSet(set));
    builder.AddMistakeCase({Mistake::SaturatedAccumulator, Mistake::TruncatedSum}, DecodeMath::Int8,
                           "sums at the ends of int32 and beyond 24 bits, in every layer", false, 12);

    set = SynthesizeEditableSet(Describe(901, 12, 10, 2, kPlainShape));
    for (std::size_t layer = 0; layer < 4; ++layer) {
        std::size_t i = 0;
        for (std::byte& weight : set.GetInt8Weights(layer)) {
            if (++i % 5 == 0)
                weight = static_cast<std::byte>(i % 256);
        }
        constexpr float kGreatest = std::numeric_limits<float>::max();
        constexpr float kLeast = std::numeric_limits<float>::min();
        const float scales[] = {kGreatest, -kGreatest, kLeast, -kLeast, 0.0f, -0.0f, 65504.0f, 0x1p-14f};
        for (std::size_t row = 0; row < 8; ++row)
            set.SetInt8Scale(layer, row, scales[row]);
    }
    builder.AddSet("scale-ends", WriteSet(set));
    builder.AddCase("scale-ends", DecodeMath::Int8, builder.ListAllTexels(6),
                    "greatest and least scales in every layer, weights of every value");
    builder.AddCase("scale-ends-half", DecodeMath::Int8Half, builder.ListAllTexels(6),
                    "greatest and least scales in every layer, weights of every value");
}

void AddOutputs(SuiteBuilder& builder) {
    EditableSet set = SynthesizeEditableSet(Describe(910, 12, 10, 2, kPlainShape));
    struct Row {
        std::int32_t bias;
        float scale;
    };
    constexpr float kGreatest = std::numeric_limits<float>::max();
    // Infinite in binary32; the last finite and the first infinite half; ties of halves; least numbers; -0.
    static constexpr Row kRows[] = {
        {2, kGreatest}, {-2, kGreatest},     {65504, 1.0f},  {65519, 1.0f},  {65520, 1.0f},
        {-65520, 1.0f}, {16773119, 0x1p-8f}, {1, kGreatest}, {2049, 1.0f},   {2051, 1.0f},
        {-4098, 1.0f},  {4102, 1.0f},        {1, 0x1p-14f},  {1, 0x1p-126f}, {0, -1.0f},
    };
    const std::span<std::byte> weights = set.GetInt8Weights(3);
    for (std::size_t row = 0; row < std::size(kRows); ++row) {
        std::memset(weights.data() + 64 * row, 0, 64);
        set.SetInt8Bias(3, row, kRows[row].bias);
        set.SetInt8Scale(3, row, kRows[row].scale);
    }
    builder.AddSet("outputs-infinite", WriteSet(set));
    builder.AddMistakeCase({Mistake::InfinityAsNan, Mistake::InfinityAsMaximum}, DecodeMath::Int8,
                           "infinite outputs, the greatest and the least numbers", false, 8);
    builder.AddCase("outputs-infinite-half", DecodeMath::Int8Half, builder.ListAllTexels(11),
                    "outputs at the ends of binary16, at ties, and infinite");
}

void AddFP8(SuiteBuilder& builder) {
    SynthesisDesc synthesis = Describe(920, 12, 10, 2, kPlainShape);
    synthesis.withFP8 = true;
    EditableSet set = SynthesizeEditableSet(synthesis);
    const NetworkDescription network = GetNetworkDescription(set.weights.networkVersion);
    const std::span<std::byte> bytes = set.weights.fp8.AsSpan();
    for (std::size_t layer = 0; layer < 3; ++layer) {
        const auto columns = static_cast<std::size_t>(network.inputs[layer]);
        std::byte* weights = bytes.data() + network.weightOffsets[layer];
        for (std::size_t row = 0; row < 64; row += 4) { // every number of E4M3 in one row of four
            for (std::size_t i = 0; i < columns; ++i) {
                const std::size_t code = (row * columns / 4 + i) % 256;
                weights[row * columns + i] = static_cast<std::byte>((code & 127) == 127 ? code - 1 : code);
            }
        }
        static constexpr std::uint16_t kBiases[] = {0x7BFF, 0xFBFF, 0x0001, 0x8001,
                                                    0x03FF, 0x8000, 0x0400, 0xB555};
        for (std::size_t i = 0; i < std::size(kBiases); ++i)
            std::memcpy(bytes.data() + network.fp8BiasOffsets[layer] + 2 * (7 * i + 1), &kBiases[i], 2);
    }
    builder.AddSet("fp8-weights", WriteSet(set));
    builder.AddMistakeCase({Mistake::E4M3WeightsFlushed, Mistake::E5M2Weights}, DecodeMath::FP8,
                           "every E4M3 weight; biases at the ends of binary16", false, 12);
    synthesis = Describe(921, 16, 16, 5, {4, 4, 4, 2, 2});
    synthesis.withFP8 = true;
    builder.AddSet("fp8-lod", SynthesizeBytes(synthesis));
    builder.AddMistakeCase({Mistake::FP8LodClamped}, DecodeMath::FP8, "levels of detail beyond 1");
}

void AddPositions(SuiteBuilder& builder) {
    EditableSet set = SynthesizeEditableSet(Describe(930, 32, 20, 6, {2, 4, 4, 2, 4}));
    static constexpr float kLods[] = {-0.5f, 0.999f, 600.0f, -600.0f, 1e6f, 0.0f};
    static constexpr float kScales[] = {0.37f, 3.0f, 0x1p100f, -2.5f, 1e6f, 0.0f};
    for (std::size_t m = 0; m < set.mips.size(); ++m) {
        set.mips[m].positionLod = kLods[m];
        set.mips[m].positionScale = kScales[m];
    }
    builder.AddSet("positions", WriteSet(set));
    builder.AddMistakeCase({Mistake::FormulaPositions}, DecodeMath::Int8,
                           "levels of detail and position scales of any sign and size");
    builder.AddCase("positions-half", DecodeMath::Int8Half, builder.ListFewTexels(6),
                    "levels of detail and position scales of any sign and size");
}

void AddColorSpaces(SuiteBuilder& builder) {
    for (std::uint32_t set = 1; set <= 2; ++set) {
        SynthesisDesc synthesis = Describe(940 + set, 20, 16, 2, kPlainShape);
        for (std::uint32_t channel = 0; channel < 16; ++channel)
            synthesis.channelColorSpaces |= (channel + set) % 3 << (2 * channel);
        builder.AddSet(set == 1 ? "colours-1" : "colours-2", SynthesizeBytes(synthesis));
        if (set == 1) {
            builder.AddMistakeCase(
                {Mistake::SharedColorSpace, Mistake::ColorSpaceOfTexture, Mistake::Channel15Stored},
                DecodeMath::Int8, "colour spaces of each channel: sRGB, HLG, linear in turn", true, 8);
            builder.AddCurveCase({Mistake::Gamma22, Mistake::SrgbNegativeZero, Mistake::SrgbKnee},
                                 DecodeMath::Int8, "the sRGB curve: near the knee, negative, above 1");
        } else {
            builder.AddCurveCase({Mistake::HlgConstantA, Mistake::HlgConstantB, Mistake::HlgClamped},
                                 DecodeMath::Int8Half, "the HLG curve: HLG, linear, sRGB in turn");
        }
    }
}

} // namespace

void AddNumberEnds(SuiteBuilder& builder) {
    AddPlainCases(builder);
    AddSums(builder);
    AddOutputs(builder);
    AddFP8(builder);
    AddPositions(builder);
    AddColorSpaces(builder);
}

} // namespace openntc::conformance
