// SPDX-License-Identifier: MIT
// Stability: internal
// Which slots of the pool are in use, by how many tiles, and which of them hold one repeated pattern.
#pragma once

#include "openntc/core/Allocator.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline constexpr std::uint32_t kNoSlot = 0xFFFFFFFFu;

/// Sixteen bytes that a tile repeats to its end.
struct TilePattern {
    std::array<std::byte, 16> bytes{};
    std::uint32_t size = 0; ///< of the tile

    friend bool operator==(const TilePattern&, const TilePattern&) = default;
};

/// True if the bytes are a pattern and its repetitions, the last of which may be cut.
inline bool FindPattern(std::span<const std::byte> tile, TilePattern& pattern) noexcept {
    const std::size_t period = pattern.bytes.size();
    if (tile.size() < period || std::memcmp(tile.data(), tile.data() + period, tile.size() - period) != 0)
        return false;
    std::memcpy(pattern.bytes.data(), tile.data(), period);
    pattern.size = static_cast<std::uint32_t>(tile.size());
    return true;
}

class SlotPool {
public:
    explicit SlotPool(Allocator& allocator) noexcept
        : slots_(allocator), free_(allocator), buckets_(allocator) {}

    Expected<void> Reset(std::uint32_t slots) noexcept {
        OPENNTC_CHECK(slots_.Resize(slots));
        OPENNTC_CHECK(free_.Reserve(slots));
        OPENNTC_CHECK(buckets_.Resize(std::min<std::size_t>(slots, 4096)));
        std::fill(buckets_.begin(), buckets_.end(), kNoSlot);
        for (std::uint32_t slot = slots; slot > 0; --slot)
            OPENNTC_CHECK(free_.PushBack(slot - 1));
        return {};
    }

    std::uint32_t GetInUse() const noexcept {
        return static_cast<std::uint32_t>(slots_.size() - free_.size());
    }
    std::uint64_t GetBytes() const noexcept { return bytes_; }
    std::uint32_t GetSize() const noexcept { return static_cast<std::uint32_t>(slots_.size()); }
    bool HasFree() const noexcept { return !free_.empty(); }

    /// There must be a free one.
    std::uint32_t Take(std::uint32_t bytes) noexcept {
        const std::uint32_t slot = free_.back();
        free_.pop_back();
        slots_[slot] = Slot{};
        slots_[slot].users = 1;
        slots_[slot].bytes = bytes;
        bytes_ += bytes;
        return slot;
    }
    /// One user fewer; true if that was the last.
    bool Release(std::uint32_t slot) noexcept {
        Slot& released = slots_[slot];
        if (--released.users > 0)
            return false;
        bytes_ -= released.bytes;
        if (released.isPattern)
            Unlink(slot);
        static_cast<void>(free_.PushBack(slot)); // has room since Reset
        return true;
    }
    std::uint32_t GetUsers(std::uint32_t slot) const noexcept { return slots_[slot].users; }

    /// A slot with these bytes, with one user more; kNoSlot if there is none.
    std::uint32_t Share(const TilePattern& pattern) noexcept {
        for (std::uint32_t slot = GetBucket(pattern); slot != kNoSlot; slot = slots_[slot].next) {
            if (slots_[slot].pattern == pattern) {
                ++slots_[slot].users;
                return slot;
            }
        }
        return kNoSlot;
    }
    /// The slot holds this pattern from now on.
    void SetPattern(std::uint32_t slot, const TilePattern& pattern) noexcept {
        std::uint32_t& bucket = GetBucket(pattern);
        slots_[slot].pattern = pattern;
        slots_[slot].isPattern = true;
        slots_[slot].next = bucket;
        bucket = slot;
    }

private:
    struct Slot {
        TilePattern pattern;
        std::uint32_t users = 0;
        std::uint32_t bytes = 0;
        std::uint32_t next = kNoSlot; ///< with a pattern of the same bucket
        bool isPattern = false;
    };

    std::uint32_t& GetBucket(const TilePattern& pattern) noexcept {
        std::uint32_t hash = 2166136261u; // FNV-1a
        for (const std::byte byte : pattern.bytes)
            hash = (hash ^ static_cast<std::uint32_t>(byte)) * 16777619u;
        return buckets_[(hash ^ hash >> 16) % buckets_.size()];
    }
    void Unlink(std::uint32_t slot) noexcept {
        std::uint32_t* link = &GetBucket(slots_[slot].pattern);
        while (*link != slot)
            link = &slots_[*link].next;
        *link = slots_[slot].next;
    }

    Array<Slot> slots_;
    Array<std::uint32_t> free_;
    Array<std::uint32_t> buckets_;
    std::uint64_t bytes_ = 0;
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
