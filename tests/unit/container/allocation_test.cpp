// SPDX-License-Identifier: MIT
// Memory: every failing allocation is reported and nothing leaks; the peak is bounded by the size of the JSON
// text.
#include "support/CountingAllocator.h"
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::container;
using namespace openntc::container::test;

namespace {

constexpr std::string_view kJson =
    R"({"schemaVersion":1,"width":1,"height":2,"numChannels":3,"mlp":{"layers":[{"inputChannels":1,"outputChannels":1,)"
    R"("weightView":0,"biasView":0}]},"mlpVersions":[{"layers":{"inputChannels":1,"outputChannels":1,"weightView":0,)"
    R"("biasView":0}}],"textures":[{"name":"colour","firstChannel":0,"numChannels":3}],"channels":[{},{},{}],)"
    R"("latents":[],"colorMips":[{}],"views":[{"offset":0,"storedSize":4}]})";

} // namespace

TEST_CASE("reader: each failing allocation gives OutOfMemory and no leak") {
    const std::string file = WrapJson(kJson);
    std::size_t needed = 0;
    {
        openntc::test::CountingAllocator counting;
        REQUIRE(ReadBytes(file, counting));
        needed = counting.GetAllocationCount();
    }
    CHECK(needed >= 9); // text, two networks' layers, networks, textures, name, channels, mips, views
    for (std::size_t n = 0; n < needed; ++n) {
        openntc::test::CountingAllocator failing;
        failing.FailAt(n);
        const Expected<Container> container = ReadBytes(file, failing);
        REQUIRE_FALSE(container);
        CHECK(container.error().GetStatus() == Status::OutOfMemory);
        CHECK(failing.GetUsedBytes() == 0);
    }
}

TEST_CASE("reader: everything comes from the given allocator and goes back to it") {
    openntc::test::CountingAllocator counting;
    {
        const Expected<Container> container = ReadBytes(WrapJson(kJson), counting);
        REQUIRE(container);
        CHECK(&container->document.mlp->layers.GetAllocator() == &counting);
        CHECK(&container->document.mlpVersions[0].layers.GetAllocator() == &counting);
        CHECK(&container->document.views.GetAllocator() == &counting);
        CHECK(counting.GetUsedBytes() > 0);
    }
    CHECK(counting.GetUsedBytes() == 0);
}

TEST_CASE("reader: peak memory is below 8 times the text, for the elements that take least text") {
    for (const std::string_view element :
         {std::string_view(R"("views":[)"), std::string_view(R"("textures":[)"),
          std::string_view(R"("x":[)")}) {
        const std::string_view one = element[1] == 'v' ? std::string_view(R"({"offset":0,"storedSize":0})")
                                     : element[1] == 't'
                                         ? std::string_view(R"({"name":"","firstChannel":0,"numChannels":0})")
                                         : std::string_view("{}");
        std::string json =
            Join({R"({"schemaVersion":1,"width":1,"height":2,"numChannels":3,)", element, one});
        const std::size_t count = element[1] == 'v' ? kMaxViews : element[1] == 't' ? kMaxTextures : 100000;
        for (std::size_t i = 1; i < count; ++i)
            json.append(",").append(one);
        json += "]}";
        openntc::test::CountingAllocator counting;
        REQUIRE(ReadBytes(WrapJson(json), counting));
        CHECK(counting.GetPeakBytes() < 8 * json.size());
    }
}

TEST_CASE("writer: each failing allocation gives OutOfMemory, and nothing is written") {
    const Expected<Container> container = ReadJson(kJson);
    REQUIRE(container);
    const std::byte data[4] = {};
    const std::span<const std::byte> views[] = {data};
    openntc::test::CountingAllocator counting;
    MemoryStream whole;
    REQUIRE(WriteContainer(whole, {&container->document, views}, counting));
    CHECK(counting.GetUsedBytes() == 0);
    for (std::size_t n = 0; n < counting.GetAllocationCount(); ++n) {
        openntc::test::CountingAllocator failing;
        failing.FailAt(n);
        MemoryStream stream;
        const Expected<void> written = WriteContainer(stream, {&container->document, views}, failing);
        REQUIRE_FALSE(written);
        CHECK(written.error().GetStatus() == Status::OutOfMemory);
        CHECK(stream.GetBytes().empty());
        CHECK(failing.GetUsedBytes() == 0);
    }
}
