// SPDX-License-Identifier: MIT
// Stability: internal
// The tiles of one source as a demand loader keeps them: the state of each, and the textures that show them.
#pragma once

#include "openntc/streaming/DemandTypes.h"
#include "openntc/streaming/detail/ChunkedArray.h"
#include "openntc/streaming/detail/SlotPool.h"

#include <atomic>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// What a tile is. From Queued to Staged it has a slot (pages of resources never have one).
enum class TileState : std::uint8_t {
    Free,
    Queued,   ///< waits for a thread
    Reading,  ///< a thread is in the source
    Filled,   ///< in host memory, waits for LaunchPrepare
    Resident, ///< shaders see it
    Staged,   ///< hidden, its slot kept until no launch can read it any more
    Failed,   ///< not asked for again before a retry
};

struct TileRecord {
    std::uint32_t slot = kNoSlot; ///< or the value of a resource's page
    std::uint32_t stamp = 0;      ///< round of the last use; Free: of the eviction
    std::uint32_t children = 0;   ///< finer tiles over it that have a slot and are not staged
    std::uint32_t place = 0;      ///< Resident, Staged: index in the list of those
    TileState state = TileState::Free;
    bool isWanted = false; ///< during ProcessRequests: among the candidates
    bool isStale = false;  ///< a page that was invalidated while it was being read
    bool wasFreed = false; ///< evicted before
    bool isForced = false; ///< Staged for a coarser one, although it was in use: not to be restored
};

struct TileSet {
    explicit TileSet(Allocator& allocator) noexcept : tiles(allocator), textures(allocator) {}

    Shared<TileSource> source; ///< empty: a resource
    PageCallback callback;     ///< of a resource
    std::uint32_t tileCount = 0;
    std::uint32_t baseFirst = 0; ///< tiles that are read at once and stay: the tail, else the coarsest level
    std::uint32_t baseCount = 0;
    std::uint64_t baseBytes = 0;
    std::uint32_t baseMissing = 0; ///< of those, not resident
    bool hasRows = false;          ///< a texture set
    bool isRemoved = false;
    bool isPending = false;    ///< in the list of those whose base is not there
    std::uint32_t holders = 0; ///< textures that show it, or will when its tail is there
    std::uint32_t residents = 0;
    std::uint32_t taken = 0; ///< while candidates are sorted
    std::atomic<bool> isCancelled{false};
    ChunkedArray<TileRecord> tiles;
    Array<std::uint32_t> textures; ///< that show it: numbers in the page table

    bool IsResource() const noexcept { return !source; }
    bool IsBase(std::uint32_t tile) const noexcept {
        return tile >= baseFirst && tile - baseFirst < baseCount;
    }
    std::uint32_t GetBytes(std::uint32_t tile) const {
        return IsResource() ? 0 : static_cast<std::uint32_t>(source->GetTileBytes(tile));
    }

    /// 0 for the base, 1 for the level above it, and so on.
    std::uint32_t GetDepth(std::uint32_t tile) const {
        if (IsResource())
            return 1;
        if (IsBase(tile))
            return 0;
        const TileLayout& layout = source->GetLayout();
        const auto position = layout.GetTilePosition(tile);
        const int base = layout.GetTailTileCount() > 0 ? layout.GetLevelCount() : layout.GetLevelCount() - 1;
        return position ? static_cast<std::uint32_t>(base - position->level) : 0;
    }

    /// Calls function(tile) for the tiles of the next coarser regular level that the tile lies over.
    template <typename Function>
    void ForEachParent(std::uint32_t tile, Function&& function) const {
        if (IsResource() || IsBase(tile))
            return;
        const TileLayout& layout = source->GetLayout();
        const auto position = layout.GetTilePosition(tile);
        if (!position || position->level + 1 >= layout.GetLevelCount())
            return;
        const int level = position->level + 1;
        const TileRect rect = layout.GetRelatedTiles(*position, level);
        const TileLevel& coarser = layout.GetLevels()[static_cast<std::size_t>(level)];
        for (int y = rect.top; y <= rect.bottom; ++y) {
            for (int x = rect.left; x <= rect.right; ++x)
                function(coarser.firstTile +
                         static_cast<std::uint32_t>(y) * static_cast<std::uint32_t>(coarser.tilesX) +
                         static_cast<std::uint32_t>(x));
        }
    }

    TilePosition GetPosition(std::uint32_t tile) const {
        if (IsResource())
            return {0, static_cast<int>(tile), 0};
        const auto position = source->GetLayout().GetTilePosition(tile);
        return position ? *position : TilePosition{};
    }
};

/// A tile of a set, by which the set stays alive.
struct TileRef {
    Shared<TileSet> set;
    std::uint32_t tile = 0;
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
