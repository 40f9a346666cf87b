// SPDX-License-Identifier: MIT
// BC7: judged through the decoder, which has tables of its own. What must be lossless is, opaque and clear
// alpha stay, every mode can be asked for, no level is worse than the one below it, and hints give what the
// search gave.
#include "BlockSamples.h"

#include <array>

using namespace openntc;
using namespace openntc::bc;
using namespace openntc_tests;

namespace {

constexpr BlockQuality kBc7Levels[] = {BlockQuality::Fast, BlockQuality::Normal, BlockQuality::Best};

constexpr int kMixedAlpha = -2; ///< opaque blocks, some nearly so, beside others

/// Kinds of 4 x 4 blocks by turns: smooth, noise, two colours, independent channels, lines; alpha as asked
/// for.
SampleImage MakeBc7Sample(std::uint32_t side, std::uint32_t seed, int alpha) {
    std::mt19937 random(seed);
    SampleImage image(side, side);
    for (std::uint32_t by = 0; by < side; by += 4) {
        for (std::uint32_t bx = 0; bx < side; bx += 4) {
            const std::uint32_t kind = (bx / 4 + by / 4) % 5;
            std::array<int, 8> ends{};
            for (int& end : ends)
                end = static_cast<int>(random() >> 24);
            const auto mask = static_cast<std::uint32_t>(random());
            for (std::uint32_t t = 0; t < 16; ++t) {
                const auto place = static_cast<int>(t % 4 + t / 4);
                for (std::uint32_t c = 0; c < 4; ++c) {
                    const int a = ends[c];
                    const int b = ends[4 + c];
                    int value = a + (b - a) * place / 6;
                    if (kind == 1)
                        value = static_cast<int>(random() >> 24);
                    if (kind == 2)
                        value = (mask >> t & 1) != 0 ? a : b;
                    if (kind == 3)
                        value = a + static_cast<int>(random() % 40) - 20;
                    if (kind == 4)
                        value = t / 4 == (mask & 3) ? b : a + static_cast<int>(random() & 3);
                    if (c == 3 &&
                        (alpha >= 0 || (alpha == kMixedAlpha && random() % 32 != 0 && bx % 12 == 0)))
                        value = std::max(alpha, alpha < 0 ? 255 : 0);
                    image.At(bx + t % 4, by + t / 4, c) =
                        static_cast<std::uint8_t>(std::clamp(value, 0, 255));
                }
            }
        }
    }
    return image;
}

int GetBc7Mode(const std::byte* block) {
    for (int mode = 0; mode < 8; ++mode) {
        if ((static_cast<int>(block[0]) >> mode & 1) != 0)
            return mode;
    }
    return 8;
}

/// The summed squared error of R, G, B and A of one block.
int GetBc7BlockError(const SampleImage& image, std::uint32_t bx, std::uint32_t by, const std::byte* block) {
    std::uint8_t decoded[64];
    DecodeBlockBytes(BlockFormat::Bc7, block, decoded);
    int error = 0;
    for (std::uint32_t t = 0; t < 16; ++t) {
        for (std::uint32_t c = 0; c < 4; ++c) {
            const std::size_t at = 4 * (std::size_t{4 * by + t / 4} * image.width + 4 * bx + t % 4) + c;
            const int off = decoded[4 * t + c] - image.texels[at];
            error += off * off;
        }
    }
    return error;
}

std::vector<int> GetBc7BlockErrors(const SampleImage& image, std::span<const std::byte> blocks) {
    std::vector<int> errors;
    const std::uint32_t columns = image.width / 4;
    for (std::uint32_t b = 0; b < columns * (image.height / 4); ++b)
        errors.push_back(GetBc7BlockError(image, b % columns, b / columns, &blocks[16 * std::size_t{b}]));
    return errors;
}

} // namespace

TEST_CASE("bc7: lanes and threads do not change a block") {
    for (const int alpha : {255, -1, kMixedAlpha}) {
        const SampleImage image = MakeBc7Sample(52, 11, alpha);
        for (const BlockQuality quality : kBc7Levels) {
            BlockOptions options;
            options.quality = quality;
            options.lanes = 1;
            options.threads = 1;
            const std::vector<std::byte> expected = EncodeSample(BlockFormat::Bc7, image, options);
            for (const int lanes : {4, 8, 16}) {
                options.lanes = lanes;
                options.threads = lanes == 8 ? 3 : 1;
                CHECK(EncodeSample(BlockFormat::Bc7, image, options) == expected);
            }
        }
    }
}

TEST_CASE("bc7: one colour is lossless, all grays and random colours with alpha") {
    std::mt19937 random(12);
    SampleImage image(128, 64);
    for (std::uint32_t b = 0; b < 512; ++b) {
        for (std::uint32_t c = 0; c < 4; ++c) {
            const auto value = static_cast<std::uint8_t>(b < 256 ? (c == 3 ? 255 : b) : random() >> 24);
            for (std::uint32_t t = 0; t < 16; ++t)
                image.At(b % 32 * 4 + t % 4, b / 32 * 4 + t / 4, c) = value;
        }
    }
    for (const BlockQuality quality : kBc7Levels) {
        BlockOptions options;
        options.quality = quality;
        CHECK(GetSampleError(BlockFormat::Bc7, image, EncodeSample(BlockFormat::Bc7, image, options), 4) ==
              0);
    }
}

TEST_CASE("bc7: opaque alpha stays 255 and clear alpha stays 0, in every mode that has one") {
    for (const int alpha : {255, 0}) {
        const SampleImage image = MakeBc7Sample(64, 13, alpha);
        for (const BlockQuality quality : kBc7Levels) {
            for (const std::uint32_t modes : {0xFFU, 0x10U, 0x20U, 0x40U, 0x80U, 0xF0U}) {
                BlockOptions options;
                options.quality = quality;
                options.allowedModes = modes;
                const auto blocks = EncodeSample(BlockFormat::Bc7, image, options);
                int others = 0;
                for (std::size_t b = 0; b < blocks.size(); b += 16) {
                    std::uint8_t decoded[64];
                    DecodeBlockBytes(BlockFormat::Bc7, &blocks[b], decoded);
                    for (int t = 0; t < 16; ++t)
                        others += decoded[4 * t + 3] != alpha ? 1 : 0;
                }
                CHECK_MESSAGE(others == 0, "alpha ", alpha, " modes ", modes, ": ", others);
            }
        }
    }
}

TEST_CASE("bc7: a mode that is the only one allowed is used, and fits what it can hold") {
    // A plane through the colour cube along one line, which every mode holds: off by what its endpoints and
    // indices round, at most half a step of 5 bits and of 2-bit indices over 64 levels, 8 / 2 + 64 / 3 / 2 <
    // 15 a channel.
    SampleImage smooth(64, 64);
    for (std::uint32_t y = 0; y < 64; ++y) {
        for (std::uint32_t x = 0; x < 64; ++x) {
            for (std::uint32_t c = 0; c < 3; ++c)
                smooth.At(x, y, c) = static_cast<std::uint8_t>(64 + x + y - 8 * c);
        }
    }
    const SampleImage mixed = MakeBc7Sample(64, 14, -1);
    for (int mode = 0; mode < 8; ++mode) {
        for (const BlockQuality quality : kBc7Levels) {
            BlockOptions options;
            options.quality = quality;
            options.allowedModes = 1U << mode;
            for (const SampleImage* image : {&std::as_const(smooth), &mixed}) {
                const auto blocks = EncodeSample(BlockFormat::Bc7, *image, options);
                int others = 0;
                for (std::size_t b = 0; b < blocks.size(); b += 16)
                    others += GetBc7Mode(&blocks[b]) != mode ? 1 : 0;
                CHECK_MESSAGE(others == 0, "mode ", mode);
                if (image == &smooth)
                    CHECK_MESSAGE(GetSampleError(BlockFormat::Bc7, *image, blocks, 4) < 15 * 15 / 3.0,
                                  "mode ", mode);
            }
        }
    }
}

TEST_CASE("bc7: of every set of modes one of it is used") {
    const SampleImage image = MakeBc7Sample(20, 17, kMixedAlpha);
    for (std::uint32_t modes = 1; modes < 256; ++modes) {
        BlockOptions options;
        options.quality = BlockQuality::Fast;
        options.allowedModes = modes;
        const auto blocks = EncodeSample(BlockFormat::Bc7, image, options);
        int others = 0;
        for (std::size_t b = 0; b < blocks.size(); b += 16)
            others += (modes >> GetBc7Mode(&blocks[b]) & 1) == 0 ? 1 : 0;
        CHECK_MESSAGE(others == 0, "modes ", modes, ": ", others);
    }
}

TEST_CASE("bc7: no block of a level is worse than that of the level below, and more modes are never worse") {
    for (const int alpha : {255, -1, 128, 0}) {
        const SampleImage image = MakeBc7Sample(80, 15, alpha);
        std::vector<int> below;
        for (const BlockQuality quality : kBc7Levels) {
            BlockOptions options;
            options.quality = quality;
            const auto errors = GetBc7BlockErrors(image, EncodeSample(BlockFormat::Bc7, image, options));
            options.allowedModes = 0x5A;
            const auto fewer = GetBc7BlockErrors(image, EncodeSample(BlockFormat::Bc7, image, options));
            int worse = 0;
            for (std::size_t b = 0; b < errors.size(); ++b)
                worse += errors[b] > fewer[b] || (!below.empty() && errors[b] > below[b]) ? 1 : 0;
            CHECK_MESSAGE(worse == 0, "alpha ", alpha, " quality ", static_cast<int>(quality), ": ", worse);
            below = errors;
        }
    }
}

TEST_CASE("bc7: a hint is followed, and gives the block that the search found") {
    for (const int alpha : {255, -1}) {
        const SampleImage image = MakeBc7Sample(96, 16, alpha);
        BlockOptions options;
        options.quality = BlockQuality::Best;
        const auto searched = EncodeSample(BlockFormat::Bc7, image, options);
        std::vector<std::int32_t> hints;
        for (std::size_t b = 0; b < searched.size(); b += 16) {
            const std::byte* block = &searched[b];
            std::uint32_t word = 0;
            std::memcpy(&word, block, 4);
            const int mode = GetBc7Mode(block);
            const auto rest = static_cast<int>(word >> (mode + 1));
            constexpr int kMasks[8] = {15, 63, 63, 63, 0, 0, 0, 63};
            const int rotation = mode == 4 || mode == 5 ? rest & 3 : 0;
            const int selector = mode == 4 ? rest >> 2 & 1 : 0;
            hints.push_back(shader::lanes1::NtcBc7Hint(mode, rest & kMasks[mode], rotation, selector));
        }
        options.hints = hints;
        for (const int lanes : {1, 8}) {
            options.lanes = lanes;
            CHECK(EncodeSample(BlockFormat::Bc7, image, options) == searched);
        }
        // Some are searched for, others are not.
        for (std::size_t i = 0; i < hints.size(); i += 3)
            hints[i] = -1;
        options.lanes = 0;
        CHECK(EncodeSample(BlockFormat::Bc7, image, options) == searched);
    }
}
