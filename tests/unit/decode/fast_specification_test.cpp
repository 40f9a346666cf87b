// SPDX-License-Identifier: MIT
// Every kernel of the fast decoder against the whole-image checks of the format specification (network 12):
// sets V1 and V2, binary16 and binary32 outputs.
#include "FastDecoderCases.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/Half.h"

using namespace openntc;

namespace {

void Check(const decode_test::SpecificationShape& shape,
           std::span<const decode_test::SpecificationMip> checks) {
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
    for (const decode_test::FastTarget& target : decode_test::GetFastTargets(1)) {
        CAPTURE(std::string(target.name));
        for (const decode_test::SpecificationMip& check : checks) {
            CAPTURE(check.mip);
            const Rect rect{0, 0, check.width, check.height};
            const std::vector<float> binary32 =
                decode_test::DecodeFast(decode_test::GetSource(set), target, check.mip, rect, {});
            CHECK(Crc32(std::as_bytes(std::span(binary32))) == check.binary32);

            std::vector<std::uint16_t> half;
            for (const float value :
                 decode_test::DecodeFast(decode_test::GetSource(set), target, check.mip, rect,
                                         {.math = DecodeMath::Int8Half, .convertToLinear = false})) {
                half.push_back(FloatToHalf(value));
                REQUIRE(HalfToFloat(half.back()) == value);
            }
            CHECK(Crc32(std::as_bytes(std::span(half))) == check.half);
        }
    }
}

} // namespace

TEST_CASE("fast decoder: V1, every kernel") {
    Check(decode_test::GetV1Shape(), decode_test::kV1Mips);
}

TEST_CASE("fast decoder: V2, every kernel") {
    Check(decode_test::GetV2Shape(), decode_test::kV2Mips);
}

TEST_CASE("fast decoder: V1 at a texel of the specification") {
    // (13, 7, 0), binary32 outputs as listed.
    constexpr std::uint32_t kExpected[16] = {
        0x3ec6dc00, 0xbce30400, 0x3eb4f0a0, 0xbc7ed400, 0x3e106800, 0xbf77f220, 0x3f6cfa60, 0x3e2cc740,
        0xbe586980, 0x3ec32c40, 0xbf44d880, 0xbf6ec1d0, 0x3fb7e3a0, 0xbe332180, 0xbf1dfe00, 0xbd6fd600};
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV1Shape());
    for (const decode_test::FastTarget& target : decode_test::GetFastTargets(1)) {
        CAPTURE(std::string(target.name));
        const std::vector<float> outputs =
            decode_test::DecodeFast(decode_test::GetSource(set), target, 0, {13, 7, 1, 1}, {});
        for (std::size_t i = 0; i < 16; ++i)
            CHECK(std::bit_cast<std::uint32_t>(outputs[i]) == kExpected[i]);
    }
}
