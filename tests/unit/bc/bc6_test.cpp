// SPDX-License-Identifier: MIT
// BC6H's encoder, judged by the reference decoder: every mode, the input rule, exact cases, levels and quality.
#include "Bc6Images.h"

#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockEncoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bc;
using namespace openntc_bc6;
using namespace openntc::shader::lanes1;

constexpr BlockQuality kBc6Levels[] = {BlockQuality::Fast, BlockQuality::Normal, BlockQuality::Best};

BlockFormat GetBc6Format(bool isSigned) {
    return isSigned ? BlockFormat::Bc6Signed : BlockFormat::Bc6Unsigned;
}

std::vector<std::byte> EncodeHalves(const HalfImage& image, BlockOptions options) {
    const BlockImage view{
        std::as_bytes(std::span(image.halves)), image.width, image.height, 0, 3, TexelType::Half};
    const BlockRect rect{0, 0, CountBlocks(image.width), CountBlocks(image.height)};
    std::vector<std::byte> blocks(std::size_t{16} * rect.width * rect.height);
    const auto done = EncodeBlocks(GetBc6Format(image.isSigned), view, rect, options, blocks);
    REQUIRE_MESSAGE(done.has_value(), std::string(done ? "" : done.error().GetText()));
    return blocks;
}

std::vector<std::uint16_t> DecodeHalves(const HalfImage& image, std::span<const std::byte> blocks) {
    std::vector<std::uint16_t> texels(std::size_t{4} * image.width * image.height);
    REQUIRE(DecodeBlocksToHalves(GetBc6Format(image.isSigned), blocks, image.width, image.height, texels)
                .has_value());
    return texels;
}

/// The sum of squared differences of the halves as integers.
double MeasureHalves(const HalfImage& image, std::span<const std::byte> blocks) {
    const std::vector<std::uint16_t> decoded = DecodeHalves(image, blocks);
    double sum = 0;
    for (std::size_t i = 0; i < image.halves.size(); ++i) {
        const double difference =
            CountHalf(image.halves[i], image.isSigned) - CountDecoded(decoded[i / 3 * 4 + i % 3]);
        sum += difference * difference;
    }
    return sum;
}

/// The mode of a block by its lowest bits, in the order of kNtcBc6Modes; -1: a reserved code.
int GetBc6Mode(const std::byte* block) {
    const int code = static_cast<int>(block[0]) & 31;
    if ((code & 3) < 2)
        return code & 3;
    constexpr int kCodes[] = {2, 6, 10, 14, 18, 22, 26, 30, 3, 7, 11, 15};
    const int* const found = std::find(std::begin(kCodes), std::end(kCodes), code);
    return found == std::end(kCodes) ? -1 : static_cast<int>(found - kCodes) + 2;
}

/// A block of two values, by bits of a mask, the same in all channels.
HalfImage MakeTwoValued(std::uint16_t first, std::uint16_t second, std::uint32_t mask, bool isSigned) {
    HalfImage image{"two values", isSigned, 4, 4, {}};
    for (std::uint32_t t = 0; t < 16; ++t) {
        for (int c = 0; c < 3; ++c)
            image.halves.push_back((mask >> t & 1) != 0 ? second : first);
    }
    return image;
}

} // namespace

TEST_CASE("BC6H: every half counts by the documented rule") {
    for (std::int32_t bits = 0; bits < 0x10000; ++bits) {
        const std::int32_t extended = static_cast<std::int16_t>(bits);
        for (const bool isSigned : {false, true}) {
            const int counted = NtcBc6Input(extended, isSigned);
            if (counted != CountHalf(static_cast<std::uint16_t>(bits), isSigned))
                FAIL_CHECK("half ", bits, isSigned ? " signed" : " unsigned", ": ", counted);
        }
    }
    CHECK(NtcBc6Input(0x7C00, false) == 31743);                            // infinity: 65504
    CHECK(NtcBc6Input(static_cast<std::int16_t>(0xFC00), true) == -31743); // -infinity
    CHECK(NtcBc6Input(static_cast<std::int16_t>(0xFC00), false) == 0);     // -infinity, unsigned
    CHECK(NtcBc6Input(0x7E00, true) == 0);                                 // NaN
    CHECK(NtcBc6Input(static_cast<std::int16_t>(0xFE01), true) == 0);      // NaN
    CHECK(NtcBc6Input(static_cast<std::int16_t>(0x8000), true) == 0);      // -0
    CHECK(NtcBc6Input(static_cast<std::int16_t>(0x8400), false) == 0);     // the negative of the least normal
    CHECK(NtcBc6Input(static_cast<std::int16_t>(0x8400), true) == -0x0400); // kept
    CHECK(NtcBc6Input(0x0001, false) == 1);                                 // the least subnormal
}

TEST_CASE("BC6H: what is packed is what the decoder yields, in every mode and partition") {
    std::mt19937 engine(6);
    const auto random = [&](int low, int high) {
        return low + static_cast<int>(engine() % static_cast<std::uint32_t>(high - low + 1));
    };
    NtcBc6Frame plain{{0, 0, 0}, 0, 0, 1 << 20};
    int blocks = 0;
    for (int repeat = 0; repeat < 400; ++repeat) {
        for (int mode = 0; mode < NTC_BC6_MODES; ++mode) {
            const bool isSigned = repeat % 2 != 0;
            const int subsets = mode < NTC_BC6_TWO_SUBSET_MODES ? 2 : 1;
            const int entry = kNtcBc6Modes[mode];
            const int largest = NtcBc6LargestEndpoint(entry & 31, isSigned);
            NtcBc6Choice choice{};
            choice.mode = mode;
            choice.pattern = subsets == 2 ? repeat / 2 % 32 : 0;
            for (int c = 0; c < 3; ++c) {
                const int reach = 1 << ((entry >> (5 + 5 * c) & 31) - 1);
                choice.endpoints[c] = random(isSigned ? -largest : 0, largest);
                for (int e = 1; e < 2 * subsets; ++e) {
                    // Often the ends of what a delta reaches.
                    const int low = std::max(choice.endpoints[c] - reach, isSigned ? -largest : 0);
                    const int high = std::min(choice.endpoints[c] + reach - 1, largest);
                    const int way = random(0, 3);
                    choice.endpoints[3 * e + c] = way == 0 ? low : way == 1 ? high : random(low, high);
                }
            }
            const int masks = subsets == 2 ? kNtcBc6Partitions[choice.pattern] : 0;
            for (int t = 0; t < 16; ++t) {
                const bool isAnchor = t == 0 || (subsets == 2 && t == masks >> 16);
                const int levels = subsets == 2 ? 8 : 16;
                const int index = random(0, isAnchor ? levels / 2 - 1 : levels - 1);
                choice.indices[t / 8] |= static_cast<int>(static_cast<std::uint32_t>(index) << (4 * (t % 8)));
            }
            const NtcBc6Block words = NtcBc6Pack(choice);
            std::byte block[16];
            std::memcpy(block, words.words, 16);
            CHECK(GetBc6Mode(block) == mode);
            std::uint16_t texels[64];
            DecodeBlockHalves(GetBc6Format(isSigned), block, texels);
            int different = 0;
            for (int t = 0; t < 16; ++t) {
                const int s = masks >> t & 1;
                for (int c = 0; c < 3; ++c) {
                    const int a = NtcBc6Unquantize(choice.endpoints[6 * s + c], entry & 31, isSigned);
                    const int b = NtcBc6Unquantize(choice.endpoints[6 * s + 3 + c], entry & 31, isSigned);
                    const int weight = NtcBc6Weight(NtcBc6Index(choice, t), subsets);
                    if (NtcBc6PaletteValue(a, b, weight, 0, plain, isSigned) !=
                        CountDecoded(texels[4 * t + c]))
                        ++different;
                }
            }
            CHECK_MESSAGE(different == 0, "mode ", mode, isSigned ? " signed" : " unsigned", ", partition ",
                          choice.pattern, ": ", different, " of 48 values");
            ++blocks;
        }
    }
    CHECK(blocks == 5600);
}

TEST_CASE("BC6H: the error that a search reports is that of the decoded block") {
    for (const HalfImage& image : MakeHalfImages(32, 1)) {
        for (std::size_t block = 0; block < 64; ++block) {
            int halves[48];
            for (std::size_t t = 0; t < 16; ++t) {
                for (std::size_t c = 0; c < 3; ++c)
                    halves[3 * t + c] = CountHalf(
                        image.halves[3 * ((block / 8 * 4 + t / 4) * 32 + block % 8 * 4 + t % 4) + c],
                        image.isSigned);
            }
            int x[48];
            std::copy(std::begin(halves), std::end(halves), x);
            const NtcBc6Frame frame = NtcBc6EnterFrame(x);
            const NtcBc6Choice choice = NtcBc6Search(halves, NTC_BC_QUALITY_NORMAL, image.isSigned);
            const NtcBc6Block words = NtcBc6Pack(choice);
            std::byte bytes[16];
            std::memcpy(bytes, words.words, 16);
            std::uint16_t texels[64];
            DecodeBlockHalves(GetBc6Format(image.isSigned), bytes, texels);
            int error = 0;
            for (int i = 0; i < 48; ++i) {
                const int away = std::clamp(CountDecoded(texels[i / 3 * 4 + i % 3]) - frame.center[i % 3],
                                            -frame.limit, frame.limit);
                const int difference = (away << frame.up >> frame.down) - x[i];
                error += difference * difference;
            }
            CHECK_MESSAGE(choice.error == error, image.name, " block ", block);
        }
    }
}

TEST_CASE("BC6H: solid blocks are exact, for every half and for colours") {
    std::mt19937 engine(7);
    for (const bool isSigned : {false, true}) {
        // A row of blocks, each of one value; behind the grays, colours.
        constexpr std::uint32_t kColors = 2000;
        const std::uint32_t grays = isSigned ? 2 * 0x7C00 : 0x7C00;
        HalfImage image{"solid", isSigned, 4 * (grays + kColors), 4, {}};
        image.halves.resize(std::size_t{3} * image.width * 4);
        for (std::uint32_t b = 0; b < grays + kColors; ++b) {
            for (std::uint32_t c = 0; c < 3; ++c) {
                std::uint32_t half = b < 0x7C00 ? b : 0x8000 + b - 0x7C00;
                if (b >= grays)
                    half = static_cast<std::uint32_t>(engine() % 0x7C00 +
                                                      (isSigned && (engine() & 1) != 0 ? 0x8000 : 0));
                for (std::uint32_t t = 0; t < 16; ++t)
                    image.halves[3 * (t / 4 * image.width + 4 * b + t % 4) + c] =
                        static_cast<std::uint16_t>(half);
            }
        }
        for (const BlockQuality level : {BlockQuality::Fast, BlockQuality::Normal}) {
            BlockOptions options;
            options.quality = level;
            CHECK(MeasureHalves(image, EncodeHalves(image, options)) == 0);
        }
    }
}

TEST_CASE("BC6H: blocks of the ends of the range are exact, whatever is where") {
    std::mt19937 engine(8);
    for (const BlockQuality level : kBc6Levels) {
        BlockOptions options;
        options.quality = level;
        for (int repeat = 0; repeat < 300; ++repeat) {
            const auto mask = static_cast<std::uint32_t>(engine() & 0xFFFF);
            const HalfImage image = MakeTwoValued(0, 0x7BFF, mask, false);
            CHECK(MeasureHalves(image, EncodeHalves(image, options)) == 0);
            const HalfImage both = MakeTwoValued(0xFBFF, 0x7BFF, mask, true);
            CHECK(MeasureHalves(both, EncodeHalves(both, options)) == 0);
        }
    }
}

TEST_CASE("BC6H: NaN, infinities and negative numbers are encoded as what they count as") {
    std::mt19937 engine(9);
    constexpr std::uint16_t kOdd[] = {0x7C00, 0xFC00, 0x7E00, 0xFE01, 0x7FFF, 0x8000, 0x8400, 0xBC00,
                                      0xFBFF, 0x0001, 0x8001, 0x03FF, 0x0000, 0x3C00, 0x7BFF};
    for (const bool isSigned : {false, true}) {
        HalfImage image{"odd", isSigned, 64, 64, {}};
        for (int i = 0; i < 3 * 64 * 64; ++i)
            image.halves.push_back(kOdd[engine() % std::size(kOdd)]);
        HalfImage plain = image;
        for (std::uint16_t& half : plain.halves) {
            const int counted = CountHalf(half, isSigned);
            half = static_cast<std::uint16_t>(counted < 0 ? 0x8000 - counted : counted);
        }
        for (const BlockQuality level : kBc6Levels) {
            BlockOptions options;
            options.quality = level;
            const std::vector<std::byte> blocks = EncodeHalves(image, options);
            CHECK(blocks == EncodeHalves(plain, options));
            for (const std::uint16_t half : DecodeHalves(image, blocks)) {
                CHECK((half & 0x7FFF) <= 0x7BFF); // finite
                CHECK((isSigned || half <= 0x7BFF));
            }
        }
    }
}

TEST_CASE("BC6H: lanes, threads, and texels beyond the image") {
    for (HalfImage image : MakeHalfImages(44, 2)) {
        for (const BlockQuality level : kBc6Levels) {
            BlockOptions options;
            options.quality = level;
            options.lanes = 1;
            options.threads = 1;
            const std::vector<std::byte> expected = EncodeHalves(image, options);
            for (const int lanes : {4, 8, 16}) {
                options.lanes = lanes;
                options.threads = lanes == 8 ? 3 : 1;
                CHECK(EncodeHalves(image, options) == expected);
            }
        }
    }
    for (const std::uint32_t width : {1U, 2U, 5U, 27U}) {
        for (const std::uint32_t height : {1U, 3U, 6U}) {
            const HalfImage whole = MakeHalfImages(32, 3)[3];
            HalfImage image{"cut", false, width, height, {}};
            HalfImage padded{"padded", false, 4 * CountBlocks(width), 4 * CountBlocks(height), {}};
            for (std::uint32_t y = 0; y < padded.height; ++y) {
                for (std::uint32_t i = 0; i < 3 * padded.width; ++i) {
                    const std::uint32_t x = std::min(i / 3, width - 1);
                    const std::uint16_t half = whole.halves[3 * (std::min(y, height - 1) * 32 + x) + i % 3];
                    padded.halves.push_back(half);
                    if (y < height && i < 3 * width)
                        image.halves.push_back(half);
                }
            }
            CHECK(EncodeHalves(image, {}) == EncodeHalves(padded, {}));
        }
    }
}

TEST_CASE("BC6H: higher levels are better on every image; all modes are used, and no reserved code") {
    // dB at Best, a tenth less than what this encoder gave when it was written. The images' order is that of
    // MakeHalfImages. The best public encoders reach 20.2 dB on noise of this range.
    constexpr double kLeast[] = {57.9, 86.7, 69.7, 52.4, 20.1, 51.9, 16.5, 11.1};
    std::size_t number = 0;
    std::array<std::uint32_t, 15> modes{};
    for (const HalfImage& image : MakeHalfImages(128, 4)) {
        double before = 0;
        std::string line = image.name + ":";
        for (const BlockQuality level : kBc6Levels) {
            BlockOptions options;
            options.quality = level;
            const std::vector<std::byte> blocks = EncodeHalves(image, options);
            for (std::size_t b = 0; b < blocks.size(); b += 16)
                ++modes[static_cast<std::size_t>(GetBc6Mode(&blocks[b]) + 1)];
            const double error = MeasureHalves(image, blocks);
            if (level != BlockQuality::Fast)
                CHECK_MESSAGE(error <= before, image.name, " level ", static_cast<int>(level));
            before = error;
            const double decibels = 20 * std::log10(31743 / std::sqrt(error / (3.0 * 128 * 128)));
            line.append(" ").append(std::to_string(decibels)); // g++ 12 warns wrongly of +
            if (level == BlockQuality::Best)
                CHECK_MESSAGE(decibels >= kLeast[number], image.name);
        }
        ++number;
        MESSAGE(line);
    }
    CHECK(modes[0] == 0);
    for (std::size_t mode = 1; mode < modes.size(); ++mode)
        CHECK_MESSAGE(modes[mode] > 0, "mode ", mode - 1);
}
