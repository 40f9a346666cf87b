// SPDX-License-Identifier: MIT
// Stability: experimental
// The buffer that launches write and the host reads back: the request queue, request bits and stamps.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/streaming/StreamingConstants.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Sizes and places in the launch state, a buffer of 32-bit words that shaders read and write.
struct LaunchState {
    std::uint32_t queueWord = 0; ///< NtcRequestQueue and its entries
    std::uint32_t bitsWord = 0;
    std::uint32_t stampsWord = 0;
    std::uint32_t words = 0;
    std::uint32_t queueCapacity = 0;

    std::size_t GetBytes() const noexcept { return std::size_t{words} * 4; }
    /// Bytes of the queue, from the start of the buffer: what the host reads back after a launch.
    std::size_t GetQueueBytes() const noexcept {
        return sizeof(NtcRequestQueue) + std::size_t{queueCapacity} * sizeof(NtcTileRequest);
    }
};

/// Prepares launch state: all zero, with the capacity in the queue's head. Errors: InvalidArgument if `bytes`
/// is not exactly the state's size.
inline Expected<void> ClearLaunchState(const LaunchState& state, std::span<std::byte> bytes) noexcept {
    if (bytes.size() != state.GetBytes())
        return Fail(Status::InvalidArgument, "launch state: %zu bytes: it has %zu", bytes.size(),
                    state.GetBytes());
    std::memset(bytes.data(), 0, bytes.size());
    const NtcRequestQueue head = {0, 0, state.queueCapacity, 0};
    std::memcpy(bytes.data() + std::size_t{state.queueWord} * 4, &head, sizeof(head));
    return {};
}

/// What one launch requested.
struct RequestList {
    std::span<const std::byte> entries; ///< NtcTileRequest, one behind the other, unaligned
    std::uint32_t overflow = 0;         ///< requests that did not fit

    std::size_t GetCount() const noexcept { return entries.size() / sizeof(NtcTileRequest); }
    NtcTileRequest operator[](std::size_t i) const noexcept {
        NtcTileRequest request;
        std::memcpy(&request, entries.data() + i * sizeof(request), sizeof(request));
        return request;
    }
};

/// Reads the queue that came back from the device. Entries are the device's word: texture and tile need not
/// exist any more. Errors: InvalidArgument for fewer bytes than LaunchState::GetQueueBytes, or a capacity
/// that is not the state's.
inline Expected<RequestList> ReadRequests(const LaunchState& state,
                                          std::span<const std::byte> bytes) noexcept {
    if (bytes.size() < state.GetQueueBytes())
        return Fail(Status::InvalidArgument, "queue: %zu bytes: it has %zu", bytes.size(),
                    state.GetQueueBytes());
    NtcRequestQueue head;
    std::memcpy(&head, bytes.data(), sizeof(head));
    if (head.capacity != state.queueCapacity)
        return Fail(Status::InvalidArgument, "queue: capacity %u: not the %u of the state", head.capacity,
                    state.queueCapacity);
    const std::size_t count = head.count < head.capacity ? head.count : head.capacity;
    return RequestList{bytes.subspan(sizeof(head), count * sizeof(NtcTileRequest)), head.overflow};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
