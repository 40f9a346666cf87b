// SPDX-License-Identifier: MIT
// Stability: internal
// A demand loader's tasks: from the start of a read to its data, its error or its end.
#pragma once

#include "openntc/streaming/detail/DemandCore.h"

#if defined(__cpp_exceptions)
#include <exception>
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// Calls `function`, which belongs to the user; what it throws becomes an error.
template <typename Result, typename Function>
Expected<Result> CallGuarded(Function&& function) noexcept {
#if defined(__cpp_exceptions)
    try {
        return function();
    } catch (const std::exception& exception) {
        return Fail(Status::IOError, "threw an exception: %s", exception.what());
    } catch (...) {
        return Fail(Status::IOError, "threw something that is no std::exception");
    }
#else
    return function();
#endif
}

/// There must be room (HasRoomFor), and a place among the outstanding ones.
inline void DemandCore::Start(const Candidate& candidate, const Shared<TicketState>& ticket) noexcept {
    TileRecord& record = *candidate.record;
    if (!candidate.set->IsResource()) {
        record.slot = pool.Take(candidate.set->GetBytes(candidate.tile));
        AddChild(*candidate.set, candidate.tile, 1);
        if (record.wasFreed && round - record.stamp < kThrashRounds)
            ++statistics.thrashed;
    }
    record.state = TileState::Queued;
    // Has room for all that can be outstanding.
    static_cast<void>(
        heap.PushBack({{*candidate.owner, candidate.tile}, candidate.depth, nextNumber++, ticket}));
    std::push_heap(heap.begin(), heap.end(),
                   [](const ReadTask& a, const ReadTask& b) { return b.IsBefore(a); });
    ++queuedCount;
    ++toNotify;
    ++statistics.started;
    if (ticket)
        ticket->Add();
}

inline void DemandCore::NotifyWorkers() noexcept {
    if (workers && toNotify > 0)
        workers->Notify(*this, toNotify);
    toNotify = 0;
}

inline ReadTask DemandCore::PopTask() noexcept {
    std::pop_heap(heap.begin(), heap.end(),
                  [](const ReadTask& a, const ReadTask& b) { return b.IsBefore(a); });
    ReadTask task = std::move(heap.back());
    heap.pop_back();
    --queuedCount;
    return task;
}

inline std::byte* DemandCore::TakeBuffer() noexcept {
    if (!buffers.empty()) {
        std::byte* buffer = buffers.back();
        buffers.pop_back();
        return buffer;
    }
    std::byte* buffer = static_cast<std::byte*>(allocator.Allocate(options.slotBytes));
    hostBytes += buffer != nullptr ? options.slotBytes : 0;
    return buffer;
}

inline void DemandCore::ReturnBuffer(std::byte* buffer) noexcept {
    if (buffer == nullptr || buffers.PushBack(buffer)) // has room for all that can be outstanding
        return;
    allocator.Deallocate(buffer, options.slotBytes);
    hostBytes -= options.slotBytes;
}

/// The calling thread reads all that is queued. Without lock.
inline void DemandCore::RunAll() noexcept {
    for (;;) {
        {
            const Lock lock(mutex);
            if (isClosed || heap.empty())
                return;
        }
        RunTask();
    }
}

inline void DemandCore::RunTask() noexcept {
    ReadTask task; // may be the last owner of a source: dropped without the lock
    Lock lock(mutex);
    if (isClosed || heap.empty())
        return;
    task = PopTask();
    TileSet& set = *task.ref.set;
    ++reading;
    static_cast<void>(readingTickets.PushBack(task.ticket)); // has room for all that can be outstanding
    set.tiles.Find(task.ref.tile)->state = TileState::Reading;
    if (set.IsResource()) {
        lock.unlock();
        const Expected<PageRead> result =
            CallGuarded<PageRead>([&] { return set.callback.call(set.callback.user, task.ref.tile); });
        lock.lock();
        --reading;
        FinishPage(task, result);
    } else {
        const std::size_t bytes = set.GetBytes(task.ref.tile);
        std::byte* buffer = TakeBuffer();
        Expected<TileRead> result = TileRead{TileAnswer::Later, 0}; // until there is memory
        if (buffer != nullptr) {
            lock.unlock();
            result = CallGuarded<TileRead>([&] {
                return set.source->ReadTile(task.ref.tile, {buffer, bytes},
                                            TileCancellation(set.isCancelled));
            });
            lock.lock();
        }
        --reading;
        FinishRead(task, buffer, result);
    }
    if (!isAborted) {
        for (Shared<TicketState>& ticket : readingTickets) {
            if (ticket.Get() == task.ticket.Get()) {
                ticket = std::move(readingTickets.back());
                break;
            }
        }
        readingTickets.pop_back();
        if (task.ticket)
            task.ticket->Finish(set.tiles.Find(task.ref.tile)->state == TileState::Failed);
    }
    if (reading == 0)
        idle.NotifyAll();
}

inline void DemandCore::FinishRead(const ReadTask& task, std::byte* buffer,
                                   const Expected<TileRead>& result) noexcept {
    TileSet& set = *task.ref.set;
    if (isClosed || set.isRemoved) {
        ++statistics.cancelled;
        Settle(task.ref, TileState::Free);
    } else if (!result) {
        ReportFailure(task.ref, result.error());
        ++statistics.failed;
    } else if (result->answer == TileAnswer::Later) {
        ++statistics.deferred;
        Settle(task.ref, TileState::Free);
    } else if (result->bytes != set.GetBytes(task.ref.tile)) {
        ReportFailure(task.ref, MakeError(Status::IOError, "tile: %zu bytes: the source promised %u",
                                          result->bytes, set.GetBytes(task.ref.tile)));
        ++statistics.failed;
    } else {
        ++statistics.filled;
        statistics.bytesRead += result->bytes;
        set.tiles.Find(task.ref.tile)->state = TileState::Filled;
        // Has room for all that can be outstanding.
        static_cast<void>(filled.PushBack(
            {task.ref, task.depth, task.number, buffer, static_cast<std::uint32_t>(result->bytes)}));
        return;
    }
    ReturnBuffer(buffer);
}

inline void DemandCore::FinishPage(const ReadTask& task, const Expected<PageRead>& result) noexcept {
    TileRecord& record = *task.ref.set->tiles.Find(task.ref.tile);
    if (isClosed || task.ref.set->isRemoved) {
        ++statistics.cancelled;
        record.state = TileState::Free;
    } else if (!result) {
        ReportFailure(task.ref, result.error());
        ++statistics.failed;
    } else if (result->answer == TileAnswer::Later || record.isStale) {
        ++statistics.deferred;
        Settle(task.ref, TileState::Free);
    } else if (result->value == NTC_TILE_MISSING) {
        ReportFailure(task.ref, MakeError(Status::OutOfRange, "value: 0x%08x: means that the page is missing",
                                          result->value));
        ++statistics.failed;
    } else {
        ++statistics.filled;
        record.state = TileState::Filled;
        static_cast<void>(filled.PushBack({task.ref, task.depth, task.number, nullptr, result->value}));
    }
    record.isStale = false;
}

/// The end of a tile that did not become resident: its slot is given back, and it may be asked for again
/// unless it failed.
inline void DemandCore::Settle(const TileRef& ref, TileState state) noexcept {
    TileRecord& record = *ref.set->tiles.Find(ref.tile);
    if (!ref.set->IsResource() && record.slot != kNoSlot) {
        pool.Release(record.slot);
        record.slot = kNoSlot;
        AddChild(*ref.set, ref.tile, -1);
    }
    record.state = state;
    if (state == TileState::Free && !ref.set->isRemoved)
        ClearBits(ref);
}

inline void DemandCore::ReportFailure(const TileRef& ref, const Error& error) noexcept {
    Settle(ref, TileState::Failed);
    if (!failed.PushBack({ref, round})) { // then it may be asked for again, and is reported again
        Settle(ref, TileState::Free);
        return;
    }
    DemandError report;
    report.tile = ref.tile;
    report.position = ref.set->GetPosition(ref.tile);
    report.error = error;
    for (std::uint32_t index = 0; index < textures.size(); ++index) {
        const DemandTexture& texture = textures[index];
        if (texture.set.Get() == ref.set.Get() || texture.next.Get() == ref.set.Get()) {
            report.texture = {index, texture.generation};
            break;
        }
    }
    if (errors.size() >= kMaxErrors || !errors.PushBack(report))
        ++lostErrors;
}

inline void DemandCore::ClearBits(const TileRef& ref) noexcept {
    if (!clearTiles.PushBack(ref))
        clearAll = true;
}

inline void DemandCore::ClearBit(std::uint32_t entry) noexcept {
    if (!clears.PushBack(entry))
        clearAll = true;
}

/// Takes the tasks of a removed set out of the queue.
inline void DemandCore::CancelQueued(const TileSet& set) noexcept {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < heap.size(); ++i) {
        if (heap[i].ref.set.Get() != &set) {
            if (kept != i)
                heap[kept] = std::move(heap[i]);
            ++kept;
            continue;
        }
        --queuedCount;
        ++statistics.cancelled;
        Settle(heap[i].ref, TileState::Free);
        if (heap[i].ticket)
            heap[i].ticket->Finish(false);
    }
    static_cast<void>(heap.Resize(kept)); // smaller: cannot fail
    idle.NotifyAll();
    std::make_heap(heap.begin(), heap.end(),
                   [](const ReadTask& a, const ReadTask& b) { return b.IsBefore(a); });
}

/// Ends everything: no task begins, those that run are asked to stop, and waited for if `wait`.
inline void DemandCore::Close(bool wait) noexcept {
    Lock lock(mutex);
    isClosed = true;
    for (ReadTask& task : heap) {
        if (task.ticket)
            task.ticket->Finish(false);
    }
    for (DemandTexture& texture : textures) {
        for (Shared<TileSet>* set : {&texture.set, &texture.next}) {
            if (*set)
                (*set)->isCancelled = true;
        }
    }
    queuedCount = 0;
    heap.clear();
    idle.NotifyAll();
    if (wait) {
        idle.Wait(lock, [&] { return reading == 0; });
        return;
    }
    isAborted = true;
    for (const Shared<TicketState>& ticket : readingTickets) {
        if (ticket)
            ticket->Finish(false);
    }
    readingTickets.clear();
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
