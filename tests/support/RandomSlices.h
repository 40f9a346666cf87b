// SPDX-License-Identifier: MIT
// Random texture sets and slices of them, and which texels a slice must hold.
#pragma once

#include "support/TestSeed.h"

#include "openntc/inference/PartialInference.h"
#include "openntc/inference/Synthesis.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace openntc_tests {

/// SplitMix64: the same numbers everywhere.
class SliceRandom {
public:
    explicit SliceRandom(std::uint64_t seed) : state_(seed) {}

    std::uint64_t Next() {
        std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
        z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
        z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
        return z ^ (z >> 31);
    }
    /// low … high, both inclusive.
    int Pick(int low, int high) {
        return low + static_cast<int>(Next() % (static_cast<std::uint64_t>(high - low) + 1));
    }

private:
    std::uint64_t state_;
};

/// A set of any shape and quantisation, up to `maxSize` texels a side. Every third has pixels of half bytes.
inline openntc::SynthesisDesc PickSet(SliceRandom& random, int maxSize) {
    openntc::SynthesisDesc synthesis;
    synthesis.seed = static_cast<std::uint32_t>(random.Next());
    const int width = random.Pick(1, maxSize);
    const int height = random.Pick(1, maxSize);
    int mips = 1;
    while (mips < NTC_MAX_MIPS && (std::max(width, height) >> mips) > 0 && random.Pick(0, 7) != 0)
        ++mips;
    synthesis.desc = {width, height, 2 * random.Pick(1, 8), mips};
    const bool isHalfBytes = random.Pick(0, 2) == 0;
    synthesis.shape = {random.Pick(2, 8), 4 * random.Pick(1, 4), 4 * random.Pick(1, 4),
                       1 << random.Pick(0, 3), 1 << random.Pick(0, 3)};
    if (isHalfBytes) {
        synthesis.shape.highResFeatures = random.Pick(0, 1) == 0 ? 4 : 12;
        synthesis.shape.highResQuantBits = 1;
        if (random.Pick(0, 1) == 0) {
            synthesis.shape.lowResFeatures = random.Pick(0, 1) == 0 ? 4 : 12;
            synthesis.shape.lowResQuantBits = 1;
        }
    }
    synthesis.channelColorSpaces = 0x24; // Linear, sRGB, HLG, Linear
    return synthesis;
}

/// The same of generation 2 or 3; those of generation 3 are mostly compressed.
inline openntc::SynthesisDesc PickLayeredSet(SliceRandom& random, int maxSize) {
    openntc::SynthesisDesc synthesis = PickSet(random, maxSize);
    synthesis.shape = openntc::MakeLayeredShape(random.Pick(1, 6), 4 * random.Pick(1, 4));
    const bool isThird = random.Pick(0, 3) != 0;
    synthesis.networkVersion = isThird ? NTC_NETWORK_GENERATION_3 : NTC_NETWORK_GENERATION_2;
    synthesis.withFP8 = true;
    synthesis.compression = {isThird && random.Pick(0, 2) != 0, false, 1, 2.0f}; // however little it gains
    return synthesis;
}

/// Any slice of a set; one in four goes to the right and lower edge.
inline openntc::SliceDesc PickSlice(SliceRandom& random, const openntc::TextureSetMetadata& set) {
    openntc::SliceDesc slice;
    slice.firstMip = random.Pick(0, set.GetDesc().mips - 1);
    slice.numMips = random.Pick(1, set.GetDesc().mips - slice.firstMip);
    const openntc::ColorMip& mip = set.GetColorMips()[static_cast<std::size_t>(slice.firstMip)];
    slice.rect.left = random.Pick(0, mip.width - 1);
    slice.rect.top = random.Pick(0, mip.height - 1);
    const bool isToEdge = random.Pick(0, 3) == 0;
    slice.rect.width = isToEdge ? mip.width - slice.rect.left : random.Pick(1, mip.width - slice.rect.left);
    slice.rect.height = isToEdge ? mip.height - slice.rect.top : random.Pick(1, mip.height - slice.rect.top);
    return slice;
}

/// The texels of mip firstMip + k that a slice holds; of no width or height where the mip ends before.
inline openntc::Rect GetHeldTexels(const openntc::TextureSetMetadata& set, const openntc::SliceDesc& slice,
                                   int k) {
    const openntc::ColorMip& mip = set.GetColorMips()[static_cast<std::size_t>(slice.firstMip + k)];
    const auto cut = [&](int start, int size, int limit) {
        const int first = start >> k;
        const int end = std::min((start + size + (1 << k) - 1) >> k, limit);
        return std::pair{first, std::max(end - first, 0)};
    };
    const auto [left, width] = cut(slice.rect.left, slice.rect.width, mip.width);
    const auto [top, height] = cut(slice.rect.top, slice.rect.height, mip.height);
    return {left, top, width, height};
}

inline std::string ToText(const openntc::SynthesisDesc& s) {
    return std::to_string(s.desc.width) + "x" + std::to_string(s.desc.height) + ", " +
           std::to_string(s.desc.mips) + " mips, shape " + std::to_string(s.shape.gridSizeScale) + "," +
           std::to_string(s.shape.highResFeatures) + "," + std::to_string(s.shape.lowResFeatures) + "," +
           std::to_string(s.shape.highResQuantBits) + "," + std::to_string(s.shape.lowResQuantBits) +
           ", set seed " + std::to_string(s.seed);
}

inline std::string ToText(const openntc::SliceDesc& s) {
    return std::to_string(s.rect.left) + "," + std::to_string(s.rect.top) + "," +
           std::to_string(s.rect.width) + "," + std::to_string(s.rect.height) + " of mips " +
           std::to_string(s.firstMip) + " + " + std::to_string(s.numMips);
}

} // namespace openntc_tests
