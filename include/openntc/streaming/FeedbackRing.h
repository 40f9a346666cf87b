// SPDX-License-Identifier: MIT
// Stability: experimental
// Feedback on its way back to the host: a ring of readback buffers, none of which is read before its fence,
// and the lists of changes that passes/ResolveFeedback leaves in them. No GPU object, no memory after Create.
// Each frame:
//
//   while (auto done = ring->Poll(completedFenceValue)) {           // the oldest that has arrived, if any
//       auto changes = ring->Read(*done, mapped bytes of readback *done);
//       for each change: table.FindRegion(change.region)            // whose region it is
//       ring->Release(*done);
//   }
//   if (auto turn = ring->Begin()) {                                // else all are under way: try next frame
//       if (turn->unknown) fill the pass's last bytes with 0xFE;    // a list was lost: all comes again
//       write MakeHead() to the changes, dispatch, copy the changes to readback turn->readback
//       ring->Submit(turn->readback, fenceValue);
//   }
//
// What is late or missing updates nothing. It never means that nothing is wanted.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/streaming/StreamingConstants.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// The changes that one resolve reported.
struct FeedbackChanges {
    std::span<const std::byte> entries; ///< NtcFeedbackChange, one behind the other, unaligned
    std::uint32_t dropped = 0; ///< that did not fit; they come with the next resolve of their regions

    std::size_t GetCount() const noexcept { return entries.size() / sizeof(NtcFeedbackChange); }
    NtcFeedbackChange operator[](std::size_t i) const noexcept {
        NtcFeedbackChange change;
        std::memcpy(&change, entries.data() + i * sizeof(change), sizeof(change));
        return change;
    }
};

/// A readback to be filled.
struct FeedbackTurn {
    std::uint32_t readback = 0;
    bool unknown =
        false; ///< a report was lost: the pass's last bytes are to be filled with 0xFE before it runs
};

class FeedbackRing {
public:
    static constexpr std::uint32_t kMaxReadbacks = 16;

    /// `readbacks`: frames in flight and one more, 1 … 16. `maxChanges`: entries of a list, 1 … 2^24. Errors:
    /// OutOfRange, OutOfMemory.
    static Expected<FeedbackRing> Create(std::uint32_t readbacks, std::uint32_t maxChanges,
                                         Allocator& allocator = GetDefaultAllocator()) noexcept {
        if (readbacks < 1 || readbacks > kMaxReadbacks)
            return Fail(Status::OutOfRange, "readbacks: %u: 1 to %u", readbacks, kMaxReadbacks);
        if (maxChanges < 1 || maxChanges > kMostChanges)
            return Fail(Status::OutOfRange, "maxChanges: %u: 1 to %u", maxChanges, kMostChanges);
        FeedbackRing ring(maxChanges, allocator);
        OPENNTC_CHECK(ring.readbacks_.Resize(readbacks));
        return ring;
    }

    /// Size of the changes' buffer, and of each readback.
    std::size_t GetBytes() const noexcept {
        return sizeof(NtcFeedbackChangesHead) + std::size_t{maxChanges_} * sizeof(NtcFeedbackChange);
    }
    /// What the changes' buffer begins with before the pass runs.
    NtcFeedbackChangesHead MakeHead() const noexcept { return {0, 0, maxChanges_, 0}; }

    /// The next readback. Errors: Incomplete while all are under way or not released; InvalidState if the
    /// last turn was neither submitted nor abandoned.
    Expected<FeedbackTurn> Begin() noexcept {
        if (recording_ != kNone)
            return Fail(Status::InvalidState, "readback: %u: neither submitted nor abandoned", recording_);
        Readback& next = readbacks_[head_];
        if (next.state != State::Free)
            return Fail(Status::Incomplete, "readbacks: all %zu are under way", readbacks_.size());
        next.state = State::Recording;
        recording_ = head_;
        return FeedbackTurn{head_, unknown_};
    }

    /// The copy to the readback has been given to a queue, and is done when the fence (a timeline) is at
    /// `fenceValue`. Errors: InvalidArgument for a readback whose turn it is not, or a value below the last.
    Expected<void> Submit(std::uint32_t readback, std::uint64_t fenceValue) noexcept {
        OPENNTC_CHECK(CheckRecording(readback));
        if (fenceValue < lastFence_)
            return Fail(Status::InvalidArgument, "fenceValue: %llu: at least the last, %llu",
                        static_cast<unsigned long long>(fenceValue),
                        static_cast<unsigned long long>(lastFence_));
        readbacks_[readback] = {State::InFlight, fenceValue};
        lastFence_ = fenceValue;
        recording_ = kNone;
        unknown_ = false; // last bytes were filled
        head_ = Next(head_);
        return {};
    }

    /// The turn ends without a submission. Set `wasResolved` if the pass ran and its list is lost.
    Expected<void> Abandon(std::uint32_t readback, bool wasResolved) noexcept {
        OPENNTC_CHECK(CheckRecording(readback));
        readbacks_[readback].state = State::Free;
        recording_ = kNone;
        unknown_ = unknown_ || wasResolved;
        return {};
    }

    /// The oldest readback under way, if its fence value has been reached: it can be read. Asked again before
    /// its release, it says the same.
    std::optional<std::uint32_t> Poll(std::uint64_t completedFenceValue) noexcept {
        Readback& oldest = readbacks_[tail_];
        if (oldest.state == State::InFlight && oldest.fence <= completedFenceValue)
            oldest.state = State::Ready;
        if (oldest.state != State::Ready)
            return std::nullopt;
        return tail_;
    }

    /// The changes in a readback that Poll has named. Regions are the device's word. Errors: InvalidState for
    /// a readback that has not arrived; InvalidArgument for bytes of another size or another ring's.
    Expected<FeedbackChanges> Read(std::uint32_t readback, std::span<const std::byte> bytes) const noexcept {
        if (readback >= readbacks_.size() || readbacks_[readback].state != State::Ready)
            return Fail(Status::InvalidState, "readback: %u: has not arrived", readback);
        if (bytes.size() < GetBytes())
            return Fail(Status::InvalidArgument, "readback: %zu bytes: it has %zu", bytes.size(), GetBytes());
        NtcFeedbackChangesHead head;
        std::memcpy(&head, bytes.data(), sizeof(head));
        if (head.capacity != maxChanges_)
            return Fail(Status::InvalidArgument, "readback: capacity %u: not the ring's %u", head.capacity,
                        maxChanges_);
        const std::size_t count = head.count < maxChanges_ ? head.count : maxChanges_;
        return FeedbackChanges{bytes.subspan(sizeof(head), count * sizeof(NtcFeedbackChange)), head.dropped};
    }

    /// The readback can be filled again. `wasRead` false: its changes are lost, as after a device was.
    /// Errors: InvalidState for a readback that has not arrived.
    Expected<void> Release(std::uint32_t readback, bool wasRead = true) noexcept {
        if (readback >= readbacks_.size() || readbacks_[readback].state != State::Ready)
            return Fail(Status::InvalidState, "readback: %u: has not arrived", readback);
        readbacks_[readback].state = State::Free;
        unknown_ = unknown_ || !wasRead;
        tail_ = Next(tail_);
        return {};
    }

    std::uint32_t GetInFlight() const noexcept {
        std::uint32_t count = 0;
        for (const Readback& readback : readbacks_)
            count += readback.state == State::InFlight ? 1u : 0u;
        return count;
    }

private:
    enum class State { Free, Recording, InFlight, Ready };
    struct Readback {
        State state = State::Free;
        std::uint64_t fence = 0;
    };
    static constexpr std::uint32_t kNone = 0xFFFFFFFFu;
    static constexpr std::uint32_t kMostChanges = 1u << 24;

    FeedbackRing(std::uint32_t maxChanges, Allocator& allocator) noexcept
        : maxChanges_(maxChanges), readbacks_(allocator) {}

    std::uint32_t Next(std::uint32_t readback) const noexcept {
        return readback + 1 < readbacks_.size() ? readback + 1 : 0;
    }

    Expected<void> CheckRecording(std::uint32_t readback) const noexcept {
        if (readback != recording_ || recording_ == kNone)
            return Fail(Status::InvalidArgument, "readback: %u: not the one that Begin gave", readback);
        return {};
    }

    std::uint32_t maxChanges_;
    std::uint32_t head_ = 0;
    std::uint32_t tail_ = 0;
    std::uint32_t recording_ = kNone;
    std::uint64_t lastFence_ = 0;
    bool unknown_ = false;
    Array<Readback> readbacks_;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
