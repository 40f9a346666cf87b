// SPDX-License-Identifier: MIT
// What the exported suite consists of. A case is one line: name, set, maths mode, what it covers.
#include "EditableSet.h"
#include "Suite.h"

#include "../Output.h"

#include "openntc/core/Stream.h"
#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace openntc::conformance {

namespace {

/// Cases that exist for one mistake have that many texels, chosen among those that the mistake changes.
constexpr std::size_t kTexelsOfMistake = 24;

SynthesisDesc Describe(std::uint32_t seed, int width, int height, int mips, const LatentShape& shape,
                       int networkVersion = NTC_NETWORK_UNKNOWN) {
    SynthesisDesc synthesis;
    synthesis.seed = seed;
    synthesis.desc = {width, height, 16, mips};
    synthesis.shape = shape;
    synthesis.networkVersion = networkVersion;
    return synthesis;
}

class Builder {
public:
    Suite Take() { return std::move(suite_); }

    void AddSet(const std::string& name, std::vector<std::byte> bytes) {
        suite_.sets.push_back({name + ".ntc", std::move(bytes)});
        ReadOnlyMemoryStream stream(suite_.sets.back().bytes);
        Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
        if (!metadata)
            throw std::runtime_error(name + ": " + metadata.error().GetText());
        metadata_ = std::move(*metadata);
    }

    /// The cases below use the set that was added last. Every `stride`-th texel of the mips first ... last.
    std::vector<tool::Texel> ListTexels(int firstMip, int lastMip, int stride = 1) const {
        std::vector<tool::Texel> texels;
        int index = 0;
        for (int mip = firstMip; mip <= lastMip; ++mip) {
            const ColorMip& size = metadata_->GetColorMips()[static_cast<std::size_t>(mip)];
            for (int y = 0; y < size.height; ++y) {
                for (int x = 0; x < size.width; ++x) {
                    if (index++ % stride == 0 || (x + 1 == size.width && y + 1 == size.height))
                        texels.push_back({mip, x, y});
                }
            }
        }
        return texels;
    }
    std::vector<tool::Texel> ListAllTexels(int stride = 1) const {
        return ListTexels(0, metadata_->GetDesc().mips - 1, stride);
    }

    SuiteCase& AddCase(const std::string& name, DecodeMath math, std::vector<tool::Texel> texels,
                       const std::string& about) {
        SuiteCase suiteCase;
        suiteCase.name = name;
        suiteCase.set = suite_.sets.back().file;
        suiteCase.values = name + ".values";
        suiteCase.math = math;
        suiteCase.mustPass = math == DecodeMath::Int8 || math == DecodeMath::Int8Half;
        suiteCase.about = about;
        suite_.cases.push_back(suiteCase);
        suite_.texels.push_back(std::move(texels));
        return suite_.cases.back();
    }

    /// A case of texels that change when a decoder makes the mistake.
    void AddMistakeCase(Mistake mistake, DecodeMath math, bool linear = false) {
        const auto mistakes = ListMistakes();
        const auto info = std::find_if(mistakes.begin(), mistakes.end(),
                                       [&](const MistakeInfo& entry) { return entry.mistake == mistake; });
        const Model model(*metadata_, suite_.sets.back().bytes);
        const std::vector<tool::Texel> all = ListAllTexels();
        std::size_t step = 7; // spreads the choice over the image
        while (std::gcd(step, all.size()) != 1)
            ++step;
        std::vector<tool::Texel> chosen;
        for (std::size_t i = 0; i < all.size() && chosen.size() < kTexelsOfMistake; ++i) {
            const tool::Texel& texel = all[i * step % all.size()];
            const Outputs right = model.Decode(math, linear, texel.mip, texel.x, texel.y);
            const Outputs wrong = model.Decode(math, linear, texel.mip, texel.x, texel.y, mistake);
            for (std::size_t c = 0; c < 16; ++c) {
                const float change = std::fabs(right[c] - wrong[c]);
                if (!(change <= (linear ? 1e-3f * std::max(1.0f, std::fabs(right[c])) : 1e-30f))) {
                    chosen.push_back(texel);
                    break;
                }
            }
        }
        if (chosen.empty())
            throw std::runtime_error(std::string(info->name) + ": changes no texel of the set meant for it");
        AddCase(info->caseName, math, std::move(chosen), std::string("catches: ") + info->cause).linear =
            linear;
    }

    /// A case for FP8 hardware, which passes inside intervals.
    void AddHardwareCase(const std::string& name, std::vector<tool::Texel> texels, const std::string& about) {
        SuiteCase& suiteCase = AddCase(name, DecodeMath::FP8, std::move(texels), about);
        suiteCase.interval = true;
        suiteCase.mustPass = true;
    }
    /// The texels of the case that was added last.
    std::vector<tool::Texel> GetLastTexels() const { return suite_.texels.back(); }

private:
    Suite suite_;
    std::optional<TextureSetMetadata> metadata_;
};

constexpr LatentShape kPlainShape = {2, 8, 16, 2, 4};

void AddNetworks(Builder& builder) {
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

void AddPlain(Builder& builder) {
    SynthesisDesc synthesis = Describe(7, 25, 21, 4, kPlainShape);
    synthesis.withFP8 = true;
    builder.AddSet("plain", SynthesizeBytes(synthesis));
    for (const Mistake mistake :
         {Mistake::TruncatedRequantisation, Mistake::WrappedTaps, Mistake::SwappedCorners, Mistake::Offset112,
          Mistake::RoundedWeights, Mistake::TruncatedShift, Mistake::SeparateLowResShifts,
          Mistake::RoundedWaves, Mistake::HalfTexelWaves})
        builder.AddMistakeCase(mistake, DecodeMath::Int8);
    builder.AddMistakeCase(Mistake::Contraction, DecodeMath::Int8Half);
    builder.AddMistakeCase(Mistake::HalfAwayTies, DecodeMath::Int8Half);
    builder.AddMistakeCase(Mistake::UnroundedHalfOutputs, DecodeMath::Int8Half);
    builder.AddMistakeCase(Mistake::FP8SubnormalsFlushed, DecodeMath::FP8);
    builder.AddCase("whole-mip", DecodeMath::Int8, builder.ListTexels(1, 1), "a whole mip in one request")
        .wholeMip = true;
}

void AddLatents(Builder& builder) {
    std::uint32_t seed = 200;
    for (const int high : {1, 2, 4, 8}) {
        for (const int low : {1, 2, 4, 8}) {
            const std::string name = tool::Format("latents-%dx%d", high, low);
            builder.AddSet(name, SynthesizeBytes(Describe(seed++, 12, 10, 2, {2, 4, 8, high, low})));
            if (high == 1 && low == 1)
                builder.AddMistakeCase(Mistake::WrongBitOrder, DecodeMath::Int8);
            else
                builder.AddCase(name, DecodeMath::Int8, builder.ListAllTexels(2),
                                tool::Format("latents of %d and %d bits", high, low));
        }
    }
    builder.AddSet("unused-slots",
                   SynthesizeBytes(Describe(220, 12, 10, 2, {2, 4, 4, 4, 4}, NTC_NETWORK_XLARGE)));
    builder.AddMistakeCase(Mistake::UnusedSlotsNotZeroed, DecodeMath::Int8);

    EditableSet set = SynthesizeEditableSet(Describe(221, 12, 10, 2, {2, 4, 4, 8, 8}));
    for (EditableSet::Latents& latents : set.latents) {
        for (std::vector<std::byte>* codes : {&latents.highRes, &latents.lowRes}) {
            for (std::size_t i = 0; i < codes->size(); i += 3)
                (*codes)[i] = static_cast<std::byte>(254 + i / 3 % 2);
        }
    }
    builder.AddSet("latent-codes-254-255", WriteSet(set));
    builder.AddMistakeCase(Mistake::SaturatedLatents, DecodeMath::Int8);
}

void AddGeometry(Builder& builder) {
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
    builder.AddMistakeCase(Mistake::ReorderedCoordinates, DecodeMath::Int8);
    builder.AddSet("lod-beyond-1", SynthesizeBytes(Describe(322, 32, 32, 6, {4, 4, 4, 2, 2})));
    builder.AddMistakeCase(Mistake::MissingLodClamp, DecodeMath::Int8);

    EditableSet set = SynthesizeEditableSet(Describe(323, 64, 64, 4, {2, 4, 4, 2, 2}));
    set.mips[0].neuralMip = 1;
    set.mips[0].positionLod = 0.5f;
    set.mips[0].positionScale = 4.0f;
    builder.AddSet("latent-image-of-mip", WriteSet(set));
    builder.AddMistakeCase(Mistake::FormulaLatentImage, DecodeMath::Int8);

    SynthesisDesc synthesis = Describe(324, 12, 10, 2, kPlainShape);
    synthesis.withFP8 = true;
    set = SynthesizeEditableSet(synthesis);
    set.mips[1].positionLod = 600.0f;
    builder.AddSet("fp8-saturation", WriteSet(set));
    builder.AddMistakeCase(Mistake::FP8SaturationMissing, DecodeMath::FP8);
    builder.AddHardwareCase("fp8-saturation-hardware", builder.GetLastTexels(),
                            "inputs beyond 448, which hardware saturates too");
}

void AddNumbers(Builder& builder) {
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
    builder.AddMistakeCase(Mistake::NarrowAccumulator, DecodeMath::Int8);

    set = SynthesizeEditableSet(Describe(401, 12, 10, 2, kPlainShape));
    for (std::size_t layer = 0; layer < 3; ++layer) {
        for (std::size_t row = 0; row < 64; row += 3)
            set.SetInt8Scale(layer, row, row % 2 == 0 ? 1e6f : 3e38f);
    }
    builder.AddSet("overflow", WriteSet(set));
    builder.AddMistakeCase(Mistake::HalfInfinity, DecodeMath::Int8Half);
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

void AddColors(Builder& builder) {
    SynthesisDesc synthesis = Describe(500, 12, 10, 2, kPlainShape);
    for (std::uint32_t channel = 0; channel < 16; ++channel) // linear, sRGB, HLG in turn
        synthesis.channelColorSpaces |= channel % 3 << (2 * channel);
    builder.AddSet("colours", SynthesizeBytes(synthesis));
    builder.AddMistakeCase(Mistake::SrgbTwice, DecodeMath::Int8, true);
    builder.AddMistakeCase(Mistake::HlgWithoutSign, DecodeMath::Int8, true);
    builder
        .AddCase("linear-half", DecodeMath::Int8Half, builder.ListAllTexels(2),
                 "conversion to linear behind the half epilogue")
        .linear = true;
    builder.AddCase("stored-colours", DecodeMath::Int8, builder.ListAllTexels(2),
                    "outputs in storage colour space stay as they are");
}

} // namespace

Suite MakeSuite() {
    Builder builder;
    AddNetworks(builder);
    AddPlain(builder);
    AddLatents(builder);
    AddGeometry(builder);
    AddNumbers(builder);
    AddColors(builder);
    return builder.Take();
}

} // namespace openntc::conformance
