// SPDX-License-Identifier: MIT
// The CPU encoder's frame: requests, edges, lanes and threads.
#include "openntc/bc/BlockEncoder.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bc;

std::vector<std::byte> MakeRandomImage(std::uint32_t width, std::uint32_t height, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<std::byte> bytes(std::size_t{4} * width * height);
    for (std::byte& byte : bytes)
        byte = static_cast<std::byte>(random() >> 24);
    return bytes;
}

std::vector<std::byte> EncodeAll(BlockFormat format, const BlockImage& image, const BlockOptions& options) {
    const BlockRect rect{0, 0, CountBlocks(image.width), CountBlocks(image.height)};
    std::vector<std::byte> blocks(GetBytesPerBlock(format) * rect.width * rect.height);
    const Expected<void> done = EncodeBlocks(format, image, rect, options, blocks);
    REQUIRE_MESSAGE(done.has_value(), std::string(done ? "" : done.error().GetText()));
    return blocks;
}

} // namespace

TEST_CASE("block encoder: lanes and threads do not change a block") {
    const std::vector<std::byte> bytes = MakeRandomImage(67, 35, 1);
    for (int number = 0; number < kBlockFormatCount * 3; ++number) {
        const auto format = static_cast<BlockFormat>(number / 3);
        if (!HasBlockEncoder(format))
            continue;
        const bool isHalf = format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
        const bool isSigned = format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
        const BlockImage image{
            bytes, isHalf ? 33U : 67U,
            35,    0,
            4,     isHalf ? TexelType::Half : isSigned ? TexelType::Signed8 : TexelType::Unsigned8};
        BlockOptions options;
        options.quality = static_cast<BlockQuality>(number % 3);
        options.alphaThreshold = 127;
        options.lanes = 1;
        options.threads = 1;
        const std::vector<std::byte> expected = EncodeAll(format, image, options);
        for (const int lanes : {4, 8, 16}) {
            for (const int threads : {1, 3}) {
                options.lanes = lanes;
                options.threads = threads;
                CHECK(EncodeAll(format, image, options) == expected);
            }
        }
    }
}

TEST_CASE("block encoder: what is asked for wrongly is named") {
    const std::vector<std::byte> bytes = MakeRandomImage(8, 8, 2);
    const BlockImage image{bytes, 8, 8, 0, 4, TexelType::Unsigned8};
    std::vector<std::byte> blocks(64);
    const auto fails = [&](const BlockImage& of, BlockRect rect, const BlockOptions& options,
                           std::size_t size, Status status, const char* text) {
        const Expected<void> done =
            EncodeBlocks(BlockFormat::Bc4Unsigned, of, rect, options, std::span(blocks).first(size));
        REQUIRE(!done.has_value());
        CHECK(done.error().GetStatus() == status);
        CHECK_MESSAGE(std::string(done.error().GetText()).find(text) != std::string::npos,
                      std::string(done.error().GetText()));
    };
    fails(image, {0, 0, 0, 1}, {}, 64, Status::OutOfRange, "rect: 0 x 1");
    fails(image, {1, 0, 2, 1}, {}, 64, Status::OutOfRange, "not within 2 x 2");
    fails(image, {0, 0, 2, 2}, {}, 31, Status::OutOfRange, "output: 31 bytes");
    BlockImage other = image;
    other.rowBytes = 31;
    fails(other, {0, 0, 1, 1}, {}, 64, Status::OutOfRange, "rowBytes: 31: at least 32");
    other = image;
    other.bytes = std::span(bytes).first(255);
    fails(other, {0, 0, 1, 1}, {}, 64, Status::OutOfRange, "bytes: 255");
    other = image;
    other.type = TexelType::Half;
    fails(other, {0, 0, 1, 1}, {}, 64, Status::InvalidArgument, "type: 2");
    other = image;
    other.channels = 5;
    fails(other, {0, 0, 1, 1}, {}, 64, Status::OutOfRange, "channels: 5: 1 ... 4");
    BlockOptions options;
    options.alphaThreshold = 256;
    fails(image, {0, 0, 1, 1}, options, 64, Status::OutOfRange, "alphaThreshold: 256");
    options = {};
    options.allowedModes = 0x100;
    fails(image, {0, 0, 1, 1}, options, 64, Status::OutOfRange, "allowedModes: 0x100");
}

TEST_CASE("block encoder: texels beyond the image repeat its edge, and none of them is read") {
    for (const std::uint32_t width : {1U, 2U, 4U, 5U, 27U}) {
        for (const std::uint32_t height : {1U, 3U, 4U, 6U}) {
            // No slack behind the last texel: a sanitizer sees what reads on.
            const std::vector<std::byte> bytes = MakeRandomImage(width, height, 3);
            const BlockImage image{bytes, width, height, 0, 4, TexelType::Unsigned8};
            const std::uint32_t fullWidth = 4 * CountBlocks(width);
            const std::uint32_t fullHeight = 4 * CountBlocks(height);
            std::vector<std::byte> full(std::size_t{4} * fullWidth * fullHeight);
            for (std::uint32_t y = 0; y < fullHeight; ++y) {
                for (std::uint32_t x = 0; x < fullWidth; ++x) {
                    const std::uint32_t fromX = x < width ? x : width - 1;
                    const std::uint32_t fromY = y < height ? y : height - 1;
                    std::memcpy(&full[4 * (std::size_t{y} * fullWidth + x)],
                                &bytes[4 * (std::size_t{fromY} * width + fromX)], 4);
                }
            }
            const BlockImage padded{full, fullWidth, fullHeight, 0, 4, TexelType::Unsigned8};
            CHECK(EncodeAll(BlockFormat::Bc4Unsigned, image, {}) ==
                  EncodeAll(BlockFormat::Bc4Unsigned, padded, {}));
        }
    }
}

TEST_CASE("block encoder: a rectangle's blocks are those of the whole image") {
    const std::vector<std::byte> bytes = MakeRandomImage(41, 30, 4);
    const BlockImage image{bytes, 41, 30, 0, 4, TexelType::Unsigned8};
    const std::vector<std::byte> whole = EncodeAll(BlockFormat::Bc4Unsigned, image, {});
    const BlockRect rect{3, 1, 7, 5};
    std::vector<std::byte> part(8 * 7 * 5);
    REQUIRE(EncodeBlocks(BlockFormat::Bc4Unsigned, image, rect, {}, part).has_value());
    for (std::uint32_t y = 0; y < rect.height; ++y)
        CHECK(std::memcmp(&part[std::size_t{8} * y * rect.width],
                          &whole[8 * ((std::size_t{rect.top} + y) * CountBlocks(41) + rect.left)],
                          8 * 7) == 0);
}
