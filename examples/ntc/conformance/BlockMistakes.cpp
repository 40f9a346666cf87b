// SPDX-License-Identifier: MIT
// Our block encoder, and what wrong integrations make of it.
#include "BlockSuite.h"

#include "openntc/image/ColorEncoding.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace openntc::conformance {

namespace {

using bc::BlockFormat;

constexpr BlockMistakeInfo kBlockMistakes[] = {
    {BlockMistake::SwappedRedBlue, "blocks_red_blue", "red and blue are swapped", "blocks-bc7-normal"},
    {BlockMistake::UpsideDown, "blocks_upside_down", "the last row is taken as the first",
     "blocks-bc4-normal"},
    {BlockMistake::ZeroBeyondEdge, "blocks_zero_border", "texels beyond the edge are 0; they repeat the edge",
     "blocks-bc5-normal"},
    {BlockMistake::SrgbRead, "blocks_srgb_read",
     "colours are made linear when they are read; blocks are made of the stored numbers", "blocks-bc7-fast"},
    {BlockMistake::LevelFast, "blocks_level_fast", "every level is fast", "blocks-bc7-best"},
    {BlockMistake::LevelNormal, "blocks_level_normal", "every level is normal", "blocks-bc4s-best"},
    {BlockMistake::ThresholdOpaque, "blocks_threshold_below",
     "alpha at the threshold is opaque; it is transparent", "blocks-bc1-cutout-normal"},
    {BlockMistake::ThresholdIgnored, "blocks_threshold_ignored", "nothing becomes transparent",
     "blocks-bc1-cutout-best"},
    {BlockMistake::ThresholdAlways, "blocks_threshold_always",
     "alpha makes texels transparent where no threshold was given", "blocks-bc1-normal"},
    {BlockMistake::SignedAsUnsigned, "blocks_unsigned_bytes", "signed bytes are taken as 0 to 255, less 128",
     "blocks-bc5s-normal"},
    {BlockMistake::NanIsLargest, "blocks_nan_largest", "NaN counts as 65504; it counts as 0",
     "blocks-bc6-normal"},
    {BlockMistake::SignDropped, "blocks_sign_dropped",
     "negative numbers count as positive ones; unsigned blocks take them as 0", "blocks-bc6-fast"},
    {BlockMistake::SwappedWords, "blocks_swapped_words",
     "the words of 32 bits are stored in pairs, the second first", "blocks-bc4-fast"},
    {BlockMistake::SwappedHalves, "blocks_swapped_halves",
     "the two halves of a block of 16 bytes are swapped", "blocks-bc3-normal"},
    {BlockMistake::ColumnOrder, "blocks_column_order", "blocks follow each other column by column",
     "blocks-bc2-normal"},
};

/// The numbers of a request, four a texel.
struct Numbers {
    int width, height;
    std::vector<int> numbers;

    Numbers(int w, int h) : width(w), height(h), numbers(static_cast<std::size_t>(4 * w * h)) {}
    int& At(int x, int y, int c) { return numbers[static_cast<std::size_t>(4 * (y * width + x) + c)]; }
};

bool IsHalf(BlockFormat format) {
    return format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
}

bool IsSignedByte(BlockFormat format) {
    return format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
}

Numbers ReadNumbers(const BlockRequest& request) {
    Numbers picture(request.width, request.height);
    for (std::size_t i = 0; i < picture.numbers.size(); ++i) {
        const auto byte = [&](std::size_t at) { return std::to_integer<int>(request.texels[at]); };
        picture.numbers[i] = IsHalf(request.format) ? byte(2 * i) | byte(2 * i + 1) << 8 : byte(i);
    }
    return picture;
}

int MakeLinear(int byte) {
    const float linear = image::DecodeColor(ColorSpace::sRGB, static_cast<float>(byte) / 255.0f);
    return static_cast<int>(std::lround(255.0f * linear));
}

void SpoilNumber(int& number, int channel, const BlockRequest& request, BlockMistake mistake) {
    const bool isHalf = IsHalf(request.format);
    if (mistake == BlockMistake::SrgbRead && channel < 3 && !isHalf && !IsSignedByte(request.format))
        number = MakeLinear(number);
    if (mistake == BlockMistake::SignedAsUnsigned && IsSignedByte(request.format))
        number = (number - 128) & 0xFF;
    if (mistake == BlockMistake::NanIsLargest && isHalf && (number & 0x7FFF) > 0x7C00)
        number = 0x7BFF;
    if (mistake == BlockMistake::SignDropped && isHalf)
        number &= 0x7FFF;
}

void SpoilPicture(Numbers& picture, const BlockRequest& request, BlockMistake mistake) {
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            for (int c = 0; c < 4; ++c)
                SpoilNumber(picture.At(x, y, c), c, request, mistake);
            if (mistake == BlockMistake::SwappedRedBlue)
                std::swap(picture.At(x, y, 0), picture.At(x, y, 2));
        }
    }
    if (mistake == BlockMistake::UpsideDown) {
        for (int y = 0; y < picture.height / 2; ++y) {
            for (int i = 0; i < 4 * picture.width; ++i)
                std::swap(picture.At(i / 4, y, i % 4), picture.At(i / 4, picture.height - 1 - y, i % 4));
        }
    }
    if (mistake == BlockMistake::ZeroBeyondEdge) {
        Numbers padded((picture.width + 3) / 4 * 4, (picture.height + 3) / 4 * 4);
        for (int y = 0; y < picture.height; ++y) {
            for (int i = 0; i < 4 * picture.width; ++i)
                padded.At(i / 4, y, i % 4) = picture.At(i / 4, y, i % 4);
        }
        picture = std::move(padded);
    }
}

void SpoilBlocks(std::vector<std::byte>& blocks, const BlockRequest& request, BlockMistake mistake) {
    const std::size_t unit = bc::GetBytesPerBlock(request.format);
    if (mistake == BlockMistake::SwappedWords) {
        for (std::size_t i = 0; i < blocks.size(); i += 8)
            std::swap_ranges(&blocks[i], &blocks[i] + 4, &blocks[i] + 4);
    }
    if (mistake == BlockMistake::SwappedHalves && unit == 16) {
        for (std::size_t i = 0; i < blocks.size(); i += unit)
            std::swap_ranges(&blocks[i], &blocks[i] + 8, &blocks[i] + 8);
    }
    if (mistake == BlockMistake::ColumnOrder) {
        const std::vector<std::byte> rows = blocks;
        const std::size_t columns = request.GetRowBytes() / unit, count = blocks.size() / unit / columns;
        for (std::size_t i = 0; i < columns * count; ++i)
            std::copy_n(&rows[(i % columns * 1 + i / columns * columns) * unit], unit,
                        &blocks[(i % columns * count + i / columns) * unit]);
    }
}

} // namespace

std::span<const BlockMistakeInfo> ListBlockMistakes() {
    return kBlockMistakes;
}

std::vector<std::byte> EncodeBlockRequest(const BlockRequest& request, BlockMistake mistake) {
    Numbers picture = ReadNumbers(request);
    SpoilPicture(picture, request, mistake);
    tool::TextureFormat format;
    format.block = request.format;
    format.channels = bc::GetBlockChannels(request.format);
    format.number = IsHalf(request.format)         ? tool::TexelNumber::Half
                    : IsSignedByte(request.format) ? tool::TexelNumber::Snorm8
                                                   : tool::TexelNumber::Unorm8;
    std::vector<std::byte> texels;
    for (int y = 0; y < picture.height; ++y) {
        for (int x = 0; x < picture.width; ++x) {
            for (int c = 0; c < format.channels; ++c) {
                const int number = picture.At(x, y, c);
                texels.push_back(static_cast<std::byte>(number & 0xFF));
                if (IsHalf(request.format))
                    texels.push_back(static_cast<std::byte>(number >> 8 & 0xFF));
            }
        }
    }
    int threshold = request.alphaThreshold;
    if (request.format == BlockFormat::Bc1) {
        if (mistake == BlockMistake::ThresholdOpaque && threshold >= 0)
            --threshold;
        if (mistake == BlockMistake::ThresholdIgnored)
            threshold = -1;
        if (mistake == BlockMistake::ThresholdAlways && threshold < 0)
            threshold = 127;
    }
    tool::BlockEffort level = request.level;
    if (mistake == BlockMistake::LevelFast)
        level = tool::BlockEffort::Fast;
    if (mistake == BlockMistake::LevelNormal)
        level = tool::BlockEffort::Normal;
    std::vector<std::byte> blocks;
    tool::EncodeTexelBlocks(
        format, level,
        {texels, static_cast<std::uint32_t>(picture.width), static_cast<std::uint32_t>(picture.height)}, 1,
        "blocks", blocks, {}, threshold);
    SpoilBlocks(blocks, request, mistake);
    return blocks;
}

} // namespace openntc::conformance
