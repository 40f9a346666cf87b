// SPDX-License-Identifier: MIT
// Stability: internal
// Tiles that wait for a slot, oldest first. Any of them can be taken out: its entry stays behind, dead.
#pragma once

#include "openntc/core/Allocator.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

class RequestQueue {
public:
    static constexpr std::uint32_t kDead = 0xFFFFFFFF;

    struct Entry {
        std::uint32_t texture = kDead; ///< index; kDead: taken out
        std::uint32_t tile = 0;

        bool IsDead() const noexcept { return texture == kDead; }
    };

    explicit RequestQueue(Allocator& allocator) noexcept : entries_(allocator) {}

    /// Makes room for that many waiting tiles. `moved(entry, place)` is told where entries lie now. Errors:
    /// OutOfMemory; nothing has changed then.
    template <typename Moved>
    Expected<void> Reserve(std::size_t count, Moved moved) noexcept {
        if (2 * count <= entries_.size())
            return {};
        Array<Entry> larger(entries_.GetAllocator());
        // Twice the room: whenever the dead are swept out they are half of it.
        OPENNTC_CHECK(larger.Resize(std::bit_ceil(2 * count < 64 ? std::size_t{64} : 2 * count)));
        std::size_t live = 0;
        for (std::size_t i = first_; i != end_; ++i) {
            if (const Entry& entry = At(i); !entry.IsDead())
                larger[live++] = entry;
        }
        entries_ = std::move(larger);
        Restart(live, moved);
        return {};
    }

    /// Appends a tile and returns its place. There is room, because of Reserve, as soon as dead entries are
    /// gone.
    template <typename Moved>
    std::uint32_t Push(Entry entry, Moved moved) noexcept {
        if (live_ == 0) // start at the front again: the memory that was used last
            first_ = end_ = 0;
        if (end_ - first_ == entries_.size())
            Compact(moved);
        ++live_;
        At(end_) = entry;
        return static_cast<std::uint32_t>(end_++ & (entries_.size() - 1));
    }

    void Remove(std::uint32_t place) noexcept {
        entries_[place].texture = kDead;
        --live_;
    }

    /// The oldest tile, which stays in the queue until Remove. There must be one.
    std::uint32_t FrontPlace() noexcept {
        while (At(first_).IsDead())
            ++first_;
        return static_cast<std::uint32_t>(first_ & (entries_.size() - 1));
    }

    /// The entry so many places behind the first one, which may be dead; null: there is none.
    const Entry* FindBehindFront(std::size_t distance) const noexcept {
        return end_ - first_ > distance ? &entries_[(first_ + distance) & (entries_.size() - 1)] : nullptr;
    }

    const Entry& operator[](std::uint32_t place) const noexcept { return entries_[place]; }
    std::size_t size() const noexcept { return live_; } ///< waiting tiles
    std::size_t GetPlaces() const noexcept { return entries_.size(); }

    /// Calls visit(entry, place), oldest first.
    template <typename Visit>
    void ForEach(Visit visit) const noexcept {
        for (std::size_t i = first_; i != end_; ++i) {
            const std::size_t place = i & (entries_.size() - 1);
            if (!entries_[place].IsDead())
                visit(entries_[place], static_cast<std::uint32_t>(place));
        }
    }

private:
    Entry& At(std::size_t number) noexcept { return entries_[number & (entries_.size() - 1)]; }

    template <typename Moved>
    void Compact(Moved moved) noexcept {
        std::size_t to = first_;
        for (std::size_t i = first_; i != end_; ++i) {
            if (!At(i).IsDead()) {
                At(to) = At(i);
                moved(At(to), static_cast<std::uint32_t>(to & (entries_.size() - 1)));
                ++to;
            }
        }
        end_ = to;
    }

    template <typename Moved>
    void Restart(std::size_t live, Moved moved) noexcept {
        first_ = 0;
        end_ = live_ = live;
        for (std::size_t i = 0; i < live; ++i)
            moved(entries_[i], static_cast<std::uint32_t>(i));
    }

    Array<Entry> entries_; // a ring; its size is a power of two
    std::size_t first_ = 0;
    std::size_t end_ = 0;
    std::size_t live_ = 0;
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
