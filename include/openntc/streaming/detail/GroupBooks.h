// SPDX-License-Identifier: MIT
// Stability: internal
// Updates of many textures at once. What an update reads of a texture that has changed is not in any cache:
// its tiles, and then their slots. A group of textures goes through each step together, and each step asks
// for the memory of the next, so that the processor waits for all of it at once.
#pragma once

#include "openntc/streaming/detail/Prefetch.h"
#include "openntc/streaming/detail/UpdateBooks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct GroupBooks : UpdateBooks {
    using UpdateBooks::UpdateBooks;

    /// The same as an update of each texture, one after the other.
    void UpdateMany(std::span<const TextureFeedback> given, const TileUpdateOptions& options) noexcept {
        const std::int16_t bias = ManagedTexture::LimitBias(options.bias);
        const std::uint8_t streamedMips = ManagedTexture::LimitStreamedMips(options.streamedMips);
        Group group;
        for (std::size_t i = 0; i < given.size(); ++i) {
            PrefetchAhead(given, i);
            const std::uint32_t index = given[i].texture.index;
            ManagedTexture& texture = textures[index];
            if (texture.shape->levels == 0)
                continue;
            const std::size_t regions = texture.GetRegionCount();
            if (group.members == kMembers || group.changes + regions > kChanges ||
                texture.lastSequence > group.sequence) // a second map for the texture
                FinishGroup(group, options);
            const std::uint8_t* map = given[i].map.empty() ? nullptr : given[i].map.data();
            if (texture.isFollowing || texture.bias != bias || texture.streamedMips != streamedMips ||
                regions > kChanges) {
                FinishGroup(group, options);
                UpdateOne(index, map, options);
                continue;
            }
            const std::size_t before = group.changes;
            Compare(group, index, map);
            if (group.changes > before || options.time - texture.oldestIdle >= options.timeout) {
                Prefetch(texture.state);
                group.member[group.members++] = {index, group.changes, 0, GetLastTime(texture)};
            }
            texture.lastTime = options.time;
            texture.lastSequence = ++sequence;
        }
        FinishGroup(group, options);
    }

private:
    static constexpr std::size_t kMembers = 32;
    static constexpr std::size_t kChanges = 1024;
    static constexpr std::size_t kAhead = 16;

    struct Change {
        std::uint32_t region = 0;
        std::uint8_t from = 0; ///< levels
        std::uint8_t to = 0;
    };
    struct Member {
        std::uint32_t index = 0;
        std::size_t changesEnd = 0; ///< its changes lie before this, those of members before it first
        std::size_t touchedEnd = 0; ///< the same of the tiles that they touch
        double lastTime = 0;
    };
    struct Group {
        std::uint64_t sequence = 0; ///< of the last update before the group
        std::size_t members = 0;
        std::size_t changes = 0;
        std::array<Member, kMembers> member;
        std::array<Change, kChanges> change;
    };

    void PrefetchAhead(std::span<const TextureFeedback> given, std::size_t i) const noexcept {
        if (given.size() - i <= 2 * kAhead)
            return;
        Prefetch(&textures[given[i + 2 * kAhead].texture.index]);
        const TextureFeedback& next = given[i + kAhead];
        if (textures[next.texture.index].shape->levels > 0) {
            Prefetch(textures[next.texture.index].GetFeedback());
            Prefetch(next.map.data());
        }
    }

    /// Takes a map and lists what changes levels.
    void Compare(Group& group, std::uint32_t index, const std::uint8_t* map) noexcept {
        const ManagedTexture& texture = textures[index];
        std::uint8_t* feedback = texture.GetFeedback();
        const std::uint32_t regions = texture.GetRegionCount();
        std::uint32_t region = 0;
        for (; region + 64 <= regions; region += 64) {
            std::uint32_t differ = 0; // a bit for every eight regions
            for (std::uint32_t i = 0; i < 8; ++i) {
                std::uint64_t before = 0;
                std::uint64_t now = ~std::uint64_t{0};
                std::memcpy(&before, feedback + region + 8 * i, 8);
                if (map != nullptr)
                    std::memcpy(&now, map + region + 8 * i, 8);
                differ |= static_cast<std::uint32_t>(before != now) << i;
            }
            for (; differ != 0; differ &= differ - 1)
                CompareEach(group, texture, map,
                            region + 8 * static_cast<std::uint32_t>(std::countr_zero(differ)), 8);
        }
        CompareEach(group, texture, map, region, regions - region);
    }

    void CompareEach(Group& group, const ManagedTexture& texture, const std::uint8_t* map,
                     std::uint32_t first, std::uint32_t count) noexcept {
        std::uint8_t* feedback = texture.GetFeedback();
        for (std::uint32_t i = first; i < first + count; ++i) {
            const std::uint8_t value = map != nullptr ? map[i] : std::uint8_t{kNoTilesFeedback};
            const std::uint8_t old = feedback[i];
            if (old == value)
                continue;
            feedback[i] = value;
            const int from = texture.GetLevel(old, texture.bias, texture.streamedMips);
            const int to = texture.GetLevel(value, texture.bias, texture.streamedMips);
            if (from == to)
                continue;
            PrefetchTiles(texture, i, from, to);
            group.change[group.changes++] = {i, static_cast<std::uint8_t>(from),
                                             static_cast<std::uint8_t>(to)};
        }
    }

    static void PrefetchTiles(const ManagedTexture& texture, std::uint32_t region, int from,
                              int to) noexcept {
        const TileShape& shape = *texture.shape;
        if (shape.isNested) {
            for (int level = std::min(from, to); level < std::max(from, to); ++level)
                Prefetch(&texture.tiles[shape.GetTileOfRegion(region, level)]);
        }
    }

    void FinishGroup(Group& group, const TileUpdateOptions& options) noexcept {
        std::size_t change = 0;
        std::size_t touchedTile = 0;
        const std::span<Member> members = std::span(group.member).first(std::exchange(group.members, 0));
        for (Member& member : members) {
            const ManagedTexture& texture = textures[member.index];
            for (; change < member.changesEnd; ++change)
                ChangeRegion(member.index, group.change[change].region, group.change[change].from,
                             group.change[change].to);
            for (; touchedTile < touchedCount; ++touchedTile) {
                const ManagedTile& tile = texture.tiles[static_cast<std::uint32_t>(touched[touchedTile])];
                if (GetState(tile.word) >= ManagedTileState::Allocated)
                    Prefetch(&pool[tile.place]);
            }
            member.touchedEnd = touchedTile;
            if (texture.state->idle.first != kNoIndex) {
                Prefetch(&pool[texture.state->idle.first]);
                Prefetch(&pool[texture.state->idle.last]);
            }
        }
        for (const Member& member : members) {
            const ManagedTexture& texture = textures[member.index];
            if (options.time - texture.oldestIdle >= options.timeout) {
                const PooledSlot& slot = pool[texture.state->idle.first];
                Prefetch(&texture.tiles[slot.tile]);
                if (slot.next != kNoIndex)
                    Prefetch(&pool[slot.next]);
            }
        }
        touchedTile = 0;
        for (const Member& member : members) {
            Finish(member.index, touched.AsSpan().subspan(touchedTile, member.touchedEnd - touchedTile),
                   member.lastTime, options.time, options.timeout);
            touchedTile = member.touchedEnd;
        }
        touchedCount = 0;
        group.changes = 0;
        group.sequence = sequence;
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
