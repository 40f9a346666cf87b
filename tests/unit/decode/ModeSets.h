// SPDX-License-Identifier: MIT
// Synthesised texture sets with both networks, as decoder sources.
#pragma once

#include "openntc/core/Crc32.h"
#include "openntc/core/Stream.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
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
        const int mips = metadata_->GetDesc().mips;
        const auto bytes = openntc::GetLatentBufferBytes(*metadata_, 0, mips);
        REQUIRE(bytes);
        latents_.resize(*bytes);
        const auto read = openntc::ReadLatents(*metadata_, stream, 0, mips, latents_);
        REQUIRE_MESSAGE(read.has_value(), std::string(read.error().GetText()));
        for (const auto type :
             {openntc::InferenceWeightType::GenericInt8, openntc::InferenceWeightType::GenericFP8}) {
            if (!metadata_->IsInferenceWeightTypeSupported(type))
                continue;
            const auto constants = openntc::MakeInferenceData(*metadata_, 0, mips, type);
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
    synthesis.shape = openntc::IsNetworkVersion(networkVersion) ? kShapes[networkVersion - 1]
                                                                : openntc::MakeLayeredShape(3, 12);
    synthesis.withFP8 = true;
    openntc::MemoryStream stream;
    const auto written = openntc::SynthesizeTextureSet(stream, synthesis);
    REQUIRE_MESSAGE(written.has_value(), std::string(written.error().GetText()));
    return ModeSet({stream.GetBytes().begin(), stream.GetBytes().end()});
}

/// The CRC-32 of all mips of a small set in a maths mode, 16 binary32 numbers a texel in the order of a
/// little-endian memory. decode(source, mip, rect, options) returns a mip's numbers.
template <typename Set, typename Decode>
std::uint32_t GetChecksum(const Set& set, openntc::DecodeMath math, Decode decode) {
    const openntc::DecodeOptions options = {.math = math, .convertToLinear = false};
    const openntc::DecodeSource source = set.GetSource(openntc::GetDecodeWeights(math));
    std::vector<float> all;
    for (int mip = 0; mip < source.constants->imageMips; ++mip) {
        const openntc::Rect rect = {0, 0, std::max(source.constants->imageWidth >> mip, 1),
                                    std::max(source.constants->imageHeight >> mip, 1)};
        const std::vector<float> outputs = decode(source, mip, rect, options);
        all.insert(all.end(), outputs.begin(), outputs.end());
    }
    return openntc::Crc32(std::as_bytes(std::span(all)));
}

/// What checksums are made of.
inline constexpr openntc::DecodeMath kChecksumModes[] = {
    openntc::DecodeMath::Int8, openntc::DecodeMath::Int8Half, openntc::DecodeMath::FP8,
    openntc::DecodeMath::FP16, openntc::DecodeMath::FP32};

/// One number for each network and mode, which every compiler, optimisation level, instruction set, machine and number
/// of threads must produce. Checks the first `modes` of Int8, Int8Half, FP8, FP16 and FP32.
template <typename Decode>
void CheckChecksums(const char* decoder, Decode decode, std::size_t modes = 5) {
    constexpr std::uint32_t kChecksums[4][5] = {
        {0xaf8a7a8bu, 0x0b6d2b05u, 0xd7caf49fu, 0xec50ee11u, 0xd3c4c287u},
        {0xb9d45912u, 0x1fed675cu, 0xca9793a4u, 0xc792656bu, 0xe30f30eau},
        {0x75798744u, 0x5e13ae68u, 0x721eeed3u, 0x0cea4b6bu, 0x24aac3e0u},
        {0xaebe2a4du, 0xc08458b0u, 0x35957daau, 0xef9d16d3u, 0x49a8c2f7u}};
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        const ModeSet set = MakeModeSet(version, 19, 17);
        for (std::size_t mode = 0; mode < modes; ++mode) {
            INFO(std::string(decoder) << ", network " << version << ", mode " << mode);
            CHECK(GetChecksum(set, kChecksumModes[mode], decode) == kChecksums[version - 1][mode]);
        }
    }
}

} // namespace decode_test
