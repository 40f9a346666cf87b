// SPDX-License-Identifier: MIT
// What is hard about block compression. Every case runs at every level; that passes on a GPU make the same
// blocks shows shader_bc. "Worst" is in steps of a byte, or counts texels or blocks that are not as they must
// be.
#include "BlockMistakes.h"
#include "HardCases.h"

#include "openntc/core/Crc32.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>

namespace numerics {

namespace {

using namespace openntc;
using bc::BlockFormat;
using tool::BlockEffort;

constexpr BlockEffort kEfforts[] = {BlockEffort::Fast, BlockEffort::Normal, BlockEffort::Best};

/// Calls use(block, left, top).
template <typename Use>
void ForBlocks(const BlockPicture& picture, std::span<const std::byte> blocks, const Use& use) {
    const int columns = (picture.width + 3) / 4;
    const std::size_t unit = bc::GetBytesPerBlock(picture.format);
    for (std::size_t i = 0; i < blocks.size() / unit; ++i)
        use(&blocks[i * unit], static_cast<int>(i) % columns * 4, static_cast<int>(i) / columns * 4);
}

/// Calls use(decoded texel, x, y) for every texel of the picture.
template <typename Use>
void ForTexels(const BlockPicture& picture, std::span<const std::byte> blocks, const Use& use) {
    ForBlocks(picture, blocks, [&](const std::byte* block, int left, int top) {
        double texels[64];
        DecodeNumbers(picture.format, block, texels);
        for (int t = 0; t < 16; ++t) {
            if (left + t % 4 < picture.width && top + t / 4 < picture.height)
                use(texels + 4 * t, left + t % 4, top + t / 4);
        }
    });
}

/// Largest difference of any channel, at any level.
double GetWorst(BlockPicture& picture, int firstChannel = 0) {
    double worst = 0;
    for (const BlockEffort effort : kEfforts) {
        ForTexels(picture, EncodePicture(picture, effort), [&](const double* texel, int x, int y) {
            for (int c = firstChannel; c < picture.GetChannels(); ++c)
                worst = std::max(worst, std::fabs(texel[c] - picture.At(x, y, c)));
        });
    }
    return worst;
}

std::uint32_t HashPlace(std::uint32_t x, std::uint32_t y, std::uint32_t c) {
    std::uint32_t h = x * 0x8da6b343u ^ y * 0xd8163841u ^ c * 0xcb1ab31fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    return h ^ (h >> 13);
}

/// The smallest squared error that BC1 has for a colour: for each place between the ends the best pair of
/// each channel.
double GetSolidOptimum(const int (&color)[3]) {
    double best = INFINITY;
    for (const double place : {0.0, 1.0 / 3, 0.5}) {
        double sum = 0;
        for (int c = 0; c < 3; ++c) {
            const int bits = c == 1 ? 6 : 5, count = 1 << bits;
            const auto expand = [&](int code) { return code << (8 - bits) | code >> (2 * bits - 8); };
            double least = INFINITY;
            for (int a = 0; a < count; ++a) {
                for (int b = 0; b < count; ++b) {
                    const double value = expand(a) * (1 - place) + expand(b) * place;
                    least = std::min(least, (value - color[c]) * (value - color[c]));
                }
            }
            sum += least;
        }
        best = std::min(best, sum);
    }
    return best;
}

Measurement MeasureSolid() {
    double worst = 0;
    // Lossless where the format has every number: all grays of a byte, one a block.
    for (const BlockFormat format : {BlockFormat::Bc4Unsigned, BlockFormat::Bc5Unsigned, BlockFormat::Bc7}) {
        BlockPicture picture = MakePicture(format, 1024, 4, 255);
        for (int x = 0; x < 1024; ++x) {
            for (int y = 0; y < 4; ++y) {
                for (int c = 0; c < picture.GetChannels(); ++c)
                    picture.At(x, y, c) = (x / 4 * (2 * c + 1)) & 255;
            }
        }
        worst = std::max(worst, GetWorst(picture));
    }
    // And the nearest that the format has elsewhere.
    BlockPicture picture = MakePicture(BlockFormat::Bc1, 64, 4, 255);
    for (int x = 0; x < 64; ++x) {
        for (int y = 0; y < 4; ++y) {
            for (int c = 0; c < 3; ++c)
                picture.At(x, y, c) = static_cast<int>(
                    HashPlace(static_cast<std::uint32_t>(x / 4), 0, static_cast<std::uint32_t>(c)) & 255);
        }
    }
    for (const BlockEffort effort : kEfforts) {
        ForTexels(picture, EncodePicture(picture, effort), [&](const double* texel, int x, int y) {
            int color[3];
            double error = 0;
            for (int c = 0; c < 3; ++c) {
                color[c] = picture.At(x, y, c);
                error += (texel[c] - color[c]) * (texel[c] - color[c]);
            }
            // Sums of squares below 2^17 of numbers with a third in them: 1e-9 is their rounding.
            worst = std::max(worst, error - GetSolidOptimum(color) - 1e-9);
        });
    }
    return {worst, {}};
}

// Two colours that the formats hold: no end may be moved for what lies between them.
Measurement MeasureTwoColors() {
    double worst = 0;
    for (const BlockFormat format : {BlockFormat::Bc1, BlockFormat::Bc4Unsigned, BlockFormat::Bc5Unsigned}) {
        BlockPicture picture = MakePicture(format, 256, 4, 255);
        for (int x = 0; x < 256; ++x) {
            for (int y = 0; y < 4; ++y) {
                const auto block = static_cast<std::uint32_t>(x / 4);
                const std::uint32_t side =
                    HashPlace(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y), 9) & 1;
                for (int c = 0; c < std::min(picture.GetChannels(), 3); ++c) {
                    const auto n = static_cast<int>(HashPlace(block, side, static_cast<std::uint32_t>(c)));
                    const int five = n & 31, six = n & 63;
                    picture.At(x, y, c) = format != BlockFormat::Bc1 ? n & 255
                                          : c == 1                   ? six << 2 | six >> 4
                                                                     : five << 3 | five >> 2;
                }
            }
        }
        worst = std::max(worst, GetWorst(picture));
    }
    return {worst, {}};
}

// Ramps of up to eight values: BC4's palettes hold them.
Measurement MeasureRamps() {
    double worst = 0;
    for (const BlockFormat format : {BlockFormat::Bc4Unsigned, BlockFormat::Bc5Unsigned}) {
        BlockPicture picture = MakePicture(format, 4 * 248, 4);
        for (int x = 0; x < picture.width; ++x) {
            for (int y = 0; y < 4; ++y) {
                for (int c = 0; c < picture.GetChannels(); ++c)
                    picture.At(x, y, c) = x / 4 + (c == 0 ? (x % 4 + y) % 8 : 7 - (2 * y + x) % 8);
            }
        }
        worst = std::max(worst, GetWorst(picture));
    }
    // A slope in all channels: a higher level is no worse.
    for (const BlockFormat format :
         {BlockFormat::Bc1, BlockFormat::Bc3, BlockFormat::Bc6Unsigned, BlockFormat::Bc7}) {
        BlockPicture picture = MakePicture(format, 64, 64);
        for (int x = 0; x < 64; ++x) {
            for (int y = 0; y < 64; ++y) {
                for (int c = 0; c < picture.GetChannels(); ++c)
                    picture.At(x, y, c) =
                        (3 * x + (1 + c) * y) / 2 + (format == BlockFormat::Bc6Unsigned ? 0x3800 : 0);
            }
        }
        double before = INFINITY;
        for (const BlockEffort effort : kEfforts) {
            double sum = 0;
            ForTexels(picture, EncodePicture(picture, effort), [&](const double* texel, int x, int y) {
                for (int c = 0; c < picture.GetChannels(); ++c)
                    sum += (texel[c] - picture.At(x, y, c)) * (texel[c] - picture.At(x, y, c));
            });
            worst = std::max(worst, sum - before - 1e-6); // rounding of thirds, as above, of 2^14 numbers
            before = sum;
        }
    }
    return {worst, {}};
}

// Texels whose alpha of 0 or 255 does not stay.
Measurement MeasureAlphaEnds() {
    double moved = 0;
    for (const BlockFormat format : {BlockFormat::Bc2, BlockFormat::Bc3, BlockFormat::Bc7}) {
        BlockPicture picture = MakePicture(format, 64, 64);
        for (int x = 0; x < 64; ++x) {
            for (int y = 0; y < 64; ++y) {
                for (int c = 0; c < 3; ++c)
                    picture.At(x, y, c) = static_cast<int>(HashPlace(static_cast<std::uint32_t>(x),
                                                                     static_cast<std::uint32_t>(y),
                                                                     static_cast<std::uint32_t>(c)) &
                                                           255);
                // BC7 shares its ends between colour and alpha: whole blocks. The others have alpha
                // apart: any texel.
                const int u = format == BlockFormat::Bc7 ? x / 4 : x,
                          v = format == BlockFormat::Bc7 ? y / 4 : y;
                picture.At(x, y, 3) =
                    (HashPlace(static_cast<std::uint32_t>(u), static_cast<std::uint32_t>(v), 5) & 1) != 0
                        ? 255
                        : 0;
            }
        }
        for (const BlockEffort effort : kEfforts) {
            ForTexels(picture, EncodePicture(picture, effort), [&](const double* texel, int x, int y) {
                moved += texel[3] != picture.At(x, y, 3) ? 1 : 0;
            });
        }
    }
    return {moved, {}};
}

// All alphas round the threshold: 127 is transparent, 128 opaque, and no other texel is.
Measurement MeasureThreshold() {
    double wrong = 0;
    for (const bool hasAlpha : {true, false}) {
        BlockPicture picture = MakePicture(BlockFormat::Bc1, 256, 8);
        picture.hasAlpha = hasAlpha;
        for (int x = 0; x < 256; ++x) {
            for (int y = 0; y < 8; ++y) {
                for (int c = 0; c < 3; ++c)
                    picture.At(x, y, c) = (x * (c + 1) + 40 * y) & 255;
                picture.At(x, y, 3) = y < 4 ? (x + 64 * y) & 255 : 126 + (x + y) % 4;
            }
        }
        for (const BlockEffort effort : kEfforts) {
            ForTexels(picture, EncodePicture(picture, effort), [&](const double* texel, int x, int y) {
                const bool isOpaque = !hasAlpha || picture.At(x, y, 3) >= 128;
                wrong += texel[3] != (isOpaque ? 255 : 0) ? 1 : 0;
            });
        }
    }
    return {wrong, {}};
}

// What halves count as: unsigned blocks hold 0 and more, no block holds an infinity or a NaN.
Measurement MeasureHalfNumbers() {
    struct Row {
        int half, unsignedHalf, signedHalf;
    };
    constexpr Row kRows[] = {
        {0x0000, 0x0000, 0x0000}, {0x8000, 0x0000, 0x0000}, {0x0001, 0x0001, 0x0001},
        {0x8001, 0x0000, 0x8001}, {0x3C00, 0x3C00, 0x3C00}, {0xBC00, 0x0000, 0xBC00},
        {0x7BFF, 0x7BFF, 0x7BFF}, {0xFBFF, 0x0000, 0xFBFF}, {0x7C00, 0x7BFF, 0x7BFF},
        {0xFC00, 0x0000, 0xFBFF}, {0x7C01, 0x0000, 0x0000}, {0xFE00, 0x0000, 0x0000},
    };
    double worst = 0;
    for (const BlockFormat format : {BlockFormat::Bc6Unsigned, BlockFormat::Bc6Signed}) {
        BlockPicture picture = MakePicture(format, 4 * static_cast<int>(std::size(kRows)), 4);
        for (int x = 0; x < picture.width; ++x) {
            for (int y = 0; y < 4; ++y) {
                for (int c = 0; c < 3; ++c)
                    picture.At(x, y, c) = kRows[x / 4].half;
            }
        }
        for (const BlockEffort effort : kEfforts) {
            ForTexels(picture, EncodePicture(picture, effort), [&](const double* texel, int x, int) {
                const Row& row = kRows[x / 4];
                for (int c = 0; c < 3; ++c) {
                    const int wanted = format == BlockFormat::Bc6Signed ? row.signedHalf : row.unsignedHalf;
                    // -0 and 0 are the same number.
                    const double got = texel[c] == 0x8000 ? 0 : texel[c];
                    worst = std::max(worst, std::fabs(got - wanted));
                }
            });
        }
    }
    return {worst, {}};
}

// Normals that point left: X from -127 to 127, one a block, and slopes across zero.
Measurement MeasureSigned() {
    double worst = 0;
    for (const BlockFormat format : {BlockFormat::Bc4Signed, BlockFormat::Bc5Signed}) {
        BlockPicture solid = MakePicture(format, 4 * 255, 4);
        BlockPicture slope = MakePicture(format, 4 * 31, 4);
        for (int x = 0; x < solid.width; ++x) {
            for (int y = 0; y < 4; ++y) {
                for (int c = 0; c < solid.GetChannels(); ++c) {
                    solid.At(x, y, c) = c == 0 ? x / 4 - 127 : 127 - x / 4;
                    if (x < slope.width)
                        slope.At(x, y, c) = (c == 0 ? 1 : -1) * (x / 4 - 15 - 3 + (x % 4 + y));
                }
            }
        }
        worst = std::max({worst, GetWorst(solid), GetWorst(slope)});
        // -128 is read as -127 and never written.
        const BlockPicture lowest = MakePicture(format, 8, 8, -128);
        for (const BlockEffort effort : kEfforts) {
            ForBlocks(lowest, EncodePicture(lowest, effort), [&](const std::byte* block, int, int) {
                for (int c = 0; c < lowest.GetChannels(); ++c) {
                    for (int e = 0; e < 2; ++e)
                        worst = std::max(worst, block[8 * c + e] == std::byte{0x80} ? 1.0 : 0.0);
                }
                double texels[64];
                DecodeNumbers(format, block, texels);
                worst = std::max(worst, std::fabs(texels[0] + 127));
            });
        }
    }
    return {worst, {}};
}

// Blocks that differ from those of the picture with its edge repeated up to whole blocks.
Measurement MeasureEdges() {
    constexpr int kSizes[][2] = {{1, 1}, {2, 1}, {1, 7}, {3, 3}, {5, 2}, {23, 11}, {47, 1}};
    double different = 0;
    for (int f = 0; f < bc::kBlockFormatCount; ++f) {
        const auto format = static_cast<BlockFormat>(f);
        for (const auto& size : kSizes) {
            BlockPicture picture = MakePicture(format, size[0], size[1]);
            BlockPicture whole = MakePicture(format, (size[0] + 3) / 4 * 4, (size[1] + 3) / 4 * 4);
            for (int x = 0; x < whole.width; ++x) {
                for (int y = 0; y < whole.height; ++y) {
                    const int fromX = std::min(x, size[0] - 1), fromY = std::min(y, size[1] - 1);
                    for (int c = 0; c < picture.GetChannels(); ++c) {
                        const auto hash =
                            HashPlace(static_cast<std::uint32_t>(fromX), static_cast<std::uint32_t>(fromY),
                                      static_cast<std::uint32_t>(c));
                        whole.At(x, y, c) = static_cast<int>(f >= 7 && f <= 8 ? hash % 0x7C00 : hash & 127);
                        picture.At(fromX, fromY, c) = whole.At(x, y, c);
                    }
                }
            }
            // The edge is repeated here, so that the blocks of `whole` hang on no rule.
            const std::vector<std::byte> expected = EncodePicture(whole, BlockEffort::Normal);
            const std::vector<std::byte> blocks = EncodePicture(picture, BlockEffort::Normal);
            different += blocks != expected ? 1 : 0;
        }
    }
    return {different, {}};
}

// Blocks of BC7 with nothing but a mode, of zeros and of ones: whatever partition, rotation and index are
// read, one colour comes out. Without a mode: transparent black.
Measurement MeasureDegenerate() {
    double wrong = 0;
    for (int mode = 0; mode <= 8; ++mode) {
        for (const int fill : {0x00, 0xFF}) {
            std::byte block[16];
            std::fill(std::begin(block), std::end(block), static_cast<std::byte>(fill));
            block[0] =
                mode == 8 ? std::byte{0} : static_cast<std::byte>((fill & ~((2 << mode) - 1)) | 1 << mode);
            double texels[64];
            DecodeNumbers(BlockFormat::Bc7, block, texels);
            for (int i = 0; i < 64; ++i) {
                const bool isOpaqueMode = mode <= 3;
                const double wanted = mode == 8                    ? 0
                                      : fill == 0xFF               ? 255
                                      : i % 4 == 3 && isOpaqueMode ? 255
                                                                   : 0;
                wrong += texels[i] != wanted ? 1 : 0;
            }
        }
    }
    // BC6H: the four codes of five bits that no mode has are black.
    for (const int code : {0x13, 0x17, 0x1B, 0x1F}) {
        std::byte block[16];
        std::fill(std::begin(block), std::end(block), std::byte{0xFF});
        block[0] = static_cast<std::byte>(0xE0 | code);
        double texels[64];
        DecodeNumbers(BlockFormat::Bc6Unsigned, block, texels);
        for (int i = 0; i < 64; ++i)
            wrong += texels[i] != (i % 4 == 3 ? 0x3C00 : 0) ? 1 : 0;
    }
    return {wrong, {}};
}

// CRC-32 of the blocks of a picture made of integers, of the three levels after one another.
constexpr std::uint32_t kBlockChecksums[bc::kBlockFormatCount] = {
    0x3c63c4c8, 0xd0e79f63, 0x9ca674c5, 0x7d97116f, 0xe8222360,
    0xe9e6f6c0, 0x57d38237, 0x7f0b9851, 0xfa0036eb, 0x3d488a39};

Measurement MeasureBlockDeterminism() {
    double different = 0;
    std::string note = "checksums:";
    for (int f = 0; f < bc::kBlockFormatCount; ++f) {
        const auto format = static_cast<BlockFormat>(f);
        BlockPicture picture = MakePicture(format, 64, 48);
        for (int x = 0; x < picture.width; ++x) {
            for (int y = 0; y < picture.height; ++y) {
                for (int c = 0; c < picture.GetChannels(); ++c) {
                    const std::uint32_t noise =
                        HashPlace(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y),
                                  static_cast<std::uint32_t>(c));
                    const int smooth = (x * (c + 2) + y * 3) & 255;
                    const int byte = x < 32   ? smooth
                                     : y < 24 ? static_cast<int>(noise & 255)
                                              : (smooth & 0xE0) + static_cast<int>(noise & 7);
                    picture.At(x, y, c) = f == 7 || f == 8   ? 0x2C00 + 64 * byte
                                          : f == 4 || f == 6 ? byte - 128
                                                             : byte;
                }
            }
        }
        for (const int threads : {1, 3}) {
            std::uint32_t crc = 0;
            for (const BlockEffort effort : kEfforts)
                crc = Crc32(EncodePicture(picture, effort, threads), crc);
            different += crc != kBlockChecksums[f] ? 1 : 0;
            if (threads == 1) {
                char text[16];
                std::snprintf(text, sizeof text, " %08x", crc);
                note += text;
            }
        }
    }
    return {different, note};
}

constexpr HardCase kBlockCases[] = {
    {"blocks-one-colour",
     "Blocks of one colour: every gray in BC4, BC5 and BC7; in BC1 the nearest that any pair of ends and any "
     "place between them gives.",
     "Encoders that round the colour to 5, 6 and 5 bits and use it for both ends: up to four steps off, and "
     "visible as bands.",
     "Ends come from tables made by trying all pairs of each channel.", 0, MeasureSolid},
    {"blocks-two-colours", "Blocks of two values that the ends can hold.",
     "Encoders that always move the ends inwards, which helps on noise.",
     "Ends are moved where the error falls only.", 0, MeasureTwoColors},
    {"blocks-ramps",
     "Ramps of eight values, which BC4's palette holds; slopes over many blocks, where no level may be worse "
     "than the one below.",
     "Encoders that start from the extremes alone, levels that search elsewhere rather than further.",
     "Palettes whose steps are the texels' are tried; a level visits all that the one below it visits.", 0,
     MeasureRamps},
    {"blocks-alpha-ends", "Alpha of 255 and 0 beside each other: counts texels that change.",
     "Encoders that fit colour and alpha together; p-bits that make 254 of 255.",
     "BC2 and BC3 hold both ends; in BC7 blocks that are opaque or clear everywhere take ends that give 255 "
     "and 0.",
     0, MeasureAlphaEnds},
    {"blocks-alpha-threshold",
     "BC1 at alpha 127 and 128: counts texels on the wrong side, and transparent ones of textures without "
     "alpha.",
     "A comparison that includes the threshold on one side; black texels that become transparent because "
     "fourth index and order of ends were left to chance.",
     "Transparent is where alpha is at most the threshold, and blocks without such texels never use the "
     "fourth index of three colours.",
     0, MeasureThreshold},
    {"blocks-half-numbers",
     "NaN, infinities, negative numbers, -0 and subnormal ones into BC6H, in units of a half's last place.",
     "Encoders that take the bits as they come: NaN beyond the largest number, negative ones as huge.",
     "The documented rule: NaN is 0, infinity 65504, negative 0 in unsigned blocks.", 0, MeasureHalfNumbers},
    {"blocks-signed",
     "Normals with negative X in signed BC4 and BC5, from -127 to 127 and across zero; -128.",
     "Bytes taken as unsigned; -128 written as an end, where decoders differ.",
     "Numbers have signs from the texel on; -128 counts as -127.", 0, MeasureSigned},
    {"blocks-edges",
     "Images of one texel, odd sides, mips that are no multiples of 4: counts images whose blocks are not "
     "those of the image with its edge repeated.",
     "LibNTC 0.7's pass takes zeros for what is outside; rows padded to blocks.",
     "Coordinates are clamped to the rectangle.", 0, MeasureEdges},
    {"blocks-degenerate-codes",
     "BC7 blocks of one mode bit and nothing else, and reserved codes of BC7 and BC6H: counts wrong numbers.",
     "Decoders that find a mode where there is none.",
     "Reserved codes are transparent black in BC7, black in BC6H, as samplers have them.", 0,
     MeasureDegenerate},
    {"blocks-determinism",
     "The same blocks from every compiler, instruction set and number of threads: counts formats whose "
     "checksum is another.",
     "Encoders in floating point: their blocks change with contraction and vector width.",
     "The mathematics are integers; the GPU's blocks are these too.", 0, MeasureBlockDeterminism},
};

} // namespace

std::span<const HardCase> ListBlockCases() {
    return kBlockCases;
}

} // namespace numerics
