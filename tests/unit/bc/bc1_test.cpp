// SPDX-License-Identifier: MIT
// BC1, BC2 and BC3: single colours are the best that the format has, opaque stays opaque and transparent transparent, and
// a level is never worse than the one below it.
#include "BlockSamples.h"

#include <array>
#include <limits>

using namespace openntc;
using namespace openntc::bc;
using namespace openntc_tests;

namespace {

constexpr BlockQuality kBc1Levels[] = {BlockQuality::Fast, BlockQuality::Normal, BlockQuality::Best};

/// The least squared error of one number by a pair of endpoints of `bits`, at 1 / steps of the way between them (in steps
/// of a byte times 6).
std::array<int, 256> MakeSolidErrors(int bits, int steps) {
    std::array<int, 256> errors{};
    errors.fill(std::numeric_limits<int>::max());
    const auto widen = [&](int x) { return bits == 5 ? x << 3 | x >> 2 : x << 2 | x >> 4; };
    for (int a = 0; a < 1 << bits; ++a) {
        for (int b = 0; b < 1 << bits; ++b) {
            const int color = (widen(a) * (steps - 1) + widen(b)) * 6 / steps;
            for (int x = 0; x < 256; ++x)
                errors[static_cast<std::size_t>(x)] =
                    std::min(errors[static_cast<std::size_t>(x)], (color - 6 * x) * (color - 6 * x));
        }
    }
    return errors;
}

/// Squared errors of the blocks' first three channels.
std::vector<double> GetBlockErrors(BlockFormat format, const SampleImage& image,
                                   std::span<const std::byte> blocks) {
    std::vector<double> errors;
    for (std::uint32_t y = 0; y < image.height; y += 4) {
        for (std::uint32_t x = 0; x < image.width; x += 4) {
            SampleImage block(4, 4);
            for (std::uint32_t t = 0; t < 16; ++t) {
                for (std::uint32_t c = 0; c < 4; ++c)
                    block.At(t % 4, t / 4, c) =
                        image.texels[4 * (std::size_t{y + t / 4} * image.width + x + t % 4) + c];
            }
            const std::size_t bytes = GetBytesPerBlock(format);
            errors.push_back(GetSampleError(format, block, blocks.subspan(errors.size() * bytes, bytes), 3));
        }
    }
    return errors;
}

/// Noise, two colours, ramps with a little noise, and lines.
SampleImage MakeColorBlocks(std::uint32_t seed) {
    std::mt19937 engine(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()) >> 8; };
    SampleImage image(128, 128);
    for (std::uint32_t by = 0; by < 32; ++by) {
        for (std::uint32_t bx = 0; bx < 32; ++bx) {
            const std::uint32_t kind = random() % 4;
            std::array<std::uint32_t, 6> ends{};
            for (std::uint32_t& end : ends)
                end = random() % 256;
            const std::uint32_t wide = random() % 16 + 1;
            for (std::uint32_t t = 0; t < 16; ++t) {
                const std::uint32_t mix = random() % 2;
                for (std::uint32_t c = 0; c < 3; ++c) {
                    std::uint32_t value = random() % 256;
                    if (kind == 1)
                        value = ends[c + 3 * mix];
                    if (kind == 2)
                        value = (ends[c] * (15 - t) + ends[c + 3] * t) / 15 + random() % 4;
                    if (kind == 3)
                        value = ends[c] + (t % 4 + t / 4) * wide / 4;
                    image.At(4 * bx + t % 4, 4 * by + t / 4, c) =
                        static_cast<std::uint8_t>(std::min(value, 255u));
                }
            }
        }
    }
    return image;
}

} // namespace

TEST_CASE("BC1 and BC3: a single colour is the nearest that the format has, at every level") {
    const auto third5 = MakeSolidErrors(5, 3);
    const auto third6 = MakeSolidErrors(6, 3);
    const auto half5 = MakeSolidErrors(5, 2);
    const auto half6 = MakeSolidErrors(6, 2);
    std::mt19937 random(21);
    SampleImage image(4096, 4);
    for (std::uint32_t b = 0; b < 1024; ++b) {
        for (std::uint32_t c = 0; c < 3; ++c) {
            const auto value = static_cast<std::uint8_t>(b < 256 ? b : random() >> 24);
            for (std::uint32_t t = 0; t < 16; ++t)
                image.At(4 * b + t % 4, t / 4, c) = value;
        }
    }
    for (const BlockFormat format : {BlockFormat::Bc1, BlockFormat::Bc3}) {
        for (const BlockQuality quality : kBc1Levels) {
            BlockOptions options;
            options.quality = quality;
            const auto blocks = EncodeSample(format, image, options);
            const auto errors = GetBlockErrors(format, image, blocks);
            std::size_t wrong = 0;
            for (std::uint32_t b = 0; b < 1024; ++b) {
                const std::size_t r = image.At(4 * b, 0, 0);
                const std::size_t g = image.At(4 * b, 0, 1);
                const std::size_t blue = image.At(4 * b, 0, 2);
                int best = third5[r] + third6[g] + third5[blue];
                if (format == BlockFormat::Bc1)
                    best = std::min(best, half5[r] + half6[g] + half5[blue]);
                wrong += std::abs(errors[b] * 3 * 36 - best) > 1e-3 ? 1u : 0u;
            }
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("BC1: opaque stays opaque, and transparent is what the threshold says") {
    SampleImage image = MakeColorBlocks(22);
    std::mt19937 random(23);
    for (std::uint32_t y = 0; y < 128; ++y) {
        for (std::uint32_t x = 0; x < 128; ++x) {
            const std::uint32_t kind = (x / 4 + y / 4 * 3) % 5;
            image.At(x, y, 3) = static_cast<std::uint8_t>(kind == 0 ? 255 : kind == 1 ? 0 : random() >> 24);
        }
    }
    for (const BlockQuality quality : kBc1Levels) {
        for (const int threshold : {-1, 0, 127, 254, 255}) {
            BlockOptions options;
            options.quality = quality;
            options.alphaThreshold = threshold;
            const auto blocks = EncodeSample(BlockFormat::Bc1, image, options);
            std::vector<std::uint8_t> texels(4 * 128 * 128);
            REQUIRE(DecodeBlocksToBytes(BlockFormat::Bc1, blocks, 128, 128, texels).has_value());
            std::size_t wrong = 0;
            for (std::size_t i = 3; i < texels.size(); i += 4)
                wrong += texels[i] != (image.texels[i] > threshold ? 255 : 0) ? 1u : 0u;
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("BC2 and BC3: alpha of 255 and 0 stays what it is, in every texel") {
    SampleImage image = MakeColorBlocks(24);
    std::mt19937 random(25);
    for (std::uint8_t* alpha = &image.texels[3]; alpha < image.texels.data() + image.texels.size();
         alpha += 4) {
        const auto number = static_cast<std::uint32_t>(random());
        *alpha = static_cast<std::uint8_t>(number % 4 == 0 ? 255 : number % 4 == 1 ? 0 : number >> 24);
    }
    for (const BlockFormat format : {BlockFormat::Bc2, BlockFormat::Bc3}) {
        for (const BlockQuality quality : kBc1Levels) {
            BlockOptions options;
            options.quality = quality;
            const auto blocks = EncodeSample(format, image, options);
            std::vector<std::uint8_t> texels(image.texels.size());
            REQUIRE(DecodeBlocksToBytes(format, blocks, 128, 128, texels).has_value());
            std::size_t wrong = 0;
            for (std::size_t i = 3; i < texels.size(); i += 4) {
                const int alpha = image.texels[i];
                wrong += (alpha == 0 || alpha == 255) && texels[i] != alpha ? 1u : 0u;
                if (format == BlockFormat::Bc2) // steps of 17
                    wrong += std::abs(texels[i] - alpha) > 8 ? 1u : 0u;
            }
            CHECK(wrong == 0);
        }
    }
}

TEST_CASE("BC1 and BC3: no block is worse at a higher level") {
    const SampleImage image = MakeColorBlocks(26);
    for (const BlockFormat format : {BlockFormat::Bc1, BlockFormat::Bc3}) {
        std::vector<double> last(1024, std::numeric_limits<double>::infinity());
        double mean = 0;
        for (const BlockQuality quality : kBc1Levels) {
            BlockOptions options;
            options.quality = quality;
            const auto errors = GetBlockErrors(format, image, EncodeSample(format, image, options));
            std::size_t worse = 0;
            mean = 0;
            for (std::size_t b = 0; b < errors.size(); ++b) {
                worse += errors[b] > last[b] + 1e-9 ? 1u : 0u;
                mean += errors[b] / static_cast<double>(errors.size());
            }
            CHECK(worse == 0);
            MESSAGE(std::string(BlockFormatToString(format)), " level ", static_cast<int>(quality), ": ",
                    ToPsnr(mean), " dB");
            last = errors;
        }
    }
}
