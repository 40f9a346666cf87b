// SPDX-License-Identifier: MIT
// Collaboration and sharing on emulated waves of 4, 8 and 32 lanes: the filter's bits, counted decodes, and
// what happens where texels are too many.
#define NTC_STF_MAX_ROUNDS 32
#include "filtering/WaveEmulator.h"

#include "support/filtering/WaveCases.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>

using namespace openntc;

namespace {

struct EmulatedPixel {
    std::uint32_t words[WAVE_WORDS];
};

/// The pixels of one wave whose first is `origin`.
std::vector<EmulatedPixel> RunWave(const WaveScene& scene, std::uint32_t lanes, shader::int2 origin,
                                   openntc_filtering::WaveEmulator& wave) {
    std::vector<EmulatedPixel> pixels(lanes);
    const auto at = [&](std::uint32_t lane) { return origin + shader::GetWavePixel(lane); };
    wave.Execute(
        lanes, [&](std::uint32_t lane) { return !shader::IsWaveDiscarded(scene, at(lane)); },
        [&](std::uint32_t lane) {
            shader::waveDecodes = 0;
            shader::RunWavePixel(scene, at(lane), lane, true, pixels[lane].words);
        });
    return pixels;
}

bool IsSameBits(const EmulatedPixel& pixel) {
    return std::equal(pixel.words, pixel.words + 4, pixel.words + 4);
}

/// Decodes a pixel of waves that are magnified, over `phases` x `phases` places in a texel; 0 if any pixel
/// differs from the exact filter.
double MeasureDecodes(const WaveScene& start, std::uint32_t lanes, int phases,
                      openntc_filtering::WaveEmulator& wave, std::uint32_t& mostRounds) {
    double decodes = 0;
    int different = 0;
    for (int phase = 0; phase < phases * phases; ++phase) {
        WaveScene scene = start;
        scene.u = static_cast<float>((phase % phases + 0.37) / phases / 256 + 0.25);
        scene.v = static_cast<float>((phase / phases + 0.61) / phases / 256 + 0.5);
        for (const EmulatedPixel& pixel : RunWave(scene, lanes, {0, 0}, wave)) {
            decodes += pixel.words[8];
            mostRounds = std::max(mostRounds, pixel.words[8]);
            different += IsSameBits(pixel) ? 0 : 1;
        }
    }
    CHECK(different == 0);
    return decodes / (phases * phases) / lanes;
}

} // namespace

TEST_CASE("waves: collaboration has the exact filter's bits, and decodes what the table says") {
    // Decodes per pixel, aligned and turned by 45 degrees (specification, section 5.1).
    struct Row {
        double magnification;
        double bilinear32[2], cubic32[2], bilinear8[2], cubic8[2];
    };
    const Row table[] = {{1, {1.41, 1.51}, {2.41, 2.77}, {1.88, 2.04}, {4.38, 4.96}},
                         {1.5, {0.83, 0.94}, {1.62, 1.90}, {1.33, 1.50}, {3.51, 3.94}},
                         {2, {0.60, 0.70}, {1.29, 1.52}, {1.09, 1.24}, {3.09, 3.44}},
                         {4, {0.32, 0.38}, {0.85, 0.97}, {0.77, 0.86}, {2.53, 2.72}},
                         {8, {0.21, 0.24}, {0.67, 0.73}, {0.64, 0.68}, {2.24, 2.35}},
                         {16, {0.17, 0.18}, {0.58, 0.61}, {0.56, 0.59}, {2.13, 2.17}}};
    openntc_filtering::WaveEmulator wave;
    for (const Row& row : table) {
        for (const bool isTurned : {false, true}) {
            CAPTURE(row.magnification);
            CAPTURE(isTurned);
            const auto check = [&](std::uint32_t kernel, std::uint32_t lanes, const double(&expected)[2]) {
                std::uint32_t rounds = 0;
                const WaveScene scene = MakeWaveScene(kernel, row.magnification, isTurned);
                const int phases = lanes == 32 ? 3 : 6;
                const double decodes = MeasureDecodes(scene, lanes, phases, wave, rounds);
                // Along an axis the number of texels takes two values, and p phases on a lattice have their
                // shares within 1 / p; and half a digit of the table.
                const double taps = kernel == NTC_KERNEL_CUBIC ? 4 : 2;
                const double columns = (lanes == 32 ? 7 : 3) / row.magnification + taps;
                const double rows = (lanes == 32 ? 3 : 1) / row.magnification + taps;
                const double slack =
                    ((columns + 1.0 / phases) * (rows + 1.0 / phases) - columns * rows) / lanes;
                CHECK(std::fabs(decodes - expected[isTurned]) <= 0.005 + slack);
                CHECK(rounds <= 8);
            };
            check(NTC_KERNEL_BILINEAR, 8, row.bilinear8);
            check(NTC_KERNEL_CUBIC, 8, row.cubic8);
            check(NTC_KERNEL_BILINEAR, 32, row.bilinear32);
            check(NTC_KERNEL_CUBIC, 32, row.cubic32);
        }
    }
    // A quad, aligned: (1/m + 2)^2 / 4.
    for (const auto& [magnification, expected] :
         {std::pair{1.0, 2.25}, std::pair{2.0, 1.56}, std::pair{4.0, 1.27}}) {
        std::uint32_t rounds = 0;
        const WaveScene scene = MakeWaveScene(NTC_KERNEL_BILINEAR, magnification, false);
        CHECK(MeasureDecodes(scene, 4, 8, wave, rounds) == doctest::Approx(expected).epsilon(0.06));
    }
    CHECK(wave.GetFindings() == "");
}

TEST_CASE("waves: partial waves, keys, mips, islands, edges and every kernel have the exact filter's bits") {
    openntc_filtering::WaveEmulator wave;
    int exact = 0, all = 0, decodes = 0, exactDecodes = 0;
    std::uint32_t number = 0;
    for (std::uint32_t kernel = NTC_KERNEL_NEAREST; kernel <= NTC_KERNEL_GAUSSIAN; ++kernel) {
        for (const std::uint32_t flags :
             {0u, WAVE_DISCARD, WAVE_KEYS, WAVE_ISLANDS, WAVE_MIPS, WAVE_DISCARD | WAVE_KEYS | WAVE_MIPS,
              WAVE_ISLANDS | WAVE_DISCARD}) {
            for (std::uint32_t wrap = NTC_WRAP_REPEAT; wrap <= NTC_WRAP_BORDER; ++wrap) {
                CAPTURE(kernel);
                CAPTURE(flags);
                CAPTURE(wrap);
                ++number;
                WaveScene scene = MakeWaveScene(kernel, number % 3 == 0 ? 0.3 : 1.3, number % 2 == 0);
                scene.wrap = wrap;
                scene.flags = flags;
                scene.maxRounds = 32;
                scene.mips = number % 2;
                scene.taps = kernel == NTC_KERNEL_BILINEAR && number % 5 == 0 ? 3 : 1;
                scene.size = number % 4 == 0 ? 5 : 64;
                scene.lod = (flags & WAVE_MIPS) != 0 ? 20000 : 0;
                scene.u = number % 3 == 0 ? -0.01f : 0.97f; // over the edges
                scene.v = 0.99f;
                for (const EmulatedPixel& pixel : RunWave(scene, 8, {3, 1}, wave)) {
                    if (pixel.words[10] == 0)
                        continue;
                    ++all;
                    exact += IsSameBits(pixel) ? 1 : 0;
                    decodes += static_cast<int>(pixel.words[8]);
                    exactDecodes += static_cast<int>(pixel.words[9]);
                }
            }
        }
    }
    CHECK(exact == all);
    CHECK(all > 1000);
    CHECK(decodes < exactDecodes);
    CHECK(wave.GetFindings() == "");
    MESSAGE("pixels " << all << ", decodes " << decodes << " where the filter alone takes " << exactDecodes
                      << ", operations " << wave.GetMostOperations());
}

TEST_CASE("waves: what takes too many rounds is one texel a lane, unbiased") {
    // A pixel steps over four texels: nothing is shared, and a quad needs 4 rounds for bilinear, 16 for
    // cubic.
    const double logarithm = std::log(2 / 1e-6);
    openntc_filtering::WaveEmulator wave;
    for (std::uint32_t kernel = NTC_KERNEL_BILINEAR; kernel <= NTC_KERNEL_MITCHELL; ++kernel) {
        CAPTURE(kernel);
        WaveScene scene = MakeWaveScene(kernel, 0.25, true);
        scene.maxRounds = 2;
        scene.frames = 1;
        const std::uint32_t frames = 512;
        double sums[4] = {}, exact[4] = {};
        std::uint32_t most = 0;
        for (scene.frame = 0; scene.frame < frames; ++scene.frame) {
            const std::vector<EmulatedPixel> pixels = RunWave(scene, 4, {0, 0}, wave);
            for (std::size_t lane = 0; lane < 4; ++lane) {
                sums[lane] += double{std::bit_cast<float>(pixels[lane].words[0])};
                exact[lane] = double{std::bit_cast<float>(pixels[lane].words[4])};
                most = std::max(most, pixels[lane].words[8]);
            }
        }
        const bool isSigned = kernel == NTC_KERNEL_CATMULL_ROM || kernel == NTC_KERNEL_MITCHELL;
        CHECK(most == (isSigned ? 2u : 1u));
        const double range = isSigned ? 1.5626 : 1; // Q+ + Q-
        const double bound = range * (std::sqrt(logarithm / (2.0 * frames)) + 3 * 0x1p-15);
        for (std::size_t lane = 0; lane < 4; ++lane)
            CHECK(std::fabs(sums[lane] / frames - exact[lane]) <= bound);
    }
    CHECK(wave.GetFindings() == "");
}

TEST_CASE("waves: shared texels are a convex mean, and the exact filter where all are there") {
    openntc_filtering::WaveEmulator wave;
    int whole = 0;
    for (std::uint32_t frame = 0; frame < 200; ++frame) {
        WaveScene scene =
            MakeWaveScene(frame % 2 == 0 ? NTC_KERNEL_BILINEAR : NTC_KERNEL_CUBIC, 6, frame % 3 == 0);
        scene.flags = WAVE_SHARE | (frame % 5 == 0 ? WAVE_DISCARD | WAVE_KEYS : 0u);
        scene.span = frame % 4 == 0 ? 4 : 128;
        scene.frame = frame;
        scene.u = static_cast<float>(frame % 16) / 4096.0f;
        const std::uint32_t lanes = frame % 7 == 0 ? 32 : 8;
        const std::vector<EmulatedPixel> pixels = RunWave(scene, lanes, {0, 0}, wave);
        for (std::uint32_t lane = 0; lane < lanes; ++lane) {
            if (pixels[lane].words[10] == 0)
                continue;
            CHECK(pixels[lane].words[8] == 1); // one decode a lane
            const shader::WaveLookup lookup = shader::MakeWaveLookup(scene, shader::GetWavePixel(lane));
            float lowest = 2, highest = -1;
            const std::uint32_t taps =
                shader::NtcStfGetTapCount(lookup.settings, lookup.extent, lookup.footprint);
            for (std::uint32_t i = 0; i < taps; ++i) {
                const float value =
                    shader::WaveFetch(lookup.context, shader::NtcStfGetTap(lookup.settings, lookup.extent,
                                                                           lookup.uv, lookup.footprint, i))
                        .x;
                lowest = std::min(lowest, value);
                highest = std::max(highest, value);
            }
            const float value = std::bit_cast<float>(pixels[lane].words[0]);
            CHECK(value >= lowest - 0x1p-21f);
            CHECK(value <= highest + 0x1p-21f);
            const float exact = std::bit_cast<float>(pixels[lane].words[4]);
            whole += std::fabs(value - exact) <= 0x1p-21f ? 1 : 0;
        }
    }
    CHECK(whole > 100); // with the wave's texels a bilinear filter is often whole
    CHECK(wave.GetFindings() == "");
}
