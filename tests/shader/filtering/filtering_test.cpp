// SPDX-License-Identifier: MIT
// Filtering on a device, by GLSL and by HLSL: the specification's vectors, and many items against the C++
// build.
#include "shader/TestDevice.h"
#include "support/Vectors.h"
#include "support/filtering/FilterItems.h"

#include "filtering_hlsl_shaders.h"
#include "filtering_shaders.h"

#include "vulkan_harness/Vulkan.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

std::vector<std::uint32_t> RunFiltersOnDevice(Context& context, std::span<const FilterItem> items,
                                              std::span<const std::uint32_t> spirv) {
    const std::uint32_t count = static_cast<std::uint32_t>(items.size());
    const auto input =
        context.CreateBuffer(std::as_bytes(items), BufferKind::Storage, BufferMemory::HostVisible);
    const auto output =
        context.CreateBuffer(items.size() * FILTER_WORDS * 4, BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE((input && output));
    const BufferSlot slots[] = {{0, BufferKind::Storage}, {1, BufferKind::Storage}};
    const auto pipeline = context.CreateComputePipeline(spirv, slots, 4);
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const BoundBuffer bound[] = {{0, &*input}, {1, &*output}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&count, 1));
    request.groups[0] = (count + 63) / 64;
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    std::vector<std::uint32_t> results(items.size() * FILTER_WORDS);
    REQUIRE(context.Read(*output, 0, std::as_writable_bytes(std::span(results))));
    return results;
}

/// SPIR-V of both languages.
std::vector<std::pair<const char*, std::span<const std::uint32_t>>> GetLanguages() {
    const auto glsl = filtering_shaders::FindShader("Filtering.comp", "");
    const auto hlsl = filtering_hlsl_shaders::FindShader("Filtering.hlsl", "");
    REQUIRE_MESSAGE(glsl.has_value(), std::string(glsl.error().GetText()));
    REQUIRE_MESSAGE(hlsl.has_value(), std::string(hlsl.error().GetText()));
    return {{"GLSL", *glsl}, {"HLSL", *hlsl}};
}

/// Words that are floats may be flushed where they are subnormal, and NaN has no fixed payload.
std::uint32_t GetComparableWord(std::uint32_t bits) {
    if ((bits & 0x7FFFFFFFu) > 0x7F800000u)
        return 0x7FC00000u;
    return bits;
}

/// True where a device may take a subnormal number as zero.
bool HasSubnormal(const FilterItem& item) {
    const std::uint32_t derivatives[] = {item.dudx,  item.dvdx,  item.dudy, item.dvdy,
                                         item.axisX, item.axisY, item.u,    item.v};
    for (const std::uint32_t bits : derivatives) {
        if ((bits & 0x7F800000u) == 0 && (bits & 0x007FFFFFu) != 0)
            return true;
    }
    return false;
}

} // namespace

TEST_CASE("filtering on a device: all vectors, bit for bit") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<FilterVector> vectors = ReadFilterVectors();
    if (vectors.empty()) {
        MESSAGE("SKIP: no vectors of filtering: set OPENNTC_SHARED_DIR");
        return;
    }
    std::vector<FilterItem> items;
    for (const FilterVector& vector : vectors)
        items.push_back(vector.item);
    for (const auto& language : GetLanguages()) {
        CAPTURE(language.first);
        const std::vector<std::uint32_t> results = RunFiltersOnDevice(*context, items, language.second);
        int different = 0;
        for (std::size_t i = 0; i < vectors.size(); ++i) {
            if (CountDifferences(vectors[i], results.data() + i * FILTER_WORDS) != 0 && ++different <= 5)
                MESSAGE("vector " << i << ": " << vectors[i].name);
        }
        CHECK(different == 0);
        ReportVectors(language.first, static_cast<int>(vectors.size()), 0);
    }
}

TEST_CASE("filtering on a device: every kind of item, bit for bit as in C++") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<FilterItem> items = MakeFilterItems(30000, 5, false);
    std::vector<std::uint32_t> expected;
    for (const FilterItem& item : items) {
        const std::vector<std::uint32_t> words = RunFilter(item);
        expected.insert(expected.end(), words.begin(), words.end());
    }
    for (const auto& language : GetLanguages()) {
        CAPTURE(language.first);
        const std::vector<std::uint32_t> results = RunFiltersOnDevice(*context, items, language.second);
        std::size_t different = 0, compared = 0;
        for (std::size_t i = 0; i < items.size(); ++i) {
            if (HasSubnormal(items[i]))
                continue;
            ++compared;
            for (std::size_t k = i * FILTER_WORDS; k < (i + 1) * FILTER_WORDS; ++k) {
                if (GetComparableWord(results[k]) == GetComparableWord(expected[k]))
                    continue;
                if (++different <= 5)
                    MESSAGE("item " << i << " of kind " << items[i].kind << ", kernel " << items[i].kernel
                                    << ", word " << k % FILTER_WORDS << ": " << std::hex << results[k]
                                    << ", not " << expected[k]);
            }
        }
        CHECK(different == 0);
        CHECK(compared > items.size() / 2);
    }
}
