// SPDX-License-Identifier: MIT
// The reference decoder against the whole-image checks of the format specification (network 12): sets V1 and
// V2.
#include "SpecificationSets.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/Half.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <string>

using namespace openntc;

namespace {

struct MipCheck {
    int mip, width, height;
    std::uint32_t inputs, half, binary32;
};

constexpr MipCheck kV1Checks[] = {
    {0, 24, 20, 0xb371c088, 0xbf80e76f, 0x007d97d0},
    {1, 12, 10, 0x27c54b25, 0x2b2db22a, 0x753fadfb},
    {2, 6, 5, 0x671158e0, 0x01aa6b12, 0xa0be28f5},
    {3, 3, 2, 0x37abac82, 0x16f196a5, 0x15b5c1e1},
};
constexpr MipCheck kV2Checks[] = {
    {0, 40, 64, 0x978577f5, 0x4484fd84, 0x9f75f00c}, {1, 20, 32, 0x90dc2a2f, 0x3ba32a83, 0xd3342cd7},
    {2, 10, 16, 0xe2b92fdc, 0xd30af414, 0xf06d2b91}, {3, 5, 8, 0xfc31cac4, 0x0426cc42, 0x7cc52f91},
    {4, 2, 4, 0x77ae567a, 0x0b35c34c, 0x3f6c89f8},   {5, 1, 2, 0x510afbe0, 0x45d68f0c, 0x265b6c2f},
};

DecodeSource GetSource(const test::SpecificationSet& set) {
    return {&set.constants, set.latents, set.weights, set.networkVersion};
}

std::uint32_t GetInputsCrc(const test::SpecificationSet& set, const MipCheck& check) {
    std::vector<std::byte> bytes;
    for (int y = 0; y < check.height; ++y) {
        for (int x = 0; x < check.width; ++x) {
            shader::uint words[NTC_MAX_INPUT_WORDS];
            REQUIRE(shader::NtcPrepareNetworkInputs(set.networkVersion, set.constants,
                                                    {set.latents.data(), set.latents.size()}, 0,
                                                    shader::int2(x, y), check.mip, words));
            for (shader::uint i = 0; i < shader::NtcGetInputWords(set.networkVersion); ++i)
                test::detail::Append(bytes, words[i]);
        }
    }
    return Crc32(bytes);
}

std::vector<float> Decode(const test::SpecificationSet& set, const MipCheck& check, DecodeMath math) {
    std::vector<float> outputs(static_cast<std::size_t>(check.width * check.height * NTC_MAX_CHANNELS));
    const Expected<void> result =
        DecodeReference(GetSource(set), check.mip, {0, 0, check.width, check.height},
                        {.math = math, .convertToLinear = false}, outputs);
    if (!result)
        FAIL(std::string(result.error().GetText()));
    return outputs;
}

void CheckSet(const test::SpecificationSet& set, std::span<const MipCheck> checks) {
    for (const MipCheck& check : checks) {
        CAPTURE(check.mip);
        CHECK(GetInputsCrc(set, check) == check.inputs);
        CHECK(Crc32(std::as_bytes(std::span<const float>(Decode(set, check, DecodeMath::Int8)))) ==
              check.binary32);
        std::vector<std::uint16_t> halves;
        for (const float value : Decode(set, check, DecodeMath::Int8Half)) {
            halves.push_back(FloatToHalf(value));
            REQUIRE(HalfToFloat(halves.back()) == value);
        }
        CHECK(Crc32(std::as_bytes(std::span<const std::uint16_t>(halves))) == check.half);
    }
}

} // namespace

TEST_CASE("V1: weights, inputs and outputs of every texel") {
    const test::SpecificationSet set = test::MakeSpecificationSet(test::GetV1Shape());
    CHECK(Crc32(set.weights) == 0x2c7b7511);
    CheckSet(set, kV1Checks);
}

TEST_CASE("V2: weights, inputs and outputs of every texel") {
    const test::SpecificationSet set = test::MakeSpecificationSet(test::GetV2Shape());
    CHECK(Crc32(set.weights) == 0x442613aa);
    CheckSet(set, kV2Checks);
}
