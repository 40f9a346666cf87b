// SPDX-License-Identifier: MIT
#include "Checks.h"

#include "../Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/InferenceData.h"

#include <cstring>

namespace openntc::conformance {

namespace {

using tool::Format;

class MetadataCheck {
public:
    MetadataCheck(const Expectations& expectations, const TextureSetMetadata& metadata)
        : expectations_(expectations), metadata_(metadata) {}

    MetadataResult Run() {
        CheckFields();
        CheckFusedMips();
        CheckStreamRanges();
        CheckWeights("GenericInt8", expectations_.int8, expectations_.int8Absent,
                     InferenceWeightType::GenericInt8);
        CheckWeights("GenericFP8", expectations_.fp8, expectations_.fp8Absent,
                     InferenceWeightType::GenericFP8);
        return result_;
    }

private:
    void Differ(const std::string& text) {
        if (result_.difference.empty())
            result_.difference = text;
    }

    template <typename T>
    void CheckField(const char* name, std::optional<T> expected, T actual) {
        if (!expected)
            return;
        ++result_.fields;
        if (*expected != actual)
            Differ(Format("%s: %lld: expected %lld", name, static_cast<long long>(actual),
                          static_cast<long long>(*expected)));
    }

    void CheckFields() {
        const TextureSetDesc& desc = metadata_.GetDesc();
        CheckField("width", expectations_.width, static_cast<int>(desc.width));
        CheckField("height", expectations_.height, static_cast<int>(desc.height));
        CheckField("channels", expectations_.channels, static_cast<int>(desc.channels));
        CheckField("mips", expectations_.mips, static_cast<int>(desc.mips));
        CheckField("networkVersion", expectations_.networkVersion,
                   static_cast<int>(metadata_.GetNetworkVersion()));
        CheckField("latentImages", expectations_.latentImages,
                   static_cast<int>(metadata_.GetLatentImages().size()));
        CheckField("validChannelMask", expectations_.validChannelMask, metadata_.GetValidChannelMask());
        if (expectations_.latentShape) {
            const Expectations::Shape& expected = *expectations_.latentShape;
            const LatentShape& shape = metadata_.GetLatentShape();
            CheckField("gridSizeScale", expected.gridSizeScale, shape.gridSizeScale);
            CheckField("highResFeatures", std::optional(expected.highResFeatures), shape.highResFeatures);
            CheckField("lowResFeatures", std::optional(expected.lowResFeatures), shape.lowResFeatures);
            CheckField("highResQuantBits", std::optional(expected.highResQuantBits), shape.highResQuantBits);
            CheckField("lowResQuantBits", std::optional(expected.lowResQuantBits), shape.lowResQuantBits);
        }
        const std::vector<int>& spaces = expectations_.channelColorSpaces;
        for (std::size_t channel = 0; channel < spaces.size() && channel < 16; ++channel)
            CheckField(Format("channelColorSpaces[%zu]", channel).c_str(), std::optional(spaces[channel]),
                       static_cast<int>(metadata_.GetChannelStorageColorSpace(static_cast<int>(channel))));
        if (spaces.size() > 16)
            Differ(Format("channelColorSpaces: %zu entries: at most 16", spaces.size()));
    }

    void CheckFusedMips() {
        for (std::size_t mip = 0; mip < expectations_.fusedMips.size(); ++mip) {
            const auto& [first, last] = expectations_.fusedMips[mip];
            const auto fused = metadata_.GetFusedMipLevels(static_cast<int>(mip));
            ++result_.fusedMips;
            if (!fused)
                Differ(Format("fusedMips[%zu]: %s", mip, fused.error().GetText()));
            else if (fused->first != first || fused->last != last)
                Differ(Format("fusedMips[%zu]: %d ... %d: expected %d ... %d", mip, fused->first, fused->last,
                              first, last));
        }
    }

    void CheckStreamRanges() {
        for (const RangeExpectation& expected : expectations_.streamRanges) {
            const auto range = metadata_.GetStreamRangeForLatents(expected.firstMip, expected.numMips);
            ++result_.streamRanges;
            const std::string name =
                Format("stream range of mips %d + %d", expected.firstMip, expected.numMips);
            if (!range)
                Differ(name + ": " + range.error().GetText());
            else if (range->offset != expected.offset || range->size != expected.size)
                Differ(Format("%s: %llu + %llu: expected %llu + %llu", name.c_str(),
                              static_cast<unsigned long long>(range->offset),
                              static_cast<unsigned long long>(range->size),
                              static_cast<unsigned long long>(expected.offset),
                              static_cast<unsigned long long>(expected.size)));
        }
    }

    void CheckWeights(const char* name, const std::optional<WeightExpectation>& expected, bool absent,
                      InferenceWeightType type) {
        if (absent && metadata_.IsInferenceWeightTypeSupported(type))
            Differ(Format("%s: present: expected none", name));
        if (!expected)
            return;
        const auto weights = metadata_.GetInferenceWeights(type);
        const auto range = metadata_.GetStreamRangeForLatents(0, metadata_.GetDesc().mips);
        if (!weights || !range)
            return Differ(
                Format("%s: %s", name, !weights ? weights.error().GetText() : range.error().GetText()));
        ++result_.weights;
        if (weights->size() != expected->weightBytes)
            Differ(Format("%s: %zu bytes of weights: expected %llu", name, weights->size(),
                          static_cast<unsigned long long>(expected->weightBytes)));
        else if (const std::uint32_t crc = Crc32(*weights); crc != expected->weightCrc32)
            Differ(Format("%s: weights with CRC-32 %u: expected %u", name, crc, expected->weightCrc32));

        const auto constants = MakeInferenceData(metadata_, *range, type);
        if (!constants)
            return Differ(Format("%s: constants: %s", name, constants.error().GetText()));
        ++result_.constants;
        if (expected->constants.size() != sizeof(NtcTextureSetConstants))
            return Differ(Format("%s: constants of %zu bytes expected: %zu", name, expected->constants.size(),
                                 sizeof(NtcTextureSetConstants)));
        const std::span<const std::byte> bytes = std::as_bytes(std::span(&*constants, 1));
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            if (bytes[i] != expected->constants[i])
                return Differ(Format("%s: constants at byte %zu: 0x%02x: expected 0x%02x", name, i,
                                     static_cast<unsigned>(bytes[i]),
                                     static_cast<unsigned>(expected->constants[i])));
        }
    }

    const Expectations& expectations_;
    const TextureSetMetadata& metadata_;
    MetadataResult result_;
};

} // namespace

MetadataResult CheckMetadata(const Expectations& expectations, const TextureSetMetadata& metadata) {
    return MetadataCheck(expectations, metadata).Run();
}

} // namespace openntc::conformance
