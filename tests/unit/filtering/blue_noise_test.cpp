// SPDX-License-Identifier: MIT
// Blue noise: its histogram, its spectra, and what it does to means of decisions (specification, section 6).
#include "openntc/image/BlueNoise.h"
#include "support/CountingAllocator.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

using namespace openntc;

namespace {

constexpr int kNoiseSize = 32, kNoiseSlices = 16;
constexpr double kTwoPi = 6.283185307179586;

/// Power of a sequence at a whole frequency, relative to white noise of the same variance.
double GetPower(const std::vector<double>& values, double variance, int frequency) {
    std::complex<double> sum = 0;
    const double count = static_cast<double>(values.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        sum += values[i] * std::polar(1.0, -kTwoPi * frequency * static_cast<double>(i) / count);
    return std::norm(sum) / count / variance;
}

} // namespace

TEST_CASE("blue noise: every slice has every value, and few low frequencies") {
    const auto noise = image::MakeBlueNoise({kNoiseSize, kNoiseSlices, 1});
    REQUIRE(noise.has_value());
    const std::size_t slice = kNoiseSize * kNoiseSize;
    REQUIRE(noise->size() == slice * kNoiseSlices);
    const auto at = [&](int x, int y, int z) {
        return (*noise)[static_cast<std::size_t>((z * kNoiseSize + y) * kNoiseSize + x)] / 65536.0 - 0.5;
    };
    for (std::size_t z = 0; z < kNoiseSlices; ++z) {
        std::vector<int> values(noise->begin() + static_cast<std::ptrdiff_t>(z * slice),
                                noise->begin() + static_cast<std::ptrdiff_t>((z + 1) * slice));
        std::sort(values.begin(), values.end());
        for (std::size_t i = 0; i < slice; ++i)
            CHECK(values[i] == static_cast<int>((2 * i + 1) * 32));
    }
    // Space: mean power of all frequencies of a ring, over all slices.
    const double variance = 1.0 / 12;
    double rings[3] = {};
    int counts[3] = {};
    for (int z = 0; z < kNoiseSlices; ++z) {
        for (int fy = -8; fy <= 8; ++fy) {
            for (int fx = -8; fx <= 8; ++fx) {
                const double radius = std::sqrt(fx * fx + fy * fy) / kNoiseSize;
                if (radius == 0 || radius >= 0.25)
                    continue;
                std::complex<double> sum = 0;
                for (int y = 0; y < kNoiseSize; ++y) {
                    for (int x = 0; x < kNoiseSize; ++x)
                        sum += at(x, y, z) * std::polar(1.0, -kTwoPi * (fx * x + fy * y) / kNoiseSize);
                }
                const int ring = radius < 0.12 ? 0 : (radius < 0.16 ? 1 : 2);
                rings[ring] += std::norm(sum) / static_cast<double>(slice) / variance;
                ++counts[ring];
            }
        }
    }
    CHECK(rings[0] / counts[0] < 0.02);
    CHECK(rings[2] / counts[2] < 0.5);
    MESSAGE("power in space: " << rings[0] / counts[0] << ", " << rings[1] / counts[1] << ", "
                               << rings[2] / counts[2]);
    // Time: mean power of a texel's sequence.
    double times[4] = {};
    for (int i = 0; i < kNoiseSize * kNoiseSize; ++i) {
        std::vector<double> sequence;
        for (int z = 0; z < kNoiseSlices; ++z)
            sequence.push_back(at(i % kNoiseSize, i / kNoiseSize, z));
        for (int frequency = 0; frequency < 4; ++frequency)
            times[frequency] += GetPower(sequence, variance, frequency) / static_cast<double>(slice);
    }
    MESSAGE("power in time: " << times[0] << ", " << times[1] << ", " << times[2] << ", " << times[3]);
    CHECK(times[0] < 0.15);
    CHECK(times[1] < 0.15);
    // Means of decisions over frames, at ten thresholds, against those of white noise: 0.211 for 4 frames.
    // The specification's blue noise has 0.57, 0.47 and 0.34 of that.
    for (const int frames : {4, 8, 16}) {
        double squares = 0;
        int number = 0;
        for (double threshold = 0.05; threshold < 1; threshold += 0.1) {
            for (int i = 0; i < kNoiseSize * kNoiseSize; ++i) {
                int taken = 0;
                for (int z = 0; z < frames; ++z)
                    taken += at(i % kNoiseSize, i / kNoiseSize, z) + 0.5 < threshold ? 1 : 0;
                squares += std::pow(static_cast<double>(taken) / frames - threshold, 2);
                ++number;
            }
        }
        const double part = std::sqrt(squares / number) / (0.422 / std::sqrt(frames));
        CHECK(part < (frames == 4 ? 0.65 : (frames == 8 ? 0.55 : 0.4)));
        MESSAGE("decisions of " << frames << " frames: " << part << " of white noise's error");
    }
}

TEST_CASE("blue noise: fixed by its seed, and checked") {
    const auto one = image::MakeBlueNoise({16, 4, 1});
    const auto same = image::MakeBlueNoise({16, 4, 1});
    const auto other = image::MakeBlueNoise({16, 4, 2});
    REQUIRE((one && same && other));
    CHECK(std::equal(one->begin(), one->end(), same->begin()));
    CHECK_FALSE(std::equal(one->begin(), one->end(), other->begin()));
    for (const image::BlueNoiseDesc& desc :
         {image::BlueNoiseDesc{7, 4, 1}, image::BlueNoiseDesc{129, 1, 1}, image::BlueNoiseDesc{16, 0, 1},
          image::BlueNoiseDesc{16, 65, 1}, image::BlueNoiseDesc{128, 17, 1}}) {
        const auto refused = image::MakeBlueNoise(desc);
        REQUIRE_FALSE(refused.has_value());
        CHECK(refused.error().GetStatus() == Status::OutOfRange);
    }
    // Every refusal of memory is an error, and nothing is lost.
    for (std::size_t number = 0; number < 7; ++number) {
        test::CountingAllocator allocator;
        allocator.FailAt(number);
        {
            const auto refused = image::MakeBlueNoise({8, 2, 1}, allocator);
            REQUIRE_FALSE(refused.has_value());
            CHECK(refused.error().GetStatus() == Status::OutOfMemory);
        }
        CHECK(allocator.GetUsedBytes() == 0);
    }
}
