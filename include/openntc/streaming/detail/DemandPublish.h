// SPDX-License-Identifier: MIT
// Stability: internal
// What a launch gets to see: data uploaded, the page table changed, request bits cleared.
#pragma once

#include "openntc/streaming/detail/DemandEviction.h"
#include "openntc/streaming/detail/DemandReading.h"
#include "openntc/streaming/detail/DemandRequests.h"
#include "openntc/streaming/detail/DemandTextures.h"

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline Expected<LaunchPlan> DemandCore::PrepareLaunch(TileUploader& uploader, const DemandLimits& limits) {
    Lock lock(mutex);
    if (isClosed)
        return Fail(Status::InvalidState, "loader: was aborted");
    ++round;
    ++statistics.rounds;
    while (launchCount > 0 && launches[0].round + options.framesInFlight <= round) {
        OPENNTC_CHECK(Abandon({launches[0].round})); // it has ended, and nobody asked for its requests
    }
    ReleaseStaged();
    if (options.retryAfterRounds > 0)
        RetryFailed(options.retryAfterRounds);
    QueueBases();
    if (!workers) {
        lock.unlock();
        RunAll();
        lock.lock();
    }
    LaunchPlan plan;
    SelectFilled(limits);
    for (const FilledTile& tile : publishing)
        Publish(tile, uploader, lock, plan);
    publishing.clear();
    FinishReplacements();
    CollectFills();
    CollectChanges();
    for (StagedTile& tile : staged)
        tile.round = tile.round == 0 ? round : tile.round;
    launches[launchCount++] = {round, GetOutstanding() == 0 && basesWaiting == 0};
    plan.context.round = round;
    plan.tableChanges = changes.AsSpan();
    plan.stateFills = fills.AsSpan();
    return plan;
}

/// Moves what this launch gets to `publishing`, the coarsest first.
inline void DemandCore::SelectFilled(const DemandLimits& limits) noexcept {
    std::sort(filled.begin(), filled.end(), [](const FilledTile& a, const FilledTile& b) {
        return a.depth != b.depth ? a.depth < b.depth : a.number < b.number;
    });
    publishing.clear();
    std::uint64_t bytes = 0;
    std::size_t taken = 0;
    while (taken < filled.size() && taken < limits.maxTiles) {
        bytes += filled[taken].buffer != nullptr ? filled[taken].bytes : 0;
        if (taken > 0 && bytes > limits.maxBytes)
            break;
        static_cast<void>(publishing.PushBack(std::move(filled[taken++]))); // has room for all
    }
    for (std::size_t i = taken; i < filled.size() && taken > 0; ++i)
        filled[i - taken] = std::move(filled[i]);
    static_cast<void>(filled.Resize(filled.size() - taken)); // smaller: cannot fail
}

inline void DemandCore::Publish(const FilledTile& tile, TileUploader& uploader, Lock& lock,
                                LaunchPlan& plan) noexcept {
    if (tile.buffer == nullptr) {
        PublishPage(tile);
        return;
    }
    TileRecord& record = *tile.ref.set->tiles.Find(tile.ref.tile);
    const std::span<const std::byte> bytes(tile.buffer, tile.bytes);
    TilePattern pattern;
    const bool isPattern = options.shareUniform && !tile.ref.set->hasRows && FindPattern(bytes, pattern);
    const std::uint32_t shared = isPattern ? pool.Share(pattern) : kNoSlot;
    if (!GrowResidents()) { // no memory: it is asked for again
        if (shared != kNoSlot)
            pool.Release(shared);
        ++statistics.discarded;
        Settle(tile.ref, TileState::Free);
    } else if (shared != kNoSlot) {
        pool.Release(record.slot);
        record.slot = shared;
        statistics.shared += MakeResident(tile.ref) ? 1u : 0u;
    } else {
        TileUpload upload;
        upload.slot = record.slot;
        upload.offset = options.slotsOffset + std::uint64_t{record.slot} * options.slotBytes;
        upload.textureId = tile.ref.set->textures.empty() ? NTC_TILE_MISSING : tile.ref.set->textures[0];
        upload.tile = tile.ref.tile;
        upload.bytes = bytes;
        lock.unlock();
        const Expected<void> uploaded = CallGuarded<void>([&] { return uploader.Upload(upload); });
        lock.lock();
        if (!uploaded) {
            ++statistics.uploadFailed;
            ReportFailure(tile.ref, uploaded.error());
        } else if (MakeResident(tile.ref)) {
            ++statistics.uploaded;
            ++plan.uploadedTiles;
            statistics.bytesUploaded += tile.bytes;
            if (isPattern)
                pool.SetPattern(record.slot, pattern);
        }
    }
    ReturnBuffer(tile.buffer);
}

inline void DemandCore::PublishPage(const FilledTile& page) noexcept {
    TileSet& set = *page.ref.set;
    TileRecord& record = *set.tiles.Find(page.ref.tile);
    if (record.isStale) {
        record.isStale = false;
        ++statistics.discarded;
        Settle(page.ref, TileState::Free);
        return;
    }
    record.state = TileState::Resident;
    ++set.residents;
    ++statistics.pages;
    static_cast<void>(MapAll(set, page.ref.tile, page.bytes)); // an entry of its own: cannot fail
    ClearBits(page.ref);
}

/// Lists of residents have room for one more.
inline bool DemandCore::GrowResidents() noexcept {
    if (residents.size() < residentRoom)
        return true;
    const std::size_t room = residentRoom * 2; // more tiles than slots: some share one
    if (!residents.Reserve(room) || !victims.Reserve(room) || !staged.Reserve(room))
        return false;
    residentRoom = room;
    return true;
}

/// Shows a tile whose data are in its slot; false if its source's slice rows make no sense.
inline bool DemandCore::MakeResident(const TileRef& ref) noexcept {
    TileSet& set = *ref.set;
    if (const Expected<void> mapped = MapAll(set, ref.tile, set.tiles.Find(ref.tile)->slot); !mapped) {
        UnmapAll(set, ref.tile);
        ++statistics.uploadFailed;
        ReportFailure(ref, mapped.error());
        return false;
    }
    TileRecord& record = *set.tiles.Find(ref.tile);
    record.state = TileState::Resident;
    record.stamp = round;
    record.place = static_cast<std::uint32_t>(residents.size());
    static_cast<void>(residents.PushBack(ref)); // GrowResidents
    ++set.residents;
    if (set.IsBase(ref.tile)) {
        --set.baseMissing;
        ++statistics.tailTiles;
    }
    ClearBits(ref);
    return true;
}

/// Textures whose new tail is there show it from this launch on.
inline void DemandCore::FinishReplacements() noexcept {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < replacing.size(); ++i) {
        const std::uint32_t index = replacing[i];
        DemandTexture& texture = textures[index];
        if (texture.next->baseMissing > 0 || !texture.next->textures.PushBack(index)) {
            replacing[kept++] = index;
            continue;
        }
        TiledTextureDesc desc = texture.nextDesc;
        std::array<TiledLevel, NTC_MAX_LEVELS> levels{};
        FillGeometry(texture.next->source->GetLayout(), desc, levels);
        ClearAllBitsOf(index);
        if (const Expected<void> replaced = table.Replace(index, desc); !replaced) {
            Hide(*texture.next, index);
            DemandError report;
            report.texture = {index, texture.generation};
            report.error = replaced.error();
            if (errors.size() >= kMaxErrors || !errors.PushBack(report))
                ++lostErrors;
            Drop(texture.next);
            continue;
        }
        Hide(*texture.set, index);
        Drop(texture.set);
        texture.set = std::move(texture.next);
        texture.next = {};
        texture.firstRound = round;
        Show(*texture.set, index);
    }
    static_cast<void>(replacing.Resize(kept)); // smaller: cannot fail
}

/// Request bits to clear, as ranges of words; bits beside them are cleared too, which costs a second request
/// at most.
inline void DemandCore::CollectFills() noexcept {
    for (const TileRef& ref : clearTiles) {
        for (const std::uint32_t texture : ref.set->textures) {
            if (const Expected<NtcTiledTexture> header = table.GetHeader(texture))
                ClearBit(header->firstEntry + ref.tile);
        }
    }
    clearTiles.clear();
    const LaunchState& state = table.GetLaunchState();
    for (std::uint32_t& entry : clears)
        entry = state.bitsWord + entry / 32;
    for (const StateFill& range : clearRanges) {
        if (range.words > kMaxFills)
            clearAll = true;
        for (std::uint32_t i = 0; i < range.words && !clearAll; ++i)
            clearAll = !clears.PushBack(range.firstWord + i);
    }
    clearRanges.clear();
    fills.clear();
    if (!clearAll) {
        std::sort(clears.begin(), clears.end());
        for (const std::uint32_t word : clears) {
            if (!fills.empty() && word < fills.back().firstWord + fills.back().words)
                continue;
            if (!fills.empty() && word == fills.back().firstWord + fills.back().words) {
                ++fills.back().words;
            } else if (fills.size() == kMaxFills) {
                clearAll = true;
                break;
            } else {
                static_cast<void>(fills.PushBack({word, 1})); // has room for kMaxFills
            }
        }
    }
    clears.clear();
    if (clearAll) {
        fills.clear();
        static_cast<void>(fills.PushBack({state.bitsWord, state.stampsWord - state.bitsWord}));
    }
    clearAll = false;
}

inline void DemandCore::CollectChanges() noexcept {
    changes.clear();
    bool isComplete = true;
    for (PageTable::ByteRange range; table.TakeChange(range);)
        isComplete = isComplete && changes.PushBack(range).has_value();
    if (!isComplete) { // no memory for the list: all of it, for which there is room
        changes.clear();
        static_cast<void>(changes.PushBack({0, table.GetBytes().size()}));
    }
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
