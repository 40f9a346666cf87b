// SPDX-License-Identifier: MIT
// The reference decoder with NTC_OPAQUE_ZERO, which languages without `precise` define: the same numbers as without it,
// bit for bit. A program of its own, because the functions have the names of those without.
#include <cstdint>

namespace {

volatile std::uint32_t opaqueZero = 0; // read each time: no compiler knows it

} // namespace

#define NTC_OPAQUE_ZERO opaqueZero

#include "unit/decode/ModeSets.h"

#include "openntc/decode/ReferenceDecoder.h"

namespace {

std::vector<float> DecodeWithOpaqueZero(const openntc::DecodeSource& source, int mip,
                                        const openntc::Rect& rect, const openntc::DecodeOptions& options) {
    std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
    REQUIRE(openntc::DecodeReference(source, mip, rect, options, outputs));
    return outputs;
}

} // namespace

TEST_CASE("with an opaque zero the reference has the checksums that it has without") {
    decode_test::CheckChecksums("reference with NTC_OPAQUE_ZERO", DecodeWithOpaqueZero);
}

TEST_CASE("the opaque zero is part of every maths mode") {
    // Were it not read, another number in its place would change nothing.
    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 19, 17);
    for (const openntc::DecodeMath math :
         {openntc::DecodeMath::Int8, openntc::DecodeMath::Int8Half, openntc::DecodeMath::FP8,
          openntc::DecodeMath::FP16, openntc::DecodeMath::FP32}) {
        CAPTURE(static_cast<int>(math));
        const std::uint32_t right = decode_test::GetChecksum(set, math, DecodeWithOpaqueZero);
        opaqueZero = 0x00600000u;
        const std::uint32_t other = decode_test::GetChecksum(set, math, DecodeWithOpaqueZero);
        opaqueZero = 0;
        CHECK(other != right);
    }
}
