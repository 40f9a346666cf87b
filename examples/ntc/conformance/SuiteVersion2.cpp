// SPDX-License-Identifier: MIT
// The cases of the suite's version 2. Their files stay as they are: a test holds their checksums.
#include "SuiteBuilder.h"

#include "../Output.h"

#include "openntc/format/NetworkDescription.h"

#include <limits>

namespace openntc::conformance {

namespace {

void AddNetworks(SuiteBuilder& builder) {
    static constexpr LatentShape kShapes[4] = {
        {2, 4, 8, 2, 4}, {2, 8, 16, 8, 1}, {3, 12, 12, 4, 8}, {2, 16, 16, 1, 2}};
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        SynthesisDesc synthesis =
            Describe(100 + static_cast<std::uint32_t>(version), 12, 10, 3, kShapes[version - 1], version);
        synthesis.withFP8 = true;
        const std::string name = std::string("network-") + GetNetworkName(version);
        builder.AddSet(name, SynthesizeBytes(synthesis));
        for (const DecodeMath math :
             {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP8, DecodeMath::FP16, DecodeMath::FP32})
            builder.AddCase(name + "-" + tool::GetName(math), math, builder.ListAllTexels(),
                            std::string("the ") + GetNetworkName(version) + " network in maths mode " +
                                tool::GetName(math));
        builder.AddHardwareCase(name + "-fp8-hardware", builder.ListAllTexels(3),
                                std::string("the ") + GetNetworkName(version) +
                                    " network as FP8 hardware may evaluate it");
    }
    SynthesisDesc synthesis = Describe(110, 12, 10, 2, {2, 8, 16, 2, 4});
    synthesis.withInt8 = false;
    synthesis.withFP8 = true;
    builder.AddSet("fp8-only", SynthesizeBytes(synthesis));
    builder.AddCase("fp8-only", DecodeMath::FP8, builder.ListAllTexels(), "a file without Int8 weights");
}

void AddPlain(SuiteBuilder& builder) {
    SynthesisDesc synthesis = Describe(7, 25, 21, 4, kPlainShape);
    synthesis.withFP8 = true;
    builder.AddSet("plain", SynthesizeBytes(synthesis));
    builder.AddMistakeCase({Mistake::TruncatedRequantisation}, DecodeMath::Int8,
                           "activations become integers, rounded to the nearest");
    builder.AddMistakeCase({Mistake::WrappedTaps}, DecodeMath::Int8, "latents at the edges of the grids");
    builder.AddMistakeCase({Mistake::SwappedCorners}, DecodeMath::Int8,
                           "the four corners of high-resolution latents");
    builder.AddMistakeCase({Mistake::Offset112}, DecodeMath::Int8, "the activation's offset of -113");
    builder.AddMistakeCase({Mistake::RoundedWeights}, DecodeMath::Int8,
                           "bilinear weights in 256 parts, truncated");
    builder.AddMistakeCase({Mistake::TruncatedShift}, DecodeMath::Int8,
                           "weighted latents divided by 256, rounded down");
    builder.AddMistakeCase({Mistake::SeparateLowResShifts}, DecodeMath::Int8,
                           "the sum of low-resolution corners, shifted once");
    builder.AddMistakeCase({Mistake::RoundedWaves}, DecodeMath::Int8,
                           "positional inputs: order, phase, truncation");
    builder.AddMistakeCase({Mistake::HalfTexelWaves}, DecodeMath::Int8,
                           "positional inputs: which position they take");
    builder.AddMistakeCase({Mistake::Contraction}, DecodeMath::Int8Half,
                           "every operation of the activation rounded by itself");
    builder.AddMistakeCase({Mistake::HalfAwayTies}, DecodeMath::Int8Half,
                           "activations at exact ties, rounded to even");
    builder.AddMistakeCase({Mistake::UnroundedHalfOutputs}, DecodeMath::Int8Half,
                           "outputs of the half epilogue, rounded to binary16");
    builder.AddMistakeCase({Mistake::FP8SubnormalsFlushed}, DecodeMath::FP8, "E4M3 numbers below 2^-6");
    builder.AddCase("whole-mip", DecodeMath::Int8, builder.ListTexels(1, 1), "a whole mip in one request")
        .wholeMip = true;
}

void AddLatents(SuiteBuilder& builder) {
    std::uint32_t seed = 200;
    for (const int high : {1, 2, 4, 8}) {
        for (const int low : {1, 2, 4, 8}) {
            const std::string name = tool::Format("latents-%dx%d", high, low);
            builder.AddSet(name, SynthesizeBytes(Describe(seed++, 12, 10, 2, {2, 4, 8, high, low})));
            if (high == 1 && low == 1)
                builder.AddMistakeCase({Mistake::WrongBitOrder}, DecodeMath::Int8,
                                       "latents of 1 and 1 bits, lowest bits first");
            else
                builder.AddCase(name, DecodeMath::Int8, builder.ListAllTexels(2),
                                tool::Format("latents of %d and %d bits", high, low));
        }
    }
    builder.AddSet("unused-slots",
                   SynthesizeBytes(Describe(220, 12, 10, 2, {2, 4, 4, 4, 4}, NTC_NETWORK_XLARGE)));
    builder.AddMistakeCase({Mistake::UnusedSlotsNotZeroed}, DecodeMath::Int8,
                           "inputs of features that the set does not have");

    EditableSet set = SynthesizeEditableSet(Describe(221, 12, 10, 2, {2, 4, 4, 8, 8}));
    for (EditableSet::Latents& latents : set.latents) {
        for (std::vector<std::byte>* codes : {&latents.highRes, &latents.lowRes}) {
            for (std::size_t i = 0; i < codes->size(); i += 3)
                (*codes)[i] = static_cast<std::byte>(254 + i / 3 % 2);
        }
    }
    builder.AddSet("latent-codes-254-255", WriteSet(set));
    builder.AddMistakeCase({Mistake::SaturatedLatents}, DecodeMath::Int8,
                           "the 8-bit codes 254 and 255: 128 and 129, wrapped after weighting");
}

void AddGeometry(SuiteBuilder& builder) {
    for (int scale = 2; scale <= 8; ++scale) {
        const std::string name = tool::Format("grid-scale-%d", scale);
        builder.AddSet(name, SynthesizeBytes(Describe(300 + static_cast<std::uint32_t>(scale), 48, 40, 5,
                                                      {scale, 4, 4, 2, 2})));
        builder.AddCase(name, DecodeMath::Int8, builder.ListAllTexels(29),
                        tool::Format("one latent pixel for %d x %d texels", scale, scale));
    }
    struct Size {
        int width, height, mips, stride;
    };
    static constexpr Size kSizes[] = {{1, 1, 1, 1},    {1, 64, 7, 2},    {64, 1, 7, 2},
                                      {94, 94, 7, 97}, {257, 33, 9, 89}, {4096, 2, 13, 151}};
    for (const Size& size : kSizes) {
        const std::string name = tool::Format("size-%dx%d", size.width, size.height);
        builder.AddSet(name,
                       SynthesizeBytes(Describe(310, size.width, size.height, size.mips, {4, 4, 4, 2, 2})));
        builder.AddCase(name, DecodeMath::Int8, builder.ListAllTexels(size.stride),
                        "grids of one latent pixel a side, slivers and odd sizes, mips to the last");
    }
    builder.AddSet("large-coordinates", SynthesizeBytes(Describe(320, 16381, 2, 1, {7, 4, 4, 1, 1})));
    builder.AddCase("large-coordinates", DecodeMath::Int8, builder.ListTexels(0, 0, 311),
                    "texels up to 16380: binary32 coordinates near the weights' resolution");
    builder.AddSet("texels-on-latents", SynthesizeBytes(Describe(321, 100, 37, 2, {4, 4, 4, 4, 4})));
    builder.AddMistakeCase({Mistake::ReorderedCoordinates}, DecodeMath::Int8,
                           "texels whose centre lies on a latent: the order of operations");
    builder.AddSet("lod-beyond-1", SynthesizeBytes(Describe(322, 32, 32, 6, {4, 4, 4, 2, 2})));
    builder.AddMistakeCase({Mistake::MissingLodClamp}, DecodeMath::Int8, "levels of detail beyond 1");

    EditableSet set = SynthesizeEditableSet(Describe(323, 64, 64, 4, {2, 4, 4, 2, 2}));
    set.mips[0].neuralMip = 1;
    set.mips[0].positionLod = 0.5f;
    set.mips[0].positionScale = 4.0f;
    builder.AddSet("latent-image-of-mip", WriteSet(set));
    builder.AddMistakeCase(
        {Mistake::FormulaLatentImage}, DecodeMath::Int8,
        "a mip whose latent image, level of detail and scale are not those of the formula");

    SynthesisDesc synthesis = Describe(324, 12, 10, 2, kPlainShape);
    synthesis.withFP8 = true;
    set = SynthesizeEditableSet(synthesis);
    set.mips[1].positionLod = 600.0f;
    builder.AddSet("fp8-saturation", WriteSet(set));
    builder.AddMistakeCase({Mistake::FP8SaturationMissing}, DecodeMath::FP8, "inputs beyond 448");
    builder.AddHardwareCase("fp8-saturation-hardware", builder.GetLastTexels(),
                            "inputs beyond 448, which hardware saturates too");
}

void AddNumbers(SuiteBuilder& builder) {
    EditableSet set = SynthesizeEditableSet(Describe(400, 12, 10, 2, kPlainShape));
    for (std::size_t row = 0; row < 64; row += 4) {
        // Sums that wrap, sums beyond the 24 bits of binary32, and the most negative one; scales that make them
        // numbers near 1.
        set.SetInt8Bias(0, row, std::numeric_limits<std::int32_t>::max() - 5000);
        set.SetInt8Scale(0, row, 0x1p-31f);
        set.SetInt8Bias(0, row + 1, (1 << 25) + 12345);
        set.SetInt8Scale(0, row + 1, 0x1p-25f);
        set.SetInt8Bias(0, row + 2, std::numeric_limits<std::int32_t>::min());
        set.SetInt8Scale(0, row + 2, -0x1p-30f);
    }
    builder.AddSet("accumulator", WriteSet(set));
    builder.AddMistakeCase({Mistake::NarrowAccumulator}, DecodeMath::Int8,
                           "sums that wrap, and sums beyond 24 bits");

    set = SynthesizeEditableSet(Describe(401, 12, 10, 2, kPlainShape));
    for (std::size_t layer = 0; layer < 3; ++layer) {
        for (std::size_t row = 0; row < 64; row += 3)
            set.SetInt8Scale(layer, row, row % 2 == 0 ? 1e6f : 3e38f);
    }
    builder.AddSet("overflow", WriteSet(set));
    builder.AddMistakeCase({Mistake::HalfInfinity}, DecodeMath::Int8Half,
                           "activations of -infinity in binary16");
    builder.AddCase("float-overflow", DecodeMath::Int8, builder.ListAllTexels(2),
                    "activations of +-infinity in binary32");

    set = SynthesizeEditableSet(Describe(402, 12, 10, 2, kPlainShape));
    for (std::size_t layer = 0; layer < 4; ++layer) {
        std::size_t i = 0;
        for (std::byte& weight : set.GetInt8Weights(layer))
            weight = static_cast<std::byte>(i++ % 3 == 0 ? 0x80
                                            : i % 3 == 0 ? 0x7F
                                                         : 0x81); // -128, 127, -127
    }
    builder.AddSet("weights-extreme", WriteSet(set));
    builder.AddCase("weights-extreme", DecodeMath::Int8, builder.ListAllTexels(2),
                    "weights of -128, -127 and 127");

    set = SynthesizeEditableSet(Describe(403, 12, 10, 2, kPlainShape));
    for (std::size_t layer = 0; layer < 4; ++layer) {
        const std::size_t rows = layer == 3 ? 16 : 64;
        for (std::size_t row = 0; row < rows; ++row)
            set.SetInt8Scale(layer, row,
                             row % 4 == 0   ? 0.0f
                             : row % 4 == 1 ? -set.GetInt8Scale(layer, row)
                                            : set.GetInt8Scale(layer, row));
    }
    builder.AddSet("scales", WriteSet(set));
    builder.AddCase("scales", DecodeMath::Int8, builder.ListAllTexels(2), "scales of zero and below");
    builder.AddCase("scales-half", DecodeMath::Int8Half, builder.ListAllTexels(2),
                    "scales of zero and below");

    set = SynthesizeEditableSet(Describe(404, 12, 10, 2, kPlainShape));
    for (std::size_t row = 0; row < 16; row += 2)
        set.SetInt8Scale(3, row, 0x1p-149f * static_cast<float>(1 + row));
    builder.AddSet("scales-subnormal", WriteSet(set));
    builder
        .AddCase("scales-subnormal", DecodeMath::Int8, builder.ListAllTexels(4),
                 "scales that a device may flush to zero; what they give is below 2^-118 either way")
        .mustPass = false;
}

void AddColors(SuiteBuilder& builder) {
    SynthesisDesc synthesis = Describe(500, 12, 10, 2, kPlainShape);
    for (std::uint32_t channel = 0; channel < 16; ++channel) // linear, sRGB, HLG in turn
        synthesis.channelColorSpaces |= channel % 3 << (2 * channel);
    builder.AddSet("colours", SynthesizeBytes(synthesis));
    builder.AddMistakeCase({Mistake::SrgbTwice}, DecodeMath::Int8, "sRGB converted to linear", true);
    builder.AddMistakeCase({Mistake::HlgWithoutSign}, DecodeMath::Int8,
                           "HLG converted to linear, negative values too", true);
    builder
        .AddCase("linear-half", DecodeMath::Int8Half, builder.ListAllTexels(2),
                 "conversion to linear behind the half epilogue")
        .linear = true;
    builder.AddCase("stored-colours", DecodeMath::Int8, builder.ListAllTexels(2),
                    "outputs in storage colour space stay as they are");
}

} // namespace

void AddVersion2(SuiteBuilder& builder) {
    AddNetworks(builder);
    AddPlain(builder);
    AddLatents(builder);
    AddGeometry(builder);
    AddNumbers(builder);
    AddColors(builder);
}

} // namespace openntc::conformance
