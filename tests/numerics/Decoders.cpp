// SPDX-License-Identifier: MIT
#include "Decoders.h"

#include "conformance/Comparison.h"

#include "openntc/core/Stream.h"
#include "openntc/inference/PartialInference.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

namespace numerics {

using namespace openntc;

namespace {

conformance::Mistake plantedMistake = conformance::Mistake::None;

} // namespace

PlantedMistake::PlantedMistake(conformance::Mistake mistake) {
    plantedMistake = mistake;
}
PlantedMistake::~PlantedMistake() {
    plantedMistake = conformance::Mistake::None;
}

TestSet::TestSet(std::vector<std::byte> file) : file_(std::move(file)), model_(file_) {
    ReadOnlyMemoryStream stream(file_);
    auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(metadata.has_value(), std::string(metadata.error().GetText()));
    metadata_ = std::move(*metadata);
}

tool::DecodeData TestSet::GetData(DecodeMath math) const {
    const InferenceWeightType type = GetDecodeWeights(math) == DecodeWeights::FP8
                                         ? InferenceWeightType::GenericFP8
                                         : InferenceWeightType::GenericInt8;
    const auto range = metadata_->GetStreamRangeForLatents(0, metadata_->GetDesc().mips);
    REQUIRE(range);
    const auto constants = MakeInferenceData(*metadata_, *range, type);
    REQUIRE_MESSAGE(constants.has_value(), std::string(constants.error().GetText()));
    const auto weights = metadata_->GetInferenceWeights(type);
    REQUIRE(weights);
    tool::DecodeData data;
    data.constants = *constants;
    const auto begin = file_.begin() + static_cast<std::ptrdiff_t>(range->offset);
    data.latents.assign(begin, begin + static_cast<std::ptrdiff_t>(range->size));
    data.latents.resize((data.latents.size() + 3) / 4 * 4); // decoders read whole words
    data.weights.assign(weights->begin(), weights->end());
    data.networkVersion = metadata_->GetNetworkVersion();
    data.math = math;
    return data;
}

tool::DecodeData TestSet::GetSliceData(DecodeMath math, const SliceDesc& slice) const {
    tool::DecodeData data = GetData(math);
    const auto layout = GetSliceLayout(*metadata_, slice);
    REQUIRE_MESSAGE(layout.has_value(), std::string(layout.error().GetText()));
    data.latents.resize(static_cast<std::size_t>(layout->bytes));
    REQUIRE(ReadSlice(*layout, file_, 0, data.latents));
    PatchConstants(data.constants, *layout);
    return data;
}

Outputs TestSet::GetExpected(DecodeMath math, bool linear, const Texel& texel) const {
    return model_.Decode(math, linear, texel.mip, texel.x, texel.y, plantedMistake);
}

std::vector<Texel> TestSet::ListTexels(std::size_t stride) const {
    std::vector<Texel> texels;
    std::size_t index = 0;
    for (int mip = 0; mip < metadata_->GetDesc().mips; ++mip) {
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

bool TestDecoder::Take(std::shared_ptr<const tool::DecodeData> data) {
    if (isAbsent_)
        return false;
    // Decoders on the CPU are for one kind of maths mode and refer to their data.
    if (decoder_ != nullptr) {
        const auto rebound = decoder_->Rebind(*data);
        REQUIRE_MESSAGE(rebound.has_value(), std::string(rebound.error().GetText()));
        if (!*rebound)
            decoder_.reset();
    }
    if (decoder_ == nullptr) {
        auto decoder = tool::MakeDecoder(*data, options_);
        if (!decoder) {
            REQUIRE_MESSAGE(decoder.error().GetStatus() == Status::Unsupported,
                            std::string(decoder.error().GetText()));
            MESSAGE("SKIP: " << name_ << ": " << std::string(decoder.error().GetText()));
            isAbsent_ = true;
            return false;
        }
        decoder_ = std::move(*decoder);
    }
    data_ = std::move(data);
    return true;
}

std::vector<Outputs> TestDecoder::Decode(const DecodeOptions& options, const TestSet& set,
                                         std::span<const Texel> texels) {
    // A device decodes whole mips: a dispatch costs more than its texels.
    std::vector<Outputs> values;
    std::vector<Outputs> mip;
    int decodedMip = -1;
    for (const Texel& texel : texels) {
        const ColorMip& size = set.GetMetadata().GetColorMips()[static_cast<std::size_t>(texel.mip)];
        const bool wholeMip = IsDevice();
        const Rect rect = wholeMip ? Rect{0, 0, size.width, size.height} : Rect{texel.x, texel.y, 1, 1};
        if (!wholeMip || decodedMip != texel.mip) {
            mip.resize(static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height));
            const auto decoded =
                decoder_->Decode(texel.mip, rect, options, std::span(mip.data()->data(), 16 * mip.size()));
            REQUIRE_MESSAGE(decoded.has_value(), std::string(decoded.error().GetText()));
            decodedMip = texel.mip;
        }
        values.push_back(
            mip[wholeMip ? static_cast<std::size_t>(texel.y) * static_cast<std::size_t>(size.width) +
                               static_cast<std::size_t>(texel.x)
                         : 0]);
    }
    return values;
}

std::span<TestDecoder> GetDecoders() {
    const char* device = std::getenv("OPENNTC_TEST_DEVICE");
    // Never destroyed: drivers that were loaded later are gone before static objects are.
    static auto& decoders = *new std::array<TestDecoder, 3>{
        TestDecoder{"reference", {tool::Backend::Reference, {}, {}, 1}},
        TestDecoder{"fast", {tool::Backend::Cpu, {}, {}, 1}},
        TestDecoder{"vulkan", {tool::Backend::Vulkan, device != nullptr ? device : "llvmpipe", {}, 0}}};
    return decoders;
}

namespace {

double CompareData(const TestSet& set, tool::DecodeData&& decodeData, std::span<const Texel> texels) {
    const DecodeMath math = decodeData.math;
    std::vector<Outputs> expected;
    for (const Texel& texel : texels)
        expected.push_back(set.GetExpected(math, false, texel));
    const auto data = std::make_shared<const tool::DecodeData>(std::move(decodeData));
    double worst = 0;
    for (TestDecoder& decoder : GetDecoders()) {
        if (!decoder.Take(data))
            continue;
        const std::vector<Outputs> values = decoder.Decode({math, false}, set, texels);
        const float flush = conformance::GetFlushLimit(
            decoder.IsDevice() ? conformance::Arithmetic::Vulkan : conformance::Arithmetic::Host, math);
        double own = 0;
        for (std::size_t i = 0; i < texels.size(); ++i) {
            for (std::size_t c = 0; c < 16; ++c) {
                if (!conformance::IsSame(values[i][c], expected[i][c], flush))
                    own = std::max({own, conformance::GetDistance(values[i][c], expected[i][c]), 1e-300});
            }
        }
        if (own > 0 && plantedMistake == conformance::Mistake::None)
            MESSAGE(decoder.GetName() << ": differs by " << own);
        worst = std::max(worst, own);
    }
    return worst;
}

} // namespace

double Compare(const TestSet& set, DecodeMath math, std::span<const Texel> texels) {
    return CompareData(set, set.GetData(math), texels);
}

double CompareSlice(const TestSet& set, DecodeMath math, const SliceDesc& slice,
                    std::span<const Texel> texels) {
    return CompareData(set, set.GetSliceData(math, slice), texels);
}

conformance::EditableSet MakeOneTexelSet(std::uint32_t channelColorSpaces) {
    SynthesisDesc synthesis;
    synthesis.desc = {1, 1, 16, 1};
    synthesis.shape = {2, 4, 4, 1, 1};
    synthesis.channelColorSpaces = channelColorSpaces;
    return conformance::SynthesizeEditableSet(synthesis);
}

void ForceOutputs(conformance::EditableSet& set, std::span<const float, 16> values) {
    std::ranges::fill(set.GetInt8Weights(3), std::byte{0});
    for (std::size_t c = 0; c < 16; ++c) {
        set.SetInt8Bias(3, c, 1);
        set.SetInt8Scale(3, c, values[c]);
    }
}

void PrepareActivations(conformance::EditableSet& set) {
    std::ranges::fill(set.GetInt8Weights(2), std::byte{0});
    std::span<std::byte> outputs = set.GetInt8Weights(3);
    std::ranges::fill(outputs, std::byte{0});
    for (std::size_t row = 0; row < 64; ++row)
        set.SetInt8Bias(2, row, 1);
    for (std::size_t c = 0; c < 16; ++c) {
        outputs[64 * c + c] = std::byte{1};
        outputs[64 * c + 16 + c] = std::byte{15};
        set.SetInt8Bias(3, c, 0);
        set.SetInt8Scale(3, c, 1.0f);
    }
}

void SetActivations(tool::DecodeData& data, std::span<const float, 32> z) {
    const int start = GetNetworkDescription(data.networkVersion).int8ScaleOffsets[2];
    std::memcpy(data.weights.data() + start, z.data(), z.size_bytes());
}

} // namespace numerics
