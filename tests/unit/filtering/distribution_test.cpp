// SPDX-License-Identifier: MIT
// Distributions: every random number once, hashed numbers by chi square, means by bounds of probability.
#include "FilterKit.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

using namespace openntc_tests;

namespace {

/// Fractions of a texel at which distributions are enumerated.
std::vector<std::uint32_t> GetFractions() {
    std::vector<std::uint32_t> fractions = {0, 1, 2, 32767, 32768, 65535};
    for (std::uint32_t k = 1; 777 * k < 65536; k += 12)
        fractions.push_back(777 * k);
    return fractions;
}

/// Critical values of chi square at 1e-6, by degrees of freedom. From 16 on Wilson and Hilferty's
/// approximation with the quantile 4.7534 of the normal distribution, which is above the table's by less
/// than 1 % there.
double GetCriticalValue(int freedom) {
    const double table[] = {23.93, 27.64, 30.66, 33.38, 35.89, 38.26, 40.52, 42.70,
                            44.81, 46.87, 48.87, 50.83, 52.75, 54.64, 56.49};
    if (freedom <= 15)
        return table[freedom - 1];
    const double part = 2.0 / (9.0 * freedom);
    return freedom * std::pow(1 - part + 4.7534 * std::sqrt(part), 3) * 1.01;
}

/// Chances of taps of an axis, from the integers that decide.
std::vector<double> GetChances(const stf::NtcStfAxis& axis) {
    std::vector<double> chances;
    for (const int count : CountDraws(axis, NTC_STF_ALL))
        chances.push_back(count / 65536.0);
    return chances;
}

} // namespace

TEST_CASE("filtering: over all random numbers taps are as frequent as their weights") {
    for (const std::uint32_t fraction : GetFractions()) {
        CAPTURE(fraction);
        for (const NamedFilter& filter : GetFilters(NTC_WRAP_CLAMP)) {
            const char* const name = filter.name;
            const stf::NtcStfSampler& settings = filter.settings;
            CAPTURE(name);
            const stf::NtcStfAxis axis = stf::NtcStfGetAxis(settings, MakeShiftedCoord(fraction));
            const double slack = settings.kernelType == NTC_KERNEL_GAUSSIAN ? 2 : 1;
            for (std::uint32_t part = NTC_STF_ALL; part <= NTC_STF_NEGATIVE; ++part) {
                const std::uint32_t total = stf::NtcStfGetTotal(axis, part);
                if (total == 0)
                    continue;
                const std::vector<int> counts = CountDraws(axis, part);
                for (int k = 0; k < axis.count; ++k) {
                    const double expected = 65536.0 * stf::NtcStfGetMass(axis, k, part) / total;
                    CHECK(std::fabs(counts[static_cast<std::size_t>(k)] - expected) < slack);
                }
            }
        }
        // The bilinear draw compares with the fraction itself, and mips with theirs.
        const stf::NtcStfSampler bilinear = stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, NTC_WRAP_CLAMP);
        const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(1, 1, 4);
        const stf::NtcStfExtent wide = stf::NtcStfMakeExtent(1024, 1, 4);
        // 1024 texels: u has a fraction in steps of 2^-14 of a texel at most.
        const float u = (5.0f + static_cast<float>((fraction + 32768) & ~15u) / 65536.0f) / 1024.0f;
        const stf::NtcStfFootprint fine = stf::NtcStfMakeFootprint(bilinear, wide, 0);
        std::uint32_t second = 0, coarser = 0;
        for (std::uint32_t r = 0; r < 65536; ++r) {
            const stf::NtcStfTap tap = stf::NtcStfSample(bilinear, wide, {u, 0.5f}, fine, {r, 0, 0, 0});
            second += tap.texel.x == 6 ? 1 : 0;
            coarser += stf::NtcStfDrawMip(bilinear, extent, 65536 + static_cast<int>(fraction), r) == 2;
        }
        CHECK(second == (fraction & ~15u));
        CHECK(coarser == fraction);
    }
}

TEST_CASE("filtering: a stretched decision leaves a uniform number") {
    // Every quotient has threshold * (65536 - threshold) preimages; the ends of each are where they must be.
    for (const std::uint32_t threshold : {1u, 2u, 3u, 777u, 32767u, 32768u, 40000u, 65534u, 65535u}) {
        CAPTURE(threshold);
        for (const std::uint32_t rest : {0u, 1u, 1000u, 32768u, 65534u, 65535u}) {
            const auto check = [&](std::uint32_t first, std::uint32_t count, bool taken) {
                for (const std::uint32_t word : {first, first + count - 1}) {
                    const stf::NtcStfDecision decision = stf::NtcStfStretch(word, threshold);
                    CHECK(decision.isTaken == taken);
                    CHECK(decision.rest == rest);
                }
            };
            check(rest * threshold, threshold, true);
            check((threshold << 16) + rest * (65536 - threshold), 65536 - threshold, false);
        }
    }
}

TEST_CASE("filtering: hashed numbers draw taps as their weights say (chi square)") {
    const std::uint32_t lookups = 1u << 20;
    const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(64, 48, 3);
    std::uint32_t number = 0;
    for (const NamedFilter& filter : GetFilters(NTC_WRAP_REPEAT)) {
        const char* const name = filter.name;
        stf::NtcStfSampler settings = filter.settings;
        if (settings.kernelType == NTC_KERNEL_NEAREST)
            settings.mips = NTC_MIPS_LINEAR; // a texel of either mip: else there is nothing to draw
        for (const stf::float2 uv : {stf::float2(0.3711f, 0.6437f), stf::float2(-1.219f, 7.0931f)}) {
            CAPTURE(name);
            CAPTURE(uv.x);
            const stf::NtcStfFootprint footprint =
                settings.maxAnisotropy > 1
                    ? stf::NtcStfGetFootprint(settings, extent, {0.13f, 0.031f}, {-0.006f, 0.033f})
                    : stf::NtcStfMakeFootprint(settings, extent, 24117);
            std::map<std::tuple<int, int, int>, std::pair<double, std::uint32_t>> cells;
            const std::uint32_t parts = stf::NtcStfCountParts(settings, extent, footprint);
            for (std::uint32_t i = 0; i < parts; ++i) {
                const stf::NtcStfPart part = stf::NtcStfGetPart(settings, extent, uv, footprint, i);
                const std::vector<double> x = GetChances(part.x), y = GetChances(part.y);
                for (int k = 0; k < part.x.count * part.y.count; ++k) {
                    const int column = k % part.x.count, row = k / part.x.count;
                    const stf::NtcStfTap tap = stf::NtcStfPlaceTap(settings, extent, part.x.first + column,
                                                                   part.y.first + row, part.mip);
                    cells[{tap.texel.x, tap.texel.y, tap.mip}].first += x[static_cast<std::size_t>(column)] *
                                                                        y[static_cast<std::size_t>(row)] *
                                                                        double{part.weight};
                }
            }
            for (std::uint32_t i = 0; i < lookups; ++i) {
                const stf::uint4 random = stf::NtcStfRandomHashed(
                    {static_cast<int>(i % 1024), static_cast<int>(i / 1024)}, 3, number, 1);
                const stf::NtcStfTap tap = stf::NtcStfSample(settings, extent, uv, footprint, random);
                ++cells[{tap.texel.x, tap.texel.y, tap.mip}].second;
            }
            double sum = 0, fewExpected = 0, fewSeen = 0;
            int freedom = -1;
            const auto add = [&](double expected, double seen) {
                sum += (seen - expected) * (seen - expected) / expected;
                ++freedom;
            };
            for (const auto& [texel, cell] : cells) {
                const double expected = cell.first * lookups;
                if (expected >= 5) {
                    add(expected, cell.second);
                } else {
                    fewExpected += expected;
                    fewSeen += cell.second;
                }
            }
            if (fewExpected >= 5)
                add(fewExpected, fewSeen);
            else
                CHECK(fewSeen <= 40); // 5 expected: more has a chance below 1e-20
            REQUIRE(freedom >= (settings.kernelType == NTC_KERNEL_NEAREST ? 1 : 3));
            CHECK_MESSAGE(sum < GetCriticalValue(freedom), sum << " with " << freedom << " degrees");
            ++number;
        }
    }
    CHECK(number == 16);
}

TEST_CASE("filtering: means converge to the exact filter within bounds of probability") {
    // min of Hoeffding's and Bernstein's bounds at 1e-6, and 3 * 2^-15 for the thresholds' 16 bits.
    const double logarithm = std::log(2 / 1e-6);
    int checks = 0;
    double largest = 0;
    for (const std::uint32_t wrap : kWraps) {
        for (const NamedFilter& filter : GetFilters(wrap)) {
            const char* const name = filter.name;
            const stf::NtcStfSampler& settings = filter.settings;
            for (std::uint32_t position = 0; position < 24; ++position) {
                const stf::uint4 words = stf::NtcStfPcg4d(position, wrap, settings.kernelType, 5);
                const double span = position % 3 == 0 ? 5 : 1; // some outside
                const stf::float2 uv(static_cast<float>((words.x / 4294967296.0 - 0.5) * span + 0.5),
                                     static_cast<float>((words.y / 4294967296.0 - 0.5) * span + 0.5));
                const stf::NtcStfExtent extent =
                    stf::NtcStfMakeExtent(1 + static_cast<int>(words.z % 40), 37, 5);
                stf::NtcStfFootprint footprint =
                    stf::NtcStfMakeFootprint(settings, extent, static_cast<int>(words.w % 250000) - 20000);
                if (settings.maxAnisotropy > 1)
                    footprint = stf::NtcStfGetFootprint(settings, extent, {0.11f, 0.03f}, {0.01f, 0.02f});
                const FilterMoments moments = GetMoments(settings, extent, uv, footprint);
                const bool isSigned = stf::NtcStfIsSigned(settings);
                double sum = 0, range = 1;
                for (std::uint32_t n = 1; n <= 1u << 14; ++n) {
                    const stf::uint4 random = stf::NtcStfRandomHashed({static_cast<int>(position), 9}, n,
                                                                      wrap, settings.kernelType);
                    const stf::NtcStfPair pair =
                        stf::NtcStfSamplePair(settings, extent, uv, footprint, random);
                    sum += double{pair.first.scale} * GetValue(pair.first) +
                           double{pair.second.scale} * GetValue(pair.second);
                    if (isSigned)
                        range =
                            std::max(range, double{pair.first.scale} - double{pair.second.scale}); // Q+ + Q-
                    if (n != 1u << 8 && n != 1u << 12 && n != 1u << 14)
                        continue;
                    const double hoeffding = range * std::sqrt(logarithm / (2.0 * n));
                    const double bernstein =
                        std::sqrt(2 * moments.variance * logarithm / n) + range * logarithm / (3.0 * n);
                    const double bound =
                        (isSigned ? hoeffding : std::min(hoeffding, bernstein)) + 3 * 0x1p-15 * range;
                    const double error = std::fabs(sum / n - moments.mean);
                    largest = std::max(largest, error / bound);
                    CHECK_MESSAGE(error <= bound, name << " at " << uv.x << ", " << uv.y << ": " << error);
                    ++checks;
                }
            }
        }
    }
    MESSAGE("largest error in its bound: " << largest << " of " << checks);
    CHECK(checks == 4 * 8 * 24 * 3);
}

TEST_CASE("filtering: errors fall with the square root of the number of frames, with R2 faster") {
    const stf::NtcStfSampler settings = stf::NtcStfMakeSampler(NTC_KERNEL_BILINEAR, NTC_WRAP_REPEAT);
    const stf::NtcStfExtent extent = stf::NtcStfMakeExtent(512, 512, 1);
    const stf::NtcStfFootprint footprint = stf::NtcStfMakeFootprint(settings, extent, 0);
    const int positions = 256;
    std::map<std::uint32_t, double> hashed, even;
    double variance = 0;
    for (int position = 0; position < positions; ++position) {
        const stf::uint4 words = stf::NtcStfPcg4d(static_cast<std::uint32_t>(position), 1, 2, 3);
        const stf::float2 uv(static_cast<float>(words.x / 4294967296.0),
                             static_cast<float>(words.y / 4294967296.0));
        const FilterMoments moments = GetMoments(settings, extent, uv, footprint);
        variance += moments.variance / positions;
        double hashedSum = 0, evenSum = 0;
        for (std::uint32_t n = 1; n <= 4096; ++n) {
            const auto sample = [&](stf::uint4 random) {
                return GetValue(stf::NtcStfSample(settings, extent, uv, footprint, random));
            };
            hashedSum += sample(stf::NtcStfRandomHashed({position, 0}, n, 0, 0));
            evenSum += sample(stf::NtcStfRandomR2(words, n));
            if (n == 16 || n == 64 || n == 256 || n == 4096) {
                hashed[n] += std::pow(hashedSum / n - moments.mean, 2) / positions;
                even[n] += std::pow(evenSum / n - moments.mean, 2) / positions;
            }
        }
    }
    for (const std::uint32_t n : {16u, 256u, 4096u}) {
        const double ratio = std::sqrt(hashed[n] / (variance / n));
        CHECK(ratio > 0.7); // a standard deviation is 0.055
        CHECK(ratio < 1.3);
    }
    // The specification's RMSE of R2, of other texels, within as much.
    for (const std::pair<std::uint32_t, double>& row :
         {std::pair{16u, 0.034}, std::pair{64u, 0.011}, std::pair{256u, 0.0034}}) {
        CAPTURE(row.first);
        CHECK(std::sqrt(even[row.first]) < 1.3 * row.second);
        CHECK(std::sqrt(even[row.first]) > 0.7 * row.second);
    }
    CHECK(std::sqrt(even[4096]) < 0.0006); // nearly 1 / N
}
