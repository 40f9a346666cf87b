// SPDX-License-Identifier: MIT
// Half and E4M3 codecs against an independent model: exact decoding by ldexp in binary64, encoding by search.
#include "openntc/core/E4M3.h"
#include "openntc/core/Half.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

using namespace openntc;

namespace {

// The value by the definition of the format, in binary64 (exact), or NaN / infinity.
double DecodeByDefinition(unsigned bits, int exponentBits, int mantissaBits, int bias, bool hasInfinity) {
    const unsigned mantissa = bits & ((1u << mantissaBits) - 1u);
    const int exponent = static_cast<int>((bits >> mantissaBits) & ((1u << exponentBits) - 1u));
    const double sign = ((bits >> (exponentBits + mantissaBits)) & 1u) != 0 ? -1.0 : 1.0;
    const int top = (1 << exponentBits) - 1;
    if (exponent == top && hasInfinity)
        return mantissa == 0 ? sign * std::numeric_limits<double>::infinity() : std::nan("");
    if (exponent == top && mantissa == (1u << mantissaBits) - 1u)
        return std::nan("");
    const double significand = mantissa + (exponent == 0 ? 0.0 : std::ldexp(1.0, mantissaBits));
    return sign * std::ldexp(significand, (exponent == 0 ? 1 : exponent) - bias - mantissaBits);
}

bool SameBits(float a, double b) {
    if (std::isnan(b))
        return std::isnan(a);
    return static_cast<double>(a) == b && std::signbit(a) == std::signbit(b);
}

} // namespace

TEST_CASE("half: all 65536 patterns decode to their definition and encode to themselves") {
    for (unsigned bits = 0; bits < 65536; ++bits) {
        const float value = HalfToFloat(static_cast<std::uint16_t>(bits));
        REQUIRE(SameBits(value, DecodeByDefinition(bits, 5, 10, 15, true)));
        const std::uint16_t encoded = FloatToHalf(value);
        if (std::isnan(value))
            REQUIRE((encoded & 0x7C00u) == 0x7C00u);
        else
            REQUIRE(encoded == bits);
    }
}

TEST_CASE("half: rounding is to nearest, ties to even, between every pair of neighbours") {
    for (unsigned bits = 0; bits < 0x7BFF; ++bits) {
        const float low = HalfToFloat(static_cast<std::uint16_t>(bits));
        const float high = HalfToFloat(static_cast<std::uint16_t>(bits + 1));
        const float middle = (low + high) * 0.5f; // exact: one more mantissa bit
        const unsigned even = (bits & 1u) == 0 ? bits : bits + 1;
        for (const float sign : {1.0f, -1.0f}) {
            const unsigned signBit = sign < 0 ? 0x8000u : 0u;
            REQUIRE(FloatToHalf(sign * middle) == (even | signBit));
            REQUIRE(FloatToHalf(sign * std::nextafter(middle, 0.0f)) == (bits | signBit));
            REQUIRE(FloatToHalf(sign * std::nextafter(middle, 1e30f)) == ((bits + 1) | signBit));
        }
    }
    CHECK(FloatToHalf(65519.996f) == 0x7BFF);
    CHECK(FloatToHalf(65520.0f) == 0x7C00);
    CHECK(FloatToHalf(-65520.0f) == 0xFC00);
    CHECK(FloatToHalf(std::numeric_limits<float>::infinity()) == 0x7C00);
    CHECK(FloatToHalf(std::numeric_limits<float>::denorm_min()) == 0);
    CHECK(FloatToHalf(-std::numeric_limits<float>::denorm_min()) == 0x8000);
    CHECK((FloatToHalf(std::numeric_limits<float>::quiet_NaN()) & 0x7E00u) == 0x7E00u);
}

TEST_CASE("E4M3: all 256 patterns decode to their definition and encode to themselves") {
    for (unsigned bits = 0; bits < 256; ++bits) {
        const float value = E4M3ToFloat(static_cast<std::uint8_t>(bits));
        REQUIRE(SameBits(value, DecodeByDefinition(bits, 4, 3, 7, false)));
        REQUIRE(FloatToE4M3(value) == bits);
    }
}

TEST_CASE("E4M3: nearest-even between neighbours, saturating beyond 448") {
    for (unsigned bits = 0; bits < 0x7E; ++bits) {
        const float low = E4M3ToFloat(static_cast<std::uint8_t>(bits));
        const float high = E4M3ToFloat(static_cast<std::uint8_t>(bits + 1));
        const float middle = (low + high) * 0.5f;
        const unsigned even = (bits & 1u) == 0 ? bits : bits + 1;
        for (const float sign : {1.0f, -1.0f}) {
            const unsigned signBit = sign < 0 ? 0x80u : 0u;
            REQUIRE(FloatToE4M3(sign * middle) == (even | signBit));
            REQUIRE(FloatToE4M3(sign * std::nextafter(middle, 0.0f)) == (bits | signBit));
            REQUIRE(FloatToE4M3(sign * std::nextafter(middle, 1e30f)) == ((bits + 1) | signBit));
        }
    }
    for (const float large :
         {448.0f, 463.9f, 464.0f, 480.0f, 65504.0f, std::numeric_limits<float>::infinity()}) {
        CHECK(FloatToE4M3(large) == 0x7E);
        CHECK(FloatToE4M3(-large) == 0xFE);
    }
    CHECK(FloatToE4M3(std::numeric_limits<float>::quiet_NaN()) == 0x7F);
}

TEST_CASE("roundings equal those of the conversions, over all exponents and ties") {
    for (std::uint32_t sign : {0u, 0x80000000u}) {
        // Every half, the middle between neighbours, and both sides of the middle.
        for (std::uint32_t half = 0; half < 0x7bff; ++half) {
            const auto bits = std::bit_cast<std::uint32_t>(HalfToFloat(static_cast<std::uint16_t>(half)));
            const auto next = std::bit_cast<std::uint32_t>(HalfToFloat(static_cast<std::uint16_t>(half + 1)));
            for (std::uint32_t at :
                 {bits, bits + 1, (bits + next) / 2 - 1, (bits + next) / 2, (bits + next) / 2 + 1}) {
                const float value = std::bit_cast<float>(at | sign);
                REQUIRE(RoundToHalf(value) == HalfToFloat(FloatToHalf(value)));
                REQUIRE(RoundToE4M3(value) == E4M3ToFloat(FloatToE4M3(value)));
            }
        }
    }
    CHECK(RoundToE4M3(1e30f) == 448.0f);
}
