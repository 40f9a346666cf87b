// SPDX-License-Identifier: MIT
// Colour spaces and channel masks.
#include "openntc/ColorSpaces.h"
#define NETWORK_VERSION NTC_NETWORK_SMALL
#include "openntc/Inference.h"

#include "openntc/image/ColorEncoding.h"

#include <bit>
#include <cmath>
#include <initializer_list>

#include <doctest/doctest.h>

namespace shader = openntc::shader;

namespace {

constexpr double kRoundoff = 1.0 / 16777216.0; // 2^-24, one rounding to binary32

double DecodeSrgb(double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double DecodeHlg(double h) {
    const double m = std::fabs(h);
    const double e = m < 0.5 ? 4 * m * m : std::exp((m - 0.55991073) / 0.17883277) + 0.28466892;
    return h < 0 ? -e : e;
}

} // namespace

TEST_CASE("colours on the host have the bits of the shader source") {
    using openntc::ColorSpace;
    const auto differs = [](float a, float b) {
        return std::bit_cast<std::uint32_t>(a) != std::bit_cast<std::uint32_t>(b);
    };
    int different = 0;
    for (const ColorSpace space : {ColorSpace::Linear, ColorSpace::sRGB, ColorSpace::HLG}) {
        const int number = static_cast<int>(space);
        for (int i = -8192; i <= 100000; ++i) {
            const float value = static_cast<float>(i) / 8192.0f;
            different +=
                differs(openntc::image::DecodeColor(space, value), shader::NtcConvertToLinear(value, number));
            different += differs(openntc::image::EncodeColor(space, value),
                                 shader::NtcConvertFromLinear(value, number));
        }
    }
    CHECK(different == 0);
}

TEST_CASE("sRGB decoding stays within the bound of its roundings") {
    // Linear branch: the constant and the division, 2 roundings. Power branch: constants, sum and quotient
    // give at most 4 roundings in t, times the exponent 2.4; the exponent is rounded, which t feels 2.4 |ln
    // t| fold; powf itself is good to 1 ulp = 2 roundings. One more for second-order terms.
    for (int i = -4000; i <= 20000; ++i) {
        const float c = static_cast<float>(i) / 8192.0f;
        const double exact = DecodeSrgb(c);
        const double t = (std::fabs(c) + 0.055) / 1.055;
        const double bound = c <= 0.04045 ? 2.5 : 2.4 * 4 + 2.4 * std::fabs(std::log(t)) + 3;
        CAPTURE(c);
        CHECK(std::fabs(shader::NtcDecodeSrgb(c) - exact) <= bound * kRoundoff * std::fabs(exact));
    }
}

TEST_CASE("HLG decoding stays within the bound of its roundings") {
    // Square branch: 2 roundings. Exponential branch: x = (m - c) / a has the error of the constant c (half
    // an ulp at 0.56: half a rounding of 1) over a, and 3 roundings of x itself (difference, constant a,
    // quotient). exp turns the absolute error of x into a relative one and is good to 1 ulp = 2 roundings; b
    // and the sum add 2.
    for (int i = -16384; i <= 16384; ++i) {
        const float h = static_cast<float>(i) / 8192.0f;
        const double exact = DecodeHlg(h);
        const double x = (std::fabs(h) - 0.55991073) / 0.17883277;
        const double bound = std::fabs(h) < 0.5 ? 2.5 : 0.5 / 0.17883277 + 3 * std::fabs(x) + 2 + 2 + 1;
        CAPTURE(h);
        CHECK(std::fabs(shader::NtcDecodeHlg(h) - exact) <= bound * kRoundoff * std::fabs(exact));
    }
}

TEST_CASE("colour space check values") {
    CHECK(shader::NtcEncodeHlg(1.0f) == doctest::Approx(0.5).epsilon(1e-6));
    CHECK(shader::NtcEncodeHlg(2.0f) == doctest::Approx(0.65641).epsilon(1e-5));
    CHECK(shader::NtcEncodeHlg(12.0f) == doctest::Approx(0.99999999).epsilon(1e-6));
    CHECK(shader::NtcDecodeHlg(0.75f) == doctest::Approx(3.17955).epsilon(1e-5));
    CHECK(shader::NtcDecodeHlg(1.0f) == doctest::Approx(12.0000003).epsilon(1e-6));
    CHECK(shader::NtcDecodeHlg(-1.0f) == -shader::NtcDecodeHlg(1.0f));
    CHECK(shader::NtcEncodeHlg(-2.0f) == -shader::NtcEncodeHlg(2.0f));
    CHECK(shader::NtcEncodeSrgb(0.5f) == doctest::Approx(0.735356983).epsilon(1e-6));
    CHECK(shader::NtcEncodeSrgb(-0.5f) == doctest::Approx(-6.46).epsilon(1e-6));
    CHECK(shader::NtcDecodeSrgb(0.5f) == doctest::Approx(0.214041140).epsilon(1e-6));
    CHECK(shader::NtcDecodeSrgb(-0.5f) == doctest::Approx(-0.5 / 12.92).epsilon(1e-6));
    // Equal spaces leave every bit alone; different ones decode, then encode.
    CHECK(shader::NtcConvertColorSpace(0.3f, NTC_COLOR_SPACE_SRGB, NTC_COLOR_SPACE_SRGB) == 0.3f);
    CHECK(shader::NtcConvertColorSpace(0.3f, NTC_COLOR_SPACE_SRGB, NTC_COLOR_SPACE_HLG) ==
          shader::NtcEncodeHlg(shader::NtcDecodeSrgb(0.3f)));
    CHECK(shader::NtcConvertColorSpace(0.3f, NTC_COLOR_SPACE_HLG, NTC_COLOR_SPACE_LINEAR) ==
          shader::NtcDecodeHlg(0.3f));
    // Channel 1 sRGB, channel 15 HLG.
    const shader::uint spaces = (1u << 2) | (2u << 30);
    CHECK(shader::NtcConvertChannelToLinearColorSpace(0.7f, 0, spaces) == 0.7f);
    CHECK(shader::NtcConvertChannelToLinearColorSpace(0.7f, 1, spaces) == shader::NtcDecodeSrgb(0.7f));
    CHECK(shader::NtcConvertChannelToLinearColorSpace(0.7f, 15, spaces) == shader::NtcDecodeHlg(0.7f));
}

TEST_CASE("channel masks") {
    CHECK(shader::NtcGetChannelMask(0, 1) == 1u);
    CHECK(shader::NtcGetChannelMask(3, 4) == 0x78u);
    CHECK(shader::NtcGetChannelMask(0, 32) == 0xFFFFFFFFu);
    CHECK(shader::NtcGetChannelMask(31, 1) == 0x80000000u);
    CHECK(shader::NtcGetChannelMask(16, 32) == 0xFFFF0000u);
    CHECK(shader::NtcGetChannelMask(32, 1) == 0u);
    CHECK(shader::NtcGetChannelMask(5, 0) == 0u);
    CHECK(shader::NtcGetChannelMask(5, -3) == 0u);
    CHECK(shader::NtcGetChannelMask(-2, 4) == 3u);
    CHECK(shader::NtcGetChannelMask(-4, 4) == 0u);
    CHECK(shader::NtcGetChannelMask(INT32_MIN, INT32_MAX) == 0u);
    CHECK(shader::NtcGetChannelMask(INT32_MAX, INT32_MAX) == 0u);
    openntc::NtcTextureSetConstants desc{};
    desc.imageWidth = 100;
    desc.imageHeight = 37;
    desc.imageMips = 7;
    desc.validChannelMask = 0x1Fu;
    CHECK(shader::NtcGetValidChannelMask(desc) == 0x1Fu);
    CHECK(shader::NtcTextureSetHasChannels(desc, 0x11u));
    CHECK_FALSE(shader::NtcTextureSetHasChannels(desc, 0x21u));
    CHECK(shader::NtcTextureSetHasChannels(desc, 0u));
    CHECK(shader::NtcGetTextureMipLevels(desc) == 7);
    CHECK(shader::NtcGetTextureDimensions(desc, 0) == shader::int2(100, 37));
    CHECK(shader::NtcGetTextureDimensions(desc, 3) == shader::int2(12, 4));
    CHECK(shader::NtcGetTextureDimensions(desc, 6) == shader::int2(1, 1));
    CHECK(shader::NtcGetTextureDimensions(desc, 40) == shader::int2(1, 1));
}
