// SPDX-License-Identifier: MIT
// Energy, symmetry, continuity, edges.
#include "FilterKit.h"

#include "support/filtering/FilterItems.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>

using namespace openntc_tests;

namespace {

struct UnitContext {};

stf::float4 FetchOnes(UnitContext, stf::NtcStfTap) {
    return {1.0f, 0.1f, 3.0f, 1000.0f};
}

} // namespace

namespace openntc::shader {
namespace {
NTC_STF_DEFINE_FILTER(FilterOnes, float4, UnitContext, FetchOnes)
}
} // namespace openntc::shader

TEST_CASE("filtering: weights add up, constants stay") {
    const double sums[] = {1, 65536, 6 * 0x1p24, 2 * 0x1p24, 18 * 0x1p24};
    const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(37, 100, 5);
    for (std::uint32_t i = 0; i < 4096; ++i) {
        const std::uint32_t fraction = i < 3 ? i : (i < 6 ? 65538 - i : i * 16 + 5);
        for (const NamedFilter& filter : GetFilters(NTC_WRAP_MIRROR)) {
            const char* const name = filter.name;
            const stf::NtcStfSampler& settings = filter.settings;
            const stf::NtcStfAxis axis = stf::NtcStfGetAxis(settings, MakeShiftedCoord(fraction));
            double integers = 0;
            float reals = 0;
            for (int k = 0; k < axis.count; ++k) {
                integers += axis.weights[k];
                reals += stf::NtcStfGetWeight(axis, k);
            }
            if (settings.kernelType != NTC_KERNEL_GAUSSIAN)
                CHECK(integers == sums[settings.kernelType]);
            CHECK_MESSAGE(std::fabs(reals - 1) <= 4 * 0x1p-24f, name << " at " << fraction);
        }
    }
    double largest = 0;
    for (std::uint32_t i = 0; i < 2000; ++i) {
        const stf::uint4 words = stf::NtcStfPcg4d(i, 2, 3, 4);
        const stf::float2 uv(static_cast<float>(words.x / 4294967296.0),
                             static_cast<float>(words.y / 4294967296.0));
        for (const NamedFilter& filter : GetFilters(NTC_WRAP_MIRROR)) {
            const char* const name = filter.name;
            const stf::NtcStfSampler& settings = filter.settings;
            const stf::NtcStfFootprint whole =
                stf::NtcStfMakeFootprint(settings, extent, static_cast<int>(words.z % 5) * 65536);
            const stf::float4 value = stf::FilterOnes({}, settings, extent, uv, whole);
            const float expected[] = {1.0f, 0.1f, 3.0f, 1000.0f};
            for (int k = 0; k < 4; ++k) {
                // Four units of the last place of 1, in proportion.
                const double error = std::fabs(double{value[k]} / double{expected[k]} - 1) * 0x1p23;
                largest = std::max(largest, error);
                CHECK_MESSAGE(error <= 4, name << ": " << value[k]);
            }
            const stf::NtcStfPair pair =
                stf::NtcStfSamplePair(settings, extent, uv, whole, {words.x >> 16, words.y >> 16, 0, 0});
            if (!stf::NtcStfIsSigned(settings)) {
                CHECK(pair.first.scale == 1.0f); // constants come out bit for bit
                CHECK(pair.second.scale == 0.0f);
            } else {
                // Q+ - Q- is 1 up to the roundings of four products and two sums below 1.3.
                CHECK(std::fabs(pair.first.scale + pair.second.scale - 1) <= 0x1p-21f);
                CHECK(pair.first.scale <= 1.2813f);
                const stf::NtcStfTap one = stf::NtcStfSample(settings, extent, uv, whole, {0, 0, 0, 0});
                CHECK(std::fabs(one.scale) >= 1.0f - 0x1p-22f);
                CHECK(std::fabs(one.scale) <= 1.5626f);
            }
        }
    }
    MESSAGE("largest error of a constant, in units of its last place: " << largest);
}

TEST_CASE("filtering: all taps of every lookup weigh 1") {
    for (const FilterItem& item : MakeFilterItems(4000, 9, true)) {
        if (item.kind != FILTER_EXACT && item.kind != FILTER_PART && item.kind != FILTER_TAP)
            continue;
        const stf::NtcStfSampler settings = stf::GetFilterSampler(item);
        const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(item.width, item.height, item.levels);
        const stf::NtcStfFootprint footprint = stf::GetFilterFootprint(item);
        const stf::float2 uv(std::bit_cast<float>(item.u), std::bit_cast<float>(item.v));
        const std::uint32_t count = stf::NtcStfGetTapCount(settings, extent, footprint);
        double sum = 0;
        for (std::uint32_t i = 0; i < count; ++i)
            sum += double{stf::NtcStfGetTap(settings, extent, uv, footprint, i).scale};
        // Every product of four numbers is off by at most 3 roundings, and weights' magnitudes add up to
        // 1.57.
        CHECK(std::fabs(sum - 1) < 16 * 0x1p-24);
    }
}

TEST_CASE("filtering: mirrored textures, whole periods and reflections") {
    // Numbers of taps over all draws; (texel in x) of one row.
    const auto count = [](const stf::NtcStfSampler& settings, float u, int size) {
        std::vector<double> counts(static_cast<std::size_t>(size));
        const stf::NtcStfAxis axis = stf::NtcStfGetAxis(
            settings, stf::NtcGetTexelCoord(u, static_cast<std::uint32_t>(size), settings.wrapX));
        const std::vector<int> draws = CountDraws(axis, NTC_STF_ALL);
        for (int k = 0; k < axis.count; ++k)
            counts[static_cast<std::size_t>(stf::NtcAddressTexel(axis.first + k, size, settings.wrapX))] +=
                draws[static_cast<std::size_t>(k)];
        return counts;
    };
    for (const std::uint32_t wrap : kWraps) {
        if (wrap == NTC_WRAP_BORDER)
            continue; // has no texel there
        for (const NamedFilter& filter : GetFilters(wrap)) {
            const char* const name = filter.name;
            const stf::NtcStfSampler& settings = filter.settings;
            if (settings.kernelType == NTC_KERNEL_NEAREST)
                continue; // takes the upper texel on an edge, from either side
            for (const int size : {1, 2, 5, 37, 64}) {
                for (const float u : {0.0f, 0.1875f, 0.3046875f, 0.5f, 0.96875f, 1.0f}) {
                    CAPTURE(name);
                    CAPTURE(u);
                    CAPTURE(size);
                    const std::vector<double> counts = count(settings, u, size);
                    const auto check = [&](float other, bool reversed) {
                        const std::vector<double> others = count(settings, other, size);
                        for (std::size_t k = 0; k < counts.size(); ++k) {
                            // A draw may change hands at each of up to eight thresholds, folded ones on one
                            // texel; weights at t and 1 - t differ by up to 42 / (18 * 2^24) of 65536: less
                            // than 1.
                            const double slack = 2.0 * (size < 8 ? 8 : 1);
                            CHECK(std::fabs(counts[k] - others[reversed ? counts.size() - 1 - k : k]) <=
                                  slack);
                        }
                    };
                    check(1 - u, true);
                    if (wrap == NTC_WRAP_REPEAT)
                        check(u + 1, false);
                    if (wrap == NTC_WRAP_MIRROR) {
                        check(-u, false);
                        check(2 - u, false);
                    }
                }
            }
        }
    }
    // Whole periods give the same integers.
    for (const float u : {0.0f, 0.1875f, 0.3046875f, 0.5f, 0.96875f}) {
        for (const std::uint32_t size : {1u, 5u, 37u, 4096u}) {
            const stf::NtcTexelCoord here = stf::NtcGetTexelCoord(u, size, NTC_WRAP_REPEAT);
            const stf::NtcTexelCoord there = stf::NtcGetTexelCoord(u + 1, size, NTC_WRAP_REPEAT);
            CHECK(here.fraction == there.fraction);
            CHECK(here.texel == there.texel);
        }
    }
}

TEST_CASE("filtering: continuous across texels and mips") {
    for (const NamedFilter& filter : GetFilters(NTC_WRAP_CLAMP)) {
        const char* const name = filter.name;
        const stf::NtcStfSampler& settings = filter.settings;
        if (settings.kernelType == NTC_KERNEL_NEAREST)
            continue;
        CAPTURE(name);
        for (const float sigma : {0.5f, 0.6f, 0.7f, 1.0f, 1.35f}) {
            stf::NtcStfSampler one = settings;
            if (one.kernelType == NTC_KERNEL_GAUSSIAN)
                one = stf::NtcStfMakeGaussian(sigma, NTC_WRAP_CLAMP);
            const stf::NtcStfAxis before = stf::NtcStfGetAxis(one, MakeShiftedCoord(65535));
            stf::NtcTexelCoord next = MakeShiftedCoord(0);
            next.texel += 1;
            const stf::NtcStfAxis after = stf::NtcStfGetAxis(one, next);
            REQUIRE(after.first == before.first + 1);
            for (int k = 0; k <= before.count; ++k) {
                const float left = k < before.count ? stf::NtcStfGetWeight(before, k) : 0.0f;
                const float right = k > 0 ? stf::NtcStfGetWeight(after, k - 1) : 0.0f;
                CHECK(std::fabs(left - right) < 0x1p-14f);
            }
        }
        if (settings.mips != NTC_MIPS_LINEAR)
            continue;
        const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(64, 64, 4);
        const stf::NtcStfFootprint before = stf::NtcStfMakeFootprint(settings, extent, 65535);
        const stf::NtcStfFootprint after = stf::NtcStfMakeFootprint(settings, extent, 65536);
        const stf::NtcStfPart coarse = stf::NtcStfGetPart(settings, extent, {0.3f, 0.4f}, before, 1);
        const stf::NtcStfPart same = stf::NtcStfGetPart(settings, extent, {0.3f, 0.4f}, after, 0);
        CHECK(coarse.mip == 1);
        CHECK(same.mip == 1);
        CHECK(same.weight - coarse.weight == 0x1p-16f);
    }
}

TEST_CASE("filtering: edges of textures, coordinates and derivatives stay inside") {
    const float specials[] = {std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(),
                              0x1p24f,
                              16777215.0f,
                              1e-40f,
                              0.0f,
                              1.0f,
                              64.5f,
                              0.999999f};
    std::size_t taps = 0;
    for (const auto& [width, height] :
         {std::pair{1, 1}, std::pair{1, 7}, std::pair{2, 2}, std::pair{16384, 3}}) {
        for (const std::uint32_t wrap : kWraps) {
            for (const NamedFilter& filter : GetFilters(wrap)) {
                const char* const name = filter.name;
                const stf::NtcStfSampler& settings = filter.settings;
                for (const float special : specials) {
                    for (const int levels : {1, 2, 15}) {
                        CAPTURE(name);
                        CAPTURE(special);
                        const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(width, height, levels);
                        const stf::float2 uv(special, -special);
                        for (const stf::float2 ddx : {stf::float2(special, 0), stf::float2(0, -special),
                                                      stf::float2(0, 0), stf::float2(0.5f, 0.25f)}) {
                            const stf::NtcStfFootprint footprint =
                                stf::NtcStfGetFootprint(settings, extent, ddx, stf::float2(ddx.y, 0.001f));
                            CHECK(footprint.lod >= 0);
                            CHECK(footprint.lod <= (levels - 1) * 65536);
                            CHECK(footprint.taps >= 1);
                            CHECK(footprint.taps <= settings.maxAnisotropy);
                            for (const std::uint32_t r : {0u, 32767u, 65535u}) {
                                const stf::NtcStfTap tap =
                                    stf::NtcStfSample(settings, extent, uv, footprint, {r, r, r, r});
                                REQUIRE(tap.mip >= 0);
                                REQUIRE(tap.mip < levels);
                                ++taps;
                                if (tap.isBorder) {
                                    CHECK(wrap == NTC_WRAP_BORDER);
                                    continue;
                                }
                                CHECK(tap.texel.x >= 0);
                                CHECK(tap.texel.y >= 0);
                                CHECK(tap.texel.x < std::max(width >> tap.mip, 1));
                                CHECK(tap.texel.y < std::max(height >> tap.mip, 1));
                            }
                        }
                    }
                }
            }
        }
    }
    MESSAGE("taps: " << taps);
    // NaN and infinities: the coarsest mip; nothing: the finest. An anisotropy of 1 is none.
    const stf::NtcStfSampler settings = stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT);
    const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(256, 256, 9);
    for (const float bad : {specials[0], -specials[0], specials[1], -specials[1]})
        CHECK(stf::NtcStfGetFootprint(settings, extent, {0, 0}, {bad, 0}).lod == 8 * 65536);
    CHECK(stf::NtcStfGetFootprint(settings, extent, {0, 0}, {0, 0}).lod == 0);
    CHECK(stf::NtcStfGetFootprint(settings, extent, {1.0f / 64, 0}, {0, 1.0f / 256}).lod == 2 * 65536);
    CHECK(stf::NtcStfGetFootprint(settings, extent, {1.0f / 64, 0}, {0, 1.0f / 256}).taps == 1);
    // A Gaussian that is too narrow or nonsense is the narrowest.
    for (const float sigma : {0.0f, -1.0f, 0.1f, specials[0]})
        CHECK(stf::NtcStfMakeGaussian(sigma, NTC_WRAP_CLAMP).sigma == 0.5f);
    CHECK(stf::NtcStfMakeGaussian(9.0f, NTC_WRAP_CLAMP).sigma == 1.35f);
}
