// SPDX-License-Identifier: MIT
// BC7 with the device's dot product (NTC_DOT4_SPIRV in shaders), compiled as C++ with an emulated one: the
// search finds what the CPU's finds.
#include "openntc/bc/BlockEncoder.h"

#include <doctest/doctest.h>

#include <random>

// The encoder once more, in a namespace of its own.
#undef OPENNTC_BC7_H
#undef OPENNTC_BC7_AXES_H
#undef OPENNTC_BC7_ENDPOINTS_H
#undef OPENNTC_BC7_ESTIMATE_H
#undef OPENNTC_BC7_INDICES_H
#undef OPENNTC_BC7_MODES_H
#undef OPENNTC_BC7_TABLES_H
#undef OPENNTC_LANES_H
#undef NTC_BC7_PLANES
#undef NTC_LANES_TARGET
#define NTC_BC7_PLANES 1
#define NTC_LANES_TARGET planes
#if defined(__clang__) // as bc/detail/Kernels.h, where the reasons stand
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpass-failed"
#elif defined(__GNUC__)
#pragma GCC push_options
#pragma GCC optimize("no-aggressive-loop-optimizations")
#endif
#include "openntc/bc/Bc7.h"
#if defined(__clang__)
#pragma clang diagnostic pop
#elif defined(__GNUC__)
#pragma GCC pop_options
#endif
#undef NTC_BC7_PLANES
#undef NTC_LANES_TARGET
#define NTC_BC7_PLANES 0
#define NTC_LANES_TARGET lanes1

namespace {

namespace texels = openntc::shader::lanes1;
namespace planes = openntc::shader::planes;

/// Smooth, noise, two colours; alpha opaque, varying or 0.
void MakePlanesBlock(std::mt19937& random, int kind, int (&x)[64]) {
    int ends[8];
    for (int& end : ends)
        end = static_cast<int>(random() >> 24);
    for (int t = 0; t < 16; ++t) {
        const bool isSecond = random() % 2 != 0;
        for (int c = 0; c < 4; ++c) {
            const int smooth = ends[c] + (ends[4 + c] - ends[c]) * (t % 4 + t / 4) / 6;
            const int noise = static_cast<int>(random() >> 24);
            x[4 * t + c] = kind % 3 == 0 ? smooth : kind % 3 == 1 ? noise : isSecond ? ends[c] : ends[4 + c];
        }
        if (kind % 4 != 3)
            x[4 * t + 3] = kind % 4 == 2 ? 0 : 255;
    }
}

} // namespace

TEST_CASE("bc7: sums of four texels at once rank partitions and rotations as sums of single ones do") {
    std::mt19937 random(21);
    int different = 0;
    for (int kind = 0; kind < 240; ++kind) {
        int x[64];
        MakePlanesBlock(random, kind, x);
        const int quality = kind / 4 % 3;
        const auto expected = texels::NtcBc7Search(x, quality, 0xFF, -1);
        const auto coding = planes::NtcBc7Search(x, quality, 0xFF, -1);
        bool isSame = coding.choice == expected.choice && coding.error == expected.error;
        for (int e = 0; e < 6; ++e)
            isSame = isSame && coding.ends.ends[e] == expected.ends.ends[e];
        different += isSame ? 0 : 1;
        // Spreads themselves: every covariance is the same.
        texels::NtcBc7Terms ownTerms;
        texels::NtcBc7Spread own;
        texels::NtcBc7MakeTerms(x, ownTerms, own);
        planes::NtcBc7Terms planeTerms;
        planes::NtcBc7Spread spread;
        planes::NtcBc7MakeTerms(x, planeTerms, spread);
        const auto mask = static_cast<std::uint32_t>(random() & 0xFFFF) | 1U;
        const int count = texels::NtcBc7CountBits(mask);
        texels::NtcBc7Collect(4, ownTerms, mask, own);
        planes::NtcBc7Collect(4, planeTerms, mask, spread);
        constexpr int kPairs[10][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
                                       {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
        for (int p = 0; p < 10; ++p) {
            const auto covariance = [&](const auto& of) {
                return of.product[p] * count - of.sum[kPairs[p][0]] * of.sum[kPairs[p][1]];
            };
            different += covariance(spread) != covariance(own) ? 1 : 0;
        }
    }
    CHECK(different == 0);
}
