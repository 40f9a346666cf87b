// SPDX-License-Identifier: MIT
// The 40-byte header: byte positions against hand-assembled bytes, every check, and their order.
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::container;
using namespace openntc::container::test;

namespace {

// Assembled by hand from the table of the format: signature, version, then four 64-bit numbers,
// little-endian.
constexpr unsigned char kBytes[40] = {
    0x4E, 0x54, 0x45, 0x58, 0x00, 0x01, 0x00, 0x00, 0x28, 0, 0, 0, 0,    0,    0, 0, 0x64, 0x07, 0, 0,
    0,    0,    0,    0,    0x8C, 0x07, 0,    0,    0,    0, 0, 0, 0xB8, 0x36, 0, 0, 0,    0,    0, 0,
};

HeaderBytes MakeBytes() {
    HeaderBytes bytes;
    std::memcpy(bytes.data(), kBytes, sizeof(kBytes));
    return bytes;
}

std::string Message(const HeaderBytes& bytes, std::uint64_t streamSize) {
    const Expected<Header> header = DecodeHeader(bytes, streamSize);
    if (header)
        return "";
    CHECK(header.error().GetStatus() == Status::FileUnrecognized);
    return header.error().GetText();
}

} // namespace

TEST_CASE("header: hand-assembled bytes decode, and encode to themselves") {
    const Expected<Header> header = DecodeHeader(MakeBytes(), 15940);
    REQUIRE(header);
    CHECK(header->jsonOffset == 40);
    CHECK(header->jsonSize == 1892);
    CHECK(header->binaryOffset == 1932);
    CHECK(header->binarySize == 14008);
    CHECK(EncodeHeader(*header) == MakeBytes());
}

TEST_CASE("header: one byte too few in the stream is refused") {
    CHECK(Message(MakeBytes(), 15939) ==
          "header.binSize: 14008 bytes at offset 1932: the stream has 15939 bytes");
    CHECK(Message(MakeBytes(), 1931) ==
          "header.jsonSize: 1892 bytes at offset 40: the stream has 1931 bytes");
}

TEST_CASE("header: the signature is checked before the version, the version before the ranges") {
    HeaderBytes bytes = MakeBytes();
    bytes[5] = std::byte{0};
    bytes[4] = std::byte{19};
    CHECK(Message(bytes, 0) == "header.containerVersion: 0x13: must be 0x100");
    bytes[0] = std::byte{'X'};
    CHECK(Message(bytes, 0) == "header.signature: 0x58455458: must be 0x5845544e (NTEX)");
}

TEST_CASE("header: sums that wrap modulo 2^64 are refused") {
    for (const std::size_t field : {8u, 16u, 24u, 32u}) {
        HeaderBytes bytes = MakeBytes();
        for (std::size_t i = 0; i < 8; ++i)
            bytes[field + i] = std::byte{0xFF};
        CHECK(Message(bytes, 15940).find("the stream has 15940 bytes") != std::string::npos);
        bytes[field] = std::byte{0xFE};
        CHECK_FALSE(DecodeHeader(bytes, 15940));
    }
}

TEST_CASE("header: an empty JSON chunk and one above the limit are refused") {
    Header header;
    header.jsonSize = 0;
    CHECK(Message(EncodeHeader(header), 40) == "header.jsonSize: 0: must be 1 to 16777216");
    header.jsonSize = kMaxJsonBytes;
    CHECK(Message(EncodeHeader(header), kMaxJsonBytes + 40) == "");
    header.jsonSize = kMaxJsonBytes + 1;
    CHECK(Message(EncodeHeader(header), kMaxJsonBytes + 41) ==
          "header.jsonSize: 16777217: must be 1 to 16777216");
}

TEST_CASE("reader: a stream shorter than the header is an IOError") {
    const std::string file = WrapJson(kMinimalJson);
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{39}}) {
        const Expected<Container> container = ReadBytes(std::string_view(file).substr(0, size));
        REQUIRE_FALSE(container);
        CHECK(container.error().GetStatus() == Status::IOError);
    }
}

TEST_CASE("reader: chunks may lie anywhere, in any order, unaligned, with bytes after them") {
    std::string file(40, '\0');
    file += "abc";
    Header header;
    header.binaryOffset = file.size();
    header.binarySize = 8;
    file += "01234567--";
    header.jsonOffset = file.size();
    const std::string json =
        R"( {"schemaVersion":1,"width":1,"height":1,"numChannels":1,"views":[{"offset":4,"storedSize":4}]} )";
    header.jsonSize = json.size();
    file += json + "trailing";
    const HeaderBytes bytes = EncodeHeader(header);
    std::memcpy(file.data(), bytes.data(), bytes.size());
    const Expected<Container> container = ReadBytes(file);
    REQUIRE(container);
    CHECK(container->binaryOffset == 43);
    CHECK(container->binarySize == 8);
    CHECK(container->streamSize == file.size());
    CHECK(container->document.views.size() == 1);
}
