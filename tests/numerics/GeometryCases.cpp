// SPDX-License-Identifier: MIT
// Where texels meet latents.
#include "Decoders.h"
#include "HardCases.h"

#include <algorithm>
#include <cmath>

namespace numerics {

namespace {

using namespace openntc;

SynthesisDesc Describe(int width, int height, int mips, const LatentShape& shape) {
    SynthesisDesc synthesis;
    synthesis.seed = static_cast<std::uint32_t>(width * 7919 + height);
    synthesis.desc = {width, height, 16, mips};
    synthesis.shape = shape;
    synthesis.networkVersion = NTC_NETWORK_SMALL;
    return synthesis;
}

double CompareSize(int width, int height, int mips, const LatentShape& shape, std::size_t stride) {
    const TestSet set(conformance::SynthesizeBytes(Describe(width, height, mips, shape)));
    const std::vector<Texel> texels = set.ListTexels(stride);
    return std::max(Compare(set, DecodeMath::Int8, texels), Compare(set, DecodeMath::Int8Half, texels));
}

Measurement MeasureTexelsOnLatents() {
    return {
        std::max(CompareSize(100, 37, 4, {4, 4, 4, 8, 4}, 3), CompareSize(94, 94, 4, {3, 4, 4, 8, 8}, 17)),
        {}};
}

Measurement MeasureClampedTaps() {
    double worst = 0;
    for (const auto& [width, height] : {std::pair(1, 1), {1, 40}, {40, 1}, {2, 3}, {5, 33}, {33, 5}, {7, 7}})
        worst = std::max(worst, CompareSize(width, height, 1, {2, 4, 4, 4, 8}, 1));
    return {worst, {}};
}

Measurement MeasureSlivers() {
    return {
        std::max({CompareSize(257, 33, 9, {4, 4, 8, 2, 4}, 61), CompareSize(4096, 2, 13, {4, 4, 4, 4, 4}, 61),
                  CompareSize(1, 300, 9, {8, 4, 4, 8, 1}, 5), CompareSize(300, 1, 9, {8, 4, 4, 1, 8}, 5),
                  CompareSize(1, 1, 1, {4, 4, 4, 2, 2}, 1), CompareSize(94, 94, 7, {8, 4, 4, 2, 4}, 211)}),
        {}};
}

Measurement MeasureTailMips() {
    return {CompareSize(64, 64, 7, {8, 4, 4, 4, 4}, 5), {}};
}

Measurement MeasureLargeCoordinates() {
    return {std::max(CompareSize(16384, 1, 1, {8, 4, 4, 4, 4}, 61),
                     CompareSize(16381, 1, 1, {3, 4, 4, 1, 1}, 61)),
            {}};
}

// Levels of detail and positions as no encoder writes them.
Measurement MeasureOddPositions() {
    double worst = 0;
    const std::pair<float, float> kMips[] = {
        {600.0f, 0.3f}, {-5.0f, -2.0f}, {1.0f / 3, 1e6f}, {1e-40f, 0x1p-30f}};
    for (const auto& [lod, scale] : kMips) {
        conformance::EditableSet set =
            conformance::SynthesizeEditableSet(Describe(23, 19, 2, {2, 4, 4, 4, 4}));
        for (ColorMip& mip : set.mips) {
            mip.positionLod = lod;
            mip.positionScale = scale;
        }
        const TestSet written(conformance::WriteSet(set));
        worst = std::max(worst, Compare(written, DecodeMath::Int8, written.ListTexels(7)));
    }
    return {worst, {}};
}

// A flat field of level 127 loses what the truncated weights lose: high-res slots are floor(127 I / 256).
Measurement MeasureWeightSums() {
    conformance::EditableSet set = conformance::SynthesizeEditableSet(Describe(100, 37, 1, {4, 4, 4, 8, 8}));
    for (conformance::EditableSet::Latents& latents : set.latents) {
        std::ranges::fill(latents.highRes, std::byte{253});
        std::ranges::fill(latents.lowRes, std::byte{253});
    }
    const TestSet written(conformance::WriteSet(set));
    // The sums themselves, by the definition of the weights.
    int low = 256;
    int high = 0;
    const auto fraction = [](int texel, int size, int grid) {
        const float position =
            static_cast<float>(texel + 0.5) / static_cast<float>(size) * static_cast<float>(grid);
        const float shifted = position - 0.5f;
        return shifted - std::floor(shifted);
    };
    for (int y = 0; y < 37; ++y) {
        for (int x = 0; x < 100; ++x) {
            const float fx = fraction(x, 100, 25);
            const float fy = fraction(y, 37, 9);
            const float gx = 1 - fx;
            const float gy = 1 - fy;
            const int sum = static_cast<int>(gx * gy * 256) + static_cast<int>(fx * gy * 256) +
                            static_cast<int>(gx * fy * 256) + static_cast<int>(fx * fy * 256);
            low = std::min(low, sum);
            high = std::max(high, sum);
        }
    }
    const double worst = Compare(written, DecodeMath::Int8, written.ListTexels(7));
    const std::string note =
        "sums of the four weights: " + std::to_string(low) + " to " + std::to_string(high);
    return {low < 253 || high > 256 ? 1.0 : worst, note};
}

constexpr HardCase kGeometryCases[] = {
    {"texels-on-latents",
     "Where a texel's centre coincides with a latent, the four high-resolution corner slots change places: "
     "the network's "
     "input is discontinuous there, and neighbouring formulas differ by up to 1.",
     "Decoders with fast division or with texel * (grid / mip), LibNTC's CUDA decoder among them.",
     "The coordinate is f32(f32(x + 1/2) / mip) * grid, each operation rounded once; the shader's division "
     "is corrected "
     "to the IEEE quotient.",
     0, MeasureTexelsOnLatents},
    {"clamped-taps", "Taps outside the grid must be clamped while the weights stay as they are.",
     "Samplers that wrap or mirror, and grids of one latent a side.",
     "Clamping is integer arithmetic on the tap's index.", 0, MeasureClampedTaps},
    {"slivers",
     "1 x N, N x 1, 1 x 1, 94 x 94, 257 x 33 and 4096 x 2 images with all their mips: grids of one latent on "
     "one axis.",
     "Passes that preload latents by block (the original's, at sliver images), index arithmetic.",
     "Grids and mips have their own sizes on each axis; every access is clamped.", 0, MeasureSlivers},
    {"tail-mips",
     "Mips of one texel far below their latent image: the level of detail saturates and the waves are "
     "constant.",
     "Integer conversions without a clamp: 4/3 * 127.5 wraps to a negative byte.",
     "Levels of detail are clamped like the waves before the conversion.", 0, MeasureTailMips},
    {"large-coordinates",
     "At 16381 and 16384 texels the coordinate's spacing is 2^-11 of a latent, near the 2^-8 of the weights.",
     "Anything that is not the specified order of operations.", "The same order everywhere.", 0,
     MeasureLargeCoordinates},
    {"odd-positions",
     "Levels of detail and position scales that no encoder writes: negative, 600, 10^6, subnormal.",
     "Conversions to integer outside their range; wave phases that are not exact.",
     "Clamps come before conversions; t - floor(t) is exact and every other step is rounded once.", 0,
     MeasureOddPositions},
    {"bilinear-weight-sums",
     "Truncated weights add up to 253 to 256, and every corner is floored: a flat field darkens by up to 1.2 "
     "%.",
     "Decoders that \"repair\" it by rounding: training saw the truncated weights.", "Copied as specified.",
     0, MeasureWeightSums},
};

} // namespace

std::span<const HardCase> ListGeometryCases() {
    return kGeometryCases;
}

} // namespace numerics
