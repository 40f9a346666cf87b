// SPDX-License-Identifier: MIT
// The fast decoder equals the reference decoder bit for bit: networks, code widths, feature counts, sizes,
// rectangles and hostile contents. (What the reference decoder computes is tested against the format
// specification elsewhere.)
#include "FastDecoderCases.h"

#include <algorithm>
#include <random>

using namespace openntc;

namespace {

std::vector<int> MakeGrid(int width, int height, int scale) {
    return {std::max(width / scale, 1), std::max(height / scale, 1), std::max(width / (2 * scale), 1),
            std::max(height / (2 * scale), 1)};
}

decode_test::SpecificationShape MakeShape(std::uint32_t seed, int width, int height, int networkVersion,
                                          int highFeatures, int lowFeatures, int highBits, int lowBits,
                                          int scale) {
    decode_test::SpecificationShape shape{seed,         width,       height,   2,       4,  networkVersion,
                                          highFeatures, lowFeatures, highBits, lowBits, {}, {}};
    shape.grids = {MakeGrid(width, height, scale)};
    shape.neuralMips = {0, 0};
    return shape;
}

void CompareMips(const decode_test::SpecificationSet& set, const decode_test::SpecificationShape& shape,
                 const std::vector<decode_test::FastTarget>& targets) {
    for (int mip = 0; mip < shape.mips; ++mip)
        CompareWithReference(
            set, mip, {0, 0, std::max(shape.width >> mip, 1), std::max(shape.height >> mip, 1)}, targets);
}

} // namespace

TEST_CASE("fast decoder: networks, features and code widths") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    std::uint32_t seed = 100;
    for (int network = NTC_NETWORK_SMALL; network <= NTC_NETWORK_XLARGE; ++network) {
        for (int highFeatures = 4; highFeatures <= 4 * network; highFeatures += 4) {
            for (const int bits : {1, 2, 4, 8}) {
                const int lowFeatures = 4 + 4 * static_cast<int>(seed % 4);
                const int lowBits = 1 << (seed / 4 % 4);
                ++seed;
                decode_test::SpecificationShape shape =
                    MakeShape(seed, 23, 9, network, highFeatures, lowFeatures, bits, lowBits, 2);
                decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
                set.constants.channelColorSpaces = 0x26262626u; // HLG, sRGB, HLG, linear, …
                CompareMips(set, shape, targets);
            }
        }
    }
}

TEST_CASE("fast decoder: sizes and slivers") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    constexpr int kSizes[][2] = {{1, 1},    {1, 40},  {40, 1},  {2, 3},  {94, 94},
                                 {257, 33}, {300, 2}, {3, 100}, {16, 16}};
    std::uint32_t seed = 500;
    for (const auto& size : kSizes) {
        const decode_test::SpecificationShape shape =
            MakeShape(++seed, size[0], size[1], NTC_NETWORK_MEDIUM, 8, 12, 2, 4, 4);
        CompareMips(decode_test::MakeSpecificationSet(shape), shape, targets);
    }
}

TEST_CASE("fast decoder: latents much finer and much coarser than the mip") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    decode_test::SpecificationShape shape = MakeShape(601, 64, 8, NTC_NETWORK_LARGE, 12, 8, 4, 2, 4);
    shape.grids = {{700, 90, 333, 61}};
    CompareMips(decode_test::MakeSpecificationSet(shape), shape, targets);
    shape.grids = {{2, 1, 1, 3}};
    CompareMips(decode_test::MakeSpecificationSet(shape), shape, targets);
}

TEST_CASE("fast decoder: rectangles inside, across the border and outside") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    const decode_test::SpecificationShape shape =
        MakeShape(701, 130, 70, NTC_NETWORK_XLARGE, 16, 16, 2, 8, 4);
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
    constexpr Rect kRects[] = {{17, 5, 33, 3},     {129, 69, 1, 1},           {0, 31, 65, 2},
                               {-7, -9, 20, 20},   {120, 60, 40, 30},         {-4194304, -4194304, 5, 3},
                               {4194300, 7, 4, 1}, {1000000, -1000000, 17, 2}};
    for (const Rect& rect : kRects)
        CompareWithReference(set, 0, rect, targets);
    CompareWithReference(set, 1, {63, 3, 2, 31}, targets);
}

TEST_CASE("fast decoder: slices of the latents") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    const decode_test::SpecificationShape shape = MakeShape(801, 64, 64, NTC_NETWORK_SMALL, 4, 4, 1, 1, 4);
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
    // The stored latents taken as a window of larger grids.
    set.constants.highResNeuralMips[0].imageWidthHeight = 40u | 33u << 16;
    set.constants.highResNeuralMips[0].sliceLeftTop = 7u | 11u << 16;
    set.constants.lowResNeuralMips[0].imageWidthHeight = 20u | 16u << 16;
    set.constants.lowResNeuralMips[0].sliceLeftTop = 3u | 5u << 16;
    CompareMips(set, shape, targets);
}

TEST_CASE("fast decoder: codes that writers never emit") {
    // 254 and 255 with 8 bits are inputs 128 and 129, which wrap after weighting.
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    const decode_test::SpecificationShape shape = MakeShape(901, 33, 21, NTC_NETWORK_XLARGE, 16, 16, 8, 8, 2);
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
    std::mt19937 random(1);
    for (std::byte& code : set.latents)
        code = static_cast<std::byte>(random() % 3 == 0 ? random() % 256 : 250 + random() % 6);
    CompareMips(set, shape, targets);
}

TEST_CASE("fast decoder: extreme weights, scales and biases") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    std::mt19937 engine(2);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
    for (int round = 0; round < 24; ++round) {
        CAPTURE(round);
        const int network = 1 + round % 4;
        const decode_test::SpecificationShape shape =
            MakeShape(static_cast<std::uint32_t>(1000 + round), 19, 7, network, 4 * network, 16, 4, 4, 2);
        decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
        const std::size_t scaleOffset = static_cast<std::size_t>(set.constants.networkScaleBiasOffset);
        // Weights of the full range, -128 included; sums at both ends.
        for (std::size_t i = 0; i < scaleOffset; ++i)
            set.weights[i] = static_cast<std::byte>(round % 3 == 0   ? 0x80u
                                                    : round % 3 == 1 ? 0x7Fu
                                                                     : random() % 256);
        for (std::size_t i = 0; i < 208; ++i) {
            // Any finite scale: subnormal, huge, negative, zero. Biases wrap the accumulator.
            std::uint32_t scale = random();
            if (round % 2 == 0)
                scale = (random() & 0x807FFFFFu) | (100 + random() % 20) << 23;
            if ((scale >> 23 & 0xFFu) == 0xFFu)
                scale &= ~0x40000000u;
            if ((scale >> 23 & 0xFFu) == 0)
                scale &= 0x80000000u; // devices may flush subnormals; zero is enough here
            const std::uint32_t bias = round % 4 < 2 ? random() : random() % 200000 - 100000;
            std::memcpy(set.weights.data() + scaleOffset + 4 * i, &scale, 4);
            std::memcpy(set.weights.data() + scaleOffset + 832 + 4 * i, &bias, 4);
        }
        CompareMips(set, shape, targets);
    }
}

TEST_CASE("fast decoder: lods and scales of deep mips") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    const decode_test::SpecificationShape shape = MakeShape(1101, 40, 12, NTC_NETWORK_MEDIUM, 8, 8, 4, 4, 4);
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
    for (const float lod : {-2.0f, -0.4f, 0.0f, 1.0f / 3.0f, 0.999f, 1.6666666f, 1e30f}) {
        for (const float scale : {0.0f, 0.3f, 1.0f, 32768.0f, 1e20f}) {
            set.constants.colorMips[0].positionLod = lod;
            set.constants.colorMips[0].positionScale = scale;
            CompareWithReference(set, 0, {0, 0, 40, 3}, targets);
        }
    }
}
