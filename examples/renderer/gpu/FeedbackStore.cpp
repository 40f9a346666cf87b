// SPDX-License-Identifier: MIT
// What is registered: pools, atlases, page table.
#include "renderer/gpu/FeedbackStore.h"

#include "renderer/gpu/RequireDevice.h"

#include <algorithm>
#include <numeric>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

constexpr std::uint32_t kStreamingSet = 2, kTable = 0, kFeedback = 2, kConstants = 3;

} // namespace

std::vector<std::size_t> FeedbackStore::Add(int set, const TextureSetMetadata& metadata,
                                            const tool::DecodeData& data,
                                            const std::vector<StreamedTexture>& textures) {
    // By format, so that sets with the same formats have the same atlases.
    std::vector<std::size_t> order(textures.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return GetStoredFormat(textures[a].slot) < GetStoredFormat(textures[b].slot);
    });
    StreamedSet streamed{
        &metadata,
        data.constants,
        RequireDevice(context_.CreateBuffer(data.latents, BufferKind::Storage, BufferMemory::DeviceLocal)),
        RequireDevice(context_.CreateBuffer(data.weights, BufferKind::Storage, BufferMemory::DeviceLocal)),
        RequireDevice(MakeFeedbackLayout(metadata.GetDesc(), options_.tileSize)),
        {},
        {}};
    std::vector<std::size_t> numbers(textures.size());
    std::vector<ImageFormat> formats;
    for (std::size_t i = 0; i < order.size(); ++i) {
        const StreamedTexture& texture = textures[order[i]];
        streamed.slots.push_back(texture.slot);
        streamed.outputs.push_back(MakeOutput(texture.slot, texture.isColor));
        formats.push_back(GetStoredFormat(texture.slot));
        numbers[order[i]] = i;
    }
    const auto found =
        std::find_if(pools_.begin(), pools_.end(), [&](const Pool& pool) { return pool.formats == formats; });
    const auto pool = static_cast<std::size_t>(found - pools_.begin());
    if (found == pools_.end())
        pools_.emplace_back().formats = std::move(formats);
    pools_[pool].sets.push_back(set);
    sets_.emplace(set, Entry{std::move(streamed), pool, 0, {}});
    return numbers;
}

std::uint64_t FeedbackStore::GetTileBytes(const Pool& pool) const {
    const auto texels =
        static_cast<std::uint64_t>(options_.tileSize) * static_cast<std::uint64_t>(options_.tileSize);
    std::uint64_t bytes = 0;
    for (const ImageFormat format : pool.formats)
        bytes += texels / (format >= ImageFormat::BC1 ? 16 : 1) * GetTexelBytes(format);
    return bytes;
}

PoolDemand FeedbackStore::GetDemand(const Pool& pool) const {
    std::uint64_t tiles = 0, pinned = 0;
    for (const int set : pool.sets) {
        const TileLayout& layout = sets_.at(set).set.layout;
        tiles += static_cast<std::uint64_t>(layout.GetTileCount());
        pinned += CountPinnedTiles(layout);
    }
    const std::uint64_t inLayer = std::uint64_t{pool.across} * pool.across;
    const auto toLayers = [&](std::uint64_t count) {
        return static_cast<std::uint32_t>(
            std::min<std::uint64_t>((count + inLayer - 1) / inLayer, kMostLayers));
    };
    return {inLayer * GetTileBytes(pool), toLayers(pinned), toLayers(tiles)};
}

void FeedbackStore::Start() {
    std::vector<PoolDemand> demands;
    for (Pool& pool : pools_) {
        std::uint64_t tiles = 0;
        for (const int set : pool.sets)
            tiles += static_cast<std::uint64_t>(sets_.at(set).set.layout.GetTileCount());
        pool.across = ChooseTilesAcross(tiles, options_.tileSize);
        demands.push_back(GetDemand(pool));
    }
    const std::vector<std::uint32_t> layers =
        ShareBudget(demands, static_cast<std::uint64_t>(options_.budgetMiB * 1048576.0));
    MakeTable();
    for (std::size_t i = 0; i < pools_.size(); ++i)
        StartPool(pools_[i], layers[i]);
    TileSeconds ignored;
    DecodePending(SIZE_MAX, ignored);
    decoded_ = 0; // the coarsest tiles are part of loading
    UploadTable();
}

void FeedbackStore::MakeTable() {
    PageTableLimits limits;
    for (const auto& [set, entry] : sets_) {
        const TileLayout& layout = entry.set.layout;
        ++limits.maxTextures;
        limits.maxTiles += static_cast<std::uint32_t>(layout.GetTileCount());
        limits.maxRegions += (static_cast<std::uint32_t>(layout.GetRegionCount()) + 3u) & ~3u;
    }
    for (const Pool& pool : pools_)
        limits.maxSlots = std::max(limits.maxSlots, kMostLayers * pool.across * pool.across);
    table_ = RequireDevice(PageTable::Create(limits));
    for (auto& [set, entry] : sets_) {
        const TileLayout& layout = entry.set.layout;
        std::vector<TiledLevel> levels;
        for (const TileLevel& level : layout.GetLevels())
            levels.push_back({level.firstMip, level.lastMip});
        TiledTextureDesc desc;
        desc.width = layout.GetWidth();
        desc.height = layout.GetHeight();
        desc.mips = layout.GetMips();
        desc.tileWidth = desc.tileHeight = options_.tileSize;
        desc.levels = levels;
        desc.tailTiles = layout.GetTailTileCount();
        desc.slotBytes = static_cast<std::uint32_t>(4 * options_.tileSize * options_.tileSize);
        entry.texture = RequireDevice(table_->Add(desc));
        setOfTexture_.resize(entry.texture + 1, set);
        setOfTexture_[entry.texture] = set;
    }
    ring_ = RequireDevice(FeedbackRing::Create(1, limits.maxRegions));
    const auto make = [&](std::uint64_t bytes, BufferKind kind) {
        return RequireDevice(context_.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal));
    };
    tableBuffer_ = make(table_->GetBytes().size(), BufferKind::Storage);
    feedback_ = make(std::uint64_t{4} * limits.maxRegions, BufferKind::Storage);
    lastBytes_ =
        RequireDevice(context_.CreateBuffer(std::vector<std::byte>(limits.maxRegions, std::byte{NTC_NO_MIP}),
                                            BufferKind::Storage, BufferMemory::DeviceLocal));
    changes_ = RequireDevice(
        context_.CreateBuffer(ring_->GetBytes(), BufferKind::Storage, BufferMemory::HostVisible));
    const NtcStreamingConstants constants = table_->MakeConstants(0);
    constants_ = RequireDevice(context_.CreateBuffer(std::as_bytes(std::span(&constants, 1)),
                                                     BufferKind::Uniform, BufferMemory::DeviceLocal));
    static constexpr BufferSlot kSlots[] = {
        {0, BufferKind::Storage}, {1, BufferKind::Storage}, {2, BufferKind::Storage}};
    resolve_ = RequireDevice(context_.CreateComputePipeline(shaders_.Get("ResolveFeedback.comp", {}), kSlots,
                                                            sizeof(NtcResolveFeedbackConstants)));
}

void FeedbackStore::StartPool(Pool& pool, std::uint32_t layers) {
    pool.mostLayers = layers;
    pool.atlases.resize(pool.formats.size());
    pool.manager =
        RequireDevice(TileManager::Create({.tilesPerHeap = pool.across * pool.across, .standbyTarget = 0}));
    for (const int set : pool.sets) {
        Entry& entry = sets_.at(set);
        entry.id = RequireDevice(pool.manager->AddTexture(entry.set.layout));
        pool.setOfIndex[entry.id.index] = set;
    }
    Schedule(pool);
}

const Image& FeedbackStore::GetAtlas(int set, std::size_t texture) const {
    return pools_[sets_.at(set).pool].atlases[texture];
}

void FeedbackStore::AddSlots(std::vector<BufferSlot>& slots) {
    slots.push_back({kTable, BufferKind::Storage, kStreamingSet});
    slots.push_back({kFeedback, BufferKind::Storage, kStreamingSet});
    slots.push_back({kConstants, BufferKind::Uniform, kStreamingSet});
}

void FeedbackStore::AddBuffers(std::vector<BoundBuffer>& buffers) const {
    buffers.push_back({kTable, &tableBuffer_, kStreamingSet});
    buffers.push_back({kFeedback, &feedback_, kStreamingSet});
    buffers.push_back({kConstants, &constants_, kStreamingSet});
}

FeedbackMemory FeedbackStore::GetMemory() const {
    FeedbackMemory memory;
    for (const Pool& pool : pools_) {
        for (const Image& atlas : pool.atlases)
            memory.atlases += atlas.GetBytes();
    }
    memory.pageTable = tableBuffer_.GetSize();
    memory.feedback = feedback_.GetSize() + lastBytes_.GetSize() + changes_.GetSize();
    memory.scratch = decoder_.GetBytes();
    return memory;
}

FeedbackStatistics FeedbackStore::GetStatistics() const {
    FeedbackStatistics statistics;
    for (const Pool& pool : pools_) {
        const TileManagerStatistics one = pool.manager->GetStatistics();
        statistics.tiles += one.tiles;
        statistics.wanted += one.wantedTiles;
        statistics.resident += one.mappedTiles + one.standbyTiles;
        statistics.waiting += one.requestedTiles + one.allocatedTiles;
        statistics.evicted += one.unmapOrders;
        statistics.thrashed += one.thrashedTiles;
        statistics.slots += one.slots;
        statistics.mostSlots += std::uint64_t{pool.mostLayers} * pool.across * pool.across;
    }
    statistics.decoded = decoded_;
    statistics.passes = passes_;
    statistics.passesUntilSettled = passesUntilSettled_;
    statistics.isComplete = isComplete_;
    statistics.decodedPerPass = decodedPerPass_;
    statistics.seconds = seconds_;
    return statistics;
}

} // namespace openntc::renderer
