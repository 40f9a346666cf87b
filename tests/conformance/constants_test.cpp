// SPDX-License-Identifier: MIT
// Metadata, weights, stream ranges and constants of every generation-1 set against what LibNTC computes from
// them.
#include "conformance/Expectations.h"
#include "support/Vectors.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

std::string ToHex(std::span<const std::byte> bytes) {
    std::string hex;
    for (const std::byte b : bytes) {
        char digits[3];
        std::snprintf(digits, sizeof digits, "%02x", static_cast<unsigned>(b));
        hex += digits;
    }
    return hex;
}

void CheckDescription(const TextureSetMetadata& set, const rapidjson::Document& expected) {
    CHECK(set.GetDesc().width == expected["width"].GetInt());
    CHECK(set.GetDesc().height == expected["height"].GetInt());
    CHECK(set.GetDesc().channels == expected["channels"].GetInt());
    CHECK(set.GetDesc().mips == expected["mips"].GetInt());
    CHECK(set.GetNetworkVersion() == expected["networkVersion"].GetInt());
    const auto& shape = expected["latentShape"];
    CHECK(set.GetLatentShape().gridSizeScale == shape["gridSizeScale"].GetInt());
    CHECK(set.GetLatentShape().highResFeatures == shape["highResFeatures"].GetInt());
    CHECK(set.GetLatentShape().lowResFeatures == shape["lowResFeatures"].GetInt());
    CHECK(set.GetLatentShape().highResQuantBits == shape["highResQuantBits"].GetInt());
    CHECK(set.GetLatentShape().lowResQuantBits == shape["lowResQuantBits"].GetInt());
    CHECK(set.GetValidChannelMask() == expected["validChannelMask"].GetUint());
    CHECK(set.GetLatentImages().size() == expected["latentImages"].GetUint());
    const auto& spaces = expected["channelColorSpaces"];
    REQUIRE(spaces.Size() == expected["channels"].GetUint());
    for (rapidjson::SizeType c = 0; c < spaces.Size(); ++c)
        CHECK(static_cast<int>(set.GetChannelStorageColorSpace(static_cast<int>(c))) == spaces[c].GetInt());
}

void CheckMips(const TextureSetMetadata& set, const rapidjson::Document& expected) {
    const auto& fused = expected["fusedMips"];
    REQUIRE(fused.Size() == static_cast<unsigned>(set.GetDesc().mips));
    for (rapidjson::SizeType mip = 0; mip < fused.Size(); ++mip) {
        const Expected<MipRange> range = set.GetFusedMipLevels(static_cast<int>(mip));
        REQUIRE(range);
        CHECK(range->first == fused[mip][0].GetInt());
        CHECK(range->last == fused[mip][1].GetInt());
    }
    const auto& ranges = expected["streamRanges"];
    const unsigned mips = static_cast<unsigned>(set.GetDesc().mips);
    CHECK(ranges.Size() == mips * (mips + 1) / 2); // every first mip with every count
    for (const auto& entry : ranges.GetArray()) {
        const Expected<StreamRange> range =
            set.GetStreamRangeForLatents(entry["firstMip"].GetInt(), entry["numMips"].GetInt());
        REQUIRE(range);
        CHECK(range->offset == entry["offset"].GetUint64());
        CHECK(range->size == entry["size"].GetUint64());
    }
}

/// The recorded constants are for the stream range of all mips: their first latent image starts at offset 0.
void CheckInference(const TextureSetMetadata& set, const rapidjson::Document& expected, const char* key,
                    InferenceWeightType type) {
    CAPTURE(key);
    const Expected<StreamRange> range = set.GetStreamRangeForLatents(0, set.GetDesc().mips);
    REQUIRE(range);
    const Expected<NtcTextureSetConstants> constants = MakeInferenceData(set, *range, type);
    const auto& entry = expected[key];
    if (entry.IsNull()) {
        CHECK_FALSE(set.IsInferenceWeightTypeSupported(type));
        REQUIRE_FALSE(constants);
        CHECK(constants.error().GetStatus() == Status::Unsupported);
        return;
    }
    const Expected<std::span<const std::byte>> weights = set.GetInferenceWeights(type);
    REQUIRE(weights);
    CHECK(weights->size() == entry["weightBytes"].GetUint64());
    CHECK(Crc32(*weights) == entry["weightCrc32"].GetUint());
    REQUIRE(constants);
    CHECK(ToHex(std::as_bytes(std::span(&*constants, 1))) == std::string(entry["constants"].GetString()));
}

} // namespace

TEST_CASE("metadata, stream ranges, weights and constants equal LibNTC's on every generation-1 set") {
    const std::vector<std::string> names = ListGeneration1Sets();
    if (names.empty()) {
        MESSAGE("SKIP: no conformance vectors: set OPENNTC_SHARED_DIR");
        ReportVectors("constants", 0, 1);
        return;
    }
    for (const std::string& name : names) {
        CAPTURE(name);
        const rapidjson::Document expected = ReadExpectations(name);
        REQUIRE(expected.IsObject());
        const std::vector<std::byte> file = ReadBytes(GetConformanceFolder() / (name + ".ntc"));
        ReadOnlyMemoryStream stream(file);
        const Expected<TextureSetMetadata> set = TextureSetMetadata::Load(stream);
        if (!set)
            FAIL(std::string(set.error().GetText()));
        CheckDescription(*set, expected);
        CheckMips(*set, expected);
        CheckInference(*set, expected, "GenericInt8", InferenceWeightType::GenericInt8);
        CheckInference(*set, expected, "GenericFP8", InferenceWeightType::GenericFP8);
    }
    ReportVectors("constants", static_cast<int>(names.size()), 0);
}
