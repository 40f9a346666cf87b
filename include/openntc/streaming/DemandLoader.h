// SPDX-License-Identifier: MIT
// Stability: experimental
// Loads the tiles that shaders ask for. One loader a device; it makes no GPU object and submits no work.
//
//   Each frame:   auto plan = loader.LaunchPrepare(uploader);      // what to bring to the device
//                 … record: uploads, plan->tableChanges, plan->stateFills, an empty queue, the launch …
//   When it has ended:  auto ticket = loader.ProcessRequests(plan->context, readback, limits);
//
// Interactive use never waits: it looks at coarser mips until tiles arrive, gives limits to each call, and
// calls AbandonLaunch where it has no time for a launch's requests. Final frames wait on the ticket and go on
// until GetProgress().state is Done, or OverBudget: then the picture is the finest that fits.
//
// Calls may come from any thread; one waits for the other. Not while a source or an uploader of the loader is
// on that thread's stack.
#pragma once

#include "openntc/streaming/DemandTicket.h"
#include "openntc/streaming/DemandTypes.h"
#include "openntc/streaming/detail/DemandPublish.h"

#include <cstdint>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

class DemandLoader {
public:
    /// Errors: OutOfRange for numbers outside the ranges at the options, OutOfMemory, Unsupported (no
    /// threads).
    static Expected<DemandLoader> Create(const DemandLoaderOptions& options,
                                         Allocator& allocator = GetDefaultAllocator());

    DemandLoader(DemandLoader&& other) noexcept = default;
    DemandLoader& operator=(DemandLoader&& other) noexcept {
        std::swap(core_, other.core_); // and `other` ends what was here
        return *this;
    }
    /// Asks sources that are reading to stop, waits for them, and frees everything.
    ~DemandLoader() { End(true); }

    /// Ends the loader without waiting: threads that are in a source leave when it returns, and what it
    /// returns is dropped. Until then the allocator, and a borrowed source, have to stay. Every later call
    /// answers InvalidState. A pool of its own goes the same way; a shared one keeps its threads.
    void Abort() noexcept {
        const detail::Lock lock(core_->apiMutex);
        core_->Close(false);
        if (!core_->workers)
            return;
        core_->workers->Remove(*core_);
        if (core_->ownsWorkers)
            core_->workers->Abandon();
    }

    /// A texture whose tiles come from `source`. Its tail is read at once and stays; until it is there
    /// samples say that nothing is. Of `desc`, size, mips, tiles, levels, tail, pool and slots are the
    /// source's and the loader's: what it says of them is not read. Errors: OutOfRange for tiles larger than
    /// a slot, or a budget without room for one more tail; those of MakeTiledTexture and PageTable::Add.
    Expected<DemandId> CreateTexture(Shared<TileSource> source, const TiledTextureDesc& desc);

    /// Another source, of any size, under the same identifier. Shaders see the old one until the new tail is
    /// there. Where that fails the error is reported, and the old one stays. Errors: as CreateTexture, and
    /// InvalidArgument for no such texture.
    Expected<void> ReplaceTexture(DemandId texture, Shared<TileSource> source, const TiledTextureDesc& desc);

    /// Reads of its tiles are cancelled, its slots are given back when no launch can read them any more, and
    /// requests for it are dropped. Errors: InvalidArgument for no such texture.
    Expected<void> RemoveTexture(DemandId texture);

    /// `pages` numbers, each with a value that the callback gives when a shader asks (NtcDemandPage): for
    /// data of any kind that the engine keeps itself. Pages have no slots and are not evicted. Errors:
    /// OutOfRange, OutOfMemory, InvalidArgument for no callback.
    Expected<DemandId> CreateResource(std::uint32_t pages, PageCallback callback);
    Expected<void> RemoveResource(DemandId resource);
    /// The page is missing from the next launch on, and fetched again when it is asked for. Errors:
    /// InvalidArgument for no such resource, OutOfRange for no such page.
    Expected<void> InvalidatePage(DemandId resource, std::uint32_t page);

    /// Before each launch: uploads what has arrived, at most `limits`, and says what else the launch needs.
    /// Launches that are framesInFlight old or more have ended by then; requests of theirs that nobody
    /// processed are dropped, and asked for again. Without memory it does less. Errors: InvalidState after
    /// Abort.
    Expected<LaunchPlan> LaunchPrepare(TileUploader& uploader, const DemandLimits& limits = {});

    /// After a launch: begins to read what it asked for, at most `limits`, coarse tiles first, then in turns.
    /// The rest is dropped, and asked for again. Where there is no room, tiles that the last launches did not
    /// use leave. Errors: InvalidState for a launch that was processed or abandoned, or that is
    /// framesInFlight old or more; OutOfMemory: then nothing has happened.
    Expected<DemandTicket> ProcessRequests(DemandContext context, const DemandReadback& readback,
                                           const DemandLimits& limits = {});

    /// In place of ProcessRequests: what the launch asked for is asked for again by the next one. Costs a
    /// fill of all request bits. Errors: as ProcessRequests.
    Expected<void> AbandonLaunch(DemandContext context);

    /// Tiles in error may be asked for again, and tails in error are read again.
    Expected<void> RetryFailed();
    /// The next error that was not taken yet, oldest first; false: none.
    bool TakeError(DemandError& error);
    /// Errors that were dropped because nobody took them.
    std::uint64_t GetLostErrorCount() const;

    /// Another budget, at most the slots of the pool. What is over it leaves with the next ProcessRequests,
    /// in so far as the last launches did not use it. Errors: OutOfRange below the sum of the tails.
    Expected<void> SetBudget(std::uint32_t tiles, std::uint64_t bytes);

    /// Waits until nothing is being read.
    void WaitIdle();

    DemandProgress GetProgress() const;
    DemandStatistics GetStatistics() const;
    const PageTable& GetPageTable() const noexcept { return core_->table; }

private:
    explicit DemandLoader(Shared<detail::DemandCore> core) noexcept : core_(std::move(core)) {}

    void End(bool wait) noexcept;
    /// Calls function() with everything locked; then, without threads, reads what it queued.
    template <typename Function>
    auto Call(Function&& function) -> decltype(function()) {
        const detail::Lock apiLock(core_->apiMutex);
        detail::Lock lock(core_->mutex);
        if (core_->isClosed)
            return Fail(Status::InvalidState, "loader: was aborted");
        auto result = function();
        lock.unlock();
        if (!core_->workers)
            core_->RunAll();
        return result;
    }

    Shared<detail::DemandCore> core_;
};

inline Expected<DemandLoader> DemandLoader::Create(const DemandLoaderOptions& options, Allocator& allocator) {
    const auto inRange = [](const char* name, std::uint64_t value, std::uint64_t least,
                            std::uint64_t most) -> Expected<void> {
        if (value >= least && value <= most)
            return {};
        return Fail(Status::OutOfRange, "%s: %llu: must be %llu … %llu", name,
                    static_cast<unsigned long long>(value), static_cast<unsigned long long>(least),
                    static_cast<unsigned long long>(most));
    };
    OPENNTC_CHECK(inRange("slots", options.slots, 1, std::uint64_t{1} << 28));
    OPENNTC_CHECK(inRange("slotBytes", options.slotBytes, 16, std::uint64_t{1} << 30));
    OPENNTC_CHECK(inRange("firstSlot", options.firstSlot, 0, 0xFFFFFFFFu - options.slots));
    OPENNTC_CHECK(inRange("table.maxSlots", options.table.maxSlots,
                          std::uint64_t{options.firstSlot} + options.slots, 0xFFFFFFFFu));
    OPENNTC_CHECK(inRange("budgetTiles", options.budgetTiles, 1, 0xFFFFFFFFu));
    OPENNTC_CHECK(inRange("maxOutstanding", options.maxOutstanding, 1, std::uint64_t{1} << 20));
    OPENNTC_CHECK(inRange("framesInFlight", options.framesInFlight, 1, 16));
    if (options.slotBytes % 16 != 0 || options.slotsOffset % 4 != 0)
        return Fail(Status::InvalidArgument, "slotBytes, slotsOffset: %u, %u: multiples of 16 and of 4",
                    options.slotBytes, options.slotsOffset);
    if (options.threads < 0 || options.threads > kMaxThreads)
        return Fail(Status::OutOfRange, "threads: %d: must be 0 … %d", options.threads, kMaxThreads);
    OPENNTC_ASSIGN(PageTable table, PageTable::Create(options.table, allocator));
    OPENNTC_ASSIGN(Shared<detail::DemandCore> core,
                   MakeShared<detail::DemandCore>(allocator, std::move(table), options, allocator));
    OPENNTC_CHECK(core->Prepare());
    core->options.workers = {}; // a core and its own pool must not hold each other
    if (options.workers || options.threads > 0) {
        Shared<WorkerPool> workers = options.workers;
        if (!workers) {
            OPENNTC_ASSIGN(workers, WorkerPool::Create(options.threads, allocator));
        }
        OPENNTC_CHECK(workers->Add(core));
        core->workers = std::move(workers);
        core->ownsWorkers = !options.workers;
    }
    return DemandLoader(std::move(core));
}

inline void DemandLoader::End(bool wait) noexcept {
    if (!core_) // moved away
        return;
    core_->Close(wait && !core_->isAborted);
    if (core_->workers)
        core_->workers->Remove(*core_);
    core_->workers = {};
}

inline Expected<DemandId> DemandLoader::CreateTexture(Shared<TileSource> source,
                                                      const TiledTextureDesc& desc) {
    return Call([&] { return core_->AddTexture(std::move(source), desc); });
}

inline Expected<void> DemandLoader::ReplaceTexture(DemandId texture, Shared<TileSource> source,
                                                   const TiledTextureDesc& desc) {
    return Call([&] { return core_->ReplaceTexture(texture, std::move(source), desc); });
}

inline Expected<void> DemandLoader::RemoveTexture(DemandId texture) {
    return Call([&] { return core_->Remove(texture, detail::DemandTexture::Kind::Texture); });
}

inline Expected<DemandId> DemandLoader::CreateResource(std::uint32_t pages, PageCallback callback) {
    return Call([&] { return core_->AddResource(pages, callback); });
}

inline Expected<void> DemandLoader::RemoveResource(DemandId resource) {
    return Call([&] { return core_->Remove(resource, detail::DemandTexture::Kind::Resource); });
}

inline Expected<void> DemandLoader::InvalidatePage(DemandId resource, std::uint32_t page) {
    return Call([&] { return core_->InvalidatePage(resource, page); });
}

inline Expected<LaunchPlan> DemandLoader::LaunchPrepare(TileUploader& uploader, const DemandLimits& limits) {
    const detail::Lock apiLock(core_->apiMutex);
    return core_->PrepareLaunch(uploader, limits);
}

inline Expected<DemandTicket> DemandLoader::ProcessRequests(DemandContext context,
                                                            const DemandReadback& readback,
                                                            const DemandLimits& limits) {
    auto ticket = Call([&] { return core_->Process(context, readback, limits); });
    if (!ticket)
        return PassError(ticket);
    return DemandTicket(std::move(*ticket));
}

inline Expected<void> DemandLoader::AbandonLaunch(DemandContext context) {
    return Call([&] { return core_->Abandon(context); });
}

inline Expected<void> DemandLoader::RetryFailed() {
    return Call([&]() -> Expected<void> {
        core_->RetryFailed(0);
        core_->QueueBases();
        return {};
    });
}

inline Expected<void> DemandLoader::SetBudget(std::uint32_t tiles, std::uint64_t bytes) {
    return Call([&] { return core_->SetBudget(tiles, bytes); });
}

inline bool DemandLoader::TakeError(DemandError& error) {
    const detail::Lock lock(core_->mutex);
    Array<DemandError>& errors = core_->errors;
    if (errors.empty())
        return false;
    error = errors[0];
    for (std::size_t i = 0; i + 1 < errors.size(); ++i)
        errors[i] = errors[i + 1];
    errors.pop_back();
    return true;
}

inline std::uint64_t DemandLoader::GetLostErrorCount() const {
    const detail::Lock lock(core_->mutex);
    return core_->lostErrors;
}

inline void DemandLoader::WaitIdle() {
    detail::Lock lock(core_->mutex);
    core_->idle.Wait(lock, [&] { return core_->isClosed || core_->queuedCount + core_->reading == 0; });
}

inline DemandProgress DemandLoader::GetProgress() const {
    const detail::Lock lock(core_->mutex);
    return core_->GetProgress();
}

inline DemandStatistics DemandLoader::GetStatistics() const {
    const detail::Lock lock(core_->mutex);
    return core_->GetStatistics();
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
