// SPDX-License-Identifier: MIT
// The fast decoder's interface: threads, target selection, errors, memory.
#include "FastDecoderCases.h"

#include <cstdlib>
#include <thread>

using namespace openntc;

namespace {

decode_test::SpecificationSet MakeLargerSet() {
    decode_test::SpecificationShape shape{
        7, 600, 150, 1, 4, NTC_NETWORK_MEDIUM, 8, 16, 2, 4, {{150, 37, 75, 18}}, {0}};
    return decode_test::MakeSpecificationSet(shape);
}

/// Counts what it lends and refuses after a number of blocks.
class CountingAllocator final : public Allocator {
public:
    explicit CountingAllocator(int blocks) : left_(blocks) {}
    void* Allocate(std::size_t bytes) noexcept override {
        if (left_-- <= 0)
            return nullptr;
        ++lent;
        return std::malloc(bytes);
    }
    void Deallocate(void* block, std::size_t) noexcept override {
        --lent;
        std::free(block);
    }
    int lent = 0;

private:
    int left_;
};

} // namespace

TEST_CASE("fast decoder: results do not depend on the number of threads") {
    const decode_test::SpecificationSet set = MakeLargerSet();
    for (const decode_test::FastTarget& target : decode_test::GetFastTargets(1)) {
        const Rect rect{3, 1, 590, 140};
        const std::vector<float> expected =
            decode_test::DecodeFast(decode_test::GetSource(set), target, 0, rect, {});
        for (const int threads : {0, 2, 3, 17, 100000}) {
            decode_test::FastTarget other = target;
            other.options.threads = threads;
            const std::vector<float> outputs =
                decode_test::DecodeFast(decode_test::GetSource(set), other, 0, rect, {});
            CHECK(std::memcmp(outputs.data(), expected.data(), expected.size() * sizeof(float)) == 0);
        }
    }
}

TEST_CASE("fast decoder: one decoder used from several threads, also after a move") {
    const decode_test::SpecificationSet set = MakeLargerSet();
    const Rect rect{0, 0, 300, 40};
    auto created =
        FastDecoder::Create(decode_test::GetSource(set), {.target = SimdTarget::Best, .threads = 2});
    REQUIRE(created.has_value());
    const FastDecoder decoder = std::move(*created);
    CHECK(decoder.GetTarget() != SimdTarget::Best);
    std::vector<float> expected(static_cast<std::size_t>(rect.width * rect.height) * NTC_MAX_CHANNELS);
    REQUIRE(DecodeReference(decode_test::GetSource(set), 0, rect, {}, expected).has_value());
    std::vector<std::vector<float>> outputs(4, std::vector<float>(expected.size()));
    std::vector<std::thread> threads;
    for (std::vector<float>& output : outputs)
        threads.emplace_back([&] { static_cast<void>(decoder.Decode(0, rect, {}, output)); });
    for (std::thread& thread : threads)
        thread.join();
    for (const std::vector<float>& output : outputs)
        CHECK(std::memcmp(output.data(), expected.data(), expected.size() * sizeof(float)) == 0);
}

TEST_CASE("fast decoder: errors") {
    decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV1Shape());
    const auto status = [](const auto& result) { return result ? Status::Ok : result.error().GetStatus(); };
    CHECK(status(FastDecoder::Create({})) == Status::InvalidArgument);
    CHECK(status(FastDecoder::Create(decode_test::GetSource(set),
                                     {.target = SimdTarget::Best, .threads = -1})) == Status::OutOfRange);
    DecodeSource cut = decode_test::GetSource(set);
    cut.latents = cut.latents.first(cut.latents.size() - 1);
    CHECK(status(FastDecoder::Create(cut)) == Status::OutOfRange);
    if (!IsSimdTargetAvailable(SimdTarget::Avx512Vnni)) {
        CHECK(status(FastDecoder::Create(decode_test::GetSource(set),
                                         {.target = SimdTarget::Avx512Vnni, .threads = 0})) ==
              Status::Unsupported);
    }

    const auto decoder = FastDecoder::Create(decode_test::GetSource(set));
    REQUIRE(decoder.has_value());
    std::vector<float> outputs(2 * 2 * NTC_MAX_CHANNELS);
    CHECK(status(decoder->Decode(0, {0, 0, 2, 2}, {}, outputs)) == Status::Ok);
    CHECK(status(decoder->Decode(-1, {0, 0, 1, 1}, {}, outputs)) == Status::OutOfRange);
    CHECK(status(decoder->Decode(4, {0, 0, 1, 1}, {}, outputs)) == Status::OutOfRange);
    CHECK(status(decoder->Decode(0, {0, 0, 0, 1}, {}, outputs)) == Status::OutOfRange);
    CHECK(status(decoder->Decode(0, {0, 0, 2, 3}, {}, outputs)) == Status::OutOfRange);

    set.constants.lowResNeuralMips[0].sliceWidthHeight = 0;
    const auto partial = FastDecoder::Create(decode_test::GetSource(set));
    REQUIRE(partial.has_value());
    CHECK(status(partial->Decode(0, {0, 0, 1, 1}, {}, outputs)) == Status::Unsupported);
}

TEST_CASE("fast decoder: running out of memory is a status, and every block is given back") {
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV1Shape());
    std::vector<float> outputs(24 * 20 * NTC_MAX_CHANNELS);
    for (int blocks = 0; blocks < 3; ++blocks) {
        CountingAllocator allocator(blocks);
        {
            const auto decoder = FastDecoder::Create(decode_test::GetSource(set), {}, allocator);
            REQUIRE(decoder.has_value() == (blocks >= 1));
            if (!decoder) {
                CHECK(decoder.error().GetStatus() == Status::OutOfMemory);
                continue;
            }
            const auto result = decoder->Decode(0, {0, 0, 24, 20}, {}, outputs);
            REQUIRE(result.has_value() == (blocks >= 2));
            if (!result)
                CHECK(result.error().GetStatus() == Status::OutOfMemory);
        }
        CHECK(allocator.lent == 0);
    }
}
