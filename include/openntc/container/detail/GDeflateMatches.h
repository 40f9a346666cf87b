// SPDX-License-Identifier: MIT
// Stability: internal
// Repeated strings in a tile of at most 64 KiB, found by chains of hashes, and the ways to choose among them.
#pragma once

#include "openntc/core/Allocator.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

/// A byte (distance 0), or a repetition.
struct GDeflateToken {
    std::uint32_t length = 1;
    std::uint16_t distance = 0;
    std::uint8_t literal = 0;
};

inline constexpr std::size_t kMinMatch = 3;

/// How much work a level does.
struct GDeflateEffort {
    unsigned depth;      ///< candidates looked at for each position
    std::size_t nice;    ///< a repetition this long is taken without looking further
    bool isLazy;         ///< looks whether the next position has a longer one
    unsigned iterations; ///< of the cheapest path through all repetitions; 0: none
};

/// Levels 1 … 12; others count as 9.
constexpr GDeflateEffort GetGDeflateEffort(int level) noexcept {
    constexpr std::array<GDeflateEffort, 12> kEfforts = {{{4, 16, false, 0},
                                                          {8, 32, false, 0},
                                                          {16, 64, false, 0},
                                                          {16, 32, true, 0},
                                                          {32, 64, true, 0},
                                                          {64, 128, true, 0},
                                                          {96, 192, true, 0},
                                                          {128, 258, true, 0},
                                                          {256, 1024, true, 0},
                                                          {64, 258, false, 2},
                                                          {128, 512, false, 3},
                                                          {512, 1024, false, 4}}};
    return kEfforts[static_cast<std::size_t>(level >= 1 && level <= 12 ? level - 1 : 8)];
}

class GDeflateMatchFinder {
public:
    explicit GDeflateMatchFinder(Allocator& allocator) noexcept : heads_(allocator), previous_(allocator) {}

    Expected<void> Start(std::span<const std::byte> tile) noexcept {
        tile_ = tile;
        heads_.clear();
        OPENNTC_CHECK(heads_.Resize(kHashes)); // zeros: no position
        OPENNTC_CHECK(previous_.Resize(tile.size() + 1));
        return {};
    }

    /// Makes a position known to later ones.
    void Insert(std::size_t at) noexcept {
        if (at + kMinMatch > tile_.size())
            return;
        std::uint32_t& head = heads_[Hash(at)];
        previous_[at + 1] = head;
        head = static_cast<std::uint32_t>(at + 1);
    }

    /// Calls found(length, distance) for every candidate that is longer than `length` and those before it.
    template <typename Found>
    void Find(std::size_t at, std::size_t length, const GDeflateEffort& effort, Found found) const noexcept {
        const std::size_t longest = tile_.size() - at;
        if (longest < kMinMatch)
            return;
        std::uint32_t candidate = heads_[Hash(at)];
        for (unsigned i = 0; i < effort.depth && candidate != 0 && length < longest; ++i) {
            const std::size_t from = candidate - 1;
            candidate = previous_[candidate];
            if (tile_[from + length] != tile_[at + length])
                continue;
            const std::size_t same = Compare(from, at, longest);
            if (same <= length)
                continue;
            length = same;
            found(same, at - from);
            if (same >= effort.nice)
                return;
        }
    }

private:
    static constexpr std::size_t kHashes = 1u << 15;

    std::size_t Hash(std::size_t at) const noexcept {
        const std::uint32_t bytes = static_cast<std::uint32_t>(tile_[at]) |
                                    static_cast<std::uint32_t>(tile_[at + 1]) << 8 |
                                    static_cast<std::uint32_t>(tile_[at + 2]) << 16;
        return (bytes * 0x9E3779B1u) >> 17;
    }
    std::size_t Compare(std::size_t from, std::size_t at, std::size_t longest) const noexcept {
        std::size_t same = 0;
        while (same < longest && tile_[from + same] == tile_[at + same])
            ++same;
        return same;
    }

    std::span<const std::byte> tile_;
    Array<std::uint32_t> heads_;    // by hash: the last position + 1
    Array<std::uint32_t> previous_; // by position + 1: the one before it with the same hash
};

struct GDeflateMatch {
    std::size_t length = 0;
    std::size_t distance = 0;
};

/// The longest repetition, if it saves anything: three bytes from far away do not.
inline GDeflateMatch FindLongest(const GDeflateMatchFinder& finder, std::size_t at, std::size_t length,
                                 const GDeflateEffort& effort) noexcept {
    constexpr std::size_t kNear = 8192;
    GDeflateMatch best;
    finder.Find(at, std::max(length, kMinMatch - 1), effort, [&](std::size_t found, std::size_t distance) {
        if (found > kMinMatch || distance <= kNear)
            best = {found, distance};
    });
    return best;
}

/// Takes the longest repetition at each position, or, if lazy, the byte alone where the next one has a
/// longer.
inline Expected<void> ParseGreedily(GDeflateMatchFinder& finder, std::span<const std::byte> tile,
                                    const GDeflateEffort& effort, Array<GDeflateToken>& tokens) noexcept {
    tokens.clear();
    OPENNTC_CHECK(tokens.Reserve(tile.size()));
    GDeflateMatch match;
    bool isKnown = false;
    for (std::size_t at = 0; at < tile.size();) {
        if (!isKnown)
            match = FindLongest(finder, at, 0, effort);
        isKnown = false;
        finder.Insert(at);
        if (match.length > 0 && effort.isLazy && match.length < effort.nice) {
            const GDeflateMatch next = FindLongest(finder, at + 1, match.length, effort);
            if (next.length > match.length) {
                OPENNTC_CHECK(tokens.PushBack({1, 0, static_cast<std::uint8_t>(tile[at++])}));
                match = next;
                isKnown = true;
                continue;
            }
        }
        if (match.length == 0) {
            OPENNTC_CHECK(tokens.PushBack({1, 0, static_cast<std::uint8_t>(tile[at++])}));
            continue;
        }
        OPENNTC_CHECK(tokens.PushBack(
            {static_cast<std::uint32_t>(match.length), static_cast<std::uint16_t>(match.distance), 0}));
        for (std::size_t i = 1; i < match.length; ++i)
            finder.Insert(at + i);
        at += match.length;
    }
    return {};
}

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
