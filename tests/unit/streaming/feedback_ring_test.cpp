// SPDX-License-Identifier: MIT
// The ring of readbacks: nothing is read before its fence, nothing late counts as "nothing wanted" (C7).
#include "support/CountingAllocator.h"

#include "openntc/streaming/FeedbackRing.h"

#include <doctest/doctest.h>

#include <cstring>
#include <deque>
#include <random>
#include <vector>

using namespace openntc;

namespace {

FeedbackRing MakeRing(std::uint32_t readbacks, std::uint32_t maxChanges) {
    auto ring = FeedbackRing::Create(readbacks, maxChanges);
    REQUIRE(ring);
    return std::move(*ring);
}

template <typename T>
Status GetRingStatus(const Expected<T>& result) {
    return result ? Status::Ok : result.error().GetStatus();
}

} // namespace

TEST_CASE("feedback ring C7: a readback is named when its fence has passed, oldest first") {
    FeedbackRing ring = MakeRing(3, 8);
    CHECK_FALSE(ring.Poll(~std::uint64_t{0}));
    for (std::uint64_t frame = 1; frame <= 3; ++frame) {
        const auto turn = ring.Begin();
        REQUIRE(turn);
        CHECK(turn->readback == frame - 1);
        CHECK_FALSE(turn->unknown);
        CHECK(GetRingStatus(ring.Begin()) == Status::InvalidState);
        REQUIRE(ring.Submit(turn->readback, 10 * frame));
    }
    CHECK(GetRingStatus(ring.Begin()) == Status::Incomplete); // all under way: no resolve, no wait
    CHECK_FALSE(ring.Poll(9));
    std::vector<std::byte> bytes(ring.GetBytes());
    CHECK(GetRingStatus(ring.Read(0, bytes)) == Status::InvalidState);
    CHECK(ring.Poll(29) == 0u);
    CHECK(ring.Poll(0) == 0u); // it has arrived
    CHECK(GetRingStatus(ring.Read(1, bytes)) == Status::InvalidState);
    CHECK(GetRingStatus(ring.Release(1)) == Status::InvalidState);
    CHECK(GetRingStatus(ring.Begin()) == Status::Incomplete); // not released
    const std::uint32_t words[] = {10, 2, 8, 0, 40, 3, 41, 255};
    std::memcpy(bytes.data(), words, sizeof(words));
    const auto changes = ring.Read(0, bytes);
    REQUIRE(changes);
    CHECK(changes->GetCount() == 8); // never more than fit
    CHECK(changes->dropped == 2);
    CHECK((*changes)[0].region == 40);
    CHECK((*changes)[0].mip == 3);
    CHECK((*changes)[1].mip == 255);
    CHECK(GetRingStatus(ring.Read(0, std::span(bytes).first(12))) == Status::InvalidArgument);
    bytes[8] = std::byte{9};
    CHECK(GetRingStatus(ring.Read(0, bytes)) == Status::InvalidArgument);
    REQUIRE(ring.Release(0));
    CHECK(GetRingStatus(ring.Release(0)) == Status::InvalidState);
    CHECK(ring.Poll(29) == 1u);
    REQUIRE(ring.Release(1));
    CHECK_FALSE(ring.Poll(29)); // the third is late: no update
    const auto next = ring.Begin();
    REQUIRE(next);
    CHECK(next->readback == 0);
    CHECK(GetRingStatus(ring.Submit(1, 40)) == Status::InvalidArgument);
    CHECK(GetRingStatus(ring.Submit(0, 29)) == Status::InvalidArgument); // fences do not run back
    REQUIRE(ring.Submit(0, 30));
    CHECK(ring.GetInFlight() == 2);
}

TEST_CASE("feedback ring: what is lost is asked for again") {
    FeedbackRing ring = MakeRing(2, 4);
    const auto turn = ring.Begin();
    REQUIRE(turn);
    CHECK(GetRingStatus(ring.Abandon(1, true)) == Status::InvalidArgument);
    REQUIRE(ring.Abandon(0, false)); // the pass did not run
    CHECK_FALSE(ring.Begin()->unknown);
    REQUIRE(ring.Abandon(0, true)); // it ran, and its list is lost
    const auto again = ring.Begin();
    REQUIRE(again);
    CHECK(again->unknown);
    REQUIRE(ring.Submit(again->readback, 1));
    CHECK_FALSE(ring.Begin()->unknown);
    REQUIRE(ring.Submit(1, 2));
    CHECK(ring.Poll(1) == 0u);
    REQUIRE(ring.Release(0, false)); // arrived, but not read
    CHECK(ring.Begin()->unknown);
}

TEST_CASE("feedback ring: random frames, fences at random delay: each list once, in order, never early") {
    const unsigned seed = 7;
    MESSAGE("seed: " << seed);
    std::mt19937 random(seed);
    FeedbackRing ring = MakeRing(4, 4);
    std::deque<std::pair<std::uint32_t, std::uint64_t>> submitted; // readback, fence
    std::uint64_t fence = 0, completed = 0;
    std::size_t read = 0, skipped = 0;
    for (int frame = 0; frame < 20000; ++frame) {
        completed = std::min<std::uint64_t>(fence, completed + random() % 3);
        while (const auto done = ring.Poll(completed)) {
            REQUIRE_FALSE(submitted.empty());
            REQUIRE(*done == submitted.front().first);
            REQUIRE(submitted.front().second <= completed);
            submitted.pop_front();
            REQUIRE(ring.Release(*done));
            ++read;
        }
        REQUIRE((submitted.empty() || submitted.front().second > completed));
        if (const auto turn = ring.Begin()) {
            ++fence;
            submitted.emplace_back(turn->readback, fence);
            REQUIRE(ring.Submit(turn->readback, fence));
        } else {
            REQUIRE(submitted.size() == 4);
            ++skipped;
        }
    }
    CHECK(read > 10000);
    CHECK(skipped > 10);
}

TEST_CASE("feedback ring: sizes out of range, memory refused") {
    CHECK(GetRingStatus(FeedbackRing::Create(0, 1)) == Status::OutOfRange);
    CHECK(GetRingStatus(FeedbackRing::Create(17, 1)) == Status::OutOfRange);
    CHECK(GetRingStatus(FeedbackRing::Create(1, 0)) == Status::OutOfRange);
    CHECK(GetRingStatus(FeedbackRing::Create(1, (1u << 24) + 1)) == Status::OutOfRange);
    test::CountingAllocator allocator;
    allocator.FailAt(0);
    CHECK(GetRingStatus(FeedbackRing::Create(2, 8, allocator)) == Status::OutOfMemory);
}
