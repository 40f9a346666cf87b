// SPDX-License-Identifier: MIT
// Stability: internal
// From feedback to wanted tiles. Every regular tile has a count of the regions that want it. A change of
// feedback changes counts; the tiles whose count reached or left zero are settled when all is counted.
#pragma once

#include "openntc/streaming/detail/Prefetch.h"
#include "openntc/streaming/detail/SlotBooks.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct UpdateBooks : SlotBooks {
    using SlotBooks::SlotBooks;

    // ---------------------------------------------------------------------------------------------- counting
    void Touch(std::uint32_t& word, std::uint32_t index, std::uint32_t tile) noexcept {
        if ((word & tile_word::kTouched) == 0) {
            word |= tile_word::kTouched;
            touched[touchedCount++] = (std::uint64_t{index} << 32) | tile;
        }
    }

    void Count(ManagedTile* tiles, std::uint32_t index, std::uint32_t tile, bool isMore) noexcept {
        std::uint32_t& word = tiles[tile].word;
        const std::uint32_t before = word;
        word = isMore ? word + tile_word::kOne : word - tile_word::kOne;
        if ((isMore ? before : word) < tile_word::kOne) // to one, or to none
            Touch(word, index, tile);
    }

    /// Counts all that a region wants at a level: its tiles there, and those of coarser levels that overlap
    /// these.
    void CountAll(std::uint32_t index, std::uint32_t region, int level, bool isMore) noexcept {
        const ManagedTexture& texture = textures[index];
        const TileLayout& layout = texture.shape->layout;
        if (level >= texture.shape->levels)
            return;
        const int regionsX = layout.GetRegionsX();
        const TileRect tiles = layout.GetTilesOfRegion(static_cast<int>(region) % regionsX,
                                                       static_cast<int>(region) / regionsX, level);
        CountWithCoarser(texture, index, tiles, level, isMore);
    }

    void CountWithCoarser(const ManagedTexture& texture, std::uint32_t index, const TileRect& tiles,
                          int level, bool isMore) noexcept {
        const TileLayout& layout = texture.shape->layout;
        for (int coarser = level; coarser < texture.shape->levels; ++coarser) {
            const TileRect related =
                coarser == level ? tiles : layout.GetOverlappingTiles(layout, level, tiles, coarser);
            const TileLevel& of = layout.GetLevels()[static_cast<std::size_t>(coarser)];
            for (int y = related.top; y <= related.bottom; ++y) {
                for (int x = related.left; x <= related.right; ++x)
                    Count(texture.tiles, index, of.firstTile + static_cast<std::uint32_t>(y * of.tilesX + x),
                          isMore);
            }
        }
    }

    /// A region goes from one level to another; the number of levels stands for none and for the tail.
    void ChangeRegion(std::uint32_t index, std::uint32_t region, int from, int to) noexcept {
        if (from == to)
            return;
        const ManagedTexture& texture = textures[index];
        const TileShape& shape = *texture.shape;
        if (!shape.isNested) {
            CountAll(index, region, from, false);
            CountAll(index, region, to, true);
            return;
        }
        // The coarser of the two levels' chains is part of the other.
        for (int level = std::min(from, to); level < std::max(from, to); ++level)
            Count(texture.tiles, index, shape.GetTileOfRegion(region, level), to < from);
    }

    void SetRegion(std::uint32_t index, std::uint32_t region, std::uint8_t value) noexcept {
        ManagedTexture& texture = textures[index];
        const int from = texture.GetLevel(texture.GetFeedback()[region], texture.bias, texture.streamedMips);
        texture.GetFeedback()[region] = value;
        ChangeRegion(index, region, from, texture.GetLevel(value, texture.bias, texture.streamedMips));
    }

    /// Takes a whole map; null: 255 everywhere. Eight regions are compared at a time.
    void ApplyMap(std::uint32_t index, const std::uint8_t* map) noexcept {
        const ManagedTexture& texture = textures[index];
        const std::uint32_t regions = texture.GetRegionCount();
        PrefetchNext(index);
        bool isFirst = true;
        std::uint32_t region = 0;
        for (; region + 8 <= regions; region += 8) {
            std::uint64_t before = 0;
            std::uint64_t now = ~std::uint64_t{0};
            std::memcpy(&before, texture.GetFeedback() + region, 8);
            if (map != nullptr)
                std::memcpy(&now, map + region, 8);
            if (before == now)
                continue;
            if (std::exchange(isFirst, false)) // the rest of a small texture will be needed
                PrefetchBytes(texture.tiles,
                              std::min<std::size_t>(texture.GetTileCount() * sizeof(ManagedTile), 1024));
            for (std::uint32_t i = region; i < region + 8; ++i) {
                const std::uint8_t value = map != nullptr ? map[i] : std::uint8_t{kNoTilesFeedback};
                if (texture.GetFeedback()[i] != value)
                    SetRegion(index, i, value);
            }
        }
        for (; region < regions; ++region) {
            const std::uint8_t value = map != nullptr ? map[region] : std::uint8_t{kNoTilesFeedback};
            if (texture.GetFeedback()[region] != value)
                SetRegion(index, region, value);
        }
    }

    /// Textures are mostly updated in the order of their indices.
    void PrefetchNext(std::uint32_t index) const noexcept {
        if (textures.size() - index <= 8)
            return;
        PrefetchBytes(&textures[index + 8], 128);
        if (const ManagedTexture& next = textures[index + 4]; next.shape != nullptr)
            Prefetch(next.GetFeedback());
    }

    /// Takes another bias or limit of streamed mips: every region is looked at.
    void ApplySettings(std::uint32_t index, int givenBias, int givenStreamedMips) noexcept {
        ManagedTexture& texture = textures[index];
        const std::int16_t bias = ManagedTexture::LimitBias(givenBias);
        const std::uint8_t streamedMips = ManagedTexture::LimitStreamedMips(givenStreamedMips);
        if (bias == texture.bias && streamedMips == texture.streamedMips)
            return;
        for (std::uint32_t region = 0; region < texture.GetRegionCount(); ++region) {
            const std::uint8_t value = texture.GetFeedback()[region];
            ChangeRegion(index, region, texture.GetLevel(value, texture.bias, texture.streamedMips),
                         texture.GetLevel(value, bias, streamedMips));
        }
        texture.bias = bias;
        texture.streamedMips = streamedMips;
    }

    /// A texture that followed another begins again with a map of nothing.
    void StopFollowing(std::uint32_t index) noexcept {
        ManagedTexture& texture = textures[index];
        if (!texture.isFollowing)
            return;
        texture.isFollowing = false;
        ClearCounts(index);
        std::memset(texture.GetFeedback(), kNoTilesFeedback, texture.GetRegionCount());
    }

    void ClearCounts(std::uint32_t index) noexcept {
        const ManagedTexture& texture = textures[index];
        const auto tiles = static_cast<std::uint32_t>(texture.shape->layout.GetRegularTileCount());
        for (std::uint32_t tile = 0; tile < tiles; ++tile) {
            std::uint32_t& word = texture.tiles[tile].word;
            if (word >= tile_word::kOne) {
                word &= tile_word::kOne - 1;
                Touch(word, index, tile);
            }
        }
    }

    // --------------------------------------------------------------------------------------------- followers
    /// log2 of the larger of the two ratios of size, rounded towards zero.
    static int GetLevelShift(const TileLayout& primary, const TileLayout& follower) noexcept {
        std::int64_t of = follower.GetWidth();
        std::int64_t to = primary.GetWidth();
        if (std::int64_t{follower.GetHeight()} * to > of * primary.GetHeight()) {
            of = follower.GetHeight();
            to = primary.GetHeight();
        }
        const bool isLarger = of >= to;
        const std::int64_t ratio = isLarger ? of / to : to / of;
        const int shift = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(ratio))) - 1;
        return isLarger ? shift : -shift;
    }

    /// The follower wants, and only that, what overlaps the wanted tiles of the primary at the same detail.
    void SetWantedFrom(std::uint32_t primaryIndex, std::uint32_t index) noexcept {
        const ManagedTexture& primary = textures[primaryIndex];
        ManagedTexture& texture = textures[index];
        texture.isFollowing = true;
        texture.state->primary = GetId(primaryIndex);
        texture.state->primaryVersion = primary.state->wantedVersion;
        ClearCounts(index);
        const TileLayout& from = primary.shape->layout;
        const TileLayout& to = texture.shape->layout;
        const int shift = GetLevelShift(from, to);
        for (int level = 0; level < primary.shape->levels; ++level) {
            const TileLevel& of = from.GetLevels()[static_cast<std::size_t>(level)];
            // Level 0 of the primary cannot say that more is wanted.
            const int target = level == 0 ? 0 : to.GetLevelOfMip(std::max(of.firstMip + shift, 0));
            if (target >= texture.shape->levels)
                continue;
            for (int y = 0; y < of.tilesY; ++y) {
                for (int x = 0; x < of.tilesX; ++x) {
                    const std::uint32_t tile = of.firstTile + static_cast<std::uint32_t>(y * of.tilesX + x);
                    if ((primary.tiles[tile].word & tile_word::kWanted) != 0)
                        CountWithCoarser(texture, index,
                                         to.GetOverlappingTiles(from, level, {x, y, x, y}, target), target,
                                         true);
                }
            }
        }
    }

    // ---------------------------------------------------------------------------------------------- settling
    /// An update by a whole map; null: 255 everywhere.
    void UpdateOne(std::uint32_t index, const std::uint8_t* map, const TileUpdateOptions& options) noexcept {
        StopFollowing(index);
        ApplySettings(index, options.bias, options.streamedMips);
        ApplyMap(index, map);
        FinishOne(index, options.time, options.timeout);
    }

    /// Ends an update of one texture.
    void FinishOne(std::uint32_t index, double time, double timeout) noexcept {
        Finish(index, touched.AsSpan().first(std::exchange(touchedCount, 0)), GetLastTime(textures[index]),
               time, timeout);
        textures[index].lastTime = time;
        textures[index].lastSequence = ++sequence;
    }

    /// Ends an update of all textures.
    void FinishAll(double time, double timeout) noexcept {
        const std::span<std::uint64_t> all = touched.AsSpan().first(std::exchange(touchedCount, 0));
        std::sort(all.begin(), all.end());
        for (std::size_t begin = 0; begin < all.size();) {
            const auto index = static_cast<std::uint32_t>(all[begin] >> 32);
            std::size_t end = begin;
            while (end < all.size() && all[end] >> 32 == index)
                ++end;
            Settle(index, all.subspan(begin, end - begin), GetLastTime(textures[index]));
            begin = end;
        }
        // From the back: a texture without idle tiles leaves the list, and the last takes its place.
        for (std::size_t i = idleTextures.size(); i-- > 0;) {
            const std::uint32_t index = idleTextures[i];
            if (time - textures[index].oldestIdle >= timeout)
                Expire(index, time, timeout);
        }
        lastAllTime = time;
        lastAllSequence = ++sequence;
    }

    double GetLastTime(const ManagedTexture& texture) const noexcept {
        return texture.lastSequence > lastAllSequence ? texture.lastTime : lastAllTime;
    }

    void Finish(std::uint32_t index, std::span<std::uint64_t> tiles, double lastTime, double time,
                double timeout) noexcept {
        if (!tiles.empty())
            Settle(index, tiles, lastTime);
        if (time - textures[index].oldestIdle >= timeout)
            Expire(index, time, timeout);
    }

    void Settle(std::uint32_t index, std::span<std::uint64_t> tiles, double lastTime) noexcept {
        ManagedTexture& texture = textures[index];
        std::sort(tiles.begin(), tiles.end());
        for (const std::uint64_t entry : tiles) {
            const auto tile = static_cast<std::uint32_t>(entry);
            if (GetState(texture.tiles[tile].word) >= ManagedTileState::Allocated)
                Prefetch(&pool[texture.tiles[tile].place]);
        }
        std::size_t requested = 0;
        std::uint32_t after = kNoIndex; // behind which idle tile the next one belongs
        bool isFirst = true;
        for (const std::uint64_t entry : tiles) {
            const auto tile = static_cast<std::uint32_t>(entry);
            std::uint32_t& word = texture.tiles[tile].word;
            word &= ~tile_word::kTouched;
            const bool isWanted = word >= tile_word::kOne || (word & tile_word::kPinned) != 0;
            if (isWanted == ((word & tile_word::kWanted) != 0))
                continue;
            ++texture.state->wantedVersion;
            word ^= tile_word::kWanted;
            if (isWanted) {
                ++texture.state->wanted;
                ++wantedTiles;
                if (GetState(word) == ManagedTileState::Free)
                    tiles[requested++] = entry;
                else
                    Restore(index, tile);
                continue;
            }
            --texture.state->wanted;
            --wantedTiles;
            if (GetState(word) == ManagedTileState::Requested) {
                CancelRequest(index, tile);
                continue;
            }
            const std::uint32_t slot = texture.tiles[tile].place;
            pool[slot].lastWanted = lastTime;
            if (isFirst) { // at the end, but for times that ran backwards
                after = texture.state->idle.last;
                while (after != kNoIndex && pool[after].lastWanted > lastTime)
                    after = pool[after].previous;
                isFirst = false;
            }
            LinkIdle(index, after, slot);
            after = slot;
        }
        RequestTiles(index, tiles.first(requested));
    }

    /// A tile with a slot is wanted again.
    void Restore(std::uint32_t index, std::uint32_t tile) noexcept {
        ManagedTexture& texture = textures[index];
        std::uint32_t& word = texture.tiles[tile].word;
        if (GetState(word) == ManagedTileState::Standby) {
            pool.Unlink(standby, texture.tiles[tile].place);
            SetState(word, ManagedTileState::Mapped);
            --standbyTiles;
            ++mappedTiles;
            ++totals.restoredTiles;
        } else if ((word & tile_word::kIdle) != 0) {
            UnlinkIdle(index, texture.tiles[tile].place);
        }
        word &= ~tile_word::kOverdue;
    }

    /// Requests tiles, given by rising number: the coarsest level first, in a level by rising number.
    void RequestTiles(std::uint32_t index, std::span<const std::uint64_t> tiles) noexcept {
        const std::span<const TileLevel> levels = textures[index].shape->layout.GetLevels();
        std::size_t end = tiles.size();
        for (std::size_t level = levels.size(); end > 0; --level) {
            std::size_t begin = end;
            while (begin > 0 && static_cast<std::uint32_t>(tiles[begin - 1]) >= levels[level - 1].firstTile)
                --begin;
            for (std::size_t i = begin; i < end; ++i)
                Request(index, static_cast<std::uint32_t>(tiles[i]));
            end = begin;
        }
    }

    /// Mapped tiles that were not wanted for the timeout go to standby, by rising number; allocated ones are
    /// remembered for their confirmation.
    void Expire(std::uint32_t index, double time, double timeout) noexcept {
        ManagedTexture& texture = textures[index];
        std::size_t count = 0;
        while (texture.state->idle.first != kNoIndex &&
               time - pool[texture.state->idle.first].lastWanted >= timeout) {
            const std::uint32_t tile = pool[texture.state->idle.first].tile;
            UnlinkIdle(index, texture.state->idle.first);
            if (GetState(texture.tiles[tile].word) == ManagedTileState::Mapped)
                expired[count++] = tile;
            else
                texture.tiles[tile].word |= tile_word::kOverdue;
        }
        std::sort(expired.begin(), expired.begin() + count);
        for (std::size_t i = 0; i < count; ++i) {
            SetState(texture.tiles[expired[i]].word, ManagedTileState::Standby);
            pool.PushBack(standby, texture.tiles[expired[i]].place);
        }
        mappedTiles -= count;
        standbyTiles += count;
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
