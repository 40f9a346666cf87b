// SPDX-License-Identifier: MIT
// Stability: internal
// All that a tile manager knows. What is done with it is in ResidencyBooks.h (what shaders may read),
// SlotBooks.h (requests, slots, orders) and UpdateBooks.h (feedback), each a layer on the one before.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/streaming/TileManagerTypes.h"
#include "openntc/streaming/detail/HeapPool.h"
#include "openntc/streaming/detail/ManagedTexture.h"
#include "openntc/streaming/detail/RequestQueue.h"
#include "openntc/streaming/detail/TileShape.h"

#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct TileBooks {
    TileBooks(const TileManagerDesc& desc, Allocator& from) noexcept
        : allocator(&from), textures(from), blocks(from), freeIndices(from), shapes(from),
          pool(desc.tilesPerHeap, from), tailRequests(from), requests(from),
          standbyTarget(desc.standbyTarget), thrashWindow(desc.thrashWindow), unmaps(from), moves(from),
          maps(from), fetchedUnmaps(from), fetchedMoves(from), fetchedMaps(from), idleTextures(from),
          dirtyTextures(from), residencyChanges(from), touched(from), expired(from) {}

    bool IsRegistered(ManagedTextureId id) const noexcept {
        return id.index < textures.size() && textures[id.index].shape != nullptr &&
               textures[id.index].generation == id.generation;
    }
    /// It was registered, and is not any more.
    bool WasRemoved(ManagedTextureId id) const noexcept {
        return id.index < textures.size() && id.generation > 0 &&
               id.generation < textures[id.index].generation;
    }
    ManagedTextureId GetId(std::uint32_t index) const noexcept { return {index, textures[index].generation}; }
    TileSlot GetSlotOf(std::uint32_t slot) const noexcept {
        return {pool.GetHeapOf(slot).id, slot % pool.GetSlotsPerHeap()};
    }

    Allocator* allocator;
    Array<ManagedTexture> textures;
    Array<Array<std::uint64_t>> blocks; ///< memory of each
    Array<std::uint32_t> freeIndices;   ///< the one removed last at the end
    TileShapes shapes;
    HeapPool pool;
    RequestQueue tailRequests; ///< of pinned tiles; served first
    RequestQueue requests;
    SlotList standby; ///< oldest first
    std::uint32_t standbyTarget;
    std::uint32_t thrashWindow;
    std::uint32_t round = 1; ///< of allocation
    std::uint32_t nextTicket = 1;
    std::uint32_t fetchedTicket = 1; ///< orders with earlier tickets were fetched
    std::uint64_t sequence = 0;      ///< of updates
    std::uint64_t lastAllSequence = 0;
    double lastAllTime = 0; ///< of the last update of all textures

    Array<TileUnmapOrder> unmaps;
    Array<TileMoveOrder> moves;
    Array<TileMapOrder> maps;
    Array<TileUnmapOrder> fetchedUnmaps;
    Array<TileMoveOrder> fetchedMoves;
    Array<TileMapOrder> fetchedMaps;
    bool hasStaleOrders = false; ///< some of those not fetched are void

    Array<std::uint32_t> idleTextures;
    Array<std::uint32_t> dirtyTextures;
    Array<ResidencyChange> residencyChanges;
    /// Texture in the upper half, tile in the lower. Room for all tiles.
    Array<std::uint64_t> touched;
    std::size_t touchedCount = 0;
    Array<std::uint32_t> expired; ///< room for the tiles of the largest texture

    std::uint32_t textureCount = 0;
    std::uint64_t tileCount = 0;
    std::uint64_t pinnedTiles = 0;
    std::uint64_t wantedTiles = 0;
    std::uint64_t allocatedTiles = 0; ///< in that state
    std::uint64_t mappedTiles = 0;
    std::uint64_t standbyTiles = 0;
    std::uint64_t movingTiles = 0;
    TileManagerStatistics totals; ///< only what counts since creation
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
