// SPDX-License-Identifier: MIT
// FLIP against the specification's values, section 5.
#include "Flip.h"

#include "openntc/StochasticFiltering.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

using namespace openntc::tool;

namespace {

constexpr int kFlipSide = 64;

std::vector<float> MakeFlipPicture(const std::function<double(int x, int y, int c)>& channel) {
    std::vector<float> picture;
    for (int y = 0; y < kFlipSide; ++y) {
        for (int x = 0; x < kFlipSide; ++x) {
            for (int c = 0; c < 3; ++c)
                picture.push_back(static_cast<float>(std::floor(channel(x, y, c) * 255 + 0.5) / 255));
        }
    }
    return picture;
}

double GetPattern(int x, int y, int c) {
    return c == 0 ? x / 63.0 : c == 1 ? y / 63.0 : (x / 8 + y / 8) % 2;
}

} // namespace

TEST_CASE("renderer FLIP: the values of the specification") {
    const auto flat = [](double r, double g, double b) {
        return MakeFlipPicture([=](int, int, int c) { return c == 0 ? r : c == 1 ? g : b; });
    };
    const std::vector<float> pattern = MakeFlipPicture(GetPattern);
    std::vector<float> hole = pattern;
    std::fill_n(hole.begin() + (32 * kFlipSide + 32) * 3, 3, 0.0f);
    struct Row {
        std::vector<float> reference, test;
        double mean, maximum, corner, middle;
    };
    const double g = 1.0 / 255;
    const Row rows[] = {
        {flat(0, 0, 0), flat(1, 1, 1), 0.967380, 0.967380, 0.967380, 0.967380},
        {flat(128 * g, 128 * g, 128 * g), flat(129 * g, 129 * g, 129 * g), 0.029855, 0.029855, 0.029855,
         0.029855},
        {flat(0, 1, 0), flat(0, 0, 1), 1, 1, 1, 1},
        {pattern, MakeFlipPicture([](int x, int y, int c) { return GetPattern(std::max(x - 1, 0), y, c); }),
         0.171823, 0.476207, 0.027609, 0.176994},
        {pattern, MakeFlipPicture([](int x, int y, int c) {
             const std::uint32_t hash =
                 openntc::shader::NtcStfPcg(static_cast<std::uint32_t>(64 * y + x)) >> 24;
             const double own = std::floor(GetPattern(x, y, c) * 255 + 0.5) / 255;
             return std::clamp(own + 0.1 * hash / 255 - 0.05, 0.0, 1.0);
         }),
         0.087123, 0.220308, 0.023422, 0.086695},
        {pattern, hole, 0.000773, 0.189053, 0, 0.189053}};
    for (const Row& row : rows) {
        const FlipResult result = ComputeFlip(row.reference, row.test, kFlipSide, kFlipSide);
        CHECK(std::fabs(result.mean - row.mean) <= 2e-5);
        CHECK(std::fabs(result.maximum - row.maximum) <= 2e-5);
        CHECK(std::fabs(static_cast<double>(result.map[0]) - row.corner) <= 2e-5);
        CHECK(std::fabs(static_cast<double>(result.map[32 * kFlipSide + 32]) - row.middle) <= 2e-5);
        CHECK(ComputeFlip(row.reference, row.test, kFlipSide, kFlipSide, 3).map == result.map);
    }
    CHECK(ComputeFlip(pattern, pattern, kFlipSide, kFlipSide).maximum == 0.0);
    // Smaller than the filters.
    CHECK(ComputeFlip(std::vector<float>(3, 0.0f), std::vector<float>(3, 1.0f), 1, 1).mean > 0.96);
}
