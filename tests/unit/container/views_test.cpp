// SPDX-License-Identifier: MIT
// Checks and reads of buffer views.
#include "openntc/container/Views.h"

#include <doctest/doctest.h>

#include <array>
#include <string>

using namespace openntc;
using namespace openntc::container;

TEST_CASE("views: an index behind the last view and a view that is too small are refused by name") {
    std::array<BufferView, 2> views;
    views[1].offset = 4;
    views[1].storedSize = 15;
    const ElementPath path{"mlp", ".layers", 3};
    CHECK(CheckView(views, 1, 15, path, "biasView"));
    const Expected<void> small = CheckView(views, 1, 16, path, "biasView");
    REQUIRE_FALSE(small);
    CHECK(small.error().GetStatus() == Status::FileUnrecognized);
    CHECK(std::string(small.error().GetText()) ==
          "mlp.layers[3].biasView: views[1].storedSize: 15: needs at least 16 bytes");
    const Expected<void> absent = CheckView(views, 2, 0, path, "biasView");
    REQUIRE_FALSE(absent);
    CHECK(absent.error().GetStatus() == Status::FileUnrecognized);
    CHECK(std::string(absent.error().GetText()) == "mlp.layers[3].biasView: 2: the file has 2 views");
}

TEST_CASE("views: bytes come from the chunk's place in the stream, or the failure is reported") {
    MemoryStream stream;
    const std::array<char, 12> bytes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};
    REQUIRE(stream.Write(bytes.data(), bytes.size()));
    std::array<BufferView, 1> views;
    views[0].offset = 4;
    views[0].storedSize = 4;
    std::array<std::byte, 3> read{};
    REQUIRE(ReadView({&stream, 5, views}, 0, read));
    CHECK(read == std::array{std::byte{9}, std::byte{10}, std::byte{11}});
    const Expected<void> failed = ReadView({&stream, 6, views}, 0, read);
    REQUIRE_FALSE(failed);
    CHECK(failed.error().GetStatus() == Status::IOError);
    CHECK(std::string(failed.error().GetText()) == "views[0]: 3 bytes at 10: cannot be read");
}
