// SPDX-License-Identifier: MIT
// Stability: internal
// Heaps of slots, and which tile is in which slot. Every slot has links, so that tiles with a slot can be in
// a
// list without memory of its own.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/streaming/detail/BitTree.h"

#include <bit>
#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline constexpr std::uint32_t kNoIndex = 0xFFFFFFFF;

struct PooledSlot {
    std::uint32_t texture = kNoIndex; ///< index; kNoIndex: free
    std::uint32_t tile = 0;
    std::uint32_t previous = kNoIndex; ///< in the list that the tile's state puts it into
    std::uint32_t next = kNoIndex;     ///< also: the next free slot of the heap
    std::uint32_t ticket = 0;          ///< of the order that fills the slot
    std::uint32_t movesTo = kNoIndex;  ///< the slot that a move order names
    double lastWanted = 0;             ///< while the tile is not wanted
};

/// Slots linked through PooledSlot::previous and next.
struct SlotList {
    std::uint32_t first = kNoIndex;
    std::uint32_t last = kNoIndex;
};

struct PooledHeap {
    std::uint32_t id = 0;    ///< the caller's
    std::uint32_t order = 0; ///< counts up with every heap added
    std::uint32_t used = 0;
    std::uint32_t movable = 0; ///< tiles that defragmentation may take
    std::uint32_t firstFree = kNoIndex;
    bool isLive = false;
};

class HeapPool {
public:
    static constexpr std::uint32_t kMaxHeaps = 1u << 20;

    HeapPool(std::uint32_t slotsPerHeap, Allocator& allocator) noexcept
        : slots_(allocator), heaps_(allocator), orders_(allocator), table_(allocator), withFree_(allocator),
          withMovable_(allocator), slotsPerHeap_(slotsPerHeap) {}

    Expected<void> AddHeap(std::uint32_t id) noexcept;
    Expected<void> RemoveHeap(std::uint32_t id) noexcept;

    /// A free slot of the heap that was added first of those that have one; kNoIndex: none.
    std::uint32_t Take(std::uint32_t texture, std::uint32_t tile, std::uint32_t ticket) noexcept {
        const std::uint32_t order = withFree_.First();
        if (order == BitTree::kNone)
            return kNoIndex;
        PooledHeap& heap = heaps_[orders_[order]];
        const std::uint32_t index = heap.firstFree;
        PooledSlot& slot = slots_[index];
        heap.firstFree = slot.next;
        if (++heap.used == slotsPerHeap_)
            withFree_.Clear(order);
        ++used_;
        slot = {texture, tile, kNoIndex, kNoIndex, ticket, kNoIndex, 0};
        return index;
    }

    void Give(std::uint32_t index) noexcept {
        PooledHeap& heap = GetHeapOf(index);
        slots_[index].texture = kNoIndex;
        slots_[index].next = heap.firstFree;
        heap.firstFree = index;
        if (heap.used-- == slotsPerHeap_)
            withFree_.Set(heap.order);
        --used_;
    }

    void CountMovable(std::uint32_t index, bool isMovable) noexcept {
        PooledHeap& heap = GetHeapOf(index);
        if (isMovable) {
            if (heap.movable++ == 0)
                withMovable_.Set(heap.order);
        } else if (--heap.movable == 0) {
            withMovable_.Clear(heap.order);
        }
    }

    /// True if a movable tile lies in a heap that was added behind one with a free slot; `heap` is then the
    /// last heap that has a movable tile.
    bool FindHeapToEmpty(std::uint32_t& heap) const noexcept {
        const std::uint32_t free = withFree_.First();
        const std::uint32_t movable = withMovable_.Last();
        if (free == BitTree::kNone || movable == BitTree::kNone || free >= movable)
            return false;
        heap = orders_[movable];
        return true;
    }

    void PushBack(SlotList& list, std::uint32_t index) noexcept { InsertAfter(list, list.last, index); }

    /// Behind `after`; kNoIndex: at the front.
    void InsertAfter(SlotList& list, std::uint32_t after, std::uint32_t index) noexcept {
        PooledSlot& slot = slots_[index];
        slot.previous = after;
        slot.next = after == kNoIndex ? list.first : slots_[after].next;
        (after == kNoIndex ? list.first : slots_[after].next) = index;
        (slot.next == kNoIndex ? list.last : slots_[slot.next].previous) = index;
    }

    void Unlink(SlotList& list, std::uint32_t index) noexcept {
        const PooledSlot& slot = slots_[index];
        (slot.previous == kNoIndex ? list.first : slots_[slot.previous].next) = slot.next;
        (slot.next == kNoIndex ? list.last : slots_[slot.next].previous) = slot.previous;
    }

    PooledSlot& operator[](std::uint32_t index) noexcept { return slots_[index]; }
    const PooledSlot& operator[](std::uint32_t index) const noexcept { return slots_[index]; }
    PooledHeap& GetHeapOf(std::uint32_t index) noexcept { return heaps_[index / slotsPerHeap_]; }
    const PooledHeap& GetHeapOf(std::uint32_t index) const noexcept { return heaps_[index / slotsPerHeap_]; }
    std::span<const PooledHeap> GetHeaps() const noexcept { return heaps_.AsSpan(); }
    std::span<const std::uint32_t> GetOrders() const noexcept { return orders_.AsSpan(); }
    std::uint32_t GetSlotsPerHeap() const noexcept { return slotsPerHeap_; }
    std::uint32_t GetSlotCount() const noexcept { return static_cast<std::uint32_t>(slots_.size()); }
    std::uint32_t GetHeapCount() const noexcept { return liveHeaps_; }
    std::uint64_t GetUsedSlots() const noexcept { return used_; }
    std::uint64_t GetLiveSlots() const noexcept { return std::uint64_t{liveHeaps_} * slotsPerHeap_; }

    /// Number of a heap; kNoIndex: there is none of that identifier.
    std::uint32_t FindHeap(std::uint32_t id) const noexcept {
        if (table_.empty())
            return kNoIndex;
        for (std::size_t i = Hash(id);; ++i) {
            const std::uint32_t heap = table_[i & (table_.size() - 1)];
            if (heap == kNoIndex || heaps_[heap].id == id)
                return heap;
        }
    }

private:
    static std::size_t Hash(std::uint32_t id) noexcept { return (id * 2654435761u) >> 7; }

    void AddToTable(std::uint32_t heap) noexcept {
        std::size_t i = Hash(heaps_[heap].id);
        while (table_[i & (table_.size() - 1)] != kNoIndex)
            ++i;
        table_[i & (table_.size() - 1)] = heap;
    }

    void RebuildTable() noexcept {
        for (std::uint32_t& entry : table_)
            entry = kNoIndex;
        for (std::uint32_t heap = 0; heap < heaps_.size(); ++heap) {
            if (heaps_[heap].isLive)
                AddToTable(heap);
        }
    }

    /// Numbers the heaps from 0 again, in the order in which they were added.
    void RenumberOrders() noexcept {
        std::uint32_t live = 0;
        withFree_.ClearAll();
        withMovable_.ClearAll();
        for (const std::uint32_t number : orders_) {
            if (number == kNoIndex)
                continue;
            PooledHeap& heap = heaps_[number];
            heap.order = live;
            orders_[live] = number;
            if (heap.used < slotsPerHeap_)
                withFree_.Set(live);
            if (heap.movable > 0)
                withMovable_.Set(live);
            ++live;
        }
        (void)orders_.Resize(live); // shrinks: cannot fail
    }

    Array<PooledSlot> slots_; // heap h has slots h · slotsPerHeap …
    Array<PooledHeap> heaps_;
    Array<std::uint32_t> orders_; // order → heap; kNoIndex: removed
    Array<std::uint32_t> table_;  // open addressing, a power of two, at most half full: heaps by identifier
    BitTree withFree_;            // orders
    BitTree withMovable_;
    std::uint32_t slotsPerHeap_;
    std::uint32_t liveHeaps_ = 0;
    std::uint64_t used_ = 0;
};

inline Expected<void> HeapPool::AddHeap(std::uint32_t id) noexcept {
    if (FindHeap(id) != kNoIndex)
        return Fail(Status::InvalidArgument, "heap: %u: was added already", id);
    std::uint32_t number = 0;
    while (number < heaps_.size() && liveHeaps_ < heaps_.size() && heaps_[number].isLive)
        ++number;
    if (liveHeaps_ == heaps_.size())
        number = liveHeaps_;
    const std::uint64_t slots = (std::uint64_t{number} + 1) * slotsPerHeap_;
    if (number >= kMaxHeaps || slots >= kNoIndex)
        return Fail(Status::OutOfRange, "heaps: %u of %u slots: at most %u heaps and 2^32 - 2 slots",
                    number + 1, slotsPerHeap_, kMaxHeaps);
    if (orders_.size() >= 2 * std::size_t{liveHeaps_} + 64)
        RenumberOrders();
    // All the memory first, so that a failure leaves everything as it was.
    OPENNTC_CHECK(withFree_.Grow(orders_.size() + 1));
    OPENNTC_CHECK(withMovable_.Grow(orders_.size() + 1));
    OPENNTC_CHECK(orders_.Reserve(std::bit_ceil(orders_.size() + 1)));
    OPENNTC_CHECK(heaps_.Reserve(std::bit_ceil(std::size_t{number} + 1)));
    if (slots > slots_.size())
        OPENNTC_CHECK(slots_.Reserve(std::bit_ceil(static_cast<std::size_t>(slots))));
    if (table_.size() < 2 * (std::size_t{liveHeaps_} + 1)) {
        OPENNTC_CHECK(table_.Resize(std::bit_ceil(4 * (std::size_t{liveHeaps_} + 1))));
        RebuildTable();
    }
    if (number == heaps_.size())
        OPENNTC_CHECK(heaps_.Resize(std::size_t{number} + 1));
    if (slots > slots_.size())
        OPENNTC_CHECK(slots_.Resize(static_cast<std::size_t>(slots)));
    const auto order = static_cast<std::uint32_t>(orders_.size());
    OPENNTC_CHECK(orders_.PushBack(number));
    PooledHeap& heap = heaps_[number];
    heap = {id, order, 0, 0, number * slotsPerHeap_, true};
    for (std::uint32_t i = 0; i < slotsPerHeap_; ++i) {
        PooledSlot& slot = slots_[heap.firstFree + i];
        slot.texture = kNoIndex;
        slot.next = i + 1 < slotsPerHeap_ ? heap.firstFree + i + 1 : kNoIndex;
    }
    withFree_.Set(order);
    AddToTable(number);
    ++liveHeaps_;
    return {};
}

inline Expected<void> HeapPool::RemoveHeap(std::uint32_t id) noexcept {
    const std::uint32_t number = FindHeap(id);
    if (number == kNoIndex)
        return Fail(Status::InvalidArgument, "heap: %u: was not added", id);
    PooledHeap& heap = heaps_[number];
    if (heap.used > 0)
        return Fail(Status::InvalidState, "heap: %u: %u of its slots are in use", id, heap.used);
    withFree_.Clear(heap.order);
    orders_[heap.order] = kNoIndex;
    heap.isLive = false;
    --liveHeaps_;
    RebuildTable();
    return {};
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
