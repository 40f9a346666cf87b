// SPDX-License-Identifier: MIT
// Stability: internal
// The state of a demand loader, which outlives it while a source does not return. Its methods are in
// DemandReading.h (tasks of the pool), DemandTextures.h (what comes and goes), DemandRequests.h
// (ProcessRequests), DemandEviction.h and DemandPublish.h (LaunchPrepare).
#pragma once

#include "openntc/streaming/DemandTicket.h"
#include "openntc/streaming/detail/TileSet.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline constexpr std::uint32_t kThrashRounds = 64;
inline constexpr std::size_t kMaxErrors = 256; ///< that wait to be asked for; later ones are counted
inline constexpr std::size_t kMaxFills = 256;  ///< then all request bits are cleared at once

/// A texture or resource, under its number in the page table.
struct DemandTexture {
    enum class Kind : std::uint8_t { Unused, Texture, Resource };
    Kind kind = Kind::Unused;
    std::uint32_t generation = 0;
    std::uint32_t firstRound = 0; ///< launches before it meant something else by the number
    Shared<TileSet> set;
    Shared<TileSet> next; ///< takes the set's place when its tail is there
    TiledTextureDesc desc;
    TiledTextureDesc nextDesc;
    std::array<TiledLevel, NTC_MAX_LEVELS> levels{}; ///< of nextDesc
};

struct ReadTask {
    TileRef ref;
    std::uint32_t depth = 0;
    std::uint64_t number = 0; ///< rises: among equals, the older first
    Shared<TicketState> ticket;

    bool IsBefore(const ReadTask& other) const noexcept {
        return depth != other.depth ? depth < other.depth : number < other.number;
    }
};

struct FilledTile {
    TileRef ref;
    std::uint32_t depth = 0;
    std::uint64_t number = 0;
    std::byte* buffer = nullptr; ///< null: a resource's page
    std::uint32_t bytes = 0;     ///< or the page's value
};

struct StagedTile {
    TileRef ref;
    std::uint32_t round = 0; ///< whose LaunchPrepare told shaders; 0: none yet
};

struct FailedTile {
    TileRef ref;
    std::uint32_t round = 0;
};

struct OpenLaunch {
    std::uint32_t round = 0;
    bool isComplete = false; ///< it saw everything that had been asked for
};

/// A tile that may begin to be read.
struct Candidate {
    enum class Reason : std::uint8_t { Request, Ancestor, Tail };
    const Shared<TileSet>* owner = nullptr;
    TileSet* set = nullptr; ///< the owner's
    TileRecord* record = nullptr;
    std::uint32_t tile = 0;
    std::uint32_t depth = 0;
    std::uint32_t number = 0; ///< among those of the same source and depth
    std::uint32_t turn = 0;   ///< among equals, the smaller first
    std::uint32_t entry = 0;  ///< of the page table
    Reason reason = Reason::Request;
    bool isPromised = false; ///< another one leaves for it
};

class DemandCore final : public PoolClient {
public:
    DemandCore(PageTable&& pageTable, const DemandLoaderOptions& given, Allocator& from) noexcept
        : allocator(from), options(given), table(std::move(pageTable)), textures(from), heap(from),
          readingTickets(from), filled(from), publishing(from), staged(from), failed(from), residents(from),
          pendingBases(from), replacing(from), errors(from), buffers(from), clears(from), clearRanges(from),
          clearTiles(from), fills(from), changes(from), candidates(from), promised(from), nextPromised(from),
          victims(from), pool(from) {}
    DemandCore(const DemandCore&) = delete;
    DemandCore& operator=(const DemandCore&) = delete;
    ~DemandCore() override;

    Expected<void> Prepare() noexcept;

    // DemandReading.h
    void RunTask() noexcept override;
    void RunAll() noexcept;
    void Start(const Candidate& candidate, const Shared<TicketState>& ticket) noexcept;
    void CancelQueued(const TileSet& set) noexcept;
    void Close(bool wait) noexcept;
    void ReportFailure(const TileRef& ref, const Error& error) noexcept;
    void Settle(const TileRef& ref, TileState state) noexcept;
    void ReturnBuffer(std::byte* buffer) noexcept;
    void ClearBits(const TileRef& ref) noexcept;
    void ClearBit(std::uint32_t entry) noexcept;
    void ClearAllBitsOf(std::uint32_t texture) noexcept;
    ReadTask PopTask() noexcept;
    void NotifyWorkers() noexcept;
    std::byte* TakeBuffer() noexcept;
    void FinishRead(const ReadTask& task, std::byte* buffer, const Expected<TileRead>& result) noexcept;
    void FinishPage(const ReadTask& task, const Expected<PageRead>& result) noexcept;

    // DemandTextures.h
    Expected<Shared<TileSet>> MakeSet(Shared<TileSource> source, bool hasRows);
    Expected<Shared<TileSet>> FindOrMakeSet(Shared<TileSource> source, bool hasRows);
    Expected<DemandId> AddTexture(Shared<TileSource> source, const TiledTextureDesc& desc);
    Expected<DemandId> AddResource(std::uint32_t pages, PageCallback callback);
    Expected<void> ReplaceTexture(DemandId id, Shared<TileSource> source, const TiledTextureDesc& desc);
    Expected<void> Remove(DemandId id, DemandTexture::Kind kind);
    Expected<void> InvalidatePage(DemandId id, std::uint32_t page);
    Expected<DemandTexture*> Find(DemandId id, DemandTexture::Kind kind);
    Expected<void> Register(std::uint32_t index, DemandTexture::Kind kind, Shared<TileSet> set);
    Expected<void> SetBudget(std::uint32_t tiles, std::uint64_t bytes);
    void FillGeometry(const TileLayout& layout, TiledTextureDesc& desc,
                      std::array<TiledLevel, NTC_MAX_LEVELS>& levels) const noexcept;
    void Show(TileSet& set, std::uint32_t texture);
    void Hide(TileSet& set, std::uint32_t texture) noexcept;
    void Drop(Shared<TileSet>& set) noexcept;
    Expected<void> Map(const TileSet& set, std::uint32_t tile, std::uint32_t slot, std::uint32_t texture);
    Expected<void> MapAll(const TileSet& set, std::uint32_t tile, std::uint32_t slot);
    void UnmapAll(const TileSet& set, std::uint32_t tile) noexcept;

    // DemandRequests.h
    Expected<Shared<TicketState>> Process(DemandContext context, const DemandReadback& readback,
                                          const DemandLimits& limits);
    Expected<void> Abandon(DemandContext context);
    bool CloseLaunch(std::uint32_t round, OpenLaunch& launch) noexcept;
    void Classify(const NtcTileRequest& request, std::uint32_t round);
    void AddAncestors(Candidate candidate);
    void AddPromised();
    bool AddCandidate(Candidate candidate);
    void SortCandidates() noexcept;
    void Take(const DemandLimits& limits, const Shared<TicketState>& ticket);
    void QueueBases();
    void RetryFailed(std::uint32_t age) noexcept;

    // DemandEviction.h
    bool HasRoomFor(std::uint32_t bytes) const noexcept;
    bool IsEvictable(const TileRecord& record, const TileSet& set, std::uint32_t tile) const noexcept;
    void Evict(std::span<const Candidate> unserved, std::span<const std::uint32_t> stamps) noexcept;
    void Stage(std::uint32_t place) noexcept;
    void Restore(TileSet& set, std::uint32_t tile, TileRecord& record) noexcept;
    void ReleaseStaged() noexcept;
    void AddChild(const TileSet& set, std::uint32_t tile, int change) noexcept;
    void RemoveResident(std::uint32_t place) noexcept;

    // DemandPublish.h
    Expected<LaunchPlan> PrepareLaunch(TileUploader& uploader, const DemandLimits& limits);
    void SelectFilled(const DemandLimits& limits) noexcept;
    void Publish(const FilledTile& tile, TileUploader& uploader, Lock& lock, LaunchPlan& plan) noexcept;
    void PublishPage(const FilledTile& page) noexcept;
    bool MakeResident(const TileRef& ref) noexcept;
    bool GrowResidents() noexcept;
    void FinishReplacements() noexcept;
    void CollectFills() noexcept;
    void CollectChanges() noexcept;

    std::uint32_t GetOutstanding() const noexcept {
        return queuedCount + reading + static_cast<std::uint32_t>(filled.size());
    }
    std::uint32_t GetSlotLimit() const noexcept { return std::min(options.budgetTiles, pool.GetSize()); }
    DemandProgress GetProgress() const noexcept;
    DemandStatistics GetStatistics() const noexcept;

    Allocator& allocator;
    DemandLoaderOptions options;
    Mutex apiMutex; ///< calls of the owner, one after another
    Mutex mutex;    ///< everything below; not held while a source or an uploader runs
    Condition idle;
    PageTable table;
    Array<DemandTexture> textures;
    Array<ReadTask> heap;                      ///< the first is the most urgent
    Array<Shared<TicketState>> readingTickets; ///< of the tasks that run; some are empty
    Array<FilledTile> filled;
    Array<FilledTile> publishing;
    Array<StagedTile> staged; ///< in the order of staging
    Array<FailedTile> failed;
    Array<TileRef> residents; ///< Resident and Staged
    Array<Shared<TileSet>> pendingBases;
    Array<std::uint32_t> replacing; ///< textures with a next set
    Array<DemandError> errors;
    std::uint64_t lostErrors = 0;
    Array<std::byte*> buffers;    ///< of slotBytes each, not in use
    Array<std::uint32_t> clears;  ///< entries whose request bit becomes 0
    Array<StateFill> clearRanges; ///< words of request bits that become 0
    Array<TileRef> clearTiles;    ///< the same by tile, for all textures that show it
    bool clearAll = true;
    Array<StateFill> fills;
    Array<PageTable::ByteRange> changes;
    Array<Candidate> candidates;
    Array<TileRef> promised; ///< tiles for which others in use were staged
    Array<TileRef> nextPromised;
    Array<std::uint32_t> victims; ///< a heap of places among the residents
    SlotPool pool;
    std::array<OpenLaunch, 16> launches{};
    std::size_t launchCount = 0;
    std::size_t residentRoom = 0; ///< tiles that `residents`, `victims` and `staged` have room for
    std::uint64_t nextNumber = 0;
    std::uint64_t baseTiles = 0; ///< of all sets: always resident in the end
    std::uint64_t baseBytes = 0;
    std::uint32_t round = 0;
    std::uint32_t turn = 0; ///< entry that comes first among equals
    std::uint32_t queuedCount = 0;
    std::uint32_t reading = 0;
    std::uint32_t basesWaiting = 0; ///< tiles of tails that could not begin to be read
    std::uint32_t toNotify = 0;     ///< tasks that the pool does not know of yet
    std::uint64_t hostBytes = 0;
    bool isClosed = false;
    bool isAborted = false; ///< threads may still be in sources
    DemandProgress progress;
    DemandStatistics statistics;
    Shared<WorkerPool> workers; ///< empty: the caller reads
    bool ownsWorkers = false;
};

inline Expected<void> DemandCore::Prepare() noexcept {
    OPENNTC_CHECK(pool.Reset(options.slots));
    residentRoom = options.slots;
    OPENNTC_CHECK(residents.Reserve(options.slots));
    OPENNTC_CHECK(victims.Reserve(options.slots));
    OPENNTC_CHECK(staged.Reserve(options.slots));
    OPENNTC_CHECK(heap.Reserve(options.maxOutstanding));
    OPENNTC_CHECK(readingTickets.Reserve(options.maxOutstanding));
    OPENNTC_CHECK(filled.Reserve(options.maxOutstanding));
    OPENNTC_CHECK(publishing.Reserve(options.maxOutstanding));
    OPENNTC_CHECK(buffers.Reserve(options.maxOutstanding));
    OPENNTC_CHECK(fills.Reserve(kMaxFills + 1));
    OPENNTC_CHECK(changes.Reserve(1));
    return {};
}

inline DemandCore::~DemandCore() {
    for (FilledTile& tile : filled)
        ReturnBuffer(tile.buffer);
    for (std::byte* buffer : buffers)
        allocator.Deallocate(buffer, options.slotBytes);
}

inline DemandProgress DemandCore::GetProgress() const noexcept {
    DemandProgress now = progress;
    now.round = round;
    now.outstanding = GetOutstanding();
    now.filled = statistics.filled;
    now.failed = failed.size();
    return now;
}

inline DemandStatistics DemandCore::GetStatistics() const noexcept {
    DemandStatistics now = statistics;
    now.slotsInUse = pool.GetInUse();
    now.bytesInUse = pool.GetBytes();
    now.residentTiles = static_cast<std::uint32_t>(residents.size());
    now.stagedTiles = static_cast<std::uint32_t>(staged.size());
    now.reading = queuedCount + reading;
    now.waiting = static_cast<std::uint32_t>(filled.size());
    for (const DemandTexture& texture : textures)
        now.textures += texture.kind != DemandTexture::Kind::Unused ? 1 : 0;
    now.pagesInUse = table.GetUsedTiles();
    now.hostBytes = hostBytes;
    return now;
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
