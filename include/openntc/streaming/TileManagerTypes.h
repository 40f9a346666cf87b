// SPDX-License-Identifier: MIT
// Stability: experimental
// What a tile manager is told and what it answers.
#pragma once

#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A registered texture. Indices are used again, the one removed last first; the generation tells a texture
/// from those that had its index before.
struct ManagedTextureId {
    std::uint32_t index = 0xFFFFFFFF;
    std::uint32_t generation = 0;

    friend constexpr bool operator==(const ManagedTextureId&, const ManagedTextureId&) noexcept = default;
};

/// free → requested → allocated → mapped ⇄ standby → free. Shaders may read mapped and standby tiles.
enum class ManagedTileState : std::uint8_t {
    Free,      ///< no slot
    Requested, ///< waits for a slot
    Allocated, ///< has a slot, its data are not confirmed
    Mapped,
    Standby, ///< not wanted for the timeout: still mapped, but its slot may be given away
};

struct TileManagerDesc {
    std::uint32_t tilesPerHeap = 256; ///< slots of every heap, 1 … 2^20
    std::uint32_t standbyTarget = 1000;
    /// A tile that is requested again at most this many calls of Allocate after its eviction counts as
    /// thrashed.
    std::uint32_t thrashWindow = 60;
};

/// When and how feedback is taken. Times are numbers of the caller's unit, finite.
struct TileUpdateOptions {
    double time = 0;
    /// A tile goes to standby at the first update of its texture at which it is not wanted and time - (when
    /// it
    /// was last wanted) >= timeout. It belongs to the call. >= 0.
    double timeout = 0;
    int bias = 0;         ///< added to every mip of the feedback; the sum is clamped to 0 or more
    int streamedMips = 0; ///< > 0: only this many of the coarsest mips are streamed
};

/// A texture's whole map of feedback: a byte per region, row by row, the finest mip that was sampled there or
/// 255. An empty map: nothing was.
struct TextureFeedback {
    ManagedTextureId texture;
    std::span<const std::uint8_t> map;
};

/// A byte of feedback that changed.
struct RegionChange {
    std::uint32_t region = 0; ///< row by row
    std::uint8_t value = 255; ///< finest mip that was sampled; 255: none
};

/// The same of any texture: what a resolve on the GPU lists.
struct TextureRegionChange {
    ManagedTextureId texture;
    std::uint32_t region = 0;
    std::uint8_t value = 255;
};

/// Slot `slot` of the heap that was added as `heap`.
struct TileSlot {
    std::uint32_t heap = 0;
    std::uint32_t slot = 0;

    friend constexpr bool operator==(const TileSlot&, const TileSlot&) noexcept = default;
};

/// The tile leaves its slot: shaders must not read it any more.
struct TileUnmapOrder {
    ManagedTextureId texture;
    std::uint32_t tile = 0;
    TileSlot from;
};

/// The tile's data are to be copied to another slot, and its mapping to follow: then Confirm. It stays
/// readable where it is until then.
struct TileMoveOrder {
    ManagedTextureId texture;
    std::uint32_t tile = 0;
    TileSlot from;
    TileSlot to;
    std::uint32_t ticket = 0; ///< tells a confirmation from one of an earlier order
};

/// The tile's data are to be loaded into a slot: then Confirm.
struct TileMapOrder {
    ManagedTextureId texture;
    std::uint32_t tile = 0;
    TileSlot to;
    std::uint32_t ticket = 0;
};

/// Orders of all textures, to be carried out in this order: unmaps, moves, maps. (A slot that a map fills may
/// be one that an unmap gave up.)
struct TileOrders {
    std::span<const TileUnmapOrder> unmaps;
    std::span<const TileMoveOrder> moves;
    std::span<const TileMapOrder> maps;
};

/// What became of confirmations. Stale ones change nothing: their order was not fetched yet, confirmed
/// before,
/// or its texture or tile went away.
struct TileConfirmations {
    std::uint32_t confirmed = 0;
    std::uint32_t stale = 0;
};

/// A byte of a residency map that changed.
struct ResidencyChange {
    ManagedTextureId texture;
    std::uint32_t entry = 0; ///< row by row
    std::uint8_t value = 255;
};

struct TileManagerStatistics {
    std::uint32_t textures = 0;
    std::uint32_t heaps = 0;
    std::uint64_t tiles = 0;       ///< of all textures
    std::uint64_t pinnedTiles = 0; ///< those of tails: slots below this number leave textures without any mip
    std::uint64_t wantedTiles = 0; ///< tails included
    std::uint64_t requestedTiles = 0;
    std::uint64_t allocatedTiles = 0; ///< in state Allocated
    std::uint64_t mappedTiles = 0;    ///< in state Mapped
    std::uint64_t standbyTiles = 0;
    std::uint64_t movingTiles = 0; ///< these have two slots
    std::uint64_t slots = 0;
    std::uint64_t usedSlots = 0;
    std::uint64_t freeSlots = 0;
    // Since creation:
    std::uint64_t mapOrders = 0;
    std::uint64_t unmapOrders = 0; ///< = evictions
    std::uint64_t moveOrders = 0;
    std::uint64_t cancelledRequests = 0; ///< not wanted any more before there was a slot
    std::uint64_t restoredTiles = 0;     ///< wanted again while in standby: no order, no load
    std::uint64_t thrashedTiles = 0;     ///< see TileManagerDesc::thrashWindow
    std::uint64_t staleConfirmations = 0;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
