// SPDX-License-Identifier: MIT
// Mip filtering: linear light, exact areas.
#include "openntc/encode/Material.h"
#include "openntc/image/MipGeneration.h"

#include <doctest/doctest.h>

#include <numeric>

using namespace openntc;

TEST_CASE("pairs are averaged in linear light") {
    const std::vector<float> texels = {0.0f, 1.0f, 0.0f, 1.0f};
    const auto linear = image::MakeNextMip(texels, 2, 2, ColorSpace::Linear);
    REQUIRE(linear.size() == 1);
    CHECK(linear[0] == doctest::Approx(0.5f));
    // sRGB of linear 0.5 by IEC 61966-2-1.
    CHECK(image::MakeNextMip(texels, 2, 2, ColorSpace::sRGB)[0] == doctest::Approx(0.735357f).epsilon(1e-5));
    // HLG: (0 + 12) / 2 = 6 nominal.
    CHECK(image::MakeNextMip(texels, 2, 2, ColorSpace::HLG)[0] == doctest::Approx(0.87164f).epsilon(1e-4));
}

TEST_CASE("odd sizes keep the mean") {
    std::vector<float> texels(7 * 5);
    std::iota(texels.begin(), texels.end(), 0.0f);
    const auto mip = image::MakeNextMip(texels, 7, 5, ColorSpace::Linear);
    REQUIRE(mip.size() == 3 * 2);
    const float mean = std::accumulate(mip.begin(), mip.end(), 0.0f) / 6.0f;
    CHECK(mean == doctest::Approx(17.0f)); // of 0 ... 34
    // 2 1/3 columns: (0 + 1 + 2/3) / (7/3) = 5/7; 2 1/2 rows: (0 + 1 + 2/2) / (5/2) = 4/5, times 7 per row.
    CHECK(mip[0] == doctest::Approx(5.6f + 5.0f / 7.0f));
    CHECK(image::GetFullMipCount(7, 5) == 3);
    CHECK(image::GetFullMipCount(1, 1) == 1);
}

TEST_CASE("weights are alpha: what is invisible does not bleed, and counts alike where all is") {
    // Opaque 1 beside transparent 0; half of a half-visible 0.25.
    const std::vector<float> texels = {1.0f, 0.0f, 0.25f, 0.75f}, alpha = {1.0f, 0.0f, 0.5f, 0.0f};
    const auto mip = image::MakeNextMip(texels, 2, 2, ColorSpace::Linear, alpha);
    CHECK(mip[0] == doctest::Approx((1.0 + 0.5 * 0.25) / 1.5));
    const std::vector<float> none(4, 0.0f), negative(4, -1.0f);
    CHECK(image::MakeNextMip(texels, 2, 2, ColorSpace::Linear, none)[0] == doctest::Approx(0.5f));
    CHECK(image::MakeNextMip(texels, 2, 2, ColorSpace::Linear, negative)[0] == doctest::Approx(0.5f));
    // In linear light: only the opaque texel counts, whatever its neighbour.
    const std::vector<float> red = {0.8f, 0.1f}, seen = {1.0f, 0.0f};
    CHECK(image::MakeNextMip(red, 2, 1, ColorSpace::sRGB, seen)[0] == doctest::Approx(0.8f));
    // Two steps give the average over all that is seen, as one step would.
    const std::vector<float> row = {1.0f, 0.0f, 0.0f, 0.0f, 0.5f, 0.5f, 0.0f, 0.0f},
                             rowAlpha = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 1.0f, 0.0f, 0.0f};
    auto color = row, weight = rowAlpha;
    for (int width = 8; width > 1; width /= 2) {
        color = image::MakeNextMip(color, width, 1, ColorSpace::Linear, weight);
        weight = image::MakeNextMip(weight, width, 1, ColorSpace::Linear);
    }
    CHECK(color[0] == doctest::Approx(2.0f / 3.0f));
    CHECK(weight[0] == doctest::Approx(3.0f / 8.0f));
}

TEST_CASE("alpha is scaled to the coverage that was asked for, as nearly as its values allow") {
    const auto scale = [](std::vector<float> alpha, float threshold, double coverage) {
        image::ScaleToCoverage(alpha, threshold, coverage);
        return alpha;
    };
    // Three of eight wanted: the third largest, 0.4, becomes the threshold: factor 1.25.
    const std::vector<float> alpha = {0.8f, 0.4f, 0.1f, 0.0f, 0.6f, 0.2f, 0.3f, 0.0f};
    const auto scaled = scale(alpha, 0.5f, 3.0 / 8.0);
    CHECK(image::MeasureCoverage(scaled, 0.5f) == 3.0 / 8.0);
    CHECK(scaled[0] == doctest::Approx(1.0f));
    CHECK(scaled[1] >= 0.5f);
    CHECK(scaled[4] == doctest::Approx(0.75f));
    CHECK(scaled[6] == doctest::Approx(0.375f));
    CHECK(scaled[3] == 0.0f);
    // Too much coverage is taken back; values above 1 are cut.
    CHECK(image::MeasureCoverage(scale({0.9f, 0.8f, 0.7f, 0.6f}, 0.5f, 0.25), 0.5f) == 0.25);
    CHECK(scale({0.9f, 0.1f}, 0.5f, 1.0)[0] == 1.0f);
    // Equal values go together: one of four is nearer to none than to four; two are not.
    CHECK(image::MeasureCoverage(scale({0.6f, 0.6f, 0.6f, 0.6f}, 0.5f, 0.25), 0.5f) == 0.0);
    CHECK(image::MeasureCoverage(scale({0.2f, 0.2f, 0.2f, 0.2f}, 0.5f, 0.5), 0.5f) == 1.0);
    // Nothing can pass that is 0, and thresholds that no factor meets exactly are met.
    CHECK(scale({0.0f, 0.0f}, 0.5f, 1.0) == std::vector<float>{0.0f, 0.0f});
    for (int i = 1; i < 2000; ++i) {
        const float value = 0.001f * static_cast<float>(i) * 0.5f;
        REQUIRE(image::MeasureCoverage(scale({value, 0.0f}, 1.0f / 3.0f, 0.5), 1.0f / 3.0f) == 0.5);
        REQUIRE(image::MeasureCoverage(scale({value, 0.0f}, 1.0f / 3.0f, 0.0), 1.0f / 3.0f) == 0.0);
    }
}

TEST_CASE("a material weighs and scales its mips by the channels that it was told") {
    encode::Material material = *encode::Material::Create(16, 16);
    std::vector<float> texels;
    for (int i = 0; i < 256; ++i) { // one column of eight is an opaque 0.9, the rest a transparent 0.1
        const bool seen = i % 8 == 0;
        texels.push_back(seen ? 0.9f : 0.1f);
        texels.push_back(seen ? 1.0f : 0.0f);
    }
    REQUIRE(material.AddTexture({.name = "Leaf", .firstChannel = 2, .channels = 2}, texels));
    CHECK_FALSE(material.WeighMips(2, 4));
    CHECK_FALSE(material.WeighMips(16, 3));
    CHECK_FALSE(material.KeepCoverage(1, 0.5f));
    CHECK_FALSE(material.KeepCoverage(3, 0.0f));
    CHECK_FALSE(material.KeepCoverage(3, 1.5f));
    REQUIRE(material.WeighMips(2, 3));
    encode::Material kept = material;
    REQUIRE(kept.KeepCoverage(3, 0.5f));
    material.GenerateMips();
    kept.GenerateMips();
    for (int m = 1; m < 4; ++m) {
        CAPTURE(m);
        // One column of 8 >> m is seen, with equal alpha 1 / 2^m: an eighth is as near to all of them as to
        // none in the first mip, and nearer to none in the others.
        const int columns = 8 >> m;
        for (std::size_t i = 0; i < material.GetPlane(m, 2).size(); ++i) {
            const bool seen = static_cast<int>(i) % columns == 0;
            REQUIRE(material.GetPlane(m, 2)[i] == doctest::Approx(seen ? 0.9f : 0.1f));
            REQUIRE(material.GetPlane(m, 3)[i] ==
                    doctest::Approx(seen ? 1.0f / static_cast<float>(1 << m) : 0.0f));
            REQUIRE(kept.GetPlane(m, 2)[i] == material.GetPlane(m, 2)[i]);
        }
        CHECK(image::MeasureCoverage(kept.GetPlane(m, 3), 0.5f) == (m == 1 ? 1.0 / columns : 0.0));
    }
}
