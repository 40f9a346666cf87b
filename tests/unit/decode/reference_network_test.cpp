// SPDX-License-Identifier: MIT
// Activation, requantisation, input quantisation and the dot product of the Int8 network.
#include "openntc/InputsPosition.h"
#include "openntc/Network.h"
#include "openntc/core/Crc32.h"
#include "openntc/core/Half.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <vector>

#include <doctest/doctest.h>

namespace shader = openntc::shader;

namespace {

int Signed(shader::uint byte) {
    return static_cast<std::int8_t>(byte);
}

} // namespace

TEST_CASE("requantisation of every finite half equals the format specification's CRCs") {
    std::vector<std::byte> half;
    std::vector<std::byte> binary32;
    for (const std::uint32_t sign : {0u, 0x8000u}) {
        for (std::uint32_t magnitude = 0; magnitude < 0x7C00u; ++magnitude) {
            const float z = openntc::HalfToFloat(static_cast<std::uint16_t>(sign | magnitude));
            half.push_back(static_cast<std::byte>(shader::NtcActivateHalf(z)));
            binary32.push_back(static_cast<std::byte>(shader::NtcActivateFloat(z)));
        }
    }
    CHECK(half.size() == 63488);
    CHECK(openntc::Crc32(half) == 0xb7293f8eu);
    CHECK(openntc::Crc32(binary32) == 0xd67d5454u);
}

TEST_CASE("requantisation check values of the format specification") {
    const struct {
        float z;
        int byte;
    } checks[] = {{-65504, -113}, {-1.5f, -113}, {-1.4f, -117}, {-1, -126},   {-0.75f, -128}, {-0.5f, -126},
                  {-0.25f, -121}, {-0.1f, -117}, {0, -113},     {0.1f, -109}, {0.25f, -101},  {0.5f, -86},
                  {0.75f, -68},   {1, -46},      {1.25f, -21},  {1.5f, 7},    {2, 47},        {2.5f, 87},
                  {2.99f, 126},   {3, 127},      {65504, 127}};
    for (const auto& check : checks) {
        CAPTURE(check.z);
        CHECK(Signed(shader::NtcActivateFloat(check.z)) == check.byte);
        CHECK(Signed(shader::NtcActivateHalf(check.z)) == check.byte);
    }
}

TEST_CASE("requantisation of numbers that are not finite or overflow half") {
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const auto activate : {shader::NtcActivateFloat, shader::NtcActivateHalf}) {
        CHECK(Signed(activate(infinity)) == 127);
        CHECK(Signed(activate(3e38f)) == 127);
        CHECK(Signed(activate(-infinity)) == -113);
        CHECK(Signed(activate(-3e38f)) == -113);
        CHECK(Signed(activate(nan)) == -113);
        CHECK(Signed(activate(-nan)) == -113);
    }
}

TEST_CASE("rounding to half equals the codec of the core library") {
    // Every half, the midpoints between neighbours, and their neighbouring floats.
    std::uint64_t wrong = 0;
    const auto check = [&](float x) {
        const float expected = openntc::HalfToFloat(openntc::FloatToHalf(x));
        wrong +=
            std::bit_cast<std::uint32_t>(shader::NtcRoundToHalf(x)) != std::bit_cast<std::uint32_t>(expected);
    };
    for (std::uint32_t half = 0; half < 0x7C00u; ++half) {
        const float value = openntc::HalfToFloat(static_cast<std::uint16_t>(half));
        const float next =
            half == 0x7BFFu ? 65536.0f : openntc::HalfToFloat(static_cast<std::uint16_t>(half + 1));
        const std::uint32_t middle = std::bit_cast<std::uint32_t>(value + (next - value) / 2);
        for (const std::uint32_t bits :
             {std::bit_cast<std::uint32_t>(value), middle - 1, middle, middle + 1}) {
            check(std::bit_cast<float>(bits));
            check(std::bit_cast<float>(bits | 0x80000000u));
        }
    }
    check(std::numeric_limits<float>::infinity());
    check(3e38f);
    check(1e-30f);
    CHECK(wrong == 0);
    CHECK(shader::NtcIsNan(shader::NtcRoundToHalf(std::numeric_limits<float>::quiet_NaN())));
}

TEST_CASE("the emulated dot product of all byte pairs, and of extremes in every lane") {
    std::uint64_t wrong = 0;
    for (std::uint32_t a = 0; a < 256; ++a) {
        for (std::uint32_t b = 0; b < 256; ++b) {
            const int product = static_cast<std::int8_t>(a) * static_cast<std::int8_t>(b);
            for (std::uint32_t lane = 0; lane < 4; ++lane)
                wrong += shader::NtcDot4Emulated(a << (8 * lane), b << (8 * lane)) != product ? 1u : 0u;
        }
    }
    CHECK(wrong == 0);
    CHECK(shader::NtcDot4Emulated(0x80808080u, 0x80808080u) == 65536);
    CHECK(shader::NtcDot4Emulated(0x7F7F7F7Fu, 0x80808080u) == -65024);
    CHECK(shader::NtcDot4Emulated(0x04030201u, 0x0403FF01u) == 1 - 2 + 9 + 16);
}

TEST_CASE("triangle wave and quantisation of inputs") {
    const struct {
        float t, wave;
    } waves[] = {{0, 1}, {0.25f, 0},  {0.5f, -1},  {0.75f, 0},
                 {1, 1}, {-0.25f, 0}, {-0.5f, -1}, {7.125f, 0.5f}};
    for (const auto& check : waves) {
        CAPTURE(check.t);
        CHECK(shader::NtcTriangleWave(check.t) == check.wave);
    }
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    CHECK(shader::NtcTriangleWave(8388608.0f) == 1.0f);
    CHECK(shader::NtcTriangleWave(8388607.5f) == -1.0f); // the last number with a fraction
    CHECK(shader::NtcTriangleWave(infinity) == 1.0f);
    CHECK(shader::NtcTriangleWave(nan) == 1.0f);
    CHECK(shader::NtcQuantizeInput(1.0f) == 127);
    CHECK(shader::NtcQuantizeInput(-1.0f) == -127);
    CHECK(shader::NtcQuantizeInput(0.5f) == 63);
    CHECK(shader::NtcQuantizeInput(-0.5f) == -63);
    CHECK(shader::NtcQuantizeInput(0.33333334f) == 42);
    CHECK(shader::NtcQuantizeInput(0.6666667f) == 85);
    CHECK(shader::NtcQuantizeInput(1.6666666f) == 127);
    CHECK(shader::NtcQuantizeInput(-2.0f) == -128);
    CHECK(shader::NtcQuantizeInput(infinity) == 127);
    CHECK(shader::NtcQuantizeInput(-infinity) == -128);
    CHECK(shader::NtcQuantizeInput(nan) == 0);
    // Texel 3 at scale 2, frequency 1/8: t = 0.75 -> 0; a quarter later t = 1 -> 1.
    CHECK(shader::NtcEncodePosition(6.0f, 0.0f, 0.125f) == 0x007F7F00u);
}
