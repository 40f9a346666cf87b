// SPDX-License-Identifier: MIT
// The Kaiser filter of mips, edges, normal maps.
#include "openntc/encode/Material.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numeric>

using namespace openntc;

namespace {

constexpr image::MipRule kKaiser{image::MipFilter::Kaiser, image::MipWrap::Wrap};
constexpr image::MipRule kKaiserClamp{image::MipFilter::Kaiser, image::MipWrap::Clamp};

/// Rounding of a sum of `taps` products along both axes, of values up to 1: each product and each sum rounds once, and the
/// weights' magnitudes sum to at most 1.4.
float GetRounding(int taps) {
    return 2.0f * 1.4f * static_cast<float>(taps + 1) * std::numeric_limits<float>::epsilon();
}

std::vector<float> MakeNoise(std::size_t count, std::uint32_t seed) {
    std::vector<float> values(count);
    for (float& value : values) {
        seed = seed * 1664525u + 1013904223u;
        value = static_cast<float>(seed >> 8) / 16777216.0f;
    }
    return values;
}

} // namespace

TEST_CASE("Kaiser: weights of halves have the values of another program, every axis filter sums to 1") {
    // sinc(x) I0(4 sqrt(1 - x^2 / 9)) / I0(4) at x = 1/4, 3/4, ..., 11/4, over twice its sum; mpmath with 30 digits.
    constexpr double kHalf[] = {0.443077048583,   0.133991725843,  -0.0656891784576,
                                -0.0339187608338, 0.0162323564863, 0.00630680837924};
    const auto filter = image::detail::MakeKaiserFilter(32, 16, image::MipWrap::Wrap);
    REQUIRE(filter.weights.size() == 16 * static_cast<std::size_t>(filter.count));
    for (int i = 0; i < 16; ++i) {
        std::vector<double> own(32);
        for (int k = 0; k < filter.count; ++k) {
            const auto at = static_cast<std::size_t>(i * filter.count + k);
            own[static_cast<std::size_t>(filter.indices[at])] += static_cast<double>(filter.weights[at]);
        }
        for (int k = 0; k < 6; ++k) {
            for (const int at : {2 * i + 1 + k, 2 * i - k})
                CHECK(own[static_cast<std::size_t>((at + 32) % 32)] ==
                      doctest::Approx(kHalf[k]).epsilon(1e-6));
        }
    }
    CHECK(image::detail::BesselI0(4.0) == doctest::Approx(11.3019219521363).epsilon(1e-13));
    CHECK(image::detail::BesselI0(1.0) == doctest::Approx(1.26606587775201).epsilon(1e-13));
    for (int source = 1; source <= 40; ++source) {
        for (const image::MipWrap wrap : {image::MipWrap::Wrap, image::MipWrap::Clamp}) {
            const int destination = std::max(source / 2, 1);
            const auto axis = image::detail::MakeKaiserFilter(source, destination, wrap);
            REQUIRE(axis.weights.size() == static_cast<std::size_t>(destination * axis.count));
            for (int i = 0; i < destination; ++i) {
                const auto begin = axis.weights.begin() + i * axis.count;
                CHECK(std::accumulate(begin, begin + axis.count, 0.0) == doctest::Approx(1.0).epsilon(1e-6));
            }
            for (const int index : axis.indices)
                REQUIRE((index >= 0 && index < source));
        }
    }
}

TEST_CASE("Kaiser: constants stay, the range is kept, the mean stays where edges wrap") {
    const std::vector<float> constant(11 * 6, 0.3f);
    for (const image::MipRule rule : {kKaiser, kKaiserClamp}) {
        for (const float value : image::MakeNextMip(constant, 11, 6, ColorSpace::Linear, {}, rule))
            CHECK(value == 0.3f); // sums would round, but the range of the source is one number
    }
    // Steps overshoot; masks must not.
    std::vector<float> step(32 * 4);
    for (std::size_t i = 0; i < step.size(); ++i)
        step[i] = i % 32 < 15 ? 0.0f : 1.0f;
    float lowest = 1.0f, highest = 0.0f;
    for (const float value : image::MakeNextMip(step, 32, 4, ColorSpace::Linear, {}, kKaiserClamp)) {
        lowest = std::min(lowest, value);
        highest = std::max(highest, value);
    }
    CHECK(lowest == 0.0f);
    CHECK(highest == 1.0f);
    // Every source texel has the same weights in all destination texels together (even sizes), so that the mean stays.
    // Noise between 0.4 and 0.6 and two outliers, so that no value is cut to the range.
    std::vector<float> noise = MakeNoise(64 * 32, 5);
    for (float& value : noise)
        value = 0.4f + 0.2f * value;
    noise[0] = 0.0f;
    noise[1] = 1.0f;
    const auto mip = image::MakeNextMip(noise, 64, 32, ColorSpace::Linear, {}, kKaiser);
    const auto mean = [](const std::vector<float>& values) {
        return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    };
    CHECK(std::fabs(mean(mip) - mean(noise)) < static_cast<double>(GetRounding(13)));
}

TEST_CASE("Kaiser: wrapped edges see the other side, clamped ones the last texel") {
    // One bright column at the right edge.
    constexpr int kWidth = 32;
    std::vector<float> texels(kWidth);
    texels[kWidth - 1] = 1.0f;
    const auto wrapped = image::MakeNextMip(texels, kWidth, 1, ColorSpace::Linear, {}, kKaiser);
    const auto clamped = image::MakeNextMip(texels, kWidth, 1, ColorSpace::Linear, {}, kKaiserClamp);
    REQUIRE(wrapped.size() == 16);
    // The first texel's centre is 1.5 source texels from the column on its left: 3/4 of its own.
    CHECK(wrapped[0] == doctest::Approx(0.133991725843).epsilon(1e-5));
    CHECK(clamped[0] == 0.0f);
    // The last one has the column once, or for all that lies beyond too.
    CHECK(wrapped[15] == doctest::Approx(0.443077048583).epsilon(1e-5));
    CHECK(clamped[15] == doctest::Approx(0.5).epsilon(1e-5));
    // A shift by two source texels is one by a texel of the mip, across the edge too.
    const std::vector<float> noise = MakeNoise(kWidth, 9);
    std::vector<float> shifted(kWidth);
    for (std::size_t i = 0; i < kWidth; ++i)
        shifted[(i + 2) % kWidth] = noise[i];
    const auto one = image::MakeNextMip(noise, kWidth, 1, ColorSpace::Linear, {}, kKaiser);
    const auto two = image::MakeNextMip(shifted, kWidth, 1, ColorSpace::Linear, {}, kKaiser);
    for (std::size_t i = 0; i < one.size(); ++i)
        CHECK(two[(i + 1) % 16] == doctest::Approx(one[i]).epsilon(1e-6));
    // Box looks nowhere else, odd sizes included.
    for (const int width : {32, 31}) {
        const std::vector<float> row(noise.begin(), noise.begin() + width);
        CHECK(image::MakeNextMip(row, width, 1, ColorSpace::Linear, {},
                                 {image::MipFilter::Box, image::MipWrap::Clamp}) ==
              image::MakeNextMip(row, width, 1, ColorSpace::Linear));
    }
}

TEST_CASE("Kaiser: keeps more of what the smaller mip can show than the box, and less of what it cannot") {
    // Amplitudes of waves of `periods` in 64 texels that become 32: 12 can be shown, 24 would alias to 8.
    const auto measure = [](int periods, image::MipRule rule) {
        std::vector<float> wave(64);
        for (std::size_t i = 0; i < 64; ++i)
            wave[i] = static_cast<float>(0.5 + 0.5 * std::cos(2.0 * 3.14159265358979 * periods *
                                                              (static_cast<double>(i) + 0.5) / 64.0));
        const auto mip = image::MakeNextMip(wave, 64, 1, ColorSpace::Linear, {}, rule);
        const auto [lowest, highest] = std::minmax_element(mip.begin(), mip.end());
        return *highest - *lowest;
    };
    constexpr image::MipRule kBox{};
    // The box's are cos(pi / 64 periods) at the centres that are hit: here 0.83 and 0.38 of what they were.
    CHECK(measure(12, kKaiser) > measure(12, kBox));
    CHECK(measure(24, kKaiser) < 0.1f * measure(24, kBox));
}

TEST_CASE("Kaiser: what is invisible does not bleed, and nothing visible is lost") {
    std::vector<float> color(64 * 8, 0.1f), alpha(64 * 8, 0.0f);
    for (std::size_t i = 0; i < color.size(); ++i) {
        if (i % 64 >= 13 && i % 64 < 40) {
            color[i] = 0.8f;
            alpha[i] = 1.0f;
        }
    }
    for (const image::MipRule rule : {kKaiser, kKaiserClamp}) {
        const auto mip = image::MakeNextMip(color, 64, 8, ColorSpace::Linear, alpha, rule);
        const auto seen = image::MakeNextMip(alpha, 64, 8, ColorSpace::Linear, {}, rule);
        for (std::size_t i = 0; i < mip.size(); ++i) {
            if (seen[i] > 0.5f / 255.0f)
                CHECK(mip[i] == doctest::Approx(0.8f).epsilon(1e-4));
            REQUIRE((mip[i] >= 0.1f && mip[i] <= 0.8f));
        }
    }
}

TEST_CASE("normal maps: mips are unit vectors along the average, with and without z") {
    // A bumpy hemisphere of unit normals.
    constexpr int kSize = 16;
    std::vector<float> three, two;
    for (int y = 0; y < kSize; ++y) {
        for (int x = 0; x < kSize; ++x) {
            const float nx = 0.7f * std::sin(0.9f * static_cast<float>(x)),
                        ny = 0.6f * std::cos(1.3f * static_cast<float>(y));
            const float nz = std::sqrt(1.0f - nx * nx - ny * ny);
            for (const float n : {nx, ny, nz})
                three.push_back(0.5f + 0.5f * n);
            two.push_back(0.5f + 0.5f * nx);
            two.push_back(0.5f + 0.5f * ny);
        }
    }
    for (const image::MipFilter filter : {image::MipFilter::Box, image::MipFilter::Kaiser}) {
        encode::Material material = *encode::Material::Create(kSize, kSize);
        REQUIRE(material.AddTexture({.name = "Xyz", .firstChannel = 0, .channels = 3}, three));
        REQUIRE(material.AddTexture({.name = "Xy", .firstChannel = 4, .channels = 2}, two));
        for (const int c : {0, 1, 2, 4, 5})
            REQUIRE(material.SetMipRule(c, {filter, image::MipWrap::Wrap}));
        encode::Material plain = material;
        REQUIRE(material.SetNormalMap(0, 3));
        REQUIRE(material.SetNormalMap(4, 2));
        material.GenerateMips();
        plain.GenerateMips();
        double shortest = 1.0;
        for (int m = 0; m < material.GetMipCount(); ++m) {
            for (std::size_t i = 0; i < material.GetPlane(m, 0).size(); ++i) {
                const auto get = [&](const encode::Material& from, int channel) {
                    return 2.0 * static_cast<double>(from.GetPlane(m, channel)[i]) - 1.0;
                };
                const double n[3] = {get(material, 0), get(material, 1), get(material, 2)};
                const double average[3] = {get(plain, 0), get(plain, 1), get(plain, 2)};
                const double length = std::hypot(average[0], average[1], average[2]);
                shortest = std::min(shortest, length);
                // A stored value rounds to half of 2^-24, which is 2^-24 of n's component: three of them and the quotient.
                REQUIRE(std::fabs(std::hypot(n[0], n[1], n[2]) - 1.0) < 4.0 * std::ldexp(1.0, -23));
                for (int c = 0; c < 3; ++c)
                    REQUIRE(std::fabs(n[c] - average[c] / length) < std::ldexp(1.0, -20));
                // With z made of x and y the same; what it loses in 2 sums of squares is at most a few times as much.
                for (int c = 0; c < 2; ++c)
                    REQUIRE(std::fabs(get(material, 4 + c) - n[c]) < std::ldexp(1.0, -18));
            }
        }
        CHECK(shortest < 0.8); // without the mend they would not be unit vectors
    }
}

TEST_CASE("normal maps: vectors that cancel become +z, given mips stay, wrong channels are refused") {
    encode::Material material = *encode::Material::Create(4, 2);
    std::vector<float> texels;
    for (int i = 0; i < 8; ++i) { // +x and -x in turn
        texels.push_back(i % 2 == 0 ? 1.0f : 0.0f);
        texels.push_back(0.5f);
        texels.push_back(0.5f);
    }
    REQUIRE(material.AddTexture({.name = "N", .channels = 3}, texels));
    CHECK_FALSE(material.SetNormalMap(0, 1));
    CHECK_FALSE(material.SetNormalMap(1, 3));
    CHECK_FALSE(material.SetMipRule(3, {}));
    REQUIRE(material.SetNormalMap(0, 3));
    for (int c = 0; c < 3; ++c)
        REQUIRE(material.SetMip(2, c, {0.25f}));
    material.GenerateMips();
    for (std::size_t i = 0; i < 2; ++i) {
        CHECK(material.GetPlane(1, 0)[i] == 0.5f);
        CHECK(material.GetPlane(1, 1)[i] == 0.5f);
        CHECK(material.GetPlane(1, 2)[i] == 1.0f);
    }
    for (int c = 0; c < 3; ++c)
        CHECK(material.GetPlane(2, c)[0] == 0.25f);
    CHECK(material.GetPlane(0, 0)[0] == 1.0f);
}

TEST_CASE(
    "coverage: within half a texel of mip 0's at every size and filter, where no two texels are alike") {
    constexpr int kSize = 64;
    const std::vector<float> alpha = MakeNoise(kSize * kSize, 77);
    for (const image::MipFilter filter : {image::MipFilter::Box, image::MipFilter::Kaiser}) {
        for (const float threshold : {0.25f, 0.5f, 0.8f}) {
            encode::Material material = *encode::Material::Create(kSize, kSize);
            REQUIRE(material.AddTexture({.name = "A", .channels = 1}, alpha));
            REQUIRE(material.SetMipRule(0, {filter, image::MipWrap::Wrap}));
            encode::Material plain = material;
            REQUIRE(material.KeepCoverage(0, threshold));
            material.GenerateMips();
            plain.GenerateMips();
            const double wanted = image::MeasureCoverage(alpha, threshold);
            double lost = 0.0;
            for (int m = 0; m < material.GetMipCount(); ++m) {
                CAPTURE(m);
                const auto count = static_cast<double>(material.GetPlane(m, 0).size());
                CHECK(std::fabs(image::MeasureCoverage(material.GetPlane(m, 0), threshold) - wanted) <=
                      0.5 / count);
                lost = std::max(lost,
                                std::fabs(image::MeasureCoverage(plain.GetPlane(m, 0), threshold) - wanted));
            }
            CHECK((threshold == 0.5f || lost > 0.2)); // averages gather around one half
        }
    }
}
