// SPDX-License-Identifier: MIT
// Stability: internal
// Textures come and go; what callers pass is checked; what they fetch is put together.
#pragma once

#include "openntc/streaming/detail/GroupBooks.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct TextureBooks : GroupBooks {
    using GroupBooks::GroupBooks;

    static constexpr std::uint64_t kMaxTilesOfAll = std::uint64_t{1} << 31;

    // ------------------------------------------------------------------------------------------ come and go
    Expected<ManagedTextureId> AddTexture(const TileLayout& layout) noexcept {
        if (tileCount + static_cast<std::uint64_t>(layout.GetTileCount()) > kMaxTilesOfAll ||
            textures.size() >= kNoIndex - 1)
            return Fail(Status::OutOfRange, "tiles: %llu with this texture: at most %llu",
                        static_cast<unsigned long long>(tileCount) +
                            static_cast<unsigned long long>(layout.GetTileCount()),
                        static_cast<unsigned long long>(kMaxTilesOfAll));
        ManagedTexture texture;
        Array<std::uint64_t> block(*allocator);
        OPENNTC_ASSIGN(texture.shape, shapes.Acquire(layout));
        const bool isNew = freeIndices.empty();
        const std::uint32_t index = isNew ? static_cast<std::uint32_t>(textures.size()) : freeIndices.back();
        if (Expected<void> reserved = ReserveFor(texture, block, textures.size() + 1); !reserved) {
            shapes.Release(texture.shape);
            return PassError(reserved);
        }
        texture.generation = isNew ? 1 : textures[index].generation;
        if (isNew) {
            (void)textures.PushBack(texture); // there is room
            (void)blocks.PushBack(std::move(block));
        } else {
            freeIndices.pop_back();
            textures[index] = texture;
            blocks[index] = std::move(block);
        }
        ++textureCount;
        tileCount += textures[index].GetTileCount();
        PinTiles(index);
        return GetId(index);
    }

    void RemoveTexture(std::uint32_t index) noexcept {
        ManagedTexture& texture = textures[index];
        for (std::uint32_t tile = 0; tile < texture.GetTileCount(); ++tile) {
            const std::uint32_t word = texture.tiles[tile].word;
            const std::uint32_t place = texture.tiles[tile].place;
            switch (GetState(word)) {
            case ManagedTileState::Free:
                continue;
            case ManagedTileState::Requested:
                GetQueueOf(word).Remove(place);
                continue;
            case ManagedTileState::Allocated:
                --allocatedTiles;
                break;
            case ManagedTileState::Mapped:
                --mappedTiles;
                break;
            case ManagedTileState::Standby:
                --standbyTiles;
                pool.Unlink(standby, place);
                break;
            }
            ReleaseSlots(place);
        }
        hasStaleOrders = true;
        ForgetIdle(index);
        ForgetDirty(index);
        --textureCount;
        tileCount -= texture.GetTileCount();
        pinnedTiles -= static_cast<std::uint64_t>(texture.shape->GetPinnedTileCount());
        wantedTiles -= texture.state->wanted;
        shapes.Release(texture.shape);
        ManagedTexture empty;
        empty.generation = texture.generation + 1;
        texture = empty;
        blocks[index] = Array<std::uint64_t>(*allocator);
        (void)freeIndices.PushBack(index); // room was reserved when the texture was added
    }

    // -------------------------------------------------------------------------------------------- what is
    // asked
    TileOrders FetchOrders() noexcept {
        DropStaleOrders();
        std::swap(unmaps, fetchedUnmaps);
        std::swap(moves, fetchedMoves);
        std::swap(maps, fetchedMaps);
        unmaps.clear();
        moves.clear();
        maps.clear();
        fetchedTicket = nextTicket;
        return {fetchedUnmaps.AsSpan(), fetchedMoves.AsSpan(), fetchedMaps.AsSpan()};
    }

    /// Any numbers will do.
    void PrefetchTile(std::uint32_t index, std::uint32_t tile) const noexcept {
        if (index < textures.size() && textures[index].shape != nullptr &&
            tile < textures[index].GetTileCount())
            Prefetch(&textures[index].tiles[tile]);
    }

    bool Confirm(const TileMapOrder& order) noexcept {
        if (!IsRegistered(order.texture) || order.tile >= textures[order.texture.index].GetTileCount())
            return false;
        const ManagedTexture& texture = textures[order.texture.index];
        return GetState(texture.tiles[order.tile].word) == ManagedTileState::Allocated &&
               pool[texture.tiles[order.tile].place].ticket == order.ticket &&
               ConfirmTile(order.texture.index, order.tile);
    }

    bool Confirm(const TileMoveOrder& order) noexcept {
        const std::uint32_t from = FindMove(order);
        if (from == kNoIndex || !IsFetched(order.ticket))
            return false;
        ConfirmMove(from);
        return true;
    }

    /// Compares the maps that changed with what the caller knows of them. Errors: OutOfMemory.
    Expected<std::span<const ResidencyChange>> FetchChanges() noexcept {
        residencyChanges.clear();
        while (!dirtyTextures.empty()) {
            const std::uint32_t index = dirtyTextures.back();
            ManagedTexture& texture = textures[index];
            const TileRect& dirty = texture.state->dirty;
            const int width = texture.shape->layout.GetResidencyWidth();
            const std::size_t entries = static_cast<std::size_t>(dirty.right - dirty.left + 1) *
                                        static_cast<std::size_t>(dirty.bottom - dirty.top + 1);
            // Nothing of this texture, or all of it: what was handed out is handed out.
            if (const std::size_t room = residencyChanges.size() + entries;
                !residencyChanges.Reserve(std::bit_ceil(room))) {
                if (residencyChanges.empty())
                    return Fail(Status::OutOfMemory, "residency: %zu changes: refused by the allocator",
                                room);
                break;
            }
            for (int y = dirty.top; y <= dirty.bottom; ++y) {
                for (int x = dirty.left; x <= dirty.right; ++x) {
                    const auto entry = static_cast<std::uint32_t>(y * width + x);
                    const std::uint8_t value = texture.residency[entry];
                    if (texture.GetSent()[entry] == value)
                        continue;
                    texture.GetSent()[entry] = value;
                    (void)residencyChanges.PushBack({GetId(index), entry, value}); // there is room
                }
            }
            ForgetDirty(index);
        }
        return std::span<const ResidencyChange>(residencyChanges.AsSpan());
    }

    TileManagerStatistics GetStatistics() const noexcept {
        TileManagerStatistics result = totals;
        result.textures = textureCount;
        result.heaps = pool.GetHeapCount();
        result.tiles = tileCount;
        result.pinnedTiles = pinnedTiles;
        result.wantedTiles = wantedTiles;
        result.requestedTiles = tailRequests.size() + requests.size();
        result.allocatedTiles = allocatedTiles;
        result.mappedTiles = mappedTiles;
        result.standbyTiles = standbyTiles;
        result.movingTiles = movingTiles;
        result.slots = pool.GetLiveSlots();
        result.usedSlots = pool.GetUsedSlots();
        result.freeSlots = result.slots - result.usedSlots;
        return result;
    }

    // -------------------------------------------------------------------------------------------------
    // checks
    Expected<void> CheckTexture(ManagedTextureId texture) const noexcept {
        if (!IsRegistered(texture))
            return Fail(Status::InvalidArgument, "texture: index %u, generation %u: is not registered",
                        texture.index, texture.generation);
        return {};
    }

    Expected<void> CheckTile(ManagedTextureId texture, std::uint32_t tile) const noexcept {
        OPENNTC_CHECK(CheckTexture(texture));
        const std::uint32_t count = textures[texture.index].GetTileCount();
        if (tile >= count)
            return Fail(Status::OutOfRange, "tile: %u: must be 0 … %u", tile, count - 1);
        return {};
    }

    /// The texture has a map of feedback that can change.
    Expected<void> CheckMap(ManagedTextureId texture) const noexcept {
        OPENNTC_CHECK(CheckTexture(texture));
        if (textures[texture.index].isFollowing)
            return Fail(Status::InvalidState,
                        "texture: index %u: follows another: give it a whole map of feedback first",
                        texture.index);
        return {};
    }

    Expected<void> CheckRegion(ManagedTextureId texture, std::uint32_t region) const noexcept {
        const std::uint32_t count = textures[texture.index].GetRegionCount();
        if (region >= count)
            return Fail(Status::OutOfRange, "region: %u: must be 0 … %u", region, count - 1);
        return {};
    }

    Expected<void> CheckFeedback(ManagedTextureId texture, std::span<const std::uint8_t> map) const noexcept {
        OPENNTC_CHECK(CheckTexture(texture));
        const std::uint32_t count = textures[texture.index].GetRegionCount();
        if (!map.empty() && map.size() != count)
            return Fail(Status::InvalidArgument, "feedback: %zu bytes: the texture has %u regions",
                        map.size(), count);
        return {};
    }

    static Expected<void> CheckTimes(double time, double timeout, int streamedMips = 0) noexcept {
        if (!std::isfinite(time))
            return Fail(Status::InvalidArgument, "time: %g: must be finite", time);
        if (!(timeout >= 0))
            return Fail(Status::InvalidArgument, "timeout: %g: must be 0 or more", timeout);
        if (streamedMips < 0)
            return Fail(Status::InvalidArgument, "streamedMips: %d: must be 0 or more", streamedMips);
        return {};
    }

private:
    /// All memory that later calls could need for this texture but for orders and changes to be fetched, so
    /// that they cannot fail half way. Errors: OutOfMemory; nothing that counts has changed then.
    Expected<void> ReserveFor(ManagedTexture& texture, Array<std::uint64_t>& block,
                              std::size_t count) noexcept {
        OPENNTC_CHECK(texture.AllocateArrays(block));
        const std::size_t room = std::bit_ceil(count);
        OPENNTC_CHECK(textures.Reserve(room));
        OPENNTC_CHECK(blocks.Reserve(room));
        OPENNTC_CHECK(freeIndices.Reserve(room));
        OPENNTC_CHECK(idleTextures.Reserve(room));
        OPENNTC_CHECK(dirtyTextures.Reserve(room));
        const std::uint32_t own = texture.GetTileCount();
        if (own > expired.size())
            OPENNTC_CHECK(expired.Resize(own));
        const auto all = static_cast<std::size_t>(tileCount + own);
        if (all > touched.size())
            OPENNTC_CHECK(touched.Resize(std::bit_ceil(all)));
        OPENNTC_CHECK(requests.Reserve(all, GetPlaceSetter()));
        return tailRequests.Reserve(static_cast<std::size_t>(pinnedTiles) +
                                        static_cast<std::size_t>(texture.shape->GetPinnedTileCount()),
                                    GetPlaceSetter());
    }

    void PinTiles(std::uint32_t index) noexcept {
        ManagedTexture& texture = textures[index];
        const auto first = static_cast<std::uint32_t>(texture.shape->GetFirstPinnedTile());
        const auto count = static_cast<std::uint32_t>(texture.shape->GetPinnedTileCount());
        texture.state->pinnedMissing = count;
        texture.state->wanted = count;
        wantedTiles += count;
        pinnedTiles += count;
        for (std::uint32_t tile = first; tile < first + count; ++tile) {
            texture.tiles[tile].word |= tile_word::kPinned | tile_word::kWanted;
            Request(index, tile);
        }
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
