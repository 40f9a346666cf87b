// SPDX-License-Identifier: MIT
// The half of the model that follows what the manager chose: evictions, allocations, moves, orders; and the
// comparison of everything.
#include "TileModel.h"

#include <algorithm>
#include <set>

namespace openntc_tests {

using namespace openntc;

void TileModel::Evict(ModelTexture& texture, std::uint32_t number) {
    ModelTile& tile = texture.tiles[number];
    unmaps_.push_back({texture.id, number, {tile.slot.first, tile.slot.second}});
    tile.state = ManagedTileState::Free;
    tile.isMoving = false;
}

/// The oldest went; of those that went to standby together, none before a finer one that overlaps it.
void TileModel::CheckEvicted(const std::vector<std::pair<ModelTexture*, std::uint32_t>>& evicted) {
    for (const auto& [texture, number] : evicted) {
        const ModelTile& gone = texture->tiles[number];
        for (ModelTexture& other : textures_) {
            for (std::size_t i = 0; i < other.tiles.size(); ++i) {
                const ModelTile& stays = other.tiles[i];
                const std::pair<ModelTexture*, std::uint32_t> entry = {&other, static_cast<std::uint32_t>(i)};
                if (stays.state != ManagedTileState::Standby ||
                    std::find(evicted.begin(), evicted.end(), entry) != evicted.end())
                    continue;
                Expect(stays.inStandby >= gone.inStandby, "an older tile stayed in standby");
                const std::vector<int>& related =
                    other.related.size() > i ? other.related[i] : std::vector<int>();
                if (&other == texture && stays.inStandby == gone.inStandby && stays.level < gone.level)
                    Expect(std::find(related.begin(), related.end(), static_cast<int>(number)) ==
                               related.end(),
                           "a tile was evicted before a finer one below it");
            }
        }
    }
}

std::uint32_t TileModel::FollowEvictions() {
    std::vector<std::pair<ModelTexture*, std::uint32_t>> evicted;
    for (ModelTexture& texture : textures_) {
        for (std::uint32_t i = 0; i < texture.tiles.size(); ++i) {
            const auto state = manager_.GetTileState(texture.id, i);
            if (state && texture.tiles[i].state == ManagedTileState::Standby &&
                *state == ManagedTileState::Free)
                evicted.emplace_back(&texture, i);
        }
    }
    CheckEvicted(evicted);
    for (const auto& [texture, number] : evicted)
        Evict(*texture, number);
    return static_cast<std::uint32_t>(evicted.size());
}

void TileModel::Trim() {
    ++operation_;
    const std::uint64_t before = Count(ManagedTileState::Standby);
    Expect(manager_.TrimStandbyTiles().has_value(), "trimming");
    const std::uint32_t evicted = FollowEvictions();
    Expect(evicted == (before > standbyTarget_ ? before - standbyTarget_ : 0), "number of tiles trimmed");
}

/// No request was passed over, but for tails and for coarser tiles above an older request; and no tile was
/// served while a coarser one above it waits.
void TileModel::CheckServed(const std::vector<std::pair<ModelTexture*, std::uint32_t>>& served) {
    for (const auto& [texture, number] : served) {
        const ModelTile& tile = texture->tiles[number];
        for (const ModelTexture& other : textures_) {
            for (const ModelTile& waits : other.tiles) {
                if (waits.state != ManagedTileState::Requested)
                    continue;
                const bool isAbove =
                    &other == texture && waits.level > tile.level &&
                    (waits.isPinned ||
                     std::find(texture->related[number].begin(), texture->related[number].end(),
                               static_cast<int>(&waits - other.tiles.data())) !=
                         texture->related[number].end());
                Expect(!isAbove, "a tile was served before a coarser one above it");
                if (tile.isPinned)
                    continue;
                Expect(!waits.isPinned, "a tile was served before a tail");
                long oldestBelow = tile.requested; // of the requests that had to wait for this tile
                for (const auto& [otherTexture, below] : served) {
                    const std::vector<int>* related =
                        below < otherTexture->related.size() ? &otherTexture->related[below] : nullptr;
                    if (otherTexture == texture && related != nullptr &&
                        std::find(related->begin(), related->end(), static_cast<int>(number)) !=
                            related->end())
                        oldestBelow = std::min(oldestBelow, otherTexture->tiles[below].requested);
                }
                for (std::size_t i = 0; i < texture->related.size(); ++i) {
                    const ModelTile& below = texture->tiles[i];
                    if (below.state == ManagedTileState::Requested &&
                        std::find(texture->related[i].begin(), texture->related[i].end(),
                                  static_cast<int>(number)) != texture->related[i].end())
                        oldestBelow = std::min(oldestBelow, below.requested);
                }
                Expect(waits.requested >= oldestBelow, "an older request was passed over");
            }
        }
    }
}

void TileModel::Allocate() {
    ++operation_;
    Expect(manager_.AllocateRequestedTiles().has_value(), "allocation");
    const std::uint32_t evicted = FollowEvictions();
    std::vector<std::pair<ModelTexture*, std::uint32_t>> served;
    for (ModelTexture& texture : textures_) {
        for (std::uint32_t i = 0; i < texture.tiles.size(); ++i) {
            ModelTile& tile = texture.tiles[i];
            const auto state = manager_.GetTileState(texture.id, i);
            if (!state || tile.state != ManagedTileState::Requested || *state != ManagedTileState::Allocated)
                continue;
            const auto slot = manager_.GetTileSlot(texture.id, i);
            Expect(slot.has_value(), "allocated tile without a slot");
            if (slot)
                tile.slot = {slot->heap, slot->slot};
            tile.state = ManagedTileState::Allocated;
            tile.isFetched = false;
            served.emplace_back(&texture, i);
        }
    }
    CheckServed(served);
    const std::uint64_t free = heaps_.size() * std::uint64_t{perHeap_} - CountSlots();
    if (Count(ManagedTileState::Requested) > 0)
        Expect(free == 0 && Count(ManagedTileState::Standby) == 0, "requests wait although there is room");
    if (evicted > 0) // the last eviction gave up to two slots, one of which was needed
        Expect(free <= 1, "more was evicted than was needed");
}

void TileModel::Defragment(std::uint32_t count) {
    ++operation_;
    std::map<std::uint32_t, std::uint32_t> free;
    for (const std::uint32_t heap : heaps_)
        free[heap] = perHeap_ - manager_.GetHeapUse(heap).value_or(perHeap_);
    const auto isMovable = [&](const ModelTexture& texture, std::uint32_t tile) {
        return manager_.IsMovableTile(texture.id, tile).value_or(false);
    };
    std::set<std::pair<std::uint32_t, std::uint32_t>> before;
    std::size_t lastHeap = 0; // that had a movable tile
    for (const ModelTexture& texture : textures_) {
        for (std::uint32_t i = 0; i < texture.tiles.size(); ++i) {
            const ModelTile& tile = texture.tiles[i];
            const bool isRight =
                !tile.isPinned && !tile.isMoving &&
                (tile.state == ManagedTileState::Mapped || tile.state == ManagedTileState::Standby);
            Expect(isMovable(texture, i) == isRight, "movable tile");
            if (isRight) {
                before.insert({texture.id.index, i});
                lastHeap = std::max(lastHeap, GetHeapNumber(tile.slot.first) + 1);
            }
        }
    }
    const auto moved = manager_.DefragmentTiles(count);
    Expect(moved.has_value() && *moved <= count, "defragmentation");
    std::uint32_t found = 0;
    for (ModelTexture& texture : textures_) {
        for (std::uint32_t i = 0; i < texture.tiles.size(); ++i) {
            if (before.count({texture.id.index, i}) == 0 || isMovable(texture, i))
                continue;
            ModelTile& tile = texture.tiles[i];
            tile.isMoving = true;
            tile.isMoveFetched = false;
            tile.moveTo = {};
            ++found;
            bool isEarlierFree = false;
            for (std::size_t h = 0; h < GetHeapNumber(tile.slot.first); ++h)
                isEarlierFree = isEarlierFree || free[heaps_[h]] > 0;
            Expect(isEarlierFree, "a tile moves although no earlier heap had room");
        }
    }
    Expect(moved && found == *moved, "number of moves");
    // With room in a heap before the last one that can be emptied, something moves.
    bool canMove = false;
    for (std::size_t h = 0; lastHeap > 0 && h + 1 < lastHeap; ++h)
        canMove = canMove || free[heaps_[h]] > 0;
    Expect(moved && (*moved > 0) == (canMove && count > 0), "defragmentation moves or does not");
    // Where they go is asked for by the orders; until then from the manager's counts alone.
    for (const ModelTexture& texture : textures_) {
        for (std::uint32_t i = 0; i < texture.tiles.size(); ++i) {
            if (texture.tiles[i].isMoving)
                Expect(manager_.GetTileSlot(texture.id, i).value_or(TileSlot{~0u, 0}) ==
                           TileSlot{texture.tiles[i].slot.first, texture.tiles[i].slot.second},
                       "a moving tile left its slot before its confirmation");
        }
    }
}

void TileModel::Fetch() {
    ++operation_;
    const TileOrders orders = manager_.FetchOrders();
    const auto less = [](const TileUnmapOrder& a, const TileUnmapOrder& b) {
        return std::pair(a.texture.index, a.tile) < std::pair(b.texture.index, b.tile);
    };
    std::vector<TileUnmapOrder> unmaps(orders.unmaps.begin(), orders.unmaps.end());
    std::sort(unmaps.begin(), unmaps.end(), less);
    std::sort(unmaps_.begin(), unmaps_.end(), less);
    Expect(std::equal(unmaps.begin(), unmaps.end(), unmaps_.begin(), unmaps_.end(),
                      [](const TileUnmapOrder& a, const TileUnmapOrder& b) {
                          return a.texture == b.texture && a.tile == b.tile && a.from == b.from;
                      }),
           "unmap orders");
    unmaps_.clear();
    for (const TileMapOrder& order : orders.maps) {
        ModelTexture* texture = Find(order.texture);
        Expect(texture != nullptr && order.tile < texture->tiles.size(), "map order of nothing");
        if (texture == nullptr)
            continue;
        ModelTile& tile = texture->tiles[order.tile];
        Expect(tile.state == ManagedTileState::Allocated && !tile.isFetched &&
                   order.to == TileSlot{tile.slot.first, tile.slot.second},
               "map order");
        tile.isFetched = true;
        tile.ticket = order.ticket;
        mapOrders_.push_back(order);
    }
    for (const TileMoveOrder& order : orders.moves) {
        ModelTexture* texture = Find(order.texture);
        Expect(texture != nullptr && order.tile < texture->tiles.size(), "move order of nothing");
        if (texture == nullptr)
            continue;
        ModelTile& tile = texture->tiles[order.tile];
        Expect(tile.isMoving && !tile.isMoveFetched &&
                   order.from == TileSlot{tile.slot.first, tile.slot.second} &&
                   GetHeapNumber(order.to.heap) < GetHeapNumber(order.from.heap),
               "move order");
        tile.isMoveFetched = true;
        tile.ticket = order.ticket;
        tile.moveTo = {order.to.heap, order.to.slot};
        moveOrders_.push_back(order);
    }
    for (const ModelTexture& texture : textures_) {
        for (const ModelTile& tile : texture.tiles)
            Expect((tile.state != ManagedTileState::Allocated || tile.isFetched) &&
                       (!tile.isMoving || tile.isMoveFetched),
                   "an order is lost");
    }
}

void TileModel::FetchResidency() {
    ++operation_;
    const auto changes = manager_.FetchResidencyChanges();
    Expect(changes.has_value(), "changes of residency");
    if (!changes)
        return;
    for (const ResidencyChange& change : *changes) {
        ModelTexture* texture = Find(change.texture);
        Expect(texture != nullptr && change.entry < texture->shadow.size() &&
                   texture->shadow[change.entry] != change.value,
               "change of residency that is none");
        if (texture != nullptr)
            texture->shadow[change.entry] = change.value;
    }
    for (const ModelTexture& texture : textures_) {
        const auto map = manager_.GetResidencyMap(texture.id);
        Expect(map && std::equal(map->begin(), map->end(), texture.shadow.begin(), texture.shadow.end()),
               "changes of residency do not make the map");
    }
}

void TileModel::ConfirmMaps(const std::vector<TileMapOrder>& orders) {
    ++operation_;
    const TileConfirmations result = manager_.ConfirmOrders(std::span<const TileMapOrder>(orders));
    std::uint32_t confirmed = 0;
    for (const TileMapOrder& order : orders) {
        ModelTexture* texture = Find(order.texture);
        if (texture == nullptr)
            continue;
        ModelTile& tile = texture->tiles[order.tile];
        if (tile.state != ManagedTileState::Allocated || !tile.isFetched || tile.ticket != order.ticket)
            continue;
        tile.state = ManagedTileState::Mapped;
        ++confirmed;
    }
    Expect(result.confirmed == confirmed && result.stale == orders.size() - confirmed, "confirmations");
    stale_ += orders.size() - confirmed;
}

void TileModel::ConfirmMoves(const std::vector<TileMoveOrder>& orders) {
    ++operation_;
    const TileConfirmations result = manager_.ConfirmOrders(std::span<const TileMoveOrder>(orders));
    std::uint32_t confirmed = 0;
    for (const TileMoveOrder& order : orders) {
        ModelTexture* texture = Find(order.texture);
        if (texture == nullptr)
            continue;
        ModelTile& tile = texture->tiles[order.tile];
        if (!tile.isMoving || !tile.isMoveFetched || tile.ticket != order.ticket)
            continue;
        tile.isMoving = false;
        tile.slot = tile.moveTo;
        ++confirmed;
    }
    Expect(result.confirmed == confirmed && result.stale == orders.size() - confirmed,
           "confirmations of moves");
    stale_ += orders.size() - confirmed;
}

void TileModel::ConfirmTiles(std::size_t number, const std::vector<std::uint32_t>& tiles) {
    ++operation_;
    ModelTexture& texture = textures_[number];
    const auto result = manager_.UpdateTilesMapping(texture.id, tiles);
    std::uint32_t confirmed = 0;
    for (const std::uint32_t i : tiles) {
        ModelTile& tile = texture.tiles[i];
        if (tile.state == ManagedTileState::Allocated && tile.isFetched) {
            tile.state = ManagedTileState::Mapped;
            ++confirmed;
        }
    }
    Expect(result && result->confirmed == confirmed && result->stale == tiles.size() - confirmed,
           "confirmations by tile");
    stale_ += tiles.size() - confirmed;
}

std::uint8_t TileModel::GetResidency(const ModelTexture& texture, std::size_t finest) const {
    const auto isVisible = [](const ModelTile& tile) {
        return tile.state == ManagedTileState::Mapped || tile.state == ManagedTileState::Standby;
    };
    for (const ModelTile& tile : texture.tiles) {
        if (tile.level == static_cast<int>(texture.levels.size()) && !isVisible(tile))
            return 255;
    }
    int tailMip = 0;
    for (const TileLevelDesc& level : texture.levels)
        tailMip = level.lastMip + 1;
    int best = texture.tailTiles > 0 ? tailMip : 255;
    for (int level = static_cast<int>(texture.levels.size()) - 1; level >= 0; --level) {
        for (const int i : texture.related[finest]) {
            const ModelTile& tile = texture.tiles[static_cast<std::size_t>(i)];
            if (tile.level == level && !isVisible(tile))
                return static_cast<std::uint8_t>(best);
        }
        best = texture.levels[static_cast<std::size_t>(level)].firstMip;
    }
    return static_cast<std::uint8_t>(best);
}

void TileModel::Compare() {
    std::uint64_t wanted = 0, tiles = 0;
    std::set<std::pair<std::uint32_t, std::uint32_t>> slots;
    for (const ModelTexture& texture : textures_) {
        for (std::uint32_t i = 0; i < texture.tiles.size(); ++i) {
            const ModelTile& tile = texture.tiles[i];
            const auto state = manager_.GetTileState(texture.id, i);
            Expect(state && *state == tile.state, "state of a tile");
            const auto isWanted = manager_.IsTileWanted(texture.id, i);
            Expect(isWanted && *isWanted == tile.isWanted, "a tile is wanted or is not");
            wanted += tile.isWanted ? 1 : 0;
            ++tiles;
            const auto slot = manager_.GetTileSlot(texture.id, i);
            const bool hasSlot =
                tile.state != ManagedTileState::Free && tile.state != ManagedTileState::Requested;
            Expect(slot.has_value() == hasSlot &&
                       (!hasSlot || *slot == TileSlot{tile.slot.first, tile.slot.second}),
                   "slot of a tile");
            Expect(!hasSlot ||
                       (slots.insert(tile.slot).second && GetHeapNumber(tile.slot.first) < heaps_.size() &&
                        tile.slot.second < perHeap_),
                   "slot belongs to two tiles or to no heap");
            Expect(!tile.isMoving || !tile.isMoveFetched || slots.insert(tile.moveTo).second,
                   "a tile moves to a slot in use");
        }
        const auto map = manager_.GetResidencyMap(texture.id);
        Expect(map && map->size() == texture.shadow.size(), "size of a residency map");
        for (std::size_t i = 0; map && i < map->size(); ++i)
            Expect((*map)[i] == GetResidency(texture, i), "residency");
    }
    const TileManagerStatistics has = manager_.GetStatistics();
    const std::uint64_t used = CountSlots();
    Expect(has.textures == textures_.size() && has.tiles == tiles && has.wantedTiles == wanted &&
               has.requestedTiles == Count(ManagedTileState::Requested) &&
               has.allocatedTiles == Count(ManagedTileState::Allocated) &&
               has.mappedTiles == Count(ManagedTileState::Mapped) &&
               has.standbyTiles == Count(ManagedTileState::Standby) && has.usedSlots == used &&
               has.slots == heaps_.size() * std::uint64_t{perHeap_} && has.freeSlots == has.slots - used &&
               has.staleConfirmations == stale_,
           "statistics");
    Expect(manager_.GetNumDesiredHeaps() == (wanted + standbyTarget_ + perHeap_ - 1) / perHeap_,
           "desired heaps");
    if (const auto checked = manager_.CheckInvariants(); !checked)
        Expect(false, checked.error().GetText());
}

} // namespace openntc_tests
