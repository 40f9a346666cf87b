// SPDX-License-Identifier: MIT
// Stability: internal
// What a launch asked for becomes reads: coarse before fine, in turns among equals, within the limits.
#pragma once

#include "openntc/streaming/detail/DemandCore.h"

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline bool DemandCore::CloseLaunch(std::uint32_t closed, OpenLaunch& launch) noexcept {
    for (std::size_t i = 0; i < launchCount; ++i) {
        if (launches[i].round != closed)
            continue;
        launch = launches[i];
        for (; i + 1 < launchCount; ++i)
            launches[i] = launches[i + 1];
        --launchCount;
        return true;
    }
    return false;
}

inline Expected<void> DemandCore::Abandon(DemandContext context) {
    OpenLaunch launch;
    if (!CloseLaunch(context.round, launch))
        return Fail(Status::InvalidState, "context: round %u: was processed, abandoned, or never prepared",
                    context.round);
    ++statistics.abandoned;
    clearAll = true; // what it asked for is not known
    for (std::size_t i = 0; i < launchCount; ++i)
        launches[i].isComplete = false;
    return {};
}

inline Expected<Shared<TicketState>>
DemandCore::Process(DemandContext context, const DemandReadback& readback, const DemandLimits& limits) {
    OPENNTC_ASSIGN(Shared<TicketState> ticket, MakeShared<TicketState>(allocator));
    OpenLaunch launch;
    if (!CloseLaunch(context.round, launch))
        return Fail(Status::InvalidState, "context: round %u: was processed, abandoned, or never prepared",
                    context.round);
    const std::size_t count = readback.requests.GetCount();
    ++statistics.processed;
    statistics.requested += count;
    statistics.overflow += readback.requests.overflow;
    if (readback.requests.overflow > 0)
        clearAll = true;
    const std::uint64_t noRoom = statistics.noRoom;
    candidates.clear();
    for (std::size_t i = 0; i < count; ++i)
        Classify(readback.requests[i], context.round);
    AddPromised();
    if (options.loadAncestors) {
        for (std::size_t i = 0, requests = candidates.size(); i < requests; ++i)
            AddAncestors(candidates[i]);
    }
    SortCandidates();
    Take(limits, ticket);
    const std::size_t unserved = candidates.size();
    nextPromised.clear();
    for (const Candidate& candidate : candidates) {
        if (candidate.isPromised && nextPromised.size() < staged.size()) // whose room is still on its way
            static_cast<void>(nextPromised.PushBack({*candidate.owner, candidate.tile}));
    }
    Evict(candidates.AsSpan(), readback.stamps);
    std::swap(promised, nextPromised);
    NotifyWorkers();
    if (count + readback.requests.overflow > 0) { // bits are set that these launches found set
        for (std::size_t i = 0; i < launchCount; ++i)
            launches[i].isComplete = false;
    }
    const std::uint64_t requested = count + std::uint64_t{readback.requests.overflow};
    progress.requested = static_cast<std::uint32_t>(std::min<std::uint64_t>(requested, 0xFFFFFFFFu));
    progress.unserved = static_cast<std::uint32_t>(statistics.noRoom - noRoom);
    const bool isIdle = GetOutstanding() == 0 && ticket->tasks == 0;
    progress.quietRounds = requested == 0 && launch.isComplete && isIdle ? progress.quietRounds + 1 : 0;
    progress.state = progress.quietRounds > 0 ? DemandState::Done : DemandState::Working;
    if (unserved > 0 && isIdle && staged.empty())
        progress.state = DemandState::OverBudget;
    return ticket;
}

inline void DemandCore::Classify(const NtcTileRequest& request, std::uint32_t asked) {
    if (request.textureId >= textures.size()) {
        ++statistics.stale;
        return;
    }
    const DemandTexture& texture = textures[request.textureId];
    if (texture.kind == DemandTexture::Kind::Unused || asked < texture.firstRound ||
        request.tile >= texture.set->tileCount) {
        ++statistics.stale;
        return;
    }
    TileSet& set = *texture.set;
    Candidate candidate;
    candidate.owner = &texture.set;
    candidate.set = &set;
    candidate.tile = request.tile;
    candidate.entry = table.GetHeader(request.textureId)->firstEntry + request.tile;
    TileRecord* record = set.tiles.Find(request.tile);
    switch (record != nullptr ? record->state : TileState::Free) {
    case TileState::Free:
        if (record != nullptr && record->isWanted) { // for another texture of the same source
            ++statistics.known;
            ClearBit(candidate.entry);
        } else if (!AddCandidate(candidate)) {
            ++statistics.overLimit;
            ClearBit(candidate.entry);
        }
        break;
    case TileState::Queued:
    case TileState::Reading:
    case TileState::Filled: // its bit stays until it has arrived: no launch asks again
        ++statistics.known;
        break;
    case TileState::Resident:
        ++statistics.known;
        ClearBit(candidate.entry);
        break;
    case TileState::Staged:
        ClearBit(candidate.entry);
        if (record->isForced) {
            ++statistics.noRoom;
            break;
        }
        ++statistics.restored;
        Restore(set, request.tile, *record);
        if (options.loadAncestors)
            AddAncestors(candidate);
        break;
    case TileState::Failed: // its bit stays until a retry
        ++statistics.inError;
        break;
    }
}

/// False where there is no memory for the tile's records.
inline bool DemandCore::AddCandidate(Candidate candidate) {
    TileSet& set = *candidate.set;
    const Expected<TileRecord*> record = set.tiles.Touch(candidate.tile);
    bool isTouched = record.has_value();
    set.ForEachParent(candidate.tile, [&](std::uint32_t parent) { // their children are counted
        isTouched = isTouched && set.tiles.Touch(parent).has_value();
    });
    if (!isTouched)
        return false;
    candidate.record = *record;
    candidate.depth = set.GetDepth(candidate.tile);
    candidate.turn = candidate.entry - turn;
    if (!candidates.PushBack(candidate))
        return false;
    (*record)->isWanted = true;
    return true;
}

/// The missing coarser tiles over a tile; staged ones are kept.
inline void DemandCore::AddAncestors(Candidate candidate) {
    TileSet& set = *candidate.set;
    set.ForEachParent(candidate.tile, [&](std::uint32_t parent) {
        TileRecord* record = set.tiles.Find(parent);
        const TileState state = record != nullptr ? record->state : TileState::Free;
        Candidate next = candidate;
        next.tile = parent;
        next.entry = candidate.entry - candidate.tile + parent;
        next.reason = Candidate::Reason::Ancestor;
        if (state == TileState::Staged && !record->isForced)
            Restore(set, parent, *record);
        else if (state != TileState::Free || (record != nullptr && record->isWanted) || !AddCandidate(next))
            return;
        AddAncestors(next); // as deep as there are levels
    });
}

inline void DemandCore::AddPromised() {
    for (const TileRef& ref : promised) {
        const TileRecord& record = *ref.set->tiles.Find(ref.tile);
        if (ref.set->isRemoved || record.state != TileState::Free || record.isWanted)
            continue;
        Candidate candidate;
        candidate.owner = &ref.set;
        candidate.set = ref.set.Get();
        candidate.tile = ref.tile;
        candidate.reason = Candidate::Reason::Ancestor;
        candidate.isPromised = true;
        static_cast<void>(AddCandidate(candidate));
    }
}

/// The coarsest first; among them one of each source, then a second of each, from where the last call ended.
inline void DemandCore::SortCandidates() noexcept {
    const auto sort = [this] {
        std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
            return a.depth != b.depth     ? a.depth < b.depth
                   : a.number != b.number ? a.number < b.number
                                          : a.turn < b.turn;
        });
    };
    sort();
    for (const Candidate& candidate : candidates)
        candidate.set->taken = 0;
    std::uint32_t depth = 0;
    for (std::size_t i = 0, first = 0; i < candidates.size(); ++i) {
        if (candidates[i].depth != depth) {
            depth = candidates[i].depth;
            for (; first < i; ++first)
                candidates[first].set->taken = 0;
        }
        candidates[i].number = candidates[i].set->taken++;
    }
    sort();
}

/// Starts what fits; of the others only those stay in `candidates` for which there was no room.
inline void DemandCore::Take(const DemandLimits& limits, const Shared<TicketState>& ticket) {
    std::uint64_t bytes = 0;
    std::uint32_t tiles = 0;
    std::size_t waiting = 0;
    bool isFirst = true;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        const Candidate candidate = candidates[i];
        const std::uint32_t size = candidate.set->GetBytes(candidate.tile);
        const bool isOverLimit = tiles >= limits.maxTiles || GetOutstanding() >= options.maxOutstanding ||
                                 (tiles > 0 && (size > limits.maxBytes || bytes > limits.maxBytes - size));
        // Behind one that has to wait for room nothing finer gets it.
        const bool isWaiting = !candidate.set->IsResource() && (waiting > 0 || !HasRoomFor(size));
        candidate.record->isWanted = false;
        if (!isOverLimit && !isWaiting) {
            Start(candidate, ticket);
            ++tiles;
            bytes += size;
            statistics.taken += candidate.reason == Candidate::Reason::Request ? 1 : 0;
            statistics.ancestors += candidate.reason == Candidate::Reason::Ancestor ? 1 : 0;
            statistics.tails += candidate.reason == Candidate::Reason::Tail ? 1 : 0;
            continue;
        }
        if (candidate.reason == Candidate::Reason::Request) {
            if (isFirst)
                turn = candidate.entry; // the next call begins with it
            isFirst = false;
            ++(isOverLimit ? statistics.overLimit : statistics.noRoom);
            ClearBit(candidate.entry);
        }
        if (isWaiting && !isOverLimit)
            candidates[waiting++] = candidate;
    }
    static_cast<void>(candidates.Resize(waiting)); // smaller: cannot fail
}

/// Begins with the tails that are not there: those of new textures, and those that were put off.
inline void DemandCore::QueueBases() {
    candidates.clear();
    std::size_t kept = 0;
    std::uint32_t added = 0;
    for (std::size_t i = 0; i < pendingBases.size(); ++i) {
        if (pendingBases[i]->isRemoved || pendingBases[i]->baseMissing == 0)
            continue;
        if (kept != i)
            pendingBases[kept] = std::move(pendingBases[i]);
        ++kept;
    }
    static_cast<void>(pendingBases.Resize(kept)); // smaller: cannot fail
    for (const Shared<TileSet>& set : pendingBases) {
        for (std::uint32_t tile = set->baseFirst; tile < set->baseFirst + set->baseCount; ++tile) {
            if (set->tiles.Find(tile)->state != TileState::Free)
                continue;
            Candidate candidate;
            candidate.owner = &set;
            candidate.set = set.Get();
            candidate.tile = tile;
            candidate.reason = Candidate::Reason::Tail;
            static_cast<void>(AddCandidate(candidate));
            ++added;
        }
    }
    const std::uint64_t before = statistics.tails;
    Take({}, {});
    basesWaiting = added - static_cast<std::uint32_t>(statistics.tails - before);
    Evict(candidates.AsSpan(), {});
    nextPromised.clear(); // tails do not have to ask again
    NotifyWorkers();
}

/// Failed tiles of at least `age` rounds may be asked for again.
inline void DemandCore::RetryFailed(std::uint32_t age) noexcept {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < failed.size(); ++i) {
        if (round - failed[i].round < age) {
            if (kept != i)
                failed[kept] = std::move(failed[i]);
            ++kept;
            continue;
        }
        Settle(failed[i].ref, TileState::Free);
    }
    static_cast<void>(failed.Resize(kept)); // smaller: cannot fail
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
