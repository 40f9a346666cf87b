// SPDX-License-Identifier: MIT
// Stability: experimental
// What goes into a demand loader and comes out of it.
#pragma once

#include "openntc/streaming/HostPageTable.h"
#include "openntc/streaming/TileSource.h"
#include "openntc/streaming/WorkerPool.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A texture or resource of one loader. `index` is what shaders are given (NtcTileRequest::textureId); it is
/// used again after removal, with another generation. The default names nothing.
struct DemandId {
    std::uint32_t index = 0xFFFFFFFFu;
    std::uint32_t generation = 0;

    friend bool operator==(const DemandId&, const DemandId&) = default;
};

struct DemandLoaderOptions {
    PageTableLimits table;           ///< of the buffers on the device; maxSlots ≥ slots
    std::uint32_t slots = 4096;      ///< tiles in the pool, 1 … 2^28
    std::uint32_t slotBytes = 65536; ///< of each, a multiple of 16
    std::uint32_t firstSlot = 0;     ///< slot s has stamp and slice row firstSlot + s
    std::uint32_t slotsOffset = 0;   ///< bytes from the start of the pool's buffer to slot 0
    std::uint32_t pool = 0;          ///< the engine's number of that buffer

    // Limits.
    std::uint32_t budgetTiles = 0xFFFFFFFFu;       ///< slots in use at a time; see SetBudget
    std::uint64_t budgetBytes = ~std::uint64_t{0}; ///< bytes of the tiles in them
    std::uint32_t maxOutstanding = 256;            ///< tiles being read or waiting for upload
    std::uint32_t framesInFlight =
        2; ///< launch n has ended when launch n + framesInFlight is prepared; 1 … 16

    // Reading.
    int threads = 2;            ///< of an own pool; 0: the calling thread reads before the call returns
    Shared<WorkerPool> workers; ///< shared with other loaders; then `threads` is ignored
    bool coalesce = true;       ///< textures of the same source (IsSameSource) share tiles, reads and slots
    bool shareUniform = true;   ///< image tiles of one repeated 16-byte pattern share a slot
    bool loadAncestors = true;  ///< a tile brings the missing coarser ones above it, so that they come first
    std::uint32_t retryAfterRounds =
        0; ///< a failed tile may be asked for again after so many; 0: RetryFailed
};

/// What a resource's callback says.
struct PageRead {
    TileAnswer answer = TileAnswer::Ready;
    std::uint32_t value = 0; ///< of the page table's entry; not NTC_TILE_MISSING
};

/// Fetches pages of a resource. Called by any thread of the pool, for several pages at once; may block, and
/// may throw where exceptions are on.
struct PageCallback {
    Expected<PageRead> (*call)(void* user, std::uint32_t page) = nullptr;
    void* user = nullptr;
};

/// How much a call may begin; the rest is asked for again by later launches.
struct DemandLimits {
    std::uint32_t maxTiles = 0xFFFFFFFFu;
    std::uint64_t maxBytes = ~std::uint64_t{0};
};

/// One launch, from LaunchPrepare to ProcessRequests or AbandonLaunch.
struct DemandContext {
    std::uint32_t round = 0; ///< 1, 2, …: NtcStreamingConstants::round of the launch; 0: none
};

/// What the launch left behind. The bytes are read during the call only.
struct DemandReadback {
    RequestList requests; ///< ReadRequests (HostPageTable.h) gives it
    /// One per slot, from LaunchState::stampsWord on; may be empty: then tiles count as used when they were
    /// uploaded.
    std::span<const std::uint32_t> stamps;
};

/// Words of the launch state that become 0.
struct StateFill {
    std::uint32_t firstWord = 0;
    std::uint32_t words = 0;
};

/// What has to be on the device before the launch, in this order: what Upload copied, the changed bytes of
/// the page table, the cleared words of the launch state and the empty queue. All of it behind what launches
/// before this one still read. The spans stay until the next LaunchPrepare, the table's bytes until the next
/// call.
struct LaunchPlan {
    DemandContext context;
    std::span<const PageTable::ByteRange> tableChanges; ///< of GetPageTable().GetBytes()
    std::span<const StateFill> stateFills;              ///< request bits that may be set again
    std::uint32_t uploadedTiles = 0;                    ///< calls of Upload that succeeded
};

/// Data for a slot.
struct TileUpload {
    std::uint32_t slot = 0;
    std::uint64_t offset = 0;                   ///< slotsOffset + slot × slotBytes
    std::uint32_t textureId = NTC_TILE_MISSING; ///< the first of those that share it; none before it is shown
    std::uint32_t tile = 0;
    std::span<const std::byte> bytes; ///< at most slotBytes
};

/// The engine's way to bring data into the pool.
class TileUploader {
public:
    virtual ~TileUploader() = default;
    /// Brings the bytes to where the launch finds them in the slot: into memory that it reads, or into a
    /// staging buffer with a copy recorded before the launch. Called by LaunchPrepare on its thread; must not
    /// call the loader. An error is the tile's: it is reported, and the slot given back.
    virtual Expected<void> Upload(const TileUpload& upload) = 0;
};

/// A tile or page that could not be had. Each is reported once, and not read again before a retry.
struct DemandError {
    DemandId texture;
    std::uint32_t tile = 0;
    TilePosition position; ///< of a resource's page: level 0, x = page
    Error error{Status::Ok};
};

enum class DemandState {
    Working,    ///< something is being read, or the last launch asked for something
    Done,       ///< a launch that saw all that was read asked for nothing
    OverBudget, ///< what the last launch asked for does not fit, and all that is there is in use
};

struct DemandProgress {
    DemandState state = DemandState::Working;
    std::uint32_t round = 0;       ///< of the last LaunchPrepare
    std::uint32_t requested = 0;   ///< by the last launch that was processed, those that overflowed included
    std::uint32_t outstanding = 0; ///< tiles and pages being read or waiting for upload
    std::uint32_t unserved = 0;    ///< requests of that launch for which there was no room
    std::uint32_t quietRounds = 0; ///< complete launches without a request, one after another. Where requests
                                   ///< are made at a rate p < 1, wait for several
    std::uint64_t filled = 0;      ///< tiles and pages that arrived, since the beginning
    std::uint64_t failed = 0;      ///< those that are in error now
};

/// Sums since the beginning, except where it says "now". Each sum is the number on its left.
struct DemandStatistics {
    std::uint64_t rounds = 0;    ///< calls of LaunchPrepare
    std::uint64_t processed = 0; ///< launches whose requests were processed
    std::uint64_t abandoned = 0; ///< launches whose requests were not
    std::uint64_t overflow = 0;  ///< requests that found the queue full

    // requested = taken + restored + known + inError + stale + overLimit + noRoom
    std::uint64_t requested = 0; ///< entries of queues
    std::uint64_t taken = 0;     ///< reading began
    std::uint64_t restored = 0;  ///< staged for eviction, and kept
    std::uint64_t known = 0;     ///< being read, or resident by now
    std::uint64_t inError = 0;
    std::uint64_t stale = 0;     ///< of a texture removed, replaced, or not there at all
    std::uint64_t overLimit = 0; ///< limits of the call, maxOutstanding, or host memory
    std::uint64_t noRoom = 0;    ///< no slot free

    // taken + ancestors + tails = started = filled + failed + deferred + cancelled + reading now
    std::uint64_t ancestors = 0; ///< read because a finer tile was asked for
    std::uint64_t tails = 0;     ///< read because their texture was made, replaced or retried
    std::uint64_t started = 0;
    std::uint64_t filled = 0;   ///< data arrived
    std::uint64_t deferred = 0; ///< the source said "later"
    std::uint64_t failed = 0;
    std::uint64_t cancelled = 0; ///< their texture went away
    std::uint64_t bytesRead = 0;

    // filled = uploaded + shared + pages + uploadFailed + discarded + waiting for upload now
    std::uint64_t uploaded = 0;
    std::uint64_t shared = 0; ///< found their bytes in a slot: uniform tiles
    std::uint64_t pages = 0;  ///< of resources
    std::uint64_t uploadFailed = 0;
    std::uint64_t discarded = 0; ///< their texture went away
    std::uint64_t bytesUploaded = 0;

    // evicted = restored, requested or not, + freed + staged now
    std::uint64_t evicted = 0; ///< staged
    std::uint64_t rescued = 0; ///< staged, and restored
    std::uint64_t freed = 0;
    std::uint64_t thrashed = 0; ///< read again within 64 rounds of being freed

    // Now.
    std::uint32_t slotsInUse = 0;
    std::uint64_t bytesInUse = 0;
    std::uint32_t residentTiles = 0; ///< staged ones and tails included
    std::uint32_t tailTiles = 0;     ///< of those: never evicted
    std::uint32_t stagedTiles = 0;
    std::uint32_t reading = 0; ///< started and not ended
    std::uint32_t waiting = 0; ///< filled and not uploaded
    std::uint32_t textures = 0;
    std::uint32_t pagesInUse = 0; ///< entries of the page table
    std::uint64_t hostBytes = 0;  ///< tile data in host memory
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
