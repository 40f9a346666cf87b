// SPDX-License-Identifier: MIT
// Mip filtering: linear light, exact areas.
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
