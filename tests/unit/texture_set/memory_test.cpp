// SPDX-License-Identifier: MIT
// Running out of memory at any allocation is a Status, and nothing is allocated out of proportion.
#include "EditedFile.h"

#include <algorithm>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// Counts, and refuses the allocation number `failAt`.
class CountingAllocator final : public Allocator {
public:
    explicit CountingAllocator(int failAt = -1) : failAt_(failAt) {}
    void* Allocate(std::size_t bytes) noexcept override {
        if (count++ == failAt_)
            return nullptr;
        largest = std::max(largest, bytes);
        ++live;
        return std::malloc(bytes);
    }
    void Deallocate(void* block, std::size_t) noexcept override {
        --live;
        std::free(block);
    }
    int count = 0;
    int live = 0;
    std::size_t largest = 0;

private:
    int failAt_;
};

} // namespace

TEST_CASE("every allocation of loading may fail") {
    SynthesisDesc synthesis = GetV1().synthesis;
    synthesis.withFP8 = true;
    const std::vector<std::byte> file = MakeFile(synthesis);
    CountingAllocator counting;
    {
        ReadOnlyMemoryStream stream(file);
        REQUIRE(TextureSetMetadata::Load(stream, counting));
    }
    CHECK(counting.live == 0);
    CHECK(counting.count > 3);
    // weight buffers are the largest: 13952 bytes; everything else grows with the JSON text
    CHECK(counting.largest <= 13952);
    for (int i = 0; i < counting.count; ++i) {
        CountingAllocator failing(i);
        ReadOnlyMemoryStream stream(file);
        const auto set = TextureSetMetadata::Load(stream, failing);
        REQUIRE_FALSE(set);
        CHECK(set.error().GetStatus() == Status::OutOfMemory);
        CHECK(failing.live == 0);
    }
}
