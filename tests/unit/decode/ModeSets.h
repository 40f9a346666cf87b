// SPDX-License-Identifier: MIT
// Synthesised texture sets with both networks, as decoder sources.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace decode_test {

/// A texture set in memory and what decoders need of it, for Int8 and for FP8 weights.
class ModeSet {
public:
    explicit ModeSet(std::vector<std::byte> file) : file_(std::move(file)) {
        openntc::ReadOnlyMemoryStream stream(file_);
        auto metadata = openntc::TextureSetMetadata::Load(stream);
        REQUIRE_MESSAGE(metadata.has_value(), std::string(metadata.error().GetText()));
        metadata_ = std::move(*metadata);
        const auto range = metadata_->GetStreamRangeForLatents(0, metadata_->GetDesc().mips);
        REQUIRE(range);
        latents_.assign(file_.begin() + static_cast<std::ptrdiff_t>(range->offset),
                        file_.begin() + static_cast<std::ptrdiff_t>(range->offset + range->size));
        latents_.resize((latents_.size() + 3) / 4 * 4); // decoders read whole words
        for (const auto type :
             {openntc::InferenceWeightType::GenericInt8, openntc::InferenceWeightType::GenericFP8}) {
            if (!metadata_->IsInferenceWeightTypeSupported(type))
                continue;
            const auto constants = openntc::MakeInferenceData(*metadata_, *range, type);
            REQUIRE_MESSAGE(constants.has_value(), std::string(constants.error().GetText()));
            (type == openntc::InferenceWeightType::GenericFP8 ? fp8_ : int8_) = *constants;
        }
    }

    const openntc::TextureSetMetadata& GetMetadata() const { return *metadata_; }

    bool HasWeights(openntc::DecodeWeights format) const {
        return metadata_->IsInferenceWeightTypeSupported(GetType(format));
    }

    openntc::DecodeSource GetSource(openntc::DecodeWeights format) const {
        const auto weights = metadata_->GetInferenceWeights(GetType(format));
        REQUIRE(weights);
        return {format == openntc::DecodeWeights::FP8 ? &fp8_ : &int8_, latents_, *weights,
                metadata_->GetNetworkVersion(), format};
    }

private:
    static openntc::InferenceWeightType GetType(openntc::DecodeWeights format) {
        return format == openntc::DecodeWeights::FP8 ? openntc::InferenceWeightType::GenericFP8
                                                     : openntc::InferenceWeightType::GenericInt8;
    }

    std::vector<std::byte> file_;
    std::optional<openntc::TextureSetMetadata> metadata_;
    std::vector<std::byte> latents_;
    openntc::NtcTextureSetConstants int8_{};
    openntc::NtcTextureSetConstants fp8_{};
};

/// One set per network version, of odd sizes; all code widths occur, and features that do not fill the network.
inline ModeSet MakeModeSet(int networkVersion, int width, int height) {
    static constexpr openntc::LatentShape kShapes[4] = {
        {4, 4, 8, 2, 4}, {2, 8, 16, 8, 1}, {3, 8, 12, 4, 8}, {4, 16, 16, 1, 2}};
    openntc::SynthesisDesc synthesis;
    synthesis.seed = 77u + static_cast<unsigned>(networkVersion);
    synthesis.desc = {width, height, 16, 5};
    synthesis.networkVersion = networkVersion;
    synthesis.shape = kShapes[networkVersion - 1];
    synthesis.withFP8 = true;
    openntc::MemoryStream stream;
    const auto written = openntc::SynthesizeTextureSet(stream, synthesis);
    REQUIRE_MESSAGE(written.has_value(), std::string(written.error().GetText()));
    return ModeSet({stream.GetBytes().begin(), stream.GetBytes().end()});
}

} // namespace decode_test
