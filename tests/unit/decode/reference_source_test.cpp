// SPDX-License-Identifier: MIT
// Validation of decoder inputs: hostile constants are refused, and what is accepted never reads outside its
// spans.
#include "SpecificationSets.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <bit>
#include <cstdint>
#include <functional>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

using namespace openntc;

namespace {

Status Validate(const decode_test::SpecificationSet& set) {
    const Expected<void> result =
        ValidateDecodeSource({&set.constants, set.latents, set.weights, set.networkVersion});
    return result ? Status::Ok : result.error().GetStatus();
}

Status Decode(const decode_test::SpecificationSet& set, int mip, Rect rect, std::size_t floats,
              DecodeOptions options = {}) {
    std::vector<float> outputs(floats);
    const Expected<void> result = DecodeReference(
        {&set.constants, set.latents, set.weights, set.networkVersion}, mip, rect, options, outputs);
    return result ? Status::Ok : result.error().GetStatus();
}

} // namespace

TEST_CASE("valid sources are accepted, each violation is refused") {
    const decode_test::SpecificationSet good = decode_test::MakeSpecificationSet(decode_test::GetV2Shape());
    CHECK(Validate(good) == Status::Ok);
    CHECK_FALSE(ValidateDecodeSource({nullptr, good.latents, good.weights, 3}));
    using Edit = std::function<void(decode_test::SpecificationSet&)>;
    const Edit edits[] = {
        [](auto& s) { s.networkVersion = 0; },
        [](auto& s) { s.networkVersion = 5; },
        [](auto& s) { s.networkVersion = 2; }, // 12 features need 3
        [](auto& s) { s.networkVersion = 4; }, // larger first layer than the weights hold
        [](auto& s) { s.constants.imageWidth = 0; },
        [](auto& s) { s.constants.imageHeight = (1 << 20) + 1; },
        [](auto& s) { s.constants.imageMips = 17; },
        [](auto& s) { s.constants.imageMips = 0; },
        [](auto& s) { s.constants.highResEncoding.numFeatures = 6; },
        [](auto& s) { s.constants.lowResEncoding.numFeatures = 20; },
        [](auto& s) { s.constants.lowResEncoding.numFeatures = INT32_MIN; },
        [](auto& s) { s.constants.highResEncoding.quantBits = 3; },
        [](auto& s) { s.constants.highResEncoding.quantBits = 0; },
        [](auto& s) { s.constants.highResEncoding.logElementsPerUint = 40; },
        [](auto& s) { s.constants.highResEncoding.addressMask = 31; },
        [](auto& s) { s.constants.highResEncoding.dataMask = 0xFFFFFFFFu; },
        [](auto& s) { s.constants.highResEncoding.quantizedScale = std::bit_cast<int>(0.117647f); }, // FP8
        [](auto& s) { s.constants.lowResEncoding.quantizedBias = INT32_MAX; },
        [](auto& s) { s.constants.highResNeuralMips[0].dataOffset = 0xFFFFFFFCu; },
        [](auto& s) { s.constants.highResNeuralMips[0].dataOffset += 2; },
        [](auto& s) { s.constants.lowResNeuralMips[1].dataOffset += 4; }, // ends 4 bytes past the latents
        [](auto& s) {
            s.constants.lowResNeuralMips[7] = {0, 0xFFFFFFFFu, 0, 0xFFFFFFFFu};
        },
        [](auto& s) { s.constants.highResNeuralMips[0].sliceLeftTop = 1; },
        [](auto& s) { s.constants.highResNeuralMips[0].imageWidthHeight -= 0x10000u; },
        [](auto& s) { s.constants.colorMips[5].neuralMip = 8; },
        [](auto& s) { s.constants.networkWeightOffset0 = -4; },
        [](auto& s) { s.constants.networkWeightOffset2 += 2; },
        [](auto& s) { s.constants.networkWeightOffset3 = INT32_MAX - 3; },
        [](auto& s) { s.constants.networkScaleBiasOffset += 4; },
        [](auto& s) { s.latents.pop_back(); },
        [](auto& s) { s.weights.pop_back(); },
    };
    for (std::size_t i = 0; i < std::size(edits); ++i) {
        decode_test::SpecificationSet bad = good;
        edits[i](bad);
        CAPTURE(i);
        CHECK(Validate(bad) != Status::Ok);
        CHECK(Decode(bad, 0, {0, 0, 1, 1}, 16) != Status::Ok);
    }
}

TEST_CASE("requests outside the set are refused, texels outside the image are clamped") {
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV2Shape());
    CHECK(Decode(set, 0, {0, 0, 4, 2}, 128) == Status::Ok);
    CHECK(Decode(set, 0, {0, 0, 4, 2}, 127) == Status::OutOfRange);
    CHECK(Decode(set, -1, {0, 0, 1, 1}, 16) == Status::OutOfRange);
    CHECK(Decode(set, 6, {0, 0, 1, 1}, 16) == Status::OutOfRange);
    CHECK(Decode(set, 0, {0, 0, 0, 1}, 16) == Status::OutOfRange);
    CHECK(Decode(set, 0, {0, 0, 1, -1}, 16) == Status::OutOfRange);
    CHECK(Decode(set, 0, {INT32_MAX, 0, INT32_MAX, 1}, 16) == Status::OutOfRange);
    CHECK(Decode(set, 0, {-(1 << 22), (1 << 22) - 1, 1, 1}, 16) == Status::Ok);
    CHECK(Decode(set, 5, {-5, 900, 3, 2}, 96, {DecodeMath::Int8Half, true}) == Status::Ok);
    // Latent image 1 serves mips 3 to 5; without it the others still decode.
    set.constants.lowResNeuralMips[1].sliceWidthHeight = 0;
    CHECK(Decode(set, 2, {0, 0, 1, 1}, 16) == Status::Ok);
    CHECK(Decode(set, 3, {0, 0, 1, 1}, 16) == Status::Unsupported);
    set.constants.colorMips[0].neuralMip = -1;
    CHECK(Decode(set, 0, {0, 0, 1, 1}, 16) == Status::Unsupported);
    shader::uint inputs[NTC_MAX_INPUT_WORDS] = {0xAAu};
    CHECK_FALSE(shader::NtcPrepareNetworkInputs(3, set.constants, {}, 0, {0, 0}, 0, inputs));
    CHECK_FALSE(shader::NtcPrepareNetworkInputs(3, set.constants, {}, 0, {0, 0}, -1, inputs));
    CHECK_FALSE(shader::NtcPrepareNetworkInputs(3, set.constants, {}, 0, {0, 0}, 6, inputs));
    CHECK(inputs[0] == 0xAAu);
}

TEST_CASE("position numbers that are not finite have a defined result") {
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV1Shape());
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float value : {infinity, -infinity, std::numeric_limits<float>::quiet_NaN(), 3e38f}) {
        set.constants.colorMips[0].positionScale = value;
        set.constants.colorMips[0].positionLod = value;
        CHECK(Decode(set, 0, {-2, -2, 5, 5}, 400) == Status::Ok);
    }
}

TEST_CASE("words outside a buffer read as zero") {
    const std::uint32_t words[2] = {0x11223344u, 0x55667788u};
    const shader::NtcBuffer buffer{words, 7};
    CHECK(shader::NtcBufferLoad(buffer, 0) == 0x11223344u);
    CHECK(shader::NtcBufferLoad(buffer, 4) == 0u); // its last byte is outside
    CHECK(shader::NtcBufferLoad(buffer, 0xFFFFFFFCu) == 0u);
    CHECK(shader::NtcBufferLoad({}, 0) == 0u);
}
