// SPDX-License-Identifier: MIT
// Weights for cooperative vectors: what the driver is given, offsets, and which weights a device gets.
#include "support/SpecificationVectors.h"

#include "openntc/inference/CooperativeVectors.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace openntc;

namespace {

/// The members of VkConvertCooperativeVectorMatrixInfoNV that the helper fills.
struct ConvertInfo {
    std::size_t srcSize;
    std::size_t* pDstSize;
    int srcComponentType, dstComponentType;
    std::uint32_t numRows, numColumns;
    int srcLayout;
    std::size_t srcStride;
    int dstLayout;
    std::size_t dstStride;
};

std::vector<std::byte> MakeGeneric(std::size_t bytes) {
    std::vector<std::byte> generic(bytes);
    for (std::size_t i = 0; i < bytes; ++i)
        generic[i] = static_cast<std::byte>(i * 7 % 127); // no E4M3 NaN
    return generic;
}

} // namespace

TEST_CASE("Int8 matrices are handed over as they are, behind them scales and biases") {
    const std::vector<std::byte> generic = MakeGeneric(13952);
    auto weights = MakeCoopVecWeights(InferenceWeightType::CoopVecInt8, NTC_NETWORK_SMALL, generic);
    REQUIRE(weights);
    ConvertInfo info = {};
    FillCoopVecConversion(weights->layers[0], info);
    CHECK(info.srcSize == 3072);
    CHECK(info.srcComponentType == 3);
    CHECK(info.dstComponentType == 3);
    CHECK(info.numRows == 64);
    CHECK(info.numColumns == 48);
    CHECK(info.srcStride == 48);
    CHECK(info.srcLayout == 0);
    CHECK(info.dstLayout == 2);
    CHECK(LayOutCoopVecWeights(*weights).error().GetStatus() ==
          Status::InvalidArgument); // sizes not asked for
    const std::size_t sizes[] = {6145, 8192, 8192, 2048};
    for (std::size_t layer = 0; layer < 4; ++layer) {
        FillCoopVecConversion(weights->layers[layer], info);
        *info.pDstSize = sizes[layer]; // as the driver does
    }
    REQUIRE(LayOutCoopVecWeights(*weights));
    NtcTextureSetConstants constants = {};
    SetCoopVecOffsets(*weights, constants);
    CHECK(constants.networkWeightOffset1 == 6208); // the next multiple of 64
    CHECK(constants.networkWeightOffset3 == 6208 + 16384);
    CHECK(constants.networkScaleBiasOffset == 6208 + 16384 + 2048);
    CHECK(weights->size == 6208 + 16384 + 2048 + 1664);
    CHECK(weights->tail[0] == generic[12288]);
    CHECK(weights->matrices[11264] == generic[11264]);
}

TEST_CASE("layers of generation 3 have shapes of their own") {
    for (const bool isFP8 : {false, true}) {
        CAPTURE(isFP8);
        const std::vector<std::byte> generic = MakeGeneric(isFP8 ? 8608 : 9472);
        auto weights =
            MakeCoopVecWeights(isFP8 ? InferenceWeightType::CoopVecFP8 : InferenceWeightType::CoopVecInt8,
                               NTC_NETWORK_GENERATION_3, generic);
        REQUIRE_MESSAGE(weights.has_value(), std::string(weights.error().GetText()));
        constexpr std::uint32_t kShapes[4][2] = {{64, 48}, {48, 64}, {32, 48}, {16, 32}};
        for (std::size_t layer = 0; layer < 4; ++layer) {
            CoopVecMatrix& matrix = weights->layers[layer];
            CHECK(matrix.rows == kShapes[layer][0]);
            CHECK(matrix.columns == kShapes[layer][1]);
            CHECK(matrix.sourceOffset % 64 == 0);
            matrix.destinationSize = matrix.sourceSize;
        }
        CHECK(weights->layers[1].sourceOffset == (isFP8 ? 6144 : 3072));
        CHECK(weights->matrices.size() == (isFP8 ? 2 * 7680 + 512 : 8192));
        REQUIRE(LayOutCoopVecWeights(*weights));
        CHECK(weights->tail.size() == generic.size() - 8192);
        CHECK(weights->tail[0] == generic[8192]);
        CHECK(weights->tailOffset == weights->matrices.size());
    }
}

TEST_CASE("E4M3 matrices are widened to binary16; the last layer stays Int8") {
    std::vector<std::byte> generic = MakeGeneric(13824);
    generic[0] = std::byte{0x38}; // 1
    generic[1] = std::byte{0x81}; // -2^-9
    const auto weights = MakeCoopVecWeights(InferenceWeightType::CoopVecFP8, NTC_NETWORK_MEDIUM, generic);
    REQUIRE(weights);
    CHECK(weights->layers[0].sourceSize == 8192);
    CHECK(weights->layers[0].sourceStride == 128);
    CHECK(weights->layers[0].destinationComponent == CoopVecComponent::FloatE4M3);
    CHECK(weights->layers[3].sourceComponent == CoopVecComponent::SInt8);
    CHECK(weights->layers[3].sourceSize == 1024);
    CHECK(weights->matrices[0] == std::byte{0x00});
    CHECK(weights->matrices[1] == std::byte{0x3C});
    CHECK(weights->matrices[2] == std::byte{0x00});
    CHECK(weights->matrices[3] == std::byte{0x98});
    CHECK(weights->matrices[weights->layers[3].sourceOffset] == generic[12288]);
}

TEST_CASE("wrong types and sizes are refused") {
    const std::vector<std::byte> generic = MakeGeneric(13952);
    CHECK_FALSE(MakeCoopVecWeights(InferenceWeightType::GenericInt8, NTC_NETWORK_SMALL, generic));
    CHECK_FALSE(MakeCoopVecWeights(InferenceWeightType::CoopVecInt8, NTC_NETWORK_MEDIUM, generic));
    for (const int network : {0, 7})
        CHECK_FALSE(MakeCoopVecWeights(InferenceWeightType::CoopVecInt8, network, generic));
    const auto tapered =
        MakeCoopVecWeights(InferenceWeightType::CoopVecInt8, NTC_NETWORK_GENERATION_3, generic);
    REQUIRE_FALSE(tapered);
    CHECK(std::string(tapered.error().GetText()) == "weights: 13952 bytes: the generic buffer has 9472");
}

TEST_CASE("the order of preference") {
    const CoopVecDevice all = {true, true, true};
    CHECK(PickWeightType(all, true, true) == InferenceWeightType::CoopVecInt8);
    CHECK(PickWeightType(all, false, true) == InferenceWeightType::CoopVecFP8);
    CHECK(PickWeightType(all, true, true, CoopVecOrder::FP8First) == InferenceWeightType::CoopVecFP8);
    CHECK(PickWeightType(all, true, false, CoopVecOrder::FP8First) == InferenceWeightType::CoopVecInt8);
    CHECK(PickWeightType({true, true, false}, true, true, CoopVecOrder::FP8First) ==
          InferenceWeightType::CoopVecInt8);
    CHECK(PickWeightType({true, false, true}, true, true, CoopVecOrder::FP8First) ==
          InferenceWeightType::GenericInt8);
    CHECK(PickWeightType(all, true, false) == InferenceWeightType::CoopVecInt8);
    CHECK(PickWeightType({true, true, false}, true, true) == InferenceWeightType::CoopVecInt8);
    CHECK(PickWeightType({false, true, true}, true, true) == InferenceWeightType::GenericInt8);
    CHECK(PickWeightType({}, false, true) == InferenceWeightType::GenericFP8);
    CHECK(PickWeightType(all, false, false) == InferenceWeightType::Unknown);
}

TEST_CASE("constants for a converted buffer: inputs as for the generic weights, offsets of the buffer") {
    SynthesisDesc synthesis;
    synthesis.desc = {32, 32, 16, 2};
    synthesis.networkVersion = NTC_NETWORK_SMALL;
    synthesis.shape = {4, 4, 8, 2, 4};
    synthesis.withFP8 = true;
    const std::vector<std::byte> file = openntc_tests::MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set.has_value(), std::string(set.error().GetText()));
    const auto range = set->GetStreamRangeForLatents(0, 2);
    REQUIRE(range);
    for (const bool isFP8 : {false, true}) {
        CAPTURE(isFP8);
        const auto type = isFP8 ? InferenceWeightType::CoopVecFP8 : InferenceWeightType::CoopVecInt8;
        const auto genericType = isFP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
        auto weights = MakeCoopVecWeights(type, NTC_NETWORK_SMALL, *set->GetInferenceWeights(genericType));
        REQUIRE(weights);
        CHECK(MakeInferenceData(*set, *range, *weights).error().GetStatus() == Status::InvalidArgument);
        for (CoopVecMatrix& matrix : weights->layers)
            matrix.destinationSize = 10'000;
        REQUIRE(LayOutCoopVecWeights(*weights));
        const auto constants = MakeInferenceData(*set, *range, *weights);
        REQUIRE_MESSAGE(constants.has_value(), std::string(constants.error().GetText()));
        NtcTextureSetConstants expected = *MakeInferenceData(*set, *range, genericType);
        CHECK(expected.networkWeightOffset1 == 48 * 64);
        expected.networkWeightOffset1 = 10'048; // multiples of 64
        expected.networkWeightOffset2 = 20'096;
        expected.networkWeightOffset3 = 30'144;
        expected.networkScaleBiasOffset = 40'192;
        CHECK(std::memcmp(&*constants, &expected, sizeof expected) == 0);
        // Without the converted buffer there are no offsets to write.
        CHECK(MakeInferenceData(*set, *range, type).error().GetStatus() == Status::Unsupported);
        const auto byMips = MakeInferenceData(*set, 0, 2, *weights);
        REQUIRE(byMips);
        CHECK(std::memcmp(&*byMips, &expected, sizeof expected) == 0);
        weights->type = genericType;
        CHECK(MakeInferenceData(*set, *range, *weights).error().GetStatus() == Status::InvalidArgument);
    }
}

TEST_CASE("constants for a converted buffer of generation 3: by mips") {
    SynthesisDesc synthesis;
    synthesis.desc = {32, 32, 16, 2};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(4, 8);
    synthesis.withFP8 = true;
    const std::vector<std::byte> file = openntc_tests::MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set.has_value(), std::string(set.error().GetText()));
    auto weights = MakeCoopVecWeights(InferenceWeightType::CoopVecFP8, NTC_NETWORK_GENERATION_3,
                                      *set->GetInferenceWeights(InferenceWeightType::GenericFP8));
    REQUIRE(weights);
    for (CoopVecMatrix& matrix : weights->layers)
        matrix.destinationSize = 10'000;
    REQUIRE(LayOutCoopVecWeights(*weights));
    const auto constants = MakeInferenceData(*set, 0, 2, *weights);
    REQUIRE_MESSAGE(constants.has_value(), std::string(constants.error().GetText()));
    NtcTextureSetConstants expected = *MakeInferenceData(*set, 0, 2, InferenceWeightType::GenericFP8);
    CHECK(expected.networkWeightOffset2 == 6144);
    SetCoopVecOffsets(*weights, expected);
    CHECK(expected.networkWeightOffset2 == 20'096);
    CHECK(std::memcmp(&*constants, &expected, sizeof expected) == 0);
    // Latents of later generations are no range of the file.
    CHECK(MakeInferenceData(*set, StreamRange{}, *weights).error().GetStatus() == Status::Unsupported);
}
