// SPDX-License-Identifier: MIT
// What happens between frames: feedback to orders of the tile manager, orders to tiles.
#include "renderer/gpu/FeedbackStore.h"
#include "renderer/gpu/RequireDevice.h"

#include <algorithm>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

/// Passes after which a tile that nobody has read gives its place away where others wait. Every pass sees all that is read;
/// a picture whose samples read different tiles keeps those of the last few.
constexpr double kTimeout = 4;
constexpr std::size_t kListedPasses = 256;

} // namespace

void FeedbackStore::Grow(Pool& pool, std::uint32_t layers) {
    const auto side = pool.across * static_cast<std::uint32_t>(options_.tileSize);
    for (std::size_t i = 0; i < pool.formats.size(); ++i) {
        Image& atlas = pool.atlases[i];
        Image larger = RequireDevice(context_.CreateImageArray(pool.formats[i], side, side, layers));
        std::vector<ImageToImage> regions;
        for (std::uint32_t layer = 0; layer < atlas.GetLayers(); ++layer)
            regions.push_back({0, 0, layer, {0, 0, layer, side, side}});
        if (!regions.empty())
            RequireDevice(context_.Copy(atlas, larger, regions));
        atlas = std::move(larger);
    }
    for (std::uint32_t layer = pool.manager->GetHeapCount(); layer < layers; ++layer)
        RequireDevice(pool.manager->AddHeap(layer));
}

void FeedbackStore::Schedule(Pool& pool) {
    const auto layers = static_cast<std::uint32_t>(
        std::min<std::uint64_t>(pool.manager->GetNumDesiredHeapsWithIdle(), pool.mostLayers));
    if (layers > pool.manager->GetHeapCount())
        Grow(pool, layers);
    RequireDevice(pool.manager->AllocateRequestedTiles());
    const TileOrders orders = pool.manager->FetchOrders();
    for (const TileUnmapOrder& order : orders.unmaps) {
        const Entry& entry = sets_.at(pool.setOfIndex.at(order.texture.index));
        RequireDevice(table_->Unmap(entry.texture, order.tile));
    }
    pool.pending.insert(pool.pending.end(), orders.maps.begin(), orders.maps.end());
}

void FeedbackStore::Confirm(Pool& pool, const TileMapOrder& order) {
    const Entry& entry = sets_.at(pool.setOfIndex.at(order.texture.index));
    RequireDevice(
        table_->Map(entry.texture, order.tile, order.to.heap * pool.across * pool.across + order.to.slot));
    pool.manager->ConfirmOrders(std::span(&order, 1));
}

std::size_t FeedbackStore::DecodePending(std::size_t most, TileSeconds& seconds) {
    std::vector<TileJob> jobs;
    std::vector<std::pair<Pool*, TileMapOrder>> orders;
    const auto size = static_cast<std::uint32_t>(options_.tileSize);
    for (bool isAny = true; isAny && jobs.size() < most;) {
        isAny = false;
        for (Pool& pool : pools_) {
            if (pool.pending.empty() || jobs.size() == most)
                continue;
            const TileMapOrder order = pool.pending.front();
            pool.pending.pop_front();
            isAny = true;
            jobs.push_back({&sets_.at(pool.setOfIndex.at(order.texture.index)).set, order.tile, &pool.atlases,
                            order.to.slot % pool.across * size, order.to.slot / pool.across * size,
                            order.to.heap});
            orders.emplace_back(&pool, order);
        }
    }
    decoder_.Run(jobs, seconds);
    for (const auto& [pool, order] : orders)
        Confirm(*pool, order);
    decoded_ += jobs.size();
    return jobs.size();
}

void FeedbackStore::UploadTable() {
    std::vector<BufferWrite> writes;
    for (PageTable::ByteRange range; table_->TakeChange(range);)
        writes.push_back({&tableBuffer_, range.offset, table_->GetBytes().subspan(range.offset, range.size)});
    if (!writes.empty())
        RequireDevice(context_.Write(writes));
}

std::size_t FeedbackStore::Resolve(TileSeconds& seconds) {
    const FeedbackTurn turn = RequireDevice(ring_->Begin());
    const NtcFeedbackChangesHead head = ring_->MakeHead();
    RequireDevice(context_.Write(changes_, 0, std::as_bytes(std::span(&head, 1))));
    const std::uint32_t regions = table_->GetUsedRegions();
    const NtcResolveFeedbackConstants push{0, 0, regions, 0};
    const BoundBuffer buffers[] = {{0, &feedback_}, {1, &lastBytes_}, {2, &changes_}};
    DispatchRequest request;
    request.pipeline = &resolve_;
    request.buffers = buffers;
    request.pushConstants = std::as_bytes(std::span(&push, 1));
    constexpr std::uint32_t kGroup = 4 * NTC_RESOLVE_FEEDBACK_GROUP;
    request.groups[0] = (regions + kGroup - 1) / kGroup;
    const DispatchTiming timing = RequireDevice(context_.Dispatch(request));
    seconds.resolve +=
        context_.GetDevice().isCpu ? timing.wallSeconds : timing.gpuSeconds.value_or(timing.wallSeconds);
    RequireDevice(ring_->Submit(turn.readback, passes_)); // has ended: the harness waits
    std::vector<std::byte> bytes(ring_->GetBytes());
    RequireDevice(context_.Read(changes_, 0, bytes));
    const std::optional<std::uint32_t> done = ring_->Poll(passes_);
    const FeedbackChanges changes = RequireDevice(ring_->Read(done.value(), bytes));
    std::vector<NtcFeedbackChange> sorted; // the device lists them in any order
    for (std::size_t i = 0; i < changes.GetCount(); ++i)
        sorted.push_back(changes[i]);
    std::sort(sorted.begin(), sorted.end(),
              [](const NtcFeedbackChange& a, const NtcFeedbackChange& b) { return a.region < b.region; });
    for (const NtcFeedbackChange& change : sorted) {
        const RegionOwner owner = RequireDevice(table_->FindRegion(change.region));
        const Entry& entry = sets_.at(setOfTexture_[owner.texture]);
        pools_[entry.pool].changes.push_back({entry.id, owner.region, static_cast<std::uint8_t>(change.mip)});
    }
    RequireDevice(ring_->Release(*done));
    return sorted.size();
}

bool FeedbackStore::Advance(TileSeconds& frame) {
    TileSeconds seconds;
    ++passes_;
    const std::size_t changes = Resolve(seconds);
    for (Pool& pool : pools_) {
        RequireDevice(
            pool.manager->UpdateAllWithRegionChanges(pool.changes, static_cast<double>(passes_), kTimeout));
        pool.changes.clear();
        Schedule(pool);
    }
    const std::size_t decoded = DecodePending(static_cast<std::size_t>(options_.tilesPerFrame), seconds);
    UploadTable();
    for (TileSeconds* const sum : {&frame, &seconds_}) {
        sum->resolve += seconds.resolve;
        sum->decode += seconds.decode;
        sum->transcode += seconds.transcode;
    }
    if (decodedPerPass_.size() < kListedPasses)
        decodedPerPass_.push_back(static_cast<std::uint32_t>(decoded));
    const std::uint64_t waiting = GetStatistics().waiting;
    isComplete_ = decoded == 0 && waiting == 0;
    quietPasses_ = decoded == 0 && changes == 0 ? quietPasses_ + 1 : 0;
    // What idles has left its place by then, and what waits still has none.
    const bool isSettled = isComplete_ || quietPasses_ > static_cast<std::uint64_t>(kTimeout);
    if (isSettled && passesUntilSettled_ == 0)
        passesUntilSettled_ = passes_;
    return isSettled;
}

} // namespace openntc::renderer
