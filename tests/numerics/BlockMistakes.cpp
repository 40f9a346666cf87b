// SPDX-License-Identifier: MIT
#include "BlockMistakes.h"

#include "openntc/bc/BlockDecoder.h"

#include <algorithm>
#include <bitset>
#include <cmath>

namespace numerics {

namespace {

using namespace openntc;
using bc::BlockFormat;

BlockMistake plantedBlockMistake = BlockMistake::None;

bool Is(BlockMistake mistake) {
    return plantedBlockMistake == mistake;
}

bool IsBc6(BlockFormat format) {
    return format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
}

bool IsSignedByte(BlockFormat format) {
    return format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
}

/// The two ends of a block of one channel, a sixteenth inwards; the indices stay.
void InsetChannel(std::byte* block) {
    const int first = std::to_integer<int>(block[0]), second = std::to_integer<int>(block[1]);
    const int inset = (first - second) / 16;
    block[0] = static_cast<std::byte>(first - inset);
    block[1] = static_cast<std::byte>(second + inset);
}

/// What a wrong encoder makes of the texels.
void Spoil(BlockPicture& picture) {
    const int channels = picture.GetChannels();
    for (std::size_t i = 0; i < picture.numbers.size(); ++i) {
        int& number = picture.numbers[i];
        const bool isAlpha = channels == 4 && i % 4 == 3;
        if (Is(BlockMistake::TruncatedColors) && !isAlpha && !IsBc6(picture.format) &&
            !IsSignedByte(picture.format))
            number &= ~7;
        if (Is(BlockMistake::RoundedAlpha) && isAlpha)
            number &= ~1;
        if (Is(BlockMistake::ThresholdOpaque) && isAlpha)
            number = std::min(number + 1, 255);
        if (Is(BlockMistake::NanIsLargest) && IsBc6(picture.format) && (number & 0x7FFF) > 0x7C00)
            number = 0x7BFF;
        if (Is(BlockMistake::SignDropped))
            number = IsBc6(picture.format) ? number & 0x7FFF : std::abs(number);
        if (Is(BlockMistake::OffsetBinary) && IsSignedByte(picture.format))
            number = (number & 0xFF) - 128;
    }
    if (Is(BlockMistake::ZeroBeyondEdge)) {
        BlockPicture padded =
            MakePicture(picture.format, (picture.width + 3) / 4 * 4, (picture.height + 3) / 4 * 4);
        for (int y = 0; y < picture.height; ++y) {
            for (int x = 0; x < picture.width; ++x) {
                for (int c = 0; c < channels; ++c)
                    padded.At(x, y, c) = picture.At(x, y, c);
            }
        }
        picture = padded;
    }
    if (Is(BlockMistake::PaddedRows)) {
        const BlockPicture whole = picture;
        const auto row = static_cast<std::size_t>((picture.width + 3) / 4 * 4 * channels);
        for (std::size_t i = 0; i < picture.numbers.size(); ++i) {
            const auto width = static_cast<std::size_t>(picture.width * channels);
            picture.numbers[i] = whole.numbers[(i / width * row + i % width) % whole.numbers.size()];
        }
    }
}

/// A block of one channel: eight or six steps between the ends, by the public text.
void DecodeChannel(const std::byte* block, bool isSigned, int channel, double (&texels)[64]) {
    const auto read = [&](int at) {
        const int byte = std::to_integer<int>(block[at]);
        return isSigned ? std::max(byte < 128 ? byte : byte - 256, -127) : byte;
    };
    const double a = read(0), b = read(1);
    const bool hasEight = isSigned ? static_cast<signed char>(block[0]) > static_cast<signed char>(block[1])
                                   : std::to_integer<int>(block[0]) > std::to_integer<int>(block[1]);
    double palette[8] = {a, b};
    for (int i = 2; i < 8; ++i)
        palette[i] = hasEight ? ((8 - i) * a + (i - 1) * b) / 7 : ((6 - i) * a + (i - 1) * b) / 5;
    if (!hasEight) {
        palette[6] = isSigned ? -127 : 0;
        palette[7] = isSigned ? 127 : 255;
    }
    for (std::size_t t = 0; t < 16; ++t) {
        std::size_t index = 0;
        for (std::size_t bit = 3 * t; bit < 3 * t + 3; ++bit)
            index |= (std::to_integer<std::size_t>(block[2 + bit / 8]) >> (bit % 8) & 1) << (bit - 3 * t);
        texels[4 * t + static_cast<std::size_t>(channel)] = palette[index];
    }
}

/// The colours of BC1, BC2 and BC3.
void DecodeColors(const std::byte* block, bool hasThree, double (&texels)[64]) {
    const auto read = [&](int at) {
        return std::to_integer<int>(block[at]) | std::to_integer<int>(block[at + 1]) << 8;
    };
    const int ends[2] = {read(0), read(2)};
    double palette[4][4];
    for (int e = 0; e < 2; ++e) {
        const int red = ends[e] >> 11, green = ends[e] >> 5 & 63, blue = ends[e] & 31;
        palette[e][0] = red << 3 | red >> 2; // the highest bits again
        palette[e][1] = green << 2 | green >> 4;
        palette[e][2] = blue << 3 | blue >> 2;
        palette[e][3] = 255;
    }
    const bool isThree = hasThree && ends[0] <= ends[1];
    for (int c = 0; c < 3; ++c) {
        const double a = palette[0][c], b = palette[1][c];
        palette[2][c] = isThree ? (a + b) / 2 : (2 * a + b) / 3;
        palette[3][c] = isThree ? 0 : (a + 2 * b) / 3;
    }
    palette[2][3] = 255;
    palette[3][3] = isThree ? 0 : 255;
    for (std::size_t t = 0; t < 16; ++t) {
        const std::size_t index = std::to_integer<std::size_t>(block[4 + t / 4]) >> (2 * (t % 4)) & 3;
        for (std::size_t c = 0; c < 4; ++c)
            texels[4 * t + c] = palette[index][c];
    }
}

/// A block of one channel with the extremes as its ends, and the nearest index for each texel.
void EncodeExtremes(const BlockPicture& picture, int left, int top, int channel, std::byte* block) {
    int numbers[16], least = 255, most = 0;
    for (int t = 0; t < 16; ++t) {
        numbers[t] = picture.At(std::min(left + t % 4, picture.width - 1),
                                std::min(top + t / 4, picture.height - 1), channel);
        least = std::min(least, numbers[t]);
        most = std::max(most, numbers[t]);
    }
    block[0] = static_cast<std::byte>(most);
    block[1] = static_cast<std::byte>(least);
    std::uint64_t indices = 0;
    for (int t = 0; t < 16; ++t) {
        double best = INFINITY;
        std::uint64_t chosen = 0;
        for (std::uint64_t index = 0; index < 8; ++index) {
            const double place =
                index < 2 ? static_cast<double>(1 - index) : static_cast<double>(8 - index) / 7;
            const double error = std::fabs(least + place * (most - least) - numbers[t]);
            if (error < best) {
                best = error;
                chosen = index;
            }
        }
        indices |= chosen << (3 * t);
    }
    for (int i = 0; i < 6; ++i)
        block[2 + i] = static_cast<std::byte>(indices >> (8 * i) & 0xFF);
}

} // namespace

PlantedBlockMistake::PlantedBlockMistake(BlockMistake mistake) {
    plantedBlockMistake = mistake;
}

PlantedBlockMistake::~PlantedBlockMistake() {
    plantedBlockMistake = BlockMistake::None;
}

BlockPicture MakePicture(BlockFormat format, int width, int height, int number) {
    BlockPicture picture;
    picture.format = format;
    picture.width = width;
    picture.height = height;
    picture.numbers.assign(static_cast<std::size_t>(width * height * picture.GetChannels()), number);
    return picture;
}

std::vector<std::byte> EncodePicture(const BlockPicture& picture, tool::BlockEffort effort, int threads) {
    BlockPicture taken = picture;
    Spoil(taken);
    tool::TextureFormat format;
    format.block = picture.format;
    format.channels = picture.GetChannels();
    format.hasAlpha = picture.hasAlpha;
    format.number = IsBc6(picture.format)          ? tool::TexelNumber::Half
                    : IsSignedByte(picture.format) ? tool::TexelNumber::Snorm8
                                                   : tool::TexelNumber::Unorm8;
    std::vector<std::byte> texels;
    for (const int number : taken.numbers) {
        texels.push_back(static_cast<std::byte>(number & 0xFF));
        if (IsBc6(picture.format))
            texels.push_back(static_cast<std::byte>(number >> 8 & 0xFF));
    }
    if (Is(BlockMistake::LevelIgnored))
        effort = effort == tool::BlockEffort::Best ? tool::BlockEffort::Normal : tool::BlockEffort::Fast;
    std::vector<std::byte> blocks;
    tool::EncodeTexelBlocks(
        format, effort,
        {texels, static_cast<std::uint32_t>(taken.width), static_cast<std::uint32_t>(taken.height)}, threads,
        "hard case", blocks);
    if (Is(BlockMistake::InsetEndpoints)) {
        const std::size_t unit = bc::GetBytesPerBlock(picture.format);
        for (std::size_t i = 0; i < blocks.size(); i += unit) {
            if (picture.format == BlockFormat::Bc3 || format.channels < 3)
                InsetChannel(&blocks[i]);
            if (format.channels == 2)
                InsetChannel(&blocks[i + 8]);
        }
    }
    if (Is(BlockMistake::ExtremesOnly) && format.channels < 3 && !IsSignedByte(picture.format)) {
        const int columns = (taken.width + 3) / 4;
        const std::size_t unit = bc::GetBytesPerBlock(picture.format);
        for (std::size_t i = 0; i < blocks.size() / unit; ++i) {
            for (int c = 0; c < format.channels; ++c)
                EncodeExtremes(taken, static_cast<int>(i) % columns * 4, static_cast<int>(i) / columns * 4, c,
                               &blocks[i * unit + 8 * static_cast<std::size_t>(c)]);
        }
    }
    return blocks;
}

void DecodeNumbers(BlockFormat format, const std::byte* block, double (&texels)[64]) {
    for (int i = 0; i < 64; ++i)
        texels[i] = i % 4 == 3 ? 255 : 0;
    switch (format) {
    case BlockFormat::Bc1:
        DecodeColors(block, true, texels);
        return;
    case BlockFormat::Bc2:
        DecodeColors(block + 8, false, texels);
        for (std::size_t t = 0; t < 16; ++t)
            texels[4 * t + 3] = 17 * (std::to_integer<int>(block[t / 2]) >> (4 * (t % 2)) & 15);
        return;
    case BlockFormat::Bc3:
        DecodeColors(block + 8, false, texels);
        DecodeChannel(block, false, 3, texels);
        return;
    case BlockFormat::Bc4Unsigned:
    case BlockFormat::Bc4Signed:
    case BlockFormat::Bc5Unsigned:
    case BlockFormat::Bc5Signed:
        for (int c = 0; c < bc::GetBlockChannels(format); ++c)
            DecodeChannel(block + 8 * c, IsSignedByte(format), c, texels);
        return;
    case BlockFormat::Bc6Unsigned:
    case BlockFormat::Bc6Signed: {
        std::uint16_t halves[64];
        bc::DecodeBlockHalves(format, block, halves);
        std::copy(std::begin(halves), std::end(halves), texels);
        return;
    }
    case BlockFormat::Bc7: {
        std::byte copy[16];
        std::copy_n(block, 16, copy);
        if (Is(BlockMistake::ReservedCodeMode0) && copy[0] == std::byte{0})
            copy[0] = std::byte{1};
        std::uint8_t bytes[64];
        bc::DecodeBlockBytes(format, copy, bytes);
        std::copy(std::begin(bytes), std::end(bytes), texels);
        return;
    }
    }
}

} // namespace numerics
