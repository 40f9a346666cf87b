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

std::uint32_t GetInputsCrc(const decode_test::SpecificationSet& set,
                           const decode_test::SpecificationMip& check) {
    std::vector<std::byte> bytes;
    for (int y = 0; y < check.height; ++y) {
        for (int x = 0; x < check.width; ++x) {
            shader::uint words[NTC_MAX_INPUT_WORDS];
            REQUIRE(shader::NtcPrepareNetworkInputs(set.networkVersion, set.constants,
                                                    {set.latents.data(), set.latents.size()}, 0,
                                                    shader::int2(x, y), check.mip, words));
            for (shader::uint i = 0; i < shader::NtcGetInputWords(set.networkVersion); ++i)
                decode_test::detail::Append(bytes, words[i]);
        }
    }
    return Crc32(bytes);
}

std::vector<float> Decode(const decode_test::SpecificationSet& set,
                          const decode_test::SpecificationMip& check, DecodeMath math) {
    std::vector<float> outputs(static_cast<std::size_t>(check.width * check.height * NTC_MAX_CHANNELS));
    const Expected<void> result =
        DecodeReference(decode_test::GetSource(set), check.mip, {0, 0, check.width, check.height},
                        {.math = math, .convertToLinear = false}, outputs);
    if (!result)
        FAIL(std::string(result.error().GetText()));
    return outputs;
}

void CheckSet(const decode_test::SpecificationSet& set,
              std::span<const decode_test::SpecificationMip> checks) {
    for (const decode_test::SpecificationMip& check : checks) {
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
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV1Shape());
    CHECK(Crc32(set.weights) == 0x2c7b7511);
    CheckSet(set, decode_test::kV1Mips);
}

TEST_CASE("V2: weights, inputs and outputs of every texel") {
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV2Shape());
    CHECK(Crc32(set.weights) == 0x442613aa);
    CheckSet(set, decode_test::kV2Mips);
}
