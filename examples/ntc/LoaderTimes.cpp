// SPDX-License-Identifier: MIT
#include "LoaderTimes.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/streaming/DemandLoader.h"

#include <algorithm>
#include <chrono>
#include <cstring>

namespace openntc::tool {

namespace {

/// Slots in memory.
class MemoryPool final : public TileUploader {
public:
    explicit MemoryPool(std::size_t bytes) : bytes_(bytes) {}
    Expected<void> Upload(const TileUpload& upload) override {
        std::memcpy(bytes_.data() + upload.offset, upload.bytes.data(), upload.bytes.size());
        return {};
    }
    std::span<const std::byte> Get() const { return bytes_; }

private:
    std::vector<std::byte> bytes_;
};

/// A tile in error stays missing: whoever waits until none is would wait for ever.
void ThrowTileError(DemandLoader& loader, const std::string& name) {
    DemandError error;
    if (loader.TakeError(error))
        throw CommandError(ExitCode::BadInput, name,
                           Format("tile %u: %s", error.tile, error.error.GetText()));
}

/// Asks for all tiles of all textures until they are there.
LoaderRun LoadAll(const LoaderJob& job, const std::vector<Shared<TileSource>>& sources, int threads) {
    std::uint32_t tiles = 0;
    for (const Shared<TileSource>& source : sources)
        tiles += static_cast<std::uint32_t>(source->GetLayout().GetTileCount());
    DemandLoaderOptions loading;
    loading.slots = tiles;
    loading.slotBytes = static_cast<std::uint32_t>((sources[0]->GetLargestTileBytes() + 15) / 16 * 16);
    const std::uint32_t textures = static_cast<std::uint32_t>(sources.size());
    loading.table = {textures, tiles, tiles, tiles, textures * NTC_MAX_MIPS, 0, 0};
    loading.framesInFlight = 1;
    loading.threads = threads;
    loading.coalesce = false;
    loading.maxOutstanding = static_cast<std::uint32_t>(job.limit);
    DemandLoader loader = Require(DemandLoader::Create(loading), ExitCode::Failed, "loader");
    MemoryPool pool(std::size_t{tiles} * loading.slotBytes);
    LoaderRun run;
    const auto begin = std::chrono::steady_clock::now();
    std::vector<NtcTileRequest> wanted, asked;
    for (const Shared<TileSource>& source : sources) {
        TiledTextureDesc desc;
        desc.format = job.format;
        desc.hasFeedback = false;
        const DemandId id = Require(loader.CreateTexture(source, desc), ExitCode::Failed, "texture");
        for (std::uint32_t t = 0; t < static_cast<std::uint32_t>(source->GetLayout().GetTileCount()); ++t)
            wanted.push_back({id.index, t});
    }
    while (!wanted.empty()) {
        ThrowIfInterrupted();
        const LaunchPlan plan = Require(loader.LaunchPrepare(pool), ExitCode::Failed, "launch");
        asked.clear();
        for (const NtcTileRequest& request : wanted) { // as a launch would
            if (*loader.GetPageTable().GetSlot(request.textureId, request.tile) == NTC_TILE_MISSING)
                asked.push_back(request);
        }
        wanted = asked;
        const std::size_t count = std::min(asked.size(), static_cast<std::size_t>(2 * job.limit));
        const DemandReadback readback{{std::as_bytes(std::span(asked).first(count)), 0}, {}};
        const DemandTicket ticket =
            Require(loader.ProcessRequests(plan.context, readback), ExitCode::Failed, "requests");
        ticket.Wait();
        loader.WaitIdle();
        ThrowTileError(loader, job.name);
        ++run.launches;
    }
    run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const DemandStatistics statistics = loader.GetStatistics();
    run.tiles = statistics.uploaded;
    run.bytes = statistics.bytesUploaded;
    for (std::uint32_t slot = 0; slot < tiles; ++slot) { // whatever the order: sums of sums
        run.crc += Crc32(
            pool.Get().subspan(std::size_t{slot} * loading.slotBytes, sources[0]->GetLargestTileBytes()));
    }
    return run;
}

} // namespace

std::vector<LoaderRun> TimeLoader(const LoaderJob& job, int threads, int repeat) {
    std::vector<LoaderRun> runs;
    for (int run = -1; run < repeat; ++run) { // the first warms up
        const LoaderRun loaded = LoadAll(job, job.open(), threads);
        if (run >= 0)
            runs.push_back(loaded);
    }
    return runs;
}

} // namespace openntc::tool
