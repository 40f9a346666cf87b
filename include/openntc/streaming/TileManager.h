// SPDX-License-Identifier: MIT
// Stability: experimental
// Decides which tiles of many textures are resident: takes feedback, gives out orders to unmap, move and load
// tiles, and says what shaders may read. Bookkeeping only: it knows no GPU object, loads nothing, and its
// budget is the heaps that it is given. docs/streaming.md has a whole frame.
//
//   auto manager = TileManager::Create({.tilesPerHeap = 256});
//   auto id = manager->AddTexture(layout);                                  // its tail is requested at once
//   every frame:
//     manager->UpdateWithSamplerFeedback(maps, {.time = t, .timeout = 1.0});  // {id, bytes} that came back
//     while (manager->GetHeapCount() < manager->GetNumDesiredHeaps()) manager->AddHeap(nextHeap++);
//     manager->TrimStandbyTiles(); manager->AllocateRequestedTiles();
//     TileOrders orders = manager->FetchOrders();       // unmap, copy, load; when the data are there:
//     manager->ConfirmOrders(orders.maps);
//     for (ResidencyChange change : *manager->FetchResidencyChanges()) …     // what shaders may read now
//
// Costs: an update compares the bytes with those before and goes on with what differs; every allocation,
// eviction, expiry and confirmation costs the same however many tiles, textures and heaps there are. Not for
// several threads at once. Every failed call has changed nothing, but for TrimStandbyTiles,
// AllocateRequestedTiles and DefragmentTiles, which without memory stop between two tiles.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/streaming/TileLayout.h"
#include "openntc/streaming/TileManagerTypes.h"
#include "openntc/streaming/detail/TextureBooks.h"
#include "openntc/streaming/detail/TileBooksCheck.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

class TileManager {
public:
    static constexpr std::uint32_t kMaxTilesPerHeap = 1u << 20;

    /// Errors: OutOfRange for a heap size outside 1 … kMaxTilesPerHeap.
    static Expected<TileManager> Create(const TileManagerDesc& desc = {},
                                        Allocator& allocator = GetDefaultAllocator()) noexcept;

    TileManager(TileManager&&) noexcept = default;
    TileManager& operator=(TileManager&&) noexcept = default;

    /// How many tiles that nobody wants keep their slots in case they are wanted again.
    void SetStandbyTarget(std::uint32_t tiles) noexcept { books_.standbyTarget = tiles; }

    // ---------------------------------------------------------------------------------------------- textures
    /// Registers a texture and requests its tail; without a tail the coarsest level takes its part. These
    /// tiles are never given up. Errors: OutOfRange with 2^32 - 1 textures or 2^31 tiles; OutOfMemory.
    Expected<ManagedTextureId> AddTexture(const TileLayout& layout) noexcept {
        return books_.AddTexture(layout);
    }

    /// Gives the slots back and drops everything about the texture, orders not fetched included: no unmap
    /// orders are made. Errors: InvalidArgument for a texture that is not registered (as everywhere below).
    Expected<void> RemoveTexture(ManagedTextureId texture) noexcept {
        OPENNTC_CHECK(books_.CheckTexture(texture));
        books_.RemoveTexture(texture.index);
        return {};
    }

    /// Sizes and regions. Valid until the texture is removed.
    Expected<const TileLayout*> GetLayout(ManagedTextureId texture) const noexcept;

    // ----------------------------------------------------------------------------------------------- updates
    /// Takes a texture's whole map of feedback: a byte per region, row by row, the finest mip that was
    /// sampled
    /// there or 255. An empty span: nothing was. Tiles that overlap a region, of its level and all coarser
    /// ones, are wanted from now on; others go to standby after the timeout, or are not requested any more. A
    /// texture whose feedback did not come back is not updated; it keeps what it has. Errors: InvalidArgument
    /// for a map of another size, a time that is not finite, a negative timeout or number of mips.
    Expected<void> UpdateWithSamplerFeedback(ManagedTextureId texture, std::span<const std::uint8_t> feedback,
                                             const TileUpdateOptions& options) noexcept;

    /// An update of each of these textures, with the same outcome as one after the other; what it reads of
    /// many textures is asked of memory at once (docs/benchmarks says what that gains). Errors: as there.
    Expected<void> UpdateWithSamplerFeedback(std::span<const TextureFeedback> maps,
                                             const TileUpdateOptions& options) noexcept;

    /// The same as with the whole map, of which these bytes changed. Errors: besides, OutOfRange for a region
    /// that does not exist; InvalidState for a texture that follows another and has no map of its own.
    Expected<void> UpdateWithRegionChanges(ManagedTextureId texture, std::span<const RegionChange> changes,
                                           const TileUpdateOptions& options) noexcept;

    /// An update of every texture, of whose maps these bytes changed. Bias and streamed mips stay those of
    /// the last update of each. Costs: the changes, and the textures with tiles that idle.
    Expected<void> UpdateAllWithRegionChanges(std::span<const TextureRegionChange> changes, double time,
                                              double timeout) noexcept;

    /// An update of `follower` that wants the same part and detail as the last update of `primary`: for two
    /// textures that are sampled together. Where the follower is larger, level 0 of the primary asks for
    /// level
    /// 0: record feedback in the largest of the group and nothing is lost. Costs nothing to speak of unless
    /// the
    /// primary's wanted tiles changed, else all tiles of both.
    Expected<void> MatchPrimaryTexture(ManagedTextureId primary, ManagedTextureId follower, double time,
                                       double timeout) noexcept;

    // ------------------------------------------------------------------------------------------------- heaps
    /// Heaps that hold all wanted tiles and the standby target. Tiles that idle but have not expired are not
    /// in it: short of heaps, requests wait for them.
    std::uint64_t GetNumDesiredHeaps() const noexcept {
        return GetHeapsFor(books_.wantedTiles + books_.standbyTarget);
    }
    /// The same with the tiles that idle: nothing waits.
    std::uint64_t GetNumDesiredHeapsWithIdle() const noexcept {
        return GetHeapsFor(books_.tailRequests.size() + books_.requests.size() + books_.allocatedTiles +
                           books_.mappedTiles + books_.standbyTarget);
    }
    std::uint32_t GetHeapCount() const noexcept { return books_.pool.GetHeapCount(); }

    /// Adds tilesPerHeap slots. Heaps are used in the order in which they were added. Errors: InvalidArgument
    /// for an identifier that is in use; OutOfRange with 2^20 heaps or 2^32 - 2 slots; OutOfMemory.
    Expected<void> AddHeap(std::uint32_t heap) noexcept { return books_.pool.AddHeap(heap); }
    /// Errors: InvalidArgument for an unknown identifier; InvalidState while a tile is in it.
    Expected<void> RemoveHeap(std::uint32_t heap) noexcept { return books_.pool.RemoveHeap(heap); }
    /// Used slots of a heap. Errors: InvalidArgument for an unknown identifier.
    Expected<std::uint32_t> GetHeapUse(std::uint32_t heap) const noexcept;
    /// Replaces `heaps` by the identifiers of the heaps without tiles. Errors: OutOfMemory.
    Expected<void> GetEmptyHeaps(Array<std::uint32_t>& heaps) const noexcept;

    // ----------------------------------------------------------------------------------------------- orders
    /// Evicts the tiles that have been in standby longest, down to the target. Errors: OutOfMemory.
    Expected<void> TrimStandbyTiles() noexcept { return books_.TrimStandby(); }
    /// Gives slots to requested tiles: tails first, then the oldest request, a coarser tile before a finer
    /// one that overlaps it. Without a free slot, evicts from standby; without that, the rest waits. Errors:
    /// OutOfMemory.
    Expected<void> AllocateRequestedTiles() noexcept { return books_.AllocateRequested(); }
    /// Moves up to `count` tiles from the heap that was added last into free slots of earlier ones, so that
    /// heaps become empty. They stay readable, and in their state, meanwhile. Returns the moves that were
    /// ordered. Errors: OutOfMemory.
    Expected<std::uint32_t> DefragmentTiles(std::uint32_t count) noexcept { return books_.Defragment(count); }
    /// True for tiles that defragmentation may take: not in a tail, mapped or in standby, not moving yet.
    /// Errors: OutOfRange for a tile that the texture does not have.
    Expected<bool> IsMovableTile(ManagedTextureId texture, std::uint32_t tile) const noexcept;

    /// Hands out all orders since the last call; they wait here until then. The spans are valid until the
    /// next
    /// call.
    TileOrders FetchOrders() noexcept { return books_.FetchOrders(); }

    /// The data of these tiles are in their slots, and shaders will find them there: they become mapped. May
    /// come late, doubled and in any order; what does not fit its order any more changes nothing and is
    /// counted.
    TileConfirmations ConfirmOrders(std::span<const TileMapOrder> orders) noexcept {
        return ConfirmEach(orders);
    }
    /// The copies of these are done, and shaders find them there: the old slots are free.
    TileConfirmations ConfirmOrders(std::span<const TileMoveOrder> orders) noexcept {
        return ConfirmEach(orders);
    }
    /// As for maps, by tile alone: does not tell a late confirmation of an earlier order. Of a texture
    /// removed
    /// meanwhile all are stale. Errors: InvalidArgument for a texture that never was; OutOfRange for a tile
    /// that the texture does not have, and then nothing is confirmed.
    Expected<TileConfirmations> UpdateTilesMapping(ManagedTextureId texture,
                                                   std::span<const std::uint32_t> tiles) noexcept;

    // --------------------------------------------------------------------------------------------- residency
    /// The residency map: a byte per tile of level 0 (one if all is tail), row by row: the finest mip such
    /// that every tile over that place, at its level and all coarser ones, is mapped or in standby, and the
    /// tail is mapped; 255: not even the tail. Shaders that clamp to it find every nearest texel; filters
    /// that reach across a tile's edge clamp to the maximum of the entries around. Valid until the texture is
    /// removed; changes with every call.
    Expected<std::span<const std::uint8_t>> GetResidencyMap(ManagedTextureId texture) const noexcept;
    /// Copies the map. Errors: InvalidArgument for a span of another size.
    Expected<void> WriteMinMipData(ManagedTextureId texture, std::span<std::uint8_t> map) const noexcept;
    /// The bytes of all maps that changed since the last call; maps begin with 255 everywhere. Valid until
    /// the
    /// next call. Errors: OutOfMemory; what was not handed out comes next time.
    Expected<std::span<const ResidencyChange>> FetchResidencyChanges() noexcept {
        return books_.FetchChanges();
    }

    // ------------------------------------------------------------------------------------------------
    // looking
    /// Errors: OutOfRange for a tile that the texture does not have.
    Expected<ManagedTileState> GetTileState(ManagedTextureId texture, std::uint32_t tile) const noexcept;
    Expected<bool> IsTileWanted(ManagedTextureId texture, std::uint32_t tile) const noexcept;
    /// Where an allocated, mapped or standby tile is. Errors: InvalidState for other tiles.
    Expected<TileSlot> GetTileSlot(ManagedTextureId texture, std::uint32_t tile) const noexcept;
    TileManagerStatistics GetStatistics() const noexcept { return books_.GetStatistics(); }

    /// Recounts everything and compares: for tests and for engines that suspect their memory. Errors:
    /// InternalError names what does not hold; OutOfMemory. Costs: all tiles and slots.
    Expected<void> CheckInvariants() const noexcept { return detail::CheckTileBooks(books_); }

private:
    TileManager(const TileManagerDesc& desc, Allocator& allocator) noexcept : books_(desc, allocator) {}

    template <typename Order>
    TileConfirmations ConfirmEach(std::span<const Order> orders) noexcept;
    std::uint64_t GetHeapsFor(std::uint64_t tiles) const noexcept {
        const std::uint32_t slots = books_.pool.GetSlotsPerHeap();
        return (tiles + slots - 1) / slots;
    }
    const detail::ManagedTexture& GetTexture(ManagedTextureId texture) const noexcept {
        return books_.textures[texture.index];
    }

    detail::TextureBooks books_;
};

inline Expected<TileManager> TileManager::Create(const TileManagerDesc& desc, Allocator& allocator) noexcept {
    if (desc.tilesPerHeap < 1 || desc.tilesPerHeap > kMaxTilesPerHeap)
        return Fail(Status::OutOfRange, "tilesPerHeap: %u: must be 1 … %u", desc.tilesPerHeap,
                    kMaxTilesPerHeap);
    return TileManager(desc, allocator);
}

inline Expected<const TileLayout*> TileManager::GetLayout(ManagedTextureId texture) const noexcept {
    OPENNTC_CHECK(books_.CheckTexture(texture));
    return &GetTexture(texture).shape->layout;
}

inline Expected<void> TileManager::UpdateWithSamplerFeedback(ManagedTextureId texture,
                                                             std::span<const std::uint8_t> feedback,
                                                             const TileUpdateOptions& options) noexcept {
    OPENNTC_CHECK(books_.CheckFeedback(texture, feedback));
    OPENNTC_CHECK(books_.CheckTimes(options.time, options.timeout, options.streamedMips));
    if (GetTexture(texture).shape->levels > 0)
        books_.UpdateOne(texture.index, feedback.empty() ? nullptr : feedback.data(), options);
    return {};
}

inline Expected<void> TileManager::UpdateWithSamplerFeedback(std::span<const TextureFeedback> maps,
                                                             const TileUpdateOptions& options) noexcept {
    OPENNTC_CHECK(books_.CheckTimes(options.time, options.timeout, options.streamedMips));
    for (const TextureFeedback& of : maps)
        OPENNTC_CHECK(books_.CheckFeedback(of.texture, of.map));
    books_.UpdateMany(maps, options);
    return {};
}

inline Expected<void> TileManager::UpdateWithRegionChanges(ManagedTextureId texture,
                                                           std::span<const RegionChange> changes,
                                                           const TileUpdateOptions& options) noexcept {
    OPENNTC_CHECK(books_.CheckMap(texture));
    OPENNTC_CHECK(books_.CheckTimes(options.time, options.timeout, options.streamedMips));
    for (const RegionChange& change : changes)
        OPENNTC_CHECK(books_.CheckRegion(texture, change.region));
    if (GetTexture(texture).shape->levels == 0)
        return {};
    books_.ApplySettings(texture.index, options.bias, options.streamedMips);
    for (const RegionChange& change : changes)
        books_.SetRegion(texture.index, change.region, change.value);
    books_.FinishOne(texture.index, options.time, options.timeout);
    return {};
}

inline Expected<void> TileManager::UpdateAllWithRegionChanges(std::span<const TextureRegionChange> changes,
                                                              double time, double timeout) noexcept {
    OPENNTC_CHECK(books_.CheckTimes(time, timeout));
    for (const TextureRegionChange& change : changes) {
        OPENNTC_CHECK(books_.CheckMap(change.texture));
        OPENNTC_CHECK(books_.CheckRegion(change.texture, change.region));
    }
    for (const TextureRegionChange& change : changes)
        books_.SetRegion(change.texture.index, change.region, change.value);
    books_.FinishAll(time, timeout);
    return {};
}

inline Expected<void> TileManager::MatchPrimaryTexture(ManagedTextureId primary, ManagedTextureId follower,
                                                       double time, double timeout) noexcept {
    OPENNTC_CHECK(books_.CheckTexture(primary));
    OPENNTC_CHECK(books_.CheckTexture(follower));
    OPENNTC_CHECK(books_.CheckTimes(time, timeout));
    if (primary == follower)
        return Fail(Status::InvalidArgument, "follower: index %u: is the primary", follower.index);
    const detail::ManagedTexture& texture = GetTexture(follower);
    if (texture.shape->levels == 0)
        return {};
    if (!texture.isFollowing || texture.state->primary != primary ||
        texture.state->primaryVersion != GetTexture(primary).state->wantedVersion)
        books_.SetWantedFrom(primary.index, follower.index);
    books_.FinishOne(follower.index, time, timeout);
    return {};
}

inline Expected<std::uint32_t> TileManager::GetHeapUse(std::uint32_t heap) const noexcept {
    const std::uint32_t number = books_.pool.FindHeap(heap);
    if (number == detail::kNoIndex)
        return Fail(Status::InvalidArgument, "heap: %u: was not added", heap);
    return books_.pool.GetHeaps()[number].used;
}

inline Expected<void> TileManager::GetEmptyHeaps(Array<std::uint32_t>& heaps) const noexcept {
    heaps.clear();
    OPENNTC_CHECK(heaps.Reserve(books_.pool.GetHeapCount()));
    for (const std::uint32_t number : books_.pool.GetOrders()) {
        if (number != detail::kNoIndex && books_.pool.GetHeaps()[number].used == 0)
            OPENNTC_CHECK(heaps.PushBack(books_.pool.GetHeaps()[number].id));
    }
    return {};
}

inline Expected<bool> TileManager::IsMovableTile(ManagedTextureId texture,
                                                 std::uint32_t tile) const noexcept {
    OPENNTC_CHECK(books_.CheckTile(texture, tile));
    return books_.IsMovable(GetTexture(texture), tile);
}

template <typename Order>
TileConfirmations TileManager::ConfirmEach(std::span<const Order> orders) noexcept {
    TileConfirmations result;
    for (std::size_t i = 0; i < orders.size(); ++i) {
        if (orders.size() - i > 8)
            books_.PrefetchTile(orders[i + 8].texture.index, orders[i + 8].tile);
        ++(books_.Confirm(orders[i]) ? result.confirmed : result.stale);
    }
    books_.totals.staleConfirmations += result.stale;
    return result;
}

inline Expected<TileConfirmations>
TileManager::UpdateTilesMapping(ManagedTextureId texture, std::span<const std::uint32_t> tiles) noexcept {
    TileConfirmations result;
    if (books_.WasRemoved(texture)) {
        result.stale = static_cast<std::uint32_t>(tiles.size());
    } else {
        OPENNTC_CHECK(books_.CheckTexture(texture));
        for (const std::uint32_t tile : tiles)
            OPENNTC_CHECK(books_.CheckTile(texture, tile));
        for (const std::uint32_t tile : tiles)
            ++(books_.ConfirmTile(texture.index, tile) ? result.confirmed : result.stale);
    }
    books_.totals.staleConfirmations += result.stale;
    return result;
}

inline Expected<std::span<const std::uint8_t>>
TileManager::GetResidencyMap(ManagedTextureId texture) const noexcept {
    OPENNTC_CHECK(books_.CheckTexture(texture));
    return std::span<const std::uint8_t>(GetTexture(texture).residency,
                                         GetTexture(texture).GetResidencyBytes());
}

inline Expected<void> TileManager::WriteMinMipData(ManagedTextureId texture,
                                                   std::span<std::uint8_t> map) const noexcept {
    OPENNTC_CHECK(books_.CheckTexture(texture));
    if (map.size() != GetTexture(texture).GetResidencyBytes())
        return Fail(Status::InvalidArgument, "map: %zu bytes: the texture's has %u", map.size(),
                    GetTexture(texture).GetResidencyBytes());
    std::memcpy(map.data(), GetTexture(texture).residency, map.size());
    return {};
}

inline Expected<ManagedTileState> TileManager::GetTileState(ManagedTextureId texture,
                                                            std::uint32_t tile) const noexcept {
    OPENNTC_CHECK(books_.CheckTile(texture, tile));
    return detail::GetState(GetTexture(texture).tiles[tile].word);
}

inline Expected<bool> TileManager::IsTileWanted(ManagedTextureId texture, std::uint32_t tile) const noexcept {
    OPENNTC_CHECK(books_.CheckTile(texture, tile));
    return (GetTexture(texture).tiles[tile].word & detail::tile_word::kWanted) != 0;
}

inline Expected<TileSlot> TileManager::GetTileSlot(ManagedTextureId texture,
                                                   std::uint32_t tile) const noexcept {
    OPENNTC_CHECK(books_.CheckTile(texture, tile));
    const ManagedTileState state = detail::GetState(GetTexture(texture).tiles[tile].word);
    if (state == ManagedTileState::Free || state == ManagedTileState::Requested)
        return Fail(Status::InvalidState, "tile: %u: has no slot", tile);
    return books_.GetSlotOf(GetTexture(texture).tiles[tile].place);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
