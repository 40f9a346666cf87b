// SPDX-License-Identifier: MIT
// Array, Text, Expected, checked arithmetic, CRC-32.
#include "openntc/core/Allocator.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/core/Crc32.h"
#include "openntc/core/Stream.h"
#include "support/CountingAllocator.h"

#include <doctest/doctest.h>

#include <limits>
#include <memory>
#include <string>

using namespace openntc;
using openntc::test::CountingAllocator;

namespace {
constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max();
} // namespace

TEST_CASE("array: growth moves the elements and gives all memory back") {
    CountingAllocator allocator;
    {
        Array<std::unique_ptr<int>> array(allocator);
        for (int i = 0; i < 100; ++i)
            REQUIRE(array.PushBack(std::make_unique<int>(i)));
        REQUIRE(array.size() == 100);
        for (int i = 0; i < 100; ++i)
            REQUIRE(*array[static_cast<std::size_t>(i)] == i);
        REQUIRE(array.Resize(10));
        CHECK(*array.back() == 9);
        Array<std::unique_ptr<int>> other(std::move(array));
        CHECK(array.empty());
        CHECK(other.size() == 10);
        array = std::move(other);
        CHECK(array.size() == 10);
        CHECK(&array.GetAllocator() == &allocator);
    }
    CHECK(allocator.GetUsedBytes() == 0);
}

TEST_CASE("array: a failed allocation leaves the contents as they were") {
    CountingAllocator allocator;
    Array<int> array(allocator);
    REQUIRE(array.PushBack(7));
    allocator.SetLimit(allocator.GetUsedBytes());
    while (true) {
        const Expected<void> pushed = array.PushBack(8);
        if (pushed)
            continue;
        CHECK(pushed.error().GetStatus() == Status::OutOfMemory);
        break;
    }
    CHECK(array[0] == 7);
    CHECK_FALSE(array.Resize(1u << 20));
    CHECK_FALSE(array.Reserve(std::numeric_limits<std::size_t>::max() / 2));
    CHECK(array.back() == 8);
}

TEST_CASE("array: new elements are zero, also where others were before") {
    Array<std::uint32_t> array;
    REQUIRE(array.Resize(4));
    for (std::uint32_t& value : array)
        value = 9;
    REQUIRE(array.Resize(1));
    REQUIRE(array.Resize(4));
    CHECK(array[0] == 9);
    for (std::size_t i = 1; i < 4; ++i)
        CHECK(array[i] == 0);
}

TEST_CASE("array and memory stream: appending allocates a logarithmic number of times") {
    CountingAllocator allocator;
    Array<char> array(allocator);
    openntc::MemoryStream stream(allocator);
    for (int i = 0; i < 10000; ++i) {
        REQUIRE(array.Append(std::span<const char>("abc", 3)));
        REQUIRE(stream.Write("abc", 3));
    }
    REQUIRE(array.Append({}));
    CHECK(array.size() == 30000);
    CHECK(array[29999] == 'c');
    CHECK(stream.Size() == 30000);
    CHECK(allocator.GetAllocationCount() < 40);
    allocator.SetLimit(0);
    const std::string much(100000, 'x');
    CHECK_FALSE(array.Append(std::span<const char>(much.data(), much.size())));
    CHECK(array.size() == 30000);
}

TEST_CASE("text: assignment replaces, and reports exhaustion") {
    CountingAllocator allocator;
    Text text(allocator);
    CHECK(text.View().empty());
    REQUIRE(text.Assign("base colour"));
    REQUIRE(text.Assign("n"));
    CHECK(text.View() == "n");
    allocator.SetLimit(0);
    CHECK_FALSE(Text(allocator).Assign("n"));
}

TEST_CASE("checked arithmetic at the edges") {
    CHECK(CheckedAdd(kMax, 0) == kMax);
    CHECK_FALSE(CheckedAdd(kMax, 1));
    CHECK_FALSE(CheckedAdd(1, kMax));
    CHECK(CheckedAlignUp(0, 4) == 0);
    CHECK(CheckedAlignUp(5, 4) == 8);
    CHECK(CheckedAlignUp(kMax - 3, 4) == kMax - 3);
    CHECK_FALSE(CheckedAlignUp(kMax - 2, 4));
    CHECK(IsRangeInside(0, 0, 0));
    CHECK(IsRangeInside(4, 0, 4));
    CHECK_FALSE(IsRangeInside(5, 0, 4));
    CHECK_FALSE(IsRangeInside(kMax, 2, 4));
    CHECK_FALSE(IsRangeInside(2, kMax, 4));
}

TEST_CASE("CRC-32: the check value of the catalogue, in one go and in parts") {
    const std::string text = "123456789";
    const std::span<const std::byte> bytes = std::as_bytes(std::span(text));
    CHECK(Crc32(bytes) == 0xCBF43926u);
    CHECK(Crc32(bytes.subspan(4), Crc32(bytes.first(4))) == 0xCBF43926u);
    CHECK(Crc32({}) == 0u);
}

TEST_CASE("CRC-32: every length and start is what the definition says, bit by bit") {
    std::vector<std::byte> bytes;
    for (unsigned i = 0; i < 64; ++i)
        bytes.push_back(static_cast<std::byte>(i * i * 37 + 11 * i));
    for (std::size_t first = 0; first < 9; ++first) {
        std::uint32_t expected = ~0x12345678u;
        for (std::size_t size = 0; first + size < bytes.size(); ++size) {
            CAPTURE(first);
            CAPTURE(size);
            REQUIRE(Crc32(std::span(bytes).subspan(first, size), 0x12345678u) == ~expected);
            expected ^= static_cast<std::uint32_t>(bytes[first + size]);
            for (int bit = 0; bit < 8; ++bit)
                expected = (expected & 1u) != 0 ? 0xEDB88320u ^ (expected >> 1) : expected >> 1;
        }
    }
}

TEST_CASE("errors: messages are cut, stay on one line and hold no control characters") {
    const Error error = MakeError(Status::OutOfRange, "%s%s", "a\nb\x1b[1m\x7F\xC2\x9B\xC3\xA9",
                                  std::string(999, 'x').c_str());
    const std::string text = error.GetText();
    CHECK(text.size() == Error::kMaxMessageBytes - 1);
    CHECK(text.find("a?b?[1m?\xC2?\xC3\xA9xxx") == 0);
    CHECK(error.GetStatus() == Status::OutOfRange);
    CHECK(std::string(StatusToString(Status::OutOfRange)) == "OutOfRange");
    CHECK(std::string(StatusToString(static_cast<Status>(99))) == "UnknownStatus");
}
