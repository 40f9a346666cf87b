// SPDX-License-Identifier: MIT
// Maps of how BC7 blocks are coded: every coding there and back, rectangles, side files, and side files that
// lie.
#include "BlockSamples.h"

#include "openntc/bc/BlockHints.h"
#include "openntc/bc/detail/Kernels.h"

#include <cstring>

using namespace openntc;
using namespace openntc::bc;
using namespace openntc_tests;

namespace {

/// All codings that blocks can have, and none.
std::vector<std::int32_t> ListBlockHints() {
    std::vector<std::int32_t> hints = {-1};
    for (int mode = 0; mode < 8; ++mode) {
        const bool isDual = mode == 4 || mode == 5;
        const int partitions = mode == 0 ? 16 : mode > 3 && mode < 7 ? 1 : 64;
        for (int partition = 0; partition < partitions; ++partition) {
            for (int rotation = 0; rotation < (isDual ? 4 : 1); ++rotation) {
                for (int selector = 0; selector < (mode == 4 ? 2 : 1); ++selector) {
                    hints.push_back(MakeBlockHint(mode, partition, rotation, selector));
                    REQUIRE(hints.back() == shader::lanes1::NtcBc7Hint(mode, partition, rotation, selector));
                }
            }
        }
    }
    return hints;
}

std::vector<std::byte> MakeHintFile() {
    const std::vector<std::int32_t> hints = ListBlockHints();
    std::vector<std::byte> first(GetBlockHintBytes(12)), second(GetBlockHintBytes(1));
    REQUIRE(PackBlockHints(std::span(hints).subspan(40, 12), first).has_value());
    REQUIRE(PackBlockHints(std::span(hints).first(1), second).has_value());
    const BlockHintMap maps[] = {{0, 0, 4, 3, first, {0x12345678, 5, true, BlockQuality::Normal}},
                                 {2, 5, 1, 1, second}};
    std::vector<std::byte> file(GetBlockHintFileBytes(maps));
    REQUIRE(WriteBlockHintFile(maps, {123456789012, 0xABCD1234}, file).has_value());
    return file;
}

} // namespace

TEST_CASE("block hints: every coding survives packing, and rectangles are cut out") {
    const std::vector<std::int32_t> hints = ListBlockHints();
    REQUIRE(hints.size() == 1 + 16 + 3 * 64 + 8 + 4 + 1 + 64);
    std::vector<std::byte> packed(GetBlockHintBytes(hints.size()));
    REQUIRE(PackBlockHints(hints, packed).has_value());
    const BlockHintMap map{0, 0, 11, 26, packed};
    REQUIRE(hints.size() == 11 * 26);
    std::vector<std::int32_t> all(hints.size());
    REQUIRE(UnpackBlockHints(map, 0, 0, 11, 26, all).has_value());
    CHECK(all == hints);
    std::vector<std::int32_t> part(12);
    REQUIRE(UnpackBlockHints(map, 8, 5, 3, 4, part).has_value());
    for (std::size_t i = 0; i < part.size(); ++i)
        CHECK(part[i] == hints[(5 + i / 3) * 11 + 8 + i % 3]);
    // The encoding of generation 3's mode buffers: 64 mode + partition, and a value of its own for 0.
    CHECK(PackBlockHint(MakeBlockHint(0, 0, 0, 0)) == 0x1BF);
    CHECK(PackBlockHint(MakeBlockHint(7, 63, 0, 0)) == 511);
    CHECK(PackBlockHint(MakeBlockHint(4, 0, 3, 1)) == 4 * 64 + 7);
    int known = 0;
    for (std::uint32_t value = 0; value < 512; ++value)
        known += UnpackBlockHint(value) >= 0 ? 1 : 0;
    CHECK(known == static_cast<int>(hints.size()) - 1);
    CHECK(!UnpackBlockHints(map, 8, 5, 4, 4, all).has_value());
    CHECK(!UnpackBlockHints(map, 0, 23, 1, 4, all).has_value());
    CHECK(!UnpackBlockHints(map, 0, 0, 4, 4, part).has_value());
    CHECK(!UnpackBlockHints({0, 0, 11, 27, packed}, 0, 0, 1, 1, part).has_value());
    CHECK(!PackBlockHints(hints, std::span(packed).first(packed.size() - 1)).has_value());
}

TEST_CASE("block hints: a block's coding is read off it") {
    std::mt19937 random(21);
    SampleImage image(64, 64);
    for (std::uint8_t& texel : image.texels)
        texel = static_cast<std::uint8_t>(random() >> 24);
    for (std::uint32_t mode = 0; mode < 8; ++mode) {
        BlockOptions options;
        options.allowedModes = 1U << mode;
        const auto blocks = EncodeSample(BlockFormat::Bc7, image, options);
        std::vector<std::int32_t> hints;
        for (std::size_t b = 0; b < blocks.size(); b += 16) {
            hints.push_back(GetBlockHint(&blocks[b]));
            CHECK((hints.back() & 7) == static_cast<int>(mode));
        }
        options.hints = hints;
        options.allowedModes = 0xFF;
        CHECK(EncodeSample(BlockFormat::Bc7, image, options) == blocks);
    }
    const std::byte reserved[16] = {};
    CHECK(GetBlockHint(reserved) == -1);
}

TEST_CASE("block hints: a side file gives its maps back") {
    const std::vector<std::byte> bytes = MakeHintFile();
    const auto file = BlockHintFile::Parse(bytes);
    REQUIRE_MESSAGE(file.has_value(), std::string(file ? "" : file.error().GetText()));
    CHECK(file->GetCount() == 2);
    CHECK(file->GetSource() == BlockHintSource{123456789012, 0xABCD1234});
    const auto map = file->Find(0, 0);
    REQUIRE(map.has_value());
    std::int32_t hints[12];
    REQUIRE(UnpackBlockHints(*map, 0, 0, 4, 3, hints).has_value());
    const std::vector<std::int32_t> all = ListBlockHints();
    CHECK(std::equal(hints, hints + 12, all.begin() + 40));
    CHECK(map->texels == BlockHintTexels{0x12345678, 5, true, BlockQuality::Normal});
    CHECK(file->Find(2, 5)->width == 1);
    CHECK(file->Find(2, 5)->texels == BlockHintTexels{});
    CHECK(file->Find(2, 4).error().GetStatus() == Status::OutOfRange);
    CHECK(file->GetMap(2).error().GetStatus() == Status::OutOfRange);
}

TEST_CASE("block hints: no byte of a side file can change or go unseen") {
    const std::vector<std::byte> good = MakeHintFile();
    const auto isWhole = [](std::span<const std::byte> bytes) {
        const auto file = BlockHintFile::Parse(bytes);
        return file.has_value() && file->GetCount() == 2 && file->GetMap(0).has_value() &&
               file->GetMap(1).has_value() && file->GetSource() == BlockHintSource{123456789012, 0xABCD1234};
    };
    REQUIRE(isWhole(good));
    for (std::size_t i = 0; i < good.size(); ++i) {
        for (const int flip : {1, 128, 255}) {
            std::vector<std::byte> bad = good;
            bad[i] ^= static_cast<std::byte>(flip);
            CHECK_MESSAGE(!isWhole(bad), "byte ", i);
        }
        CHECK(!isWhole(std::span(good).first(i)));
    }
    // Records with a right checksum that point out of the file or claim absurd sizes.
    const auto change = [&](std::size_t at, std::uint64_t value, int size) {
        std::vector<std::byte> bad = good;
        bc::detail::StoreNumber(&bad[40 + at], value, size);
        bc::detail::StoreNumber(&bad[28], Crc32(std::span(bad).subspan(40, 80)), 4);
        const auto file = BlockHintFile::Parse(bad);
        REQUIRE(file.has_value());
        CHECK(file->GetMap(0).error().GetStatus() == Status::FileUnrecognized);
    };
    change(16, ~std::uint64_t{0}, 8);
    change(16, good.size() - 4, 8);
    change(8, 0xFFFFFFFF, 4);
    change(12, 0x10001, 4);
    change(24, 0xFFFFFFFF, 4);
    change(36, 0, 1);
    change(36, 8, 1);
    change(37, 2, 1);
    change(38, 3, 1);
}
