// SPDX-License-Identifier: MIT
// Memory: every failing allocation is reported and nothing leaks; the peak is bounded by the size of the JSON
// text.
#include "support/CountingAllocator.h"
#include "unit/container/TestDocuments.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

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

namespace {

constexpr std::string_view kStartOfDocument = R"({"schemaVersion":1,"width":1,"height":2,"numChannels":3)";

std::string ArrayOf(std::string_view key, std::string_view element, std::size_t count) {
    std::string json = Join({",\"", key, "\":["});
    for (std::size_t i = 0; i < count; ++i)
        json.append(i > 0 ? "," : "").append(element);
    return json + "]";
}

/// Peak memory beyond 8 bytes for each of the text, which includes the text itself; not below 0.
std::size_t ReadForExcess(const std::string& json) {
    openntc::test::CountingAllocator counting;
    const auto container = ReadBytes(WrapJson(json), counting);
    CHECK_MESSAGE(container, std::string(container ? "" : container.error().GetText()));
    CHECK(counting.GetPeakBytes() < GetMaxDocumentBytes(json.size()));
    return counting.GetPeakBytes() > 8 * json.size() ? counting.GetPeakBytes() - 8 * json.size() : 0;
}

} // namespace

// Arrays grow by doubling and hold the old block meanwhile, so the peak is just behind each power of two.
TEST_CASE("reader: peak memory is bounded by the text, for the elements that take least text") {
    const std::string start(kStartOfDocument);
    std::size_t excess = 0;
    for (std::size_t count = 1; count <= 16; ++count) {
        CAPTURE(count);
        for (const std::string_view key : {"mlpVersions", "channels", "colorMips"})
            excess = std::max(excess, ReadForExcess(start + ArrayOf(key, "{}", count) + "}"));
        const std::string rest = ArrayOf("channels", "{}", count) + ArrayOf("colorMips", "{}", count) + "}";
        excess = std::max(excess, ReadForExcess(start + ArrayOf("mlpVersions", "{}", count) + rest));
        excess =
            std::max(excess, ReadForExcess(start + ArrayOf("mlpVersions", R"({"layers":[]})", count) + rest));
    }
    CHECK(excess > 512); // so the constant is needed
    for (const std::size_t count : {std::size_t{1}, std::size_t{33}, static_cast<std::size_t>(kMaxTextures)})
        ReadForExcess(start + ArrayOf("textures", R"({"name":"","firstChannel":0,"numChannels":0})", count) +
                      "}");
    for (const std::size_t count :
         {std::size_t{1}, std::size_t{5}, std::size_t{4097}, std::size_t{32769}, kMaxViews})
        ReadForExcess(start + ArrayOf("views", R"({"offset":0,"storedSize":0})", count) + "}");
    ReadForExcess(start + ArrayOf("x", "{}", 100000) + "}");
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
