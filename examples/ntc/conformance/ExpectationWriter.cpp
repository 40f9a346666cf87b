// SPDX-License-Identifier: MIT
#include "../Json.h"
#include "VectorFiles.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/InferenceData.h"

namespace openntc::conformance {

namespace {

Expected<void> WriteWeights(tool::JsonWriter& json, const char* key, const TextureSetMetadata& metadata,
                            InferenceWeightType type) {
    json.Key(key);
    if (!metadata.IsInferenceWeightTypeSupported(type)) {
        json.Null();
        return {};
    }
    const auto weights = metadata.GetInferenceWeights(type);
    if (!weights)
        return Unexpected(weights.error());
    const auto range = metadata.GetStreamRangeForLatents(0, metadata.GetDesc().mips);
    if (!range)
        return Unexpected(range.error());
    const auto constants = MakeInferenceData(metadata, *range, type);
    if (!constants)
        return Unexpected(constants.error());
    json.BeginObject();
    json.Member("weightBytes", static_cast<std::uint64_t>(weights->size()));
    json.Member("weightCrc32", Crc32(*weights));
    json.Member("constants", tool::ToHex(std::as_bytes(std::span(&*constants, 1))));
    json.EndObject();
    return {};
}

Expected<void> WriteMips(tool::JsonWriter& json, const TextureSetMetadata& metadata) {
    const int mips = metadata.GetDesc().mips;
    json.Key("fusedMips");
    json.BeginArray();
    for (int mip = 0; mip < mips; ++mip) {
        const auto fused = metadata.GetFusedMipLevels(mip);
        if (!fused)
            return Unexpected(fused.error());
        json.BeginArray();
        json.Value(fused->first);
        json.Value(fused->last);
        json.EndArray();
    }
    json.EndArray();
    json.Key("streamRanges");
    json.BeginArray();
    for (int first = 0; first < mips; ++first) {
        for (int count = 1; first + count <= mips; ++count) {
            const auto range = metadata.GetStreamRangeForLatents(first, count);
            if (!range)
                return Unexpected(range.error());
            json.BeginObject();
            json.Member("firstMip", first);
            json.Member("numMips", count);
            json.Member("offset", range->offset);
            json.Member("size", range->size);
            json.EndObject();
        }
    }
    json.EndArray();
    return {};
}

} // namespace

Expected<std::string> WriteExpectations(const TextureSetMetadata& metadata) {
    const TextureSetDesc& desc = metadata.GetDesc();
    tool::JsonWriter json;
    json.BeginObject();
    json.Member("producer", "OpenNTC");
    json.Member("width", desc.width);
    json.Member("height", desc.height);
    json.Member("channels", desc.channels);
    json.Member("mips", desc.mips);
    json.Member("networkVersion", metadata.GetNetworkVersion());
    tool::WriteLatentShape(json, metadata.GetLatentShape());
    json.Member("validChannelMask", metadata.GetValidChannelMask());
    json.Key("channelColorSpaces");
    json.BeginArray();
    for (int channel = 0; channel < desc.channels; ++channel)
        json.Value(static_cast<int>(metadata.GetChannelStorageColorSpace(channel)));
    json.EndArray();
    json.Member("latentImages", static_cast<int>(metadata.GetLatentImages().size()));
    if (auto written = WriteMips(json, metadata); !written)
        return Unexpected(written.error());
    for (const auto& [key, type] : {std::pair("GenericInt8", InferenceWeightType::GenericInt8),
                                    std::pair("GenericFP8", InferenceWeightType::GenericFP8)}) {
        if (auto written = WriteWeights(json, key, metadata, type); !written)
            return Unexpected(written.error());
    }
    json.EndObject();
    return json.Take();
}

} // namespace openntc::conformance
