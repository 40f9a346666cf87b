// SPDX-License-Identifier: MIT
// Stability: internal
// Everything that must hold between the parts of a tile manager's books, recounted from the words of the
// tiles
// and from the geometry, without the tables and counters that the books themselves go by.
#pragma once

#include "openntc/streaming/detail/TextureBooks.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

class TileBooksCheck {
public:
    explicit TileBooksCheck(const TextureBooks& books) noexcept
        : books_(books), seen_(*books.allocator), tiles_(*books.allocator), counts_(*books.allocator) {}

    Expected<void> Run() noexcept {
        OPENNTC_CHECK(seen_.Resize(books_.pool.GetSlotCount()));
        for (std::uint32_t index = 0; index < books_.textures.size(); ++index) {
            if (books_.textures[index].shape == nullptr)
                continue;
            OPENNTC_CHECK(CheckTiles(index));
            OPENNTC_CHECK(CheckIdle(index));
            OPENNTC_CHECK(CheckWanted(index));
            OPENNTC_CHECK(CheckResidency(index));
        }
        OPENNTC_CHECK(CheckQueues());
        OPENNTC_CHECK(CheckHeaps());
        OPENNTC_CHECK(CheckOrders());
        return CheckCounters();
    }

private:
    static Unexpected Broken(const char* what, std::uint64_t a = 0, std::uint64_t b = 0) noexcept {
        return Fail(Status::InternalError, "tile manager: %s: %llu, %llu", what,
                    static_cast<unsigned long long>(a), static_cast<unsigned long long>(b));
    }

    /// Slots of tiles, and the states that pinned tiles may have.
    Expected<void> CheckTiles(std::uint32_t index) noexcept {
        const ManagedTexture& texture = books_.textures[index];
        std::uint32_t missing = 0, wanted = 0;
        for (std::uint32_t tile = 0; tile < texture.GetTileCount(); ++tile) {
            const std::uint32_t word = texture.tiles[tile].word;
            const ManagedTileState state = GetState(word);
            const bool isPinned = (word & tile_word::kPinned) != 0;
            ++states_[static_cast<std::size_t>(state)];
            if ((word & tile_word::kTouched) != 0)
                return Broken("tile is still marked as touched", index, tile);
            if (isPinned != (tile >= static_cast<std::uint32_t>(texture.shape->GetFirstPinnedTile())))
                return Broken("wrong tile is pinned", index, tile);
            if (isPinned && (state == ManagedTileState::Free || state == ManagedTileState::Standby))
                return Broken("pinned tile is free or in standby", index, tile);
            if ((word & tile_word::kWanted) != 0 &&
                (state == ManagedTileState::Free || state == ManagedTileState::Standby))
                return Broken("wanted tile is free or in standby", index, tile);
            if ((word & tile_word::kWanted) == 0 && state == ManagedTileState::Requested)
                return Broken("requested tile is not wanted", index, tile);
            wanted += (word & tile_word::kWanted) != 0 ? 1u : 0u;
            missing += isPinned && !IsVisible(word) ? 1u : 0u;
            if (state == ManagedTileState::Free || state == ManagedTileState::Requested)
                continue;
            const std::uint32_t slot = texture.tiles[tile].place;
            OPENNTC_CHECK(See(slot, index, tile));
            if (const std::uint32_t to = books_.pool[slot].movesTo; to != kNoIndex) {
                OPENNTC_CHECK(See(to, index, tile));
                ++moving_;
                if (!IsVisible(word) || isPinned)
                    return Broken("tile that may not move is moving", index, tile);
            }
        }
        if (missing != texture.state->pinnedMissing)
            return Broken("count of missing pinned tiles", missing, texture.state->pinnedMissing);
        if (wanted != texture.state->wanted)
            return Broken("count of wanted tiles", wanted, texture.state->wanted);
        wanted_ += wanted;
        return {};
    }

    Expected<void> See(std::uint32_t slot, std::uint32_t index, std::uint32_t tile) noexcept {
        if (slot >= seen_.size())
            return Broken("slot does not exist", index, tile);
        if (seen_[slot]++ != 0)
            return Broken("slot belongs to two tiles", slot, index);
        if (books_.pool[slot].texture != index || books_.pool[slot].tile != tile)
            return Broken("slot names another tile", slot, index);
        return {};
    }

    Expected<void> CheckIdle(std::uint32_t index) noexcept {
        const ManagedTexture& texture = books_.textures[index];
        std::size_t idle = 0, listed = 0;
        for (std::uint32_t tile = 0; tile < texture.GetTileCount(); ++tile) {
            const std::uint32_t word = texture.tiles[tile].word;
            const ManagedTileState state = GetState(word);
            const bool isIdle = (word & tile_word::kIdle) != 0;
            const bool isOverdue = (word & tile_word::kOverdue) != 0;
            const bool waits = (word & tile_word::kWanted) == 0 &&
                               (state == ManagedTileState::Mapped || state == ManagedTileState::Allocated);
            if (waits != (isIdle || isOverdue) || (isIdle && isOverdue) ||
                (isOverdue && state != ManagedTileState::Allocated))
                return Broken("tile is idle or is not, against its state", index, tile);
            idle += isIdle ? 1u : 0u;
        }
        std::uint32_t previous = kNoIndex;
        for (std::uint32_t slot = texture.state->idle.first; slot != kNoIndex;
             slot = books_.pool[slot].next) {
            const PooledSlot& of = books_.pool[slot];
            if (of.previous != previous || of.texture != index ||
                (texture.tiles[of.tile].word & tile_word::kIdle) == 0)
                return Broken("idle list", index, slot);
            if (previous != kNoIndex && books_.pool[previous].lastWanted > of.lastWanted)
                return Broken("idle list is not sorted by time", index, slot);
            if (++listed > idle)
                return Broken("idle list is too long", index, listed);
            previous = slot;
        }
        if (listed != idle || texture.state->idle.last != previous)
            return Broken("idle list", listed, idle);
        const bool isListed = texture.state->idleIndex != kNoIndex;
        if (isListed != (idle > 0) || (isListed && (texture.state->idleIndex >= books_.idleTextures.size() ||
                                                    books_.idleTextures[texture.state->idleIndex] != index)))
            return Broken("list of textures with idle tiles", index, idle);
        if (isListed && !(texture.oldestIdle <= books_.pool[texture.state->idle.first].lastWanted &&
                          texture.oldestIdle >= books_.pool[texture.state->idle.first].lastWanted))
            return Broken("time of the oldest idle tile", index);
        idleTextures_ += isListed ? 1u : 0u;
        return {};
    }

    /// Counts of wanting regions, from the feedback and the geometry.
    Expected<void> CheckWanted(std::uint32_t index) noexcept {
        const ManagedTexture& texture = books_.textures[index];
        const TileLayout& layout = texture.shape->layout;
        for (std::uint32_t tile = 0; tile < texture.GetTileCount(); ++tile) {
            const std::uint32_t word = texture.tiles[tile].word;
            const bool isWanted = word >= tile_word::kOne || (word & tile_word::kPinned) != 0;
            if (isWanted != ((word & tile_word::kWanted) != 0))
                return Broken("tile is wanted or is not, against its count", index, tile);
        }
        if (texture.isFollowing || texture.shape->levels == 0)
            return {};
        counts_.clear();
        OPENNTC_CHECK(counts_.Resize(texture.GetTileCount()));
        for (int y = 0; y < layout.GetRegionsY(); ++y) {
            for (int x = 0; x < layout.GetRegionsX(); ++x) {
                const int level = texture.GetLevel(texture.GetFeedback()[y * layout.GetRegionsX() + x],
                                                   texture.bias, texture.streamedMips);
                for (int coarser = level; coarser < texture.shape->levels; ++coarser)
                    CountRect(layout, coarser,
                              layout.GetOverlappingTiles(layout, level, layout.GetTilesOfRegion(x, y, level),
                                                         coarser));
            }
        }
        for (std::uint32_t tile = 0; tile < texture.GetTileCount(); ++tile) {
            if (counts_[tile] != texture.tiles[tile].word / tile_word::kOne)
                return Broken("count of regions that want a tile", counts_[tile],
                              texture.tiles[tile].word / tile_word::kOne);
        }
        return {};
    }

    void CountRect(const TileLayout& layout, int level, const TileRect& rect) noexcept {
        const TileLevel& of = layout.GetLevels()[static_cast<std::size_t>(level)];
        for (int y = rect.top; y <= rect.bottom; ++y) {
            for (int x = rect.left; x <= rect.right; ++x)
                ++counts_[of.firstTile + static_cast<std::uint32_t>(y * of.tilesX + x)];
        }
    }

    Expected<void> CheckResidency(std::uint32_t index) noexcept {
        const ManagedTexture& texture = books_.textures[index];
        const TileLayout& layout = texture.shape->layout;
        for (int y = 0; y < layout.GetResidencyHeight(); ++y) {
            for (int x = 0; x < layout.GetResidencyWidth(); ++x) {
                const std::uint8_t has = texture.residency[y * layout.GetResidencyWidth() + x];
                if (has != ComputeResidency(texture, x, y))
                    return Broken("residency map", index, has);
                const bool isInside = x >= texture.state->dirty.left && x <= texture.state->dirty.right &&
                                      y >= texture.state->dirty.top && y <= texture.state->dirty.bottom;
                if (has != texture.GetSent()[y * layout.GetResidencyWidth() + x] &&
                    (texture.state->dirtyIndex == kNoIndex || !isInside))
                    return Broken("change of residency that is not listed", index, has);
            }
        }
        return {};
    }

    static std::uint8_t ComputeResidency(const ManagedTexture& texture, int x, int y) noexcept {
        const TileLayout& layout = texture.shape->layout;
        const auto regular = static_cast<std::uint32_t>(layout.GetRegularTileCount());
        for (std::uint32_t tile = regular; tile < texture.GetTileCount(); ++tile) {
            if (!IsVisible(texture.tiles[tile].word))
                return kNoTilesFeedback;
        }
        int finest = layout.GetLevelCount();
        for (int level = finest - 1; level >= 0; --level) {
            const TileLevel& of = layout.GetLevels()[static_cast<std::size_t>(level)];
            const TileRect rect = layout.GetRelatedTiles({0, x, y}, level);
            bool isComplete = true;
            for (int row = rect.top; row <= rect.bottom; ++row) {
                for (int column = rect.left; column <= rect.right; ++column)
                    isComplete =
                        isComplete &&
                        IsVisible(
                            texture.tiles[of.firstTile + static_cast<std::uint32_t>(row * of.tilesX + column)]
                                .word);
            }
            if (!isComplete)
                break;
            finest = level;
        }
        if (finest == layout.GetLevelCount() && layout.GetTailTileCount() == 0)
            return kNoTilesFeedback;
        return static_cast<std::uint8_t>(layout.GetFirstMipOfLevel(finest));
    }

    Expected<void> CheckQueues() noexcept {
        std::uint64_t waiting = 0;
        bool isGood = true;
        for (const RequestQueue* queue : {&books_.tailRequests, &books_.requests}) {
            std::uint64_t live = 0;
            queue->ForEach([&](const RequestQueue::Entry& entry, std::uint32_t place) {
                ++live;
                const ManagedTexture& texture = books_.textures[entry.texture];
                isGood = isGood && texture.shape != nullptr && entry.tile < texture.GetTileCount() &&
                         GetState(texture.tiles[entry.tile].word) == ManagedTileState::Requested &&
                         texture.tiles[entry.tile].place == place &&
                         ((texture.tiles[entry.tile].word & tile_word::kPinned) != 0) ==
                             (queue == &books_.tailRequests);
            });
            if (live != queue->size())
                return Broken("count of waiting tiles", live, queue->size());
            waiting += live;
        }
        if (!isGood || waiting != states_[static_cast<std::size_t>(ManagedTileState::Requested)])
            return Broken("request queue", waiting,
                          states_[static_cast<std::size_t>(ManagedTileState::Requested)]);
        std::uint64_t listed = 0;
        std::uint32_t previous = kNoIndex;
        for (std::uint32_t slot = books_.standby.first; slot != kNoIndex; slot = books_.pool[slot].next) {
            const PooledSlot& of = books_.pool[slot];
            if (of.previous != previous || of.texture == kNoIndex ||
                GetState(books_.textures[of.texture].tiles[of.tile].word) != ManagedTileState::Standby ||
                ++listed > books_.standbyTiles)
                return Broken("standby queue", listed, slot);
            previous = slot;
        }
        if (listed != states_[static_cast<std::size_t>(ManagedTileState::Standby)] ||
            books_.standby.last != previous)
            return Broken("standby queue", listed,
                          states_[static_cast<std::size_t>(ManagedTileState::Standby)]);
        return {};
    }

    Expected<void> CheckHeaps() noexcept {
        const std::uint32_t perHeap = books_.pool.GetSlotsPerHeap();
        std::uint64_t used = 0;
        for (std::uint32_t heap = 0; heap < books_.pool.GetHeaps().size(); ++heap) {
            const PooledHeap& of = books_.pool.GetHeaps()[heap];
            std::uint32_t inUse = 0, movable = 0, free = 0;
            for (std::uint32_t slot = heap * perHeap; slot < (heap + 1) * perHeap; ++slot) {
                const PooledSlot& record = books_.pool[slot];
                if ((record.texture != kNoIndex) != (seen_[slot] != 0) || (seen_[slot] != 0 && !of.isLive))
                    return Broken("slot is in use without a tile, or free with one", slot, heap);
                if (record.texture == kNoIndex)
                    continue;
                ++inUse;
                const ManagedTexture& texture = books_.textures[record.texture];
                if (texture.tiles[record.tile].place == slot && books_.IsMovable(texture, record.tile))
                    ++movable;
            }
            if (!of.isLive)
                continue;
            for (std::uint32_t slot = of.firstFree; slot != kNoIndex && free <= perHeap;
                 slot = books_.pool[slot].next)
                ++free;
            if (inUse != of.used || movable != of.movable || inUse + free != perHeap)
                return Broken("counts of a heap", heap, inUse);
            if (books_.pool.FindHeap(of.id) != heap || books_.pool.GetOrders()[of.order] != heap)
                return Broken("heap is not found", heap, of.id);
            used += inUse;
        }
        if (used != books_.pool.GetUsedSlots())
            return Broken("used slots", used, books_.pool.GetUsedSlots());
        return {};
    }

    /// Each tile is at most once in each list; allocated tiles are in the list of maps exactly until it is
    /// fetched.
    Expected<void> CheckOrders() noexcept {
        OPENNTC_CHECK(CheckOnce(books_.unmaps.AsSpan()));
        OPENNTC_CHECK(CheckOnce(books_.moves.AsSpan()));
        OPENNTC_CHECK(CheckOnce(books_.maps.AsSpan()));
        std::uint64_t waiting = 0;
        for (const ManagedTexture& texture : books_.textures) {
            for (std::uint32_t tile = 0; texture.shape != nullptr && tile < texture.GetTileCount(); ++tile) {
                if (GetState(texture.tiles[tile].word) == ManagedTileState::Allocated &&
                    !books_.IsFetched(books_.pool[texture.tiles[tile].place].ticket))
                    ++waiting;
            }
        }
        if (waiting != tiles_.size()) // those of the maps, by the last CheckOnce
            return Broken("allocated tiles and map orders", waiting, tiles_.size());
        return {};
    }

    template <typename Order>
    Expected<void> CheckOnce(std::span<const Order> orders) noexcept {
        tiles_.clear();
        for (const Order& order : orders) {
            if (books_.IsRegistered(order.texture))
                OPENNTC_CHECK(tiles_.PushBack((std::uint64_t{order.texture.index} << 32) | order.tile));
        }
        std::sort(tiles_.begin(), tiles_.end());
        if (std::adjacent_find(tiles_.begin(), tiles_.end()) != tiles_.end() && !books_.hasStaleOrders)
            return Broken("tile is twice in a list of orders");
        return {};
    }

    Expected<void> CheckCounters() noexcept {
        const TileManagerStatistics has = books_.GetStatistics();
        const struct {
            const char* name;
            std::uint64_t counted;
            std::uint64_t has;
        } counters[] = {
            {"requested tiles", states_[static_cast<std::size_t>(ManagedTileState::Requested)],
             has.requestedTiles},
            {"allocated tiles", states_[static_cast<std::size_t>(ManagedTileState::Allocated)],
             has.allocatedTiles},
            {"mapped tiles", states_[static_cast<std::size_t>(ManagedTileState::Mapped)], has.mappedTiles},
            {"standby tiles", states_[static_cast<std::size_t>(ManagedTileState::Standby)], has.standbyTiles},
            {"moving tiles", moving_, has.movingTiles},
            {"wanted tiles", wanted_, has.wantedTiles},
            {"used slots", has.allocatedTiles + has.mappedTiles + has.standbyTiles + moving_, has.usedSlots},
            {"slots", has.usedSlots + has.freeSlots, has.slots},
            {"tiles", states_[0] + states_[1] + states_[2] + states_[3] + states_[4], has.tiles},
            {"touched tiles", 0, books_.touchedCount},
            {"textures with idle tiles", idleTextures_, books_.idleTextures.size()},
        };
        for (const auto& counter : counters) {
            if (counter.counted != counter.has)
                return Broken(counter.name, counter.counted, counter.has);
        }
        return {};
    }

    const TextureBooks& books_;
    Array<std::uint8_t> seen_;
    Array<std::uint64_t> tiles_;
    Array<std::uint32_t> counts_;
    std::uint64_t states_[5] = {};
    std::uint64_t moving_ = 0;
    std::uint64_t wanted_ = 0;
    std::uint64_t idleTextures_ = 0;
};

inline Expected<void> CheckTileBooks(const TextureBooks& books) noexcept {
    return TileBooksCheck(books).Run();
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
