// SPDX-License-Identifier: MIT
// What is hard about slices: which latents a rectangle needs, and how they are packed again.
#include "Decoders.h"
#include "HardCases.h"
#include "support/RandomSlices.h"

#include <algorithm>

namespace numerics {

namespace {

using namespace openntc;

TestSet MakeSet(int width, int height, int mips, const LatentShape& shape) {
    SynthesisDesc synthesis;
    synthesis.seed = static_cast<std::uint32_t>(width * 7919 + height);
    synthesis.desc = {width, height, 16, mips};
    synthesis.shape = shape;
    synthesis.networkVersion = NTC_NETWORK_LARGE;
    return TestSet(conformance::SynthesizeBytes(synthesis));
}

/// Every `stride`-th texel that the slice holds, and the last of each mip.
std::vector<Texel> ListHeldTexels(const TestSet& set, const SliceDesc& slice, std::size_t stride) {
    std::vector<Texel> texels;
    std::size_t index = 0;
    for (int k = 0; k < slice.numMips; ++k) {
        const Rect held = openntc_tests::GetHeldTexels(set.GetMetadata(), slice, k);
        for (int y = 0; y < held.height; ++y) {
            for (int x = 0; x < held.width; ++x) {
                if (index++ % stride == 0 || (x + 1 == held.width && y + 1 == held.height))
                    texels.push_back({slice.firstMip + k, held.left + x, held.top + y});
            }
        }
    }
    return texels;
}

double CompareSlices(const TestSet& set, std::span<const SliceDesc> slices, std::size_t stride) {
    double worst = 0;
    for (const SliceDesc& slice : slices)
        worst =
            std::max(worst, CompareSlice(set, DecodeMath::Int8, slice, ListHeldTexels(set, slice, stride)));
    return worst;
}

// Grids of 15 x 9 and 7 x 4 pixels of 12 and 4 bits: odd rows begin within a byte.
Measurement MeasureHalfBytes() {
    const TestSet set = MakeSet(30, 19, 2, {2, 12, 4, 1, 1});
    const SliceDesc slices[] = {{0, 2, {3, 3, 9, 9}}, {0, 2, {11, 1, 19, 18}}, {1, 1, {6, 5, 8, 4}}};
    return {CompareSlices(set, slices, 3), {}};
}

// 1 031, 515, 257, 128 texels: the last mip ends before the last 7 texels of the first.
Measurement MeasureOddMips() {
    const TestSet set = MakeSet(1031, 9, 4, {4, 4, 4, 4, 4});
    const SliceDesc slices[] = {{0, 4, {1024, 0, 7, 9}}, {0, 4, {900, 0, 64, 9}}, {1, 3, {509, 1, 6, 3}}};
    return {CompareSlices(set, slices, 3), {}};
}

// Columns whose latents begin one pixel later in exact arithmetic (format specification, streaming 3.2), of
// an image with 88 texels and 22 latents.
Measurement MeasureRoundedEdges() {
    const TestSet set = MakeSet(88, 8, 1, {4, 4, 4, 4, 4});
    const SliceDesc slices[] = {{0, 1, {22, 0, 4, 8}}, {0, 1, {21, 0, 5, 8}}, {0, 1, {22, 3, 1, 2}}};
    return {CompareSlices(set, slices, 1), {}};
}

constexpr HardCase kSliceCases[] = {
    {"slices-half-bytes",
     "Pixels of 4 and 12 bits in rows of odd length: a slice's row begins and ends within a byte.",
     "LibNTC 0.7: rows are cut at whole bytes, every odd one is shifted by half a byte, and the size is too "
     "small.",
     "A slice is a grid of its own, packed bit by bit.", 0, MeasureHalfBytes},
    {"slices-sizes-that-do-not-halve",
     "Where a mip is more than twice as large as the next, a rectangle seen by the coarsest mip lies further "
     "right "
     "than its own texels.",
     "LibNTC 0.7, which asks the coarsest mip alone: a slice of the last 7 of 1031 texels lacks their "
     "latents.",
     "Every mip of the slice is asked for its first latent.", 0, MeasureOddMips},
    {"slices-rounded-edges",
     "The first and last latents of a slice come from binary32 positions; another rounding gives another "
     "slice.",
     "Double precision, contraction, -ffast-math.", "The roundings are done in integers.", 0,
     MeasureRoundedEdges},
};

} // namespace

std::span<const HardCase> ListSliceCases() {
    return kSliceCases;
}

} // namespace numerics
