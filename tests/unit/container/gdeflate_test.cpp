// SPDX-License-Identifier: MIT
// GDeflate streams: those of the format specification, and round trips of every kind of block.
#include "support/GDeflateTiles.h"

#include "openntc/container/GDeflateEncoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

using namespace openntc;
using namespace openntc::container;

namespace {

std::vector<std::byte> FromHex(std::string_view hex, std::size_t zeros) {
    std::vector<std::byte> bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
    bytes.resize(bytes.size() + zeros);
    return bytes;
}

std::string DecompressText(std::span<const std::byte> stream, std::size_t room = 1 << 20) {
    std::vector<std::byte> bytes(room);
    const Expected<std::size_t> size = DecompressGDeflate(stream, bytes);
    if (!size)
        return std::string("ERROR ") + size.error().GetText();
    return {reinterpret_cast<const char*>(bytes.data()), *size};
}

/// Bytes of which each level of `kind` needs another sort of block: noise is stored, few bytes are static,
/// skewed and repeated ones dynamic.
std::string MakeData(int kind, std::size_t size) {
    std::string data(size, '\0');
    std::uint32_t state = 12345;
    for (std::size_t i = 0; i < size; ++i) {
        state = state * 1664525u + 1013904223u;
        const std::uint32_t random = state >> 16;
        const std::uint32_t bytes[] = {0, random, (random & 3u) * 17u,
                                       i % 251 < 100 ? static_cast<std::uint32_t>(i % 7) : random % 20u,
                                       i % 5000 < 2500 ? random & 1u : 0x41u + random % 7u};
        data[i] = static_cast<char>(bytes[kind]);
    }
    return data;
}

unsigned GetBlockType(std::span<const std::byte> stream) {
    const std::size_t tiles = static_cast<std::size_t>(stream[2]) | static_cast<std::size_t>(stream[3]) << 8;
    return (static_cast<unsigned>(stream[8 + 4 * tiles]) >> 1) & 3u;
}

std::span<const std::byte> BytesOf(const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

} // namespace

TEST_CASE("gdeflate: the specification's streams") {
    CHECK(DecompressText(FromHex("04fb0100050000000100000063070000", 132)) == "\x07");
    const std::vector<std::byte> text =
        FromHex("04fb010059000000160000004b04000049000000c9000000890000001808000011000000", 132);
    CHECK(DecompressText(text) == "abcabcabcabcabcabcabcX");
    CHECK(DecompressText(text, 22) == "abcabcabcabcabcabcabcX");
    CHECK(DecompressText(text, 21) == "ERROR GDeflate: 22 bytes: the destination has 21");
    // The writer makes the first one's words too; the place of tile 0's offset differs.
    GDeflateEncoder encoder;
    Array<std::byte> stream;
    REQUIRE(encoder.Compress(BytesOf("\x07"), stream));
    const std::vector<std::byte> expected = FromHex("04fb0100050000008800000063070000", 132);
    CHECK(std::equal(stream.begin(), stream.end(), expected.begin(), expected.end()));
}

TEST_CASE("gdeflate: every size around lanes and tiles, every kind of block and every level comes back") {
    bool hasType[3] = {};
    for (int kind = 0; kind < 5; ++kind) {
        CAPTURE(kind);
        for (const std::size_t size : {std::size_t{1}, std::size_t{2}, std::size_t{31}, std::size_t{32},
                                       std::size_t{33}, std::size_t{1000}, std::size_t{65535},
                                       std::size_t{65536}, std::size_t{65537}, std::size_t{131072}}) {
            CAPTURE(size);
            const std::string data = MakeData(kind, size);
            std::size_t last = 0;
            for (const int level : {1, 4, 9, 12}) {
                if (level == 12 && size > 70000)
                    continue; // thorough, and the same as a tile
                CAPTURE(level);
                GDeflateEncoder encoder(level);
                Array<std::byte> stream;
                REQUIRE(encoder.Compress(BytesOf(data), stream));
                REQUIRE(DecompressText(std::as_const(stream).AsSpan()) == data);
                hasType[GetBlockType(std::as_const(stream).AsSpan())] = true;
                last = stream.size();
            }
            // A stored tile has a header, a length and what 32 lanes hold in advance.
            const std::size_t tiles = (size + 65535) / 65536;
            CHECK(last <= size + 8 + tiles * (4 + 2 * 8 + 3 * 32 * 4));
        }
    }
    CHECK((hasType[0] && hasType[1] && hasType[2]));
}

TEST_CASE("gdeflate: higher levels are smaller on data with repetitions") {
    const std::string data = MakeData(3, 65536);
    std::size_t previous = data.size();
    for (const int level : {1, 6, 9, 12}) {
        GDeflateEncoder encoder(level);
        Array<std::byte> stream;
        REQUIRE(encoder.Compress(BytesOf(data), stream));
        CHECK_MESSAGE(stream.size() <= previous, level);
        previous = stream.size();
    }
    GDeflateEncoder defaults(0);
    GDeflateEncoder ninth(9);
    Array<std::byte> a;
    Array<std::byte> b;
    REQUIRE(defaults.Compress(BytesOf(data), a));
    REQUIRE(ninth.Compress(BytesOf(data), b));
    CHECK(std::equal(a.begin(), a.end(), b.begin(), b.end()));
}

TEST_CASE("gdeflate: Huffman codes of skewed counts stay within 15 bits and are complete") {
    std::array<std::uint32_t, 288> counts{};
    std::uint32_t a = 1;
    std::uint32_t b = 1;
    for (std::size_t i = 0; i < 40; ++i) { // Fibonacci numbers make the deepest trees
        counts[i] = a;
        a = std::exchange(b, a + b);
    }
    for (const unsigned limit : {7u, 15u}) {
        container::detail::HuffmanCode<288> code;
        code.Make(counts, limit);
        std::uint32_t total = 0;
        for (const std::uint8_t length : code.lengths) {
            CHECK(length <= limit);
            total += length > 0 ? 1u << (limit - length) : 0u;
        }
        CHECK(total == 1u << limit);
    }
    container::detail::HuffmanCode<32> single;
    single.Make(std::array<std::uint32_t, 32>{0, 0, 5}, 15);
    CHECK(single.lengths[0] == 1);
    CHECK(single.lengths[2] == 1);
}

TEST_CASE("gdeflate: what is wrong with a stream is named") {
    const std::string data = MakeData(3, 70000);
    GDeflateEncoder encoder(4);
    Array<std::byte> good;
    REQUIRE(encoder.Compress(BytesOf(data), good));
    const auto with = [&good](std::size_t at, unsigned value) {
        std::vector<std::byte> stream(good.begin(), good.end());
        stream[at] = static_cast<std::byte>(value);
        return DecompressText(stream);
    };
    CHECK(with(0, 5) == "ERROR GDeflate: id 5, 251: must be 4, 251");
    CHECK(with(1, 5) == "ERROR GDeflate: id 4, 5: must be 4, 251");
    CHECK(with(2, 0) == "ERROR GDeflate: tiles: 0: must be 1 or more");
    CHECK(with(4, 0).find("ERROR GDeflate: tile size 0, last tile of ") == 0);
    CHECK(with(6, 8).find("ERROR GDeflate: tile size 1, last tile of ") == 0);
    CHECK(with(3, 255).find(": the destination has ") != std::string::npos);
    CHECK(with(15, 255).find("ERROR GDeflate: tile 0: from 0 to ") == 0);
    CHECK(with(8, 77) == data); // nobody reads the place of tile 0's offset
    CHECK(DecompressText(std::span(good.data(), 7)) == "ERROR GDeflate: 7 bytes: the header has 8");
    // Tiles: a byte more or less than the header says, a block of type 3, an end in the middle.
    std::vector<std::byte> out(4470);
    const auto tile = [&](std::size_t bytes, std::span<const std::byte> input) {
        const Expected<void> done = DecompressGDeflateTile(input, std::span(out).first(bytes), 7);
        return done ? std::string() : std::string(done.error().GetText());
    };
    const Expected<GDeflateTileRange> range =
        FindGDeflateTile(*DecodeGDeflateHeader(good.AsSpan()), good.AsSpan(), good.size(), 1);
    REQUIRE(range);
    const std::span<const std::byte> last = std::span(good.data() + range->offset, range->size);
    CHECK(tile(4464, last) == "");
    CHECK(tile(4465, last) == "GDeflate: tile 7: too few bytes: corrupt");
    CHECK(tile(4463, last) == "GDeflate: tile 7: too many bytes: corrupt");
    CHECK(tile(4464, last.first(last.size() / 2)) != "");
    CHECK(tile(1, FromHex("07000000", 0)) == "GDeflate: tile 7: a block: of type 3: corrupt");
    CHECK(tile(1, {}) == "GDeflate: tile 7: cut short: corrupt"); // empty stored blocks without end
    CHECK(tile(4, FromHex("03000000"
                          "02000000",
                          0)) != "");
    CHECK_FALSE(encoder.Compress({}, good));
}

TEST_CASE("gdeflate: blocks of no bytes are refused where there are many, which would take long") {
    std::byte byte{};
    for (const std::size_t blocks : {0u, 1u, 100u, 255u}) {
        CAPTURE(blocks);
        REQUIRE(DecompressGDeflateTile(openntc_tests::MakeEmptyBlocks(blocks), std::span(&byte, 1), 0));
        CHECK(std::to_integer<int>(byte) == 7);
    }
    for (const std::size_t blocks : {256u, 100000u}) {
        const auto done =
            DecompressGDeflateTile(openntc_tests::MakeEmptyBlocks(blocks), std::span(&byte, 1), 3);
        REQUIRE_FALSE(done);
        CHECK(std::string(done.error().GetText()) == "GDeflate: tile 3: more than 256 blocks: corrupt");
    }
}
