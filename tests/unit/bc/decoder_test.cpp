// SPDX-License-Identifier: MIT
// Reference decoders on blocks whose texels the formats' text gives; tests/shader/bc compares them with a device's
// sampler on random blocks of every mode and partition.
#include "openntc/bc/BlockDecoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bc;

/// Appends bits, the lowest first.
class BitWriter {
public:
    void Put(int value, int count) {
        for (int i = 0; i < count; ++i, ++position_)
            block_[position_ / 8] |= static_cast<std::byte>((value >> i & 1) << (position_ % 8));
    }
    const std::byte* GetBlock() const { return block_.data(); }
    std::size_t GetPosition() const { return position_; }

private:
    std::array<std::byte, 16> block_{};
    std::size_t position_ = 0;
};

/// Endpoints of 565 and one index for all texels.
std::array<std::byte, 8> MakeColorBlock(int first, int second, int index) {
    std::array<std::byte, 8> block{};
    block[0] = static_cast<std::byte>(first & 255);
    block[1] = static_cast<std::byte>(first >> 8);
    block[2] = static_cast<std::byte>(second & 255);
    block[3] = static_cast<std::byte>(second >> 8);
    for (std::size_t i = 4; i < 8; ++i)
        block[i] = static_cast<std::byte>(index * 0x55);
    return block;
}

} // namespace

TEST_CASE(
    "block decoder: BC1 has four colours iff the first is the larger, else three and transparent black") {
    // Red 31, green 63, blue 31 are 255; 10000 00000... halves widen by repeating bits: 16 -> 132, 32 -> 130.
    const int light = 31 << 11 | 63 << 5 | 31;
    const int dark = 16 << 11 | 32 << 5 | 16;
    std::uint8_t texels[64];
    const auto first = [&](int a, int b, int index) {
        DecodeBlockBytes(BlockFormat::Bc1, MakeColorBlock(a, b, index).data(), texels);
        for (int t = 1; t < 16; ++t)
            CHECK(std::memcmp(texels, texels + 4 * t, 4) == 0);
        return std::array<int, 4>{texels[0], texels[1], texels[2], texels[3]};
    };
    using Color = std::array<int, 4>;
    CHECK(first(light, dark, 0) == Color{255, 255, 255, 255});
    CHECK(first(light, dark, 1) == Color{132, 130, 132, 255});
    CHECK(first(light, dark, 2) == Color{214, 213, 214, 255}); // (2 * 255 + 132) / 3 = 214, 213.33
    CHECK(first(light, dark, 3) == Color{173, 172, 173, 255}); // 173, 171.67
    CHECK(first(dark, light, 0) == Color{132, 130, 132, 255});
    CHECK(first(dark, light, 2) == Color{194, 193, 194, 255}); // 193.5 and 192.5, halves up
    CHECK(first(dark, light, 3) == Color{0, 0, 0, 0});
    CHECK(first(dark, dark, 3) == Color{0, 0, 0, 0});
    // BC2 and BC3 have four colours always.
    std::array<std::byte, 16> block{};
    const auto colors = MakeColorBlock(dark, light, 3);
    std::memcpy(&block[8], colors.data(), 8);
    for (std::size_t i = 0; i < 8; ++i)
        block[i] = static_cast<std::byte>(0x10 * (2 * i + 1) + 2 * i);
    DecodeBlockBytes(BlockFormat::Bc2, block.data(), texels);
    for (int t = 0; t < 16; ++t) {
        CHECK(texels[4 * t] == 214);
        CHECK(texels[4 * t + 3] == 17 * t);
    }
    block[0] = std::byte{200};
    block[1] = std::byte{60};
    std::memset(&block[2], 0xFF, 6); // index 7
    DecodeBlockBytes(BlockFormat::Bc3, block.data(), texels);
    CHECK(texels[0] == 214);
    CHECK(texels[3] == 80); // (200 + 6 * 60) / 7
}

TEST_CASE("block decoder: BC4's and BC5's palettes, of every pair of endpoints, are exact") {
    for (const bool isSigned : {false, true}) {
        const BlockFormat format = isSigned ? BlockFormat::Bc4Signed : BlockFormat::Bc4Unsigned;
        const std::int64_t scale = GetExactOne(format) / (isSigned ? 127 : 255);
        std::size_t wrong = 0;
        for (int a = 0; a < 256; ++a) {
            for (int b = 0; b < 256; ++b) {
                std::array<std::byte, 8> block{};
                block[0] = static_cast<std::byte>(a);
                block[1] = static_cast<std::byte>(b);
                std::uint64_t indices = 0;
                for (unsigned t = 0; t < 16; ++t)
                    indices |= std::uint64_t{t & 7} << (3 * t);
                for (std::size_t i = 0; i < 6; ++i)
                    block[2 + i] = static_cast<std::byte>(indices >> (8 * i) & 255);
                std::int32_t texels[64];
                DecodeBlockExact(format, block.data(), texels);
                const int x = isSigned ? static_cast<std::int8_t>(a) : a;
                const int y = isSigned ? static_cast<std::int8_t>(b) : b;
                const std::int64_t low = isSigned ? -127 : 0;
                const std::int64_t high = isSigned ? 127 : 255;
                const std::int64_t p = std::max<std::int64_t>(x, low);
                const std::int64_t q = std::max<std::int64_t>(y, low);
                for (std::int64_t i = 0; i < 8; ++i) {
                    // Values times 7 or 5, over the same of what was decoded.
                    std::int64_t value = x > y ? (i == 0   ? 7 * p
                                                  : i == 1 ? 7 * q
                                                           : (8 - i) * p + (i - 1) * q)
                                               : (i == 0   ? 5 * p
                                                  : i == 1 ? 5 * q
                                                  : i == 6 ? 5 * low
                                                  : i == 7 ? 5 * high
                                                           : (6 - i) * p + (i - 1) * q);
                    value *= scale;
                    for (std::int64_t t = i; t < 16; t += 8)
                        wrong += texels[4 * t] * (x > y ? 7 : 5) != value ? 1u : 0u;
                }
                // BC5's second channel is the same.
                std::array<std::byte, 16> both{};
                std::memcpy(&both[8], block.data(), 8);
                std::int32_t pair[64];
                DecodeBlockExact(isSigned ? BlockFormat::Bc5Signed : BlockFormat::Bc5Unsigned, both.data(),
                                 pair);
                for (std::size_t t = 0; t < 16; ++t)
                    wrong += pair[4 * t + 1] != texels[4 * t] || pair[4 * t + 2] != 0 ? 1u : 0u;
            }
        }
        CHECK(wrong == 0);
    }
    // -128 is -127; bytes round to nearest.
    const std::array<std::byte, 8> lowest = {std::byte{0x80}, std::byte{0x7F}};
    std::uint8_t texels[64];
    DecodeBlockBytes(BlockFormat::Bc4Signed, lowest.data(), texels);
    CHECK(static_cast<std::int8_t>(texels[0]) == -127);
    CHECK(texels[3] == 127);
    float floats[64];
    DecodeBlockFloats(BlockFormat::Bc4Signed, lowest.data(), floats);
    CHECK(floats[0] == -1.0f);
    CHECK(floats[3] == 1.0f);
}

TEST_CASE("block decoder: BC7's mode 5 keeps every solid colour, by the rule of the public texts") {
    for (int value = 0; value < 256; ++value) {
        for (int rotation = 0; rotation < 4; ++rotation) {
            BitWriter bits;
            bits.Put(1 << 5, 6);
            bits.Put(rotation, 2);
            const int first = value >> 1;
            const int second = (value < 128 ? value + 1 : value - 1) >> 1;
            for (int c = 0; c < 3; ++c) {
                bits.Put(first, 7);
                bits.Put(second, 7);
            }
            bits.Put(255 - value, 8);
            bits.Put(255 - value, 8);
            bits.Put(1, 1); // colour index 1 everywhere
            for (int t = 1; t < 16; ++t)
                bits.Put(1, 2);
            bits.Put(0, 31);
            REQUIRE(bits.GetPosition() == 128);
            std::uint8_t texels[64];
            DecodeBlockBytes(BlockFormat::Bc7, bits.GetBlock(), texels);
            for (int i = 0; i < 64; ++i)
                REQUIRE(texels[i] == (i % 4 == (rotation + 3) % 4 ? 255 - value : value));
        }
    }
}

TEST_CASE("block decoder: reserved codes") {
    std::uint8_t bytes[64];
    std::array<std::byte, 16> block{};
    block.fill(std::byte{0xFF});
    block[0] = std::byte{0};
    DecodeBlockBytes(BlockFormat::Bc7, block.data(), bytes);
    for (const std::uint8_t byte : bytes)
        CHECK(byte == 0);
    for (const int code : {0b10011, 0b10111, 0b11011, 0b11111}) {
        for (const BlockFormat format : {BlockFormat::Bc6Unsigned, BlockFormat::Bc6Signed}) {
            block[0] = static_cast<std::byte>(0xE0 | code);
            std::uint16_t halves[64];
            DecodeBlockHalves(format, block.data(), halves);
            for (int i = 0; i < 64; ++i)
                CHECK(halves[i] == (i % 4 == 3 ? 0x3C00 : 0));
        }
    }
}

TEST_CASE("block decoder: BC6H endpoints of 10 bits are what the text makes of them") {
    const auto decode = [](BlockFormat format, int endpoint) {
        BitWriter bits;
        bits.Put(0b00011, 5);
        for (int c = 0; c < 6; ++c)
            bits.Put(endpoint, 10);
        std::uint16_t halves[64];
        DecodeBlockHalves(format, bits.GetBlock(), halves);
        return static_cast<int>(halves[0]);
    };
    CHECK(decode(BlockFormat::Bc6Unsigned, 0) == 0);
    CHECK(decode(BlockFormat::Bc6Unsigned, 1023) == 0x7BFF);                                 // 65504
    CHECK(decode(BlockFormat::Bc6Unsigned, 512) == (((512 << 15) + 0x4000) >> 9) * 31 / 64); // by the formula
    CHECK(decode(BlockFormat::Bc6Signed, 511) == 0x7BFF);
    CHECK(decode(BlockFormat::Bc6Signed, 513) == 0xFBFF); // -511: -65504
    CHECK(decode(BlockFormat::Bc6Signed, 512) == 0xFBFF); // -512 too
    CHECK(decode(BlockFormat::Bc6Signed, 1023) == (0x8000 | ((((1 << 15) + 0x4000) >> 9) * 31 >> 5)));
}

TEST_CASE("block decoder: images whose sides are no multiples of 4, and requests that do not fit") {
    std::vector<std::byte> blocks(8 * 4);
    for (std::size_t i = 0; i < 4; ++i) {
        const auto block = MakeColorBlock(static_cast<int>(i * 8 + 8) << 11, 0, 0);
        std::memcpy(&blocks[8 * i], block.data(), 8);
    }
    std::vector<std::uint8_t> texels(4 * 5 * 7 + 4, 0xA5);
    REQUIRE(
        DecodeBlocksToBytes(BlockFormat::Bc1, blocks, 5, 7, std::span(texels).first(4 * 5 * 7)).has_value());
    for (std::size_t y = 0; y < 7; ++y) {
        for (std::size_t x = 0; x < 5; ++x) {
            const int red = static_cast<int>(8 * (x / 4 + 2 * (y / 4)) + 8) & 31;
            CHECK(texels[4 * (5 * y + x)] == (red << 3 | red >> 2));
        }
    }
    CHECK(texels[4 * 5 * 7] == 0xA5);
    const auto few = DecodeBlocksToBytes(BlockFormat::Bc1, std::span(blocks).first(31), 5, 7, texels);
    REQUIRE(!few.has_value());
    CHECK(std::string(few.error().GetText()).find("blocks: 31 bytes: 4 blocks of 8") != std::string::npos);
    const auto narrow =
        DecodeBlocksToBytes(BlockFormat::Bc1, blocks, 5, 7, std::span(texels).first(4 * 5 * 7 - 1));
    REQUIRE(!narrow.has_value());
    CHECK(std::string(narrow.error().GetText()).find("texels: 139") != std::string::npos);
    CHECK(!DecodeBlocksToBytes(static_cast<BlockFormat>(10), blocks, 5, 7, texels).has_value());
}
