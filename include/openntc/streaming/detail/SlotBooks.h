// SPDX-License-Identifier: MIT
// Stability: internal
// Requests, slots and orders: from a request to a mapped tile, and back.
#pragma once

#include "openntc/streaming/detail/Prefetch.h"
#include "openntc/streaming/detail/ResidencyBooks.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct SlotBooks : ResidencyBooks {
    using ResidencyBooks::ResidencyBooks;

    // --------------------------------------------------------------------- tiles that idle: a list a texture
    /// Behind slot `after` of the texture's list; kNoIndex: at its front.
    void LinkIdle(std::uint32_t index, std::uint32_t after, std::uint32_t slot) noexcept {
        ManagedTexture& texture = textures[index];
        if (texture.state->idle.first == kNoIndex) {
            texture.state->idleIndex = static_cast<std::uint32_t>(idleTextures.size());
            (void)idleTextures.PushBack(index); // room was reserved when the texture was added
        }
        pool.InsertAfter(texture.state->idle, after, slot);
        texture.tiles[pool[slot].tile].word |= tile_word::kIdle;
        texture.oldestIdle = pool[texture.state->idle.first].lastWanted;
    }

    void UnlinkIdle(std::uint32_t index, std::uint32_t slot) noexcept {
        ManagedTexture& texture = textures[index];
        pool.Unlink(texture.state->idle, slot);
        texture.tiles[pool[slot].tile].word &= ~tile_word::kIdle;
        if (texture.state->idle.first == kNoIndex)
            ForgetIdle(index);
        else
            texture.oldestIdle = pool[texture.state->idle.first].lastWanted;
    }

    /// The texture has no idle tiles any more.
    void ForgetIdle(std::uint32_t index) noexcept {
        const std::uint32_t place = std::exchange(textures[index].state->idleIndex, kNoIndex);
        textures[index].oldestIdle = std::numeric_limits<double>::infinity();
        textures[index].state->idle = {};
        if (place == kNoIndex)
            return;
        idleTextures[place] = idleTextures.back();
        textures[idleTextures[place]].state->idleIndex = idleTextures[place] == index ? kNoIndex : place;
        (void)idleTextures.Resize(idleTextures.size() - 1); // shrinks: cannot fail
    }

    // ---------------------------------------------------------------------------------------------- requests
    RequestQueue& GetQueueOf(std::uint32_t word) noexcept {
        return (word & tile_word::kPinned) != 0 ? tailRequests : requests;
    }

    /// Tells tiles where their requests have moved to.
    auto GetPlaceSetter() noexcept {
        return [this](const RequestQueue::Entry& entry, std::uint32_t place) {
            textures[entry.texture].tiles[entry.tile].place = place;
        };
    }

    void Request(std::uint32_t index, std::uint32_t tile) noexcept {
        ManagedTexture& texture = textures[index];
        std::uint32_t& word = texture.tiles[tile].word;
        const std::uint32_t evicted = texture.tiles[tile].place;
        if (evicted != 0 && round - evicted <= thrashWindow)
            ++totals.thrashedTiles;
        SetState(word, ManagedTileState::Requested);
        texture.tiles[tile].place = GetQueueOf(word).Push({index, tile}, GetPlaceSetter());
    }

    void CancelRequest(std::uint32_t index, std::uint32_t tile) noexcept {
        ManagedTexture& texture = textures[index];
        GetQueueOf(texture.tiles[tile].word).Remove(texture.tiles[tile].place);
        SetState(texture.tiles[tile].word, ManagedTileState::Free);
        texture.tiles[tile].place = 0;
        ++totals.cancelledRequests;
    }

    // -------------------------------------------------------------------------------------------- allocation
    /// The tile's slot, and the one it was to move to, become free.
    void ReleaseSlots(std::uint32_t slot) noexcept {
        if (pool[slot].movesTo != kNoIndex) {
            pool.Give(pool[slot].movesTo);
            --movingTiles;
            hasStaleOrders = true;
        } else if (IsMovable(textures[pool[slot].texture], pool[slot].tile)) {
            pool.CountMovable(slot, false);
        }
        pool.Give(slot);
    }

    /// False: nothing is in standby. Errors: OutOfMemory.
    Expected<bool> EvictOldest() noexcept {
        const std::uint32_t slot = standby.first;
        if (slot == kNoIndex)
            return false;
        const std::uint32_t index = pool[slot].texture;
        const std::uint32_t tile = pool[slot].tile;
        OPENNTC_CHECK(unmaps.PushBack({GetId(index), tile, GetSlotOf(slot)}));
        pool.Unlink(standby, slot);
        if (standby.first != kNoIndex) { // asked for before; the one behind it is needed next
            const PooledSlot& next = pool[standby.first];
            Prefetch(&textures[next.texture].tiles[next.tile]);
            if (next.next != kNoIndex)
                Prefetch(&pool[next.next]);
        }
        ReleaseSlots(slot);
        --standbyTiles;
        ManagedTexture& texture = textures[index];
        SetState(texture.tiles[tile].word, ManagedTileState::Free);
        texture.tiles[tile].place = round;
        HideTile(index, tile);
        ++totals.unmapOrders;
        return true;
    }

    /// Evicts the oldest down to the target. Errors: OutOfMemory.
    Expected<void> TrimStandby() noexcept {
        while (standbyTiles > standbyTarget) {
            if (const Expected<bool> isEvicted = EvictOldest(); !isEvicted)
                return PassError(isEvicted);
        }
        return {};
    }

    /// Serves requests until none waits or no slot is left. Errors: OutOfMemory.
    Expected<void> AllocateRequested() noexcept {
        ++round;
        for (RequestQueue* queue : {&tailRequests, &requests}) {
            while (queue->size() > 0) {
                OPENNTC_ASSIGN(const bool isServed, AllocateFront(*queue));
                if (!isServed)
                    return {};
            }
        }
        return {};
    }

    /// Gives a slot to a requested tile. False: there is none. Errors: OutOfMemory.
    Expected<bool> AllocateTile(std::uint32_t index, std::uint32_t tile) noexcept {
        OPENNTC_CHECK(maps.Reserve(std::bit_ceil(maps.size() + 1)));
        std::uint32_t slot = pool.Take(index, tile, nextTicket);
        if (slot == kNoIndex) {
            OPENNTC_ASSIGN(const bool isEvicted, EvictOldest());
            if (!isEvicted)
                return false;
            slot = pool.Take(index, tile, nextTicket);
        }
        ManagedTexture& texture = textures[index];
        GetQueueOf(texture.tiles[tile].word).Remove(texture.tiles[tile].place);
        SetState(texture.tiles[tile].word, ManagedTileState::Allocated);
        texture.tiles[tile].place = slot;
        ++allocatedTiles;
        ++totals.mapOrders;
        OPENNTC_CHECK(maps.PushBack({GetId(index), tile, GetSlotOf(slot), nextTicket++}));
        return true;
    }

    /// Serves the request at the front, coarser tiles that overlap it first. False: no slot is left.
    Expected<bool> AllocateFront(RequestQueue& queue) noexcept {
        const RequestQueue::Entry entry = queue[queue.FrontPlace()];
        if (const RequestQueue::Entry* next = queue.FindBehindFront(8); next != nullptr && !next->IsDead())
            Prefetch(&textures[next->texture].tiles[next->tile]);
        // Where levels nest, a coarser tile is wanted whenever a finer one is, and was requested before it.
        if (!textures[entry.texture].shape->isNested) {
            OPENNTC_ASSIGN(const bool isServed, AllocateCoarser(entry.texture, entry.tile));
            if (!isServed)
                return false;
        }
        return AllocateTile(entry.texture, entry.tile);
    }

    Expected<bool> AllocateCoarser(std::uint32_t index, std::uint32_t tile) noexcept {
        const ManagedTexture& texture = textures[index];
        const TileLayout& layout = texture.shape->layout;
        const int level = texture.shape->GetLevelOfTile(tile);
        if (level == texture.shape->levels)
            return true;
        const TileLevel& of = layout.GetLevels()[static_cast<std::size_t>(level)];
        const int number = static_cast<int>(tile - of.firstTile);
        for (int coarser = texture.shape->levels - 1; coarser > level; --coarser) {
            const TileLevel& other = layout.GetLevels()[static_cast<std::size_t>(coarser)];
            const TileRect related =
                layout.GetRelatedTiles({level, number % of.tilesX, number / of.tilesX}, coarser);
            for (int y = related.top; y <= related.bottom; ++y) {
                for (int x = related.left; x <= related.right; ++x) {
                    const std::uint32_t above =
                        other.firstTile + static_cast<std::uint32_t>(y * other.tilesX + x);
                    if (GetState(texture.tiles[above].word) != ManagedTileState::Requested)
                        continue;
                    OPENNTC_ASSIGN(const bool isServed, AllocateTile(index, above));
                    if (!isServed)
                        return false;
                }
            }
        }
        return true;
    }

    // -------------------------------------------------------------------------------- moves and
    // confirmations
    /// Counted as movable in the tile's heap.
    bool IsMovable(const ManagedTexture& texture, std::uint32_t tile) const noexcept {
        const std::uint32_t word = texture.tiles[tile].word;
        return IsVisible(word) && (word & tile_word::kPinned) == 0 &&
               pool[texture.tiles[tile].place].movesTo == kNoIndex;
    }

    /// Orders up to `count` moves; how many. Errors: OutOfMemory.
    Expected<std::uint32_t> Defragment(std::uint32_t count) noexcept {
        std::uint32_t moved = 0;
        std::uint32_t heap = 0;
        while (moved < count && pool.FindHeapToEmpty(heap)) {
            OPENNTC_CHECK(MoveOutOf(heap));
            ++moved;
        }
        return moved;
    }

    /// Moves one tile of a heap. Errors: OutOfMemory.
    Expected<void> MoveOutOf(std::uint32_t heap) noexcept {
        std::uint32_t from = heap * pool.GetSlotsPerHeap();
        while (pool[from].texture == kNoIndex ||
               textures[pool[from].texture].tiles[pool[from].tile].place != from ||
               !IsMovable(textures[pool[from].texture], pool[from].tile))
            ++from; // the heap has one: it was found by its count
        const std::uint32_t index = pool[from].texture;
        const std::uint32_t tile = pool[from].tile;
        OPENNTC_CHECK(moves.Reserve(std::bit_ceil(moves.size() + 1)));
        pool.CountMovable(from, false);
        const std::uint32_t to = pool.Take(index, tile, nextTicket);
        pool[from].movesTo = to;
        ++movingTiles;
        ++totals.moveOrders;
        return moves.PushBack({GetId(index), tile, GetSlotOf(from), GetSlotOf(to), nextTicket++});
    }

    bool IsFetched(std::uint32_t ticket) const noexcept {
        return static_cast<std::int32_t>(ticket - fetchedTicket) < 0; // tickets may wrap
    }

    /// An allocated tile becomes mapped. False: stale.
    bool ConfirmTile(std::uint32_t index, std::uint32_t tile) noexcept {
        ManagedTexture& texture = textures[index];
        std::uint32_t& word = texture.tiles[tile].word;
        const std::uint32_t slot = texture.tiles[tile].place;
        if (GetState(word) != ManagedTileState::Allocated || !IsFetched(pool[slot].ticket))
            return false;
        SetState(word, ManagedTileState::Mapped);
        --allocatedTiles;
        ++mappedTiles;
        if ((word & tile_word::kPinned) == 0)
            pool.CountMovable(slot, true);
        if ((word & tile_word::kOverdue) != 0) { // its time came before its data: it is among the oldest
            word &= ~tile_word::kOverdue;
            std::uint32_t after = kNoIndex;
            std::uint32_t next = texture.state->idle.first;
            while (next != kNoIndex && pool[next].lastWanted < pool[slot].lastWanted) {
                after = next;
                next = pool[next].next;
            }
            LinkIdle(index, after, slot);
        }
        ShowTile(index, tile);
        return true;
    }

    /// The tile in slot `from` is in slot movesTo from now on.
    void ConfirmMove(std::uint32_t from) noexcept {
        const std::uint32_t to = std::exchange(pool[from].movesTo, kNoIndex);
        const std::uint32_t index = pool[from].texture;
        ManagedTexture& texture = textures[index];
        const std::uint32_t tile = pool[from].tile;
        pool[to].lastWanted = pool[from].lastWanted;
        if ((texture.tiles[tile].word & tile_word::kIdle) != 0) {
            pool.InsertAfter(texture.state->idle, from, to);
            pool.Unlink(texture.state->idle, from);
        } else if (GetState(texture.tiles[tile].word) == ManagedTileState::Standby) {
            pool.InsertAfter(standby, from, to);
            pool.Unlink(standby, from);
        }
        texture.tiles[tile].place = to;
        pool.CountMovable(to, true);
        --movingTiles;
        pool.Give(from);
    }

    // ------------------------------------------------------------------------------------------------ orders
    /// Takes out the orders of textures that were removed, and moves of tiles that lost their slots.
    void DropStaleOrders() noexcept {
        if (!hasStaleOrders)
            return;
        hasStaleOrders = false;
        const auto keepIf = [](auto& orders, auto isValid) {
            std::size_t kept = 0;
            for (const auto& order : orders) {
                if (isValid(order))
                    orders[kept++] = order;
            }
            (void)orders.Resize(kept); // shrinks: cannot fail
        };
        keepIf(unmaps, [this](const TileUnmapOrder& order) { return IsRegistered(order.texture); });
        keepIf(maps, [this](const TileMapOrder& order) { return IsRegistered(order.texture); });
        keepIf(moves, [this](const TileMoveOrder& order) { return FindMove(order) != kNoIndex; });
    }

    /// The slot that a move order takes its tile from; kNoIndex: the order is void.
    std::uint32_t FindMove(const TileMoveOrder& order) const noexcept {
        if (!IsRegistered(order.texture) || order.tile >= textures[order.texture.index].GetTileCount())
            return kNoIndex;
        const ManagedTexture& texture = textures[order.texture.index];
        if (!IsVisible(texture.tiles[order.tile].word))
            return kNoIndex;
        const std::uint32_t from = texture.tiles[order.tile].place;
        const std::uint32_t to = pool[from].movesTo;
        return to != kNoIndex && pool[to].ticket == order.ticket ? from : kNoIndex;
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
