// SPDX-License-Identifier: MIT
// Stability: internal
// Which tiles leave when there is no room, in two steps: a staged tile is hidden from the next launch, and
// its slot is given away when no launch can read it any more. Asked for in between, it is shown again.
#pragma once

#include "openntc/streaming/detail/DemandCore.h"

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline bool DemandCore::HasRoomFor(std::uint32_t bytes) const noexcept {
    return pool.HasFree() && pool.GetInUse() < GetSlotLimit() && bytes <= options.budgetBytes &&
           pool.GetBytes() <= options.budgetBytes - bytes;
}

/// A child before its parents, and never a tail.
inline bool DemandCore::IsEvictable(const TileRecord& record, const TileSet& set,
                                    std::uint32_t tile) const noexcept {
    return record.state == TileState::Resident && record.children == 0 && !set.IsBase(tile);
}

inline void DemandCore::AddChild(const TileSet& set, std::uint32_t tile, int change) noexcept {
    set.ForEachParent(tile, [&](std::uint32_t parent) {
        if (TileRecord* record = set.tiles.Find(parent)) // AddCandidate touched it
            record->children += static_cast<std::uint32_t>(change);
    });
}

/// Stages tiles until what is wanted will fit. First those that the last launches did not use, the longest
/// unused and, among equals, the finest first. Where that does not do, a tile in use makes room for a coarser
/// one: without it the picture would show neither there.
inline void DemandCore::Evict(std::span<const Candidate> unserved,
                              std::span<const std::uint32_t> stamps) noexcept {
    std::uint64_t tiles = pool.GetInUse() + unserved.size();
    std::uint64_t bytes = pool.GetBytes();
    for (const Candidate& candidate : unserved)
        bytes += candidate.set->GetBytes(candidate.tile);
    const auto leave = [&](const TileRef& ref) {
        const TileRecord& record = *ref.set->tiles.Find(ref.tile);
        if (pool.GetUsers(record.slot) > 1) // its slot stays
            return;
        tiles -= 1;
        bytes -= ref.set->GetBytes(ref.tile);
    };
    for (const StagedTile& tile : staged)
        leave(tile.ref);
    const auto fits = [&] { return tiles <= GetSlotLimit() && bytes <= options.budgetBytes; };
    if (fits())
        return;
    for (TileRef& ref : residents) {
        TileRecord& record = *ref.set->tiles.Find(ref.tile);
        const std::size_t stamp = std::size_t{options.firstSlot} + record.slot;
        if (stamp < stamps.size() && stamps[stamp] <= round)
            record.stamp = std::max(record.stamp, stamps[stamp]);
    }
    const auto isUnused = [&](const TileRecord& record) {
        return record.stamp + options.framesInFlight <= round;
    };
    const auto depthOf = [&](std::uint32_t place) {
        return residents[place].set->GetDepth(residents[place].tile);
    };
    const auto recordOf = [&](std::uint32_t place) -> const TileRecord& {
        return *residents[place].set->tiles.Find(residents[place].tile);
    };
    for (const bool isForced : {false, true}) {
        // The heap's first: isForced: the deepest; else the longest unused.
        const auto isBehind = [&](std::uint32_t a, std::uint32_t b) {
            const std::uint32_t depthA = depthOf(a), depthB = depthOf(b);
            const std::uint32_t stampA = recordOf(a).stamp, stampB = recordOf(b).stamp;
            if (isForced && depthA != depthB)
                return depthA < depthB;
            return stampA != stampB ? stampA > stampB : depthA != depthB ? depthA < depthB : a > b;
        };
        victims.clear();
        for (std::uint32_t place = 0; place < residents.size(); ++place) {
            const TileRecord& record = recordOf(place);
            if (IsEvictable(record, *residents[place].set, residents[place].tile) &&
                (isForced || isUnused(record)))
                static_cast<void>(victims.PushBack(place)); // has room for all residents
        }
        std::make_heap(victims.begin(), victims.end(), isBehind);
        std::size_t backed = staged.size(); // promises whose room is on its way
        std::size_t served = 0; // isForced: whom the next victim makes room for, the coarsest first
        while (!fits() && !victims.empty()) {
            std::pop_heap(victims.begin(), victims.end(), isBehind);
            const std::uint32_t place = victims.back();
            victims.pop_back();
            if (isForced) {
                for (; served < unserved.size() && unserved[served].isPromised && backed > 0; --backed)
                    ++served;
                if (served == unserved.size() || depthOf(place) <= unserved[served].depth)
                    break;
                // The room is for this one, also if the next launch has no room in its queue to ask again.
                static_cast<void>(nextPromised.PushBack({*unserved[served].owner, unserved[served].tile}));
                ++served;
            }
            const TileRef ref = residents[place];
            leave(ref);
            Stage(place);
            ref.set->tiles.Find(ref.tile)->isForced = isForced;
            ref.set->ForEachParent(ref.tile, [&](std::uint32_t parent) {
                const TileRecord* record = ref.set->tiles.Find(parent);
                if (record == nullptr || !IsEvictable(*record, *ref.set, parent) ||
                    !(isForced || isUnused(*record)))
                    return;
                if (victims.PushBack(record->place))
                    std::push_heap(victims.begin(), victims.end(), isBehind);
            });
        }
        if (fits())
            return;
    }
}

inline void DemandCore::Stage(std::uint32_t place) noexcept {
    const TileRef& ref = residents[place];
    TileRecord& record = *ref.set->tiles.Find(ref.tile);
    record.state = TileState::Staged;
    UnmapAll(*ref.set, ref.tile);
    AddChild(*ref.set, ref.tile, -1);
    static_cast<void>(staged.PushBack({ref, 0})); // has room for all residents
    ++statistics.evicted;
}

inline void DemandCore::Restore(TileSet& set, std::uint32_t tile, TileRecord& record) noexcept {
    for (std::size_t i = 0; i < staged.size(); ++i) {
        if (staged[i].ref.set.Get() != &set || staged[i].ref.tile != tile)
            continue;
        for (; i + 1 < staged.size(); ++i)
            staged[i] = std::move(staged[i + 1]);
        staged.pop_back();
    }
    record.state = TileState::Resident;
    record.stamp = round;
    AddChild(set, tile, 1);
    static_cast<void>(MapAll(set, tile, record.slot)); // went well before
    ++statistics.rescued;
}

/// Called after `round` has risen: slots of tiles that launches before round - framesInFlight were told of.
inline void DemandCore::ReleaseStaged() noexcept {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < staged.size(); ++i) {
        StagedTile& tile = staged[i];
        if (tile.round != 0 && tile.round + options.framesInFlight <= round) {
            TileRecord& record = *tile.ref.set->tiles.Find(tile.ref.tile);
            pool.Release(record.slot);
            RemoveResident(record.place);
            const bool isBase = tile.ref.set->IsBase(tile.ref.tile);
            statistics.tailTiles -= isBase ? 1 : 0;
            record.slot = kNoSlot;
            record.state = TileState::Free;
            record.stamp = round;
            record.wasFreed = true;
            record.isForced = false;
            ++statistics.freed;
            continue;
        }
        if (kept != i)
            staged[kept] = std::move(tile);
        ++kept;
    }
    static_cast<void>(staged.Resize(kept)); // smaller: cannot fail
}

inline void DemandCore::RemoveResident(std::uint32_t place) noexcept {
    --residents[place].set->residents;
    if (place + 1 != residents.size()) {
        residents[place] = std::move(residents.back());
        residents[place].set->tiles.Find(residents[place].tile)->place = place;
    }
    residents.pop_back();
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
