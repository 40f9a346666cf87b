// SPDX-License-Identifier: MIT
// V1 and V2 of the format specification: file, blob, constants and weight buffer by CRC-32.
#include "support/SpecificationVectors.h"
#include "support/Vectors.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/InferenceData.h"

#include <doctest/doctest.h>

#include <cstring>
#include <span>
#include <string>

using namespace openntc;
using namespace openntc_tests;

TEST_CASE("V1 and V2 come out as the specification's files and constants") {
    for (const SpecificationVector& vector : {GetV1(), GetV2()}) {
        CAPTURE(vector.name);
        const std::vector<std::byte> file = MakeFile(vector.synthesis);
        REQUIRE(file.size() == vector.fileBytes);
        CHECK(Crc32(file) == vector.fileCrc);
        CHECK(Crc32(std::span(file).last(vector.blobBytes)) == vector.blobCrc);
        ReadOnlyMemoryStream stream(file);
        const auto set = TextureSetMetadata::Load(stream);
        REQUIRE(set);
        const auto constants = MakeInferenceData(*set, kEntireStream, InferenceWeightType::GenericInt8);
        REQUIRE(constants);
        CHECK(Crc32(std::as_bytes(std::span(&*constants, 1))) == vector.constantsCrc);
        CHECK(Crc32(*set->GetInferenceWeights(InferenceWeightType::GenericInt8)) == vector.weightsCrc);
        ReportVectors(vector.name, 1, 0);
    }
}

TEST_CASE("first weights of V1 and V2") {
    const int expected[2][8] = {{69, 103, 24, -87, 125, 119, -98, 113},
                                {94, -73, 16, 44, -58, -95, 100, -27}};
    const std::vector<std::byte> files[2] = {SynthesizeV1(), SynthesizeV2()};
    const std::size_t blobs[2] = {1932, 2348};
    for (std::size_t v = 0; v < 2; ++v) {
        for (std::size_t i = 0; i < 8; ++i)
            CHECK(static_cast<std::int8_t>(files[v][blobs[v] + i]) == expected[v][i]);
    }
}

TEST_CASE("descriptions that no file can hold are refused") {
    const auto refuse = [](auto change, Status status) {
        SynthesisDesc synthesis = GetV1().synthesis;
        change(synthesis);
        MemoryStream stream;
        const auto result = SynthesizeTextureSet(stream, synthesis);
        REQUIRE_FALSE(result);
        CHECK(result.error().GetStatus() == status);
        CHECK(stream.GetBytes().empty());
    };
    refuse([](SynthesisDesc& d) { d.desc.width = 0; }, Status::OutOfRange);
    refuse([](SynthesisDesc& d) { d.desc.mips = 17; }, Status::OutOfRange);
    refuse([](SynthesisDesc& d) { d.shape = {}; }, Status::InvalidArgument);
    refuse([](SynthesisDesc& d) { d.shape.highResFeatures = 8; }, Status::OutOfRange); // small network
    refuse([](SynthesisDesc& d) { d.networkVersion = 5; }, Status::OutOfRange);
    refuse([](SynthesisDesc& d) { d.withInt8 = false; }, Status::InvalidArgument);
    refuse([](SynthesisDesc& d) { d.desc.width = 1 << 19; }, Status::OutOfRange); // 131072 latent pixels
    refuse([](SynthesisDesc& d) { d.channelColorSpaces = 3; }, Status::OutOfRange);
}

TEST_CASE("every network and shape of the table synthesises and loads") {
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        for (int i = 0; i < GetKnownLatentShapeCount(version); ++i) {
            SynthesisDesc synthesis;
            synthesis.desc = {33, 17, 7, 6};
            synthesis.networkVersion = version;
            synthesis.shape = EnumerateKnownLatentShapes(i, version)->shape;
            synthesis.withFP8 = true;
            const std::vector<std::byte> file = MakeFile(synthesis);
            ReadOnlyMemoryStream stream(file);
            const auto set = TextureSetMetadata::Load(stream);
            REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
            CHECK(set->GetNetworkVersion() == version);
            CHECK(set->GetDesc().channels == 8);
            CHECK(set->IsInferenceWeightTypeSupported(InferenceWeightType::GenericFP8));
        }
    }
}
