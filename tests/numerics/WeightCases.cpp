// SPDX-License-Identifier: MIT
// Latent codes, network weights, accumulators and scales at their bounds.
#include "Decoders.h"
#include "HardCases.h"

#include "openntc/core/Stream.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace numerics {

namespace {

using namespace openntc;

SynthesisDesc Describe(const LatentShape& shape, int width = 12, int height = 10) {
    SynthesisDesc synthesis;
    synthesis.seed = 77;
    synthesis.desc = {width, height, 16, 2};
    synthesis.shape = shape;
    synthesis.networkVersion = NTC_NETWORK_SMALL;
    return synthesis;
}

double CompareModes(const conformance::EditableSet& set) {
    const TestSet written(conformance::WriteSet(set));
    const std::vector<Texel> texels = written.ListTexels(5);
    return std::max(Compare(written, DecodeMath::Int8, texels),
                    Compare(written, DecodeMath::Int8Half, texels));
}

// Every code of every width in both grids: the codes of 8 bits need 256 latents.
Measurement MeasureLatentCodes() {
    double worst = 0;
    for (const int bits : {1, 2, 4, 8}) {
        conformance::EditableSet set =
            conformance::SynthesizeEditableSet(Describe({2, 4, 4, bits, bits}, 34, 30));
        for (conformance::EditableSet::Latents& latents : set.latents) {
            std::uint8_t value = 0;
            for (std::vector<std::byte>* codes : {&latents.highRes, &latents.lowRes}) {
                for (std::byte& code : *codes)
                    code = static_cast<std::byte>(value += 37); // odd: all 256 bytes
            }
        }
        const TestSet written(conformance::WriteSet(set));
        worst = std::max(worst, Compare(written, DecodeMath::Int8, written.ListTexels(4)));
    }
    return {worst, {}};
}

Measurement MeasureExtremeWeights() {
    double worst = 0;
    for (const int first : {-128, -127, 127}) {
        conformance::EditableSet set = conformance::SynthesizeEditableSet(Describe({2, 4, 16, 8, 8}));
        for (std::size_t layer = 0; layer < 4; ++layer) {
            int sign = 1;
            std::size_t i = 0;
            for (std::byte& weight : set.GetInt8Weights(layer)) {
                weight = static_cast<std::byte>((i++ % 5 == 0 ? first : sign * 127) & 255);
                sign = i % 3 == 0 ? -sign : sign;
            }
        }
        worst = std::max(worst, CompareModes(set));
    }
    return {worst, {}};
}

Measurement MeasureAccumulators() {
    constexpr int kMax = std::numeric_limits<std::int32_t>::max();
    constexpr int kMin = std::numeric_limits<std::int32_t>::min();
    conformance::EditableSet set = conformance::SynthesizeEditableSet(Describe({2, 4, 16, 8, 8}));
    const std::pair<int, float> kRows[] = {
        {kMax, 0x1p-31f},    {kMax - 10000, -0x1p-30f}, {kMin, 0x1p-31f},          {kMin + 777, 0x1p-29f},
        {1 << 24, 0x1p-24f}, {(1 << 24) + 1, 0x1p-24f}, {-(1 << 26) - 3, 0x1p-26f}};
    for (std::size_t layer = 0; layer < 4; ++layer) {
        for (std::size_t row = 0; row < (layer == 3 ? 16u : 64u); ++row) {
            if (row % 8 == 7)
                continue;
            set.SetInt8Bias(layer, row, kRows[row % 8].first);
            set.SetInt8Scale(layer, row, kRows[row % 8].second);
        }
    }
    return {CompareModes(set), {}};
}

Measurement MeasureScales() {
    conformance::EditableSet set = conformance::SynthesizeEditableSet(Describe({2, 4, 16, 8, 8}));
    const float kScales[] = {0.0f, -0.0f, 3e38f, -3e38f, 1e6f, -1e6f, 0x1p-126f};
    for (std::size_t layer = 0; layer < 3; ++layer) {
        for (std::size_t row = 0; row < 64; row += 3)
            set.SetInt8Scale(layer, row, kScales[row % 7]);
    }
    for (std::size_t row = 0; row < 16; row += 2)
        set.SetInt8Scale(3, row, kScales[row / 2 % 7]);
    return {CompareModes(set), {}};
}

// A device may take a subnormal scale for zero. |sum| < 2^31, so what it loses is below 2^31 * 2^-126 = 2^-95.
Measurement MeasureSubnormalScales() {
    conformance::EditableSet set = conformance::SynthesizeEditableSet(Describe({2, 4, 16, 8, 8}));
    for (std::size_t row = 0; row < 16; ++row)
        set.SetInt8Scale(3, row, std::ldexp(1.0f, -149 + static_cast<int>(row)));
    return {CompareModes(set), {}};
}

// Scales that are not finite are refused at load: 1 for each that is accepted.
Measurement MeasureScalesNotFinite() {
    double accepted = 0;
    for (const float scale : {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN()}) {
        conformance::EditableSet set = conformance::SynthesizeEditableSet(Describe({2, 4, 4, 1, 1}));
        set.SetInt8Scale(1, 17, scale);
        const std::vector<std::byte> file = conformance::WriteSet(set);
        ReadOnlyMemoryStream stream(file);
        accepted += TextureSetMetadata::Load(stream) ? 1 : 0;
    }
    return {accepted, {}};
}

constexpr HardCase kWeightCases[] = {
    {"latent-codes",
     "Every code of 1, 2, 4 and 8 bits. The 8-bit codes 254 and 255 stand for 128 and 129, which are no "
     "signed bytes.",
     "Decoders that saturate them, or wrap them before weighting as the original's preloading pass does.",
     "The level is a plain integer; the weighted value wraps when it is packed.", 0, MeasureLatentCodes},
    {"extreme-weights", "Weights of -128, -127 and 127 against inputs at their bounds.",
     "Dot products by tricks: unsigned times signed with an offset, 16-bit intermediate sums (vpmaddubsw "
     "saturates).",
     "Kernels use forms that are exact for every pair of bytes.", 0, MeasureExtremeWeights},
    {"accumulators", "Biases at the ends of int32, sums that wrap, sums beyond the 24 bits of binary32.",
     "Saturating instructions (VPDPBUSDS), accumulation in floating point.",
     "Sums wrap; one conversion to binary32 rounds to nearest even.", 0, MeasureAccumulators},
    {"scales",
     "Scales of +-0, +-3e38, +-1e6 and 2^-126: activations of zero, infinity and NaN-free -infinity.",
     "-infinity * 0 = NaN in the activation, NaN to integer.",
     "z <= -1.5 and z >= 3 are settled by comparison before any multiplication.", 0, MeasureScales},
    {"subnormal-scales",
     "A device may flush subnormal scales to zero. Known limit: outputs below 2^-95 may then be 0; no file "
     "of an encoder "
     "has such scales.",
     "GPUs without denorm preservation in binary32.",
     "Not repaired: nothing that is displayed depends on it. Encoders bound their scales.", 0x1p-95,
     MeasureSubnormalScales},
    {"scales-not-finite", "Scales of NaN and +-infinity in the file.", "Everything behind them.",
     "The loader refuses such files.", 0, MeasureScalesNotFinite},
};

} // namespace

std::span<const HardCase> ListWeightCases() {
    return kWeightCases;
}

} // namespace numerics
