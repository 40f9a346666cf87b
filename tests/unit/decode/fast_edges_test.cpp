// SPDX-License-Identifier: MIT
// Where a kernel could go wrong unseen: linear light in every channel and at the borders of tiles, half outputs at the ends
// of their range, position numbers that are not finite. Every kernel, against the reference and against what the format
// specification says.
#include "FastDecoderCases.h"

#include "openntc/core/Half.h"

#include <algorithm>
#include <cmath>
#include <limits>

using namespace openntc;

namespace {

decode_test::SpecificationShape MakeShape(std::uint32_t seed, int width, int height) {
    return {seed,
            width,
            height,
            1,
            4,
            NTC_NETWORK_SMALL,
            4,
            4,
            4,
            4,
            {{width / 4, height / 4, width / 8, height / 8}},
            {0}};
}

std::uint32_t MakeColorSpaces(int first) {
    std::uint32_t spaces = 0;
    for (int channel = 0; channel < NTC_MAX_CHANNELS; ++channel)
        spaces |= static_cast<std::uint32_t>((first + channel) % 3) << (2 * channel);
    return spaces;
}

std::size_t Index(const Rect& rect, int x, int y, int channel) {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(rect.width) +
            static_cast<std::size_t>(x)) *
               NTC_MAX_CHANNELS +
           static_cast<std::size_t>(channel);
}

} // namespace

TEST_CASE("fast decoder: every channel in every colour space") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(MakeShape(1201, 24, 16));
    const Rect rect{0, 0, 24, 16};
    for (int first = 0; first < 3; ++first) {
        set.constants.channelColorSpaces = MakeColorSpaces(first);
        decode_test::CompareWithReference(set, 0, rect, targets);
        // Equal mistakes in both decoders: linear channels keep their bits, all others change.
        for (const decode_test::FastTarget& target : targets) {
            const std::vector<float> stored =
                decode_test::DecodeFast(decode_test::GetSource(set), target, 0, rect, {});
            const std::vector<float> linear =
                decode_test::DecodeFast(decode_test::GetSource(set), target, 0, rect,
                                        {.math = DecodeMath::Int8, .convertToLinear = true});
            for (int channel = 0; channel < NTC_MAX_CHANNELS; ++channel) {
                int different = 0;
                for (int i = 0; i < rect.width * rect.height; ++i)
                    different += std::memcmp(&stored[Index(rect, i, 0, channel)],
                                             &linear[Index(rect, i, 0, channel)], sizeof(float)) != 0;
                CAPTURE(channel);
                if ((first + channel) % 3 == 0)
                    CHECK(different == 0);
                else
                    CHECK(different > rect.width * rect.height / 2);
            }
        }
    }
}

TEST_CASE("fast decoder: linear light at the borders of tiles") {
    // Tiles of full width and height, and what is left beside and below them.
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(2);
    const int width = fast::kTileWidth + 19;
    const int height = fast::kTileHeight + 5;
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(MakeShape(1202, width, height));
    set.constants.channelColorSpaces = MakeColorSpaces(1);
    decode_test::CompareWithReference(set, 0, {0, 0, width, height}, targets);
    decode_test::CompareWithReference(set, 0, {3, 2, fast::kTileWidth, fast::kTileHeight}, targets);
}

TEST_CASE("fast decoder: half outputs round to nearest even up to infinity and down to zero") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    // bias · scale, exact in binary32; weights are 0.
    constexpr struct {
        std::int32_t bias;
        int exponent; // of the scale
        double half;
    } kOutputs[NTC_MAX_CHANNELS] = {
        {65520, 0, std::numeric_limits<double>::infinity()}, // half way to 2^16
        {16773119, -8, 65504},                               // just below
        {-65520, 0, -std::numeric_limits<double>::infinity()},
        {-16773119, -8, -65504},
        {65535, 0, std::numeric_limits<double>::infinity()},
        {65536, 0, std::numeric_limits<double>::infinity()},
        {65504, 0, 65504},
        {65488, 0, 65472},        // a tie, to even
        {1, -24, 0x1p-24},        // the smallest
        {1, -25, 0},              // a tie, to even
        {3, -25, 0x1p-23},        // a tie, to even
        {16777215, -48, 0x1p-24}, // just below the smallest
        {8388609, -48, 0x1p-24},  // just above half of it
        {2047, -25, 0x1p-14},     // a tie between the largest subnormal and the smallest normal
        {8187, -27, 0x3ffp-24},   // just below that tie
        {-2049, -25, -0x1p-14},   // 2^-14 and half a quantum: a tie, to even
    };
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(MakeShape(1203, 24, 8));
    const std::size_t scaleOffset = static_cast<std::size_t>(set.constants.networkScaleBiasOffset);
    for (std::size_t i = static_cast<std::size_t>(set.constants.networkWeightOffset3); i < scaleOffset; ++i)
        set.weights[i] = std::byte{0};
    for (std::size_t channel = 0; channel < NTC_MAX_CHANNELS; ++channel) {
        const float scale = std::ldexp(1.0f, kOutputs[channel].exponent);
        std::memcpy(set.weights.data() + scaleOffset + 4 * (192 + channel), &scale, 4);
        std::memcpy(set.weights.data() + scaleOffset + 832 + 4 * (192 + channel), &kOutputs[channel].bias, 4);
    }
    const Rect rect{0, 0, 24, 8};
    decode_test::CompareWithReference(set, 0, rect, targets);
    for (const decode_test::FastTarget& target : targets) {
        CAPTURE(std::string(target.name));
        const std::vector<float> half =
            decode_test::DecodeFast(decode_test::GetSource(set), target, 0, rect,
                                    {.math = DecodeMath::Int8Half, .convertToLinear = false});
        const std::vector<float> full =
            decode_test::DecodeFast(decode_test::GetSource(set), target, 0, rect, {});
        for (int channel = 0; channel < NTC_MAX_CHANNELS; ++channel) {
            CAPTURE(channel);
            const auto& expected = kOutputs[channel];
            const double exact = std::ldexp(static_cast<double>(expected.bias), expected.exponent);
            CHECK(static_cast<double>(HalfToFloat(FloatToHalf(static_cast<float>(exact)))) == expected.half);
            for (int i = 0; i < rect.width * rect.height; ++i) {
                REQUIRE(static_cast<double>(full[Index(rect, i, 0, channel)]) == exact);
                REQUIRE(static_cast<double>(half[Index(rect, i, 0, channel)]) == expected.half);
            }
        }
    }
}

TEST_CASE("fast decoder: position numbers that are not finite") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(MakeShape(1204, 40, 16));
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float value : {nan, -nan, kInfinity, -kInfinity, 3e38f, -3e38f}) {
        CAPTURE(value);
        set.constants.colorMips[0].positionScale = 1.0f;
        set.constants.colorMips[0].positionLod = value;
        decode_test::CompareWithReference(set, 0, {-1, 0, 40, 2}, targets);
        set.constants.colorMips[0].positionScale = value;
        set.constants.colorMips[0].positionLod = 0.25f;
        decode_test::CompareWithReference(set, 0, {-1, 0, 40, 2}, targets);
    }
}
