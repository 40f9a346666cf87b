// SPDX-License-Identifier: MIT
// Textures of texture sets that are decoded on demand: shaders record what they read, the tile manager decides what is
// resident, tiles are decoded and transcoded into atlases.
#pragma once

#include "renderer/gpu/FeedbackDecoder.h"
#include "renderer/gpu/RenderOptions.h"

#include "openntc/streaming/FeedbackRing.h"
#include "openntc/streaming/HostPageTable.h"
#include "openntc/streaming/TileManager.h"

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

namespace openntc::renderer {

struct StreamedTexture {
    SlotPlan slot;
    bool isColor = false;
};

/// Bytes on the device.
struct FeedbackMemory {
    std::uint64_t atlases = 0;
    std::uint64_t pageTable = 0;
    std::uint64_t feedback = 0; ///< words, last bytes, changes
    std::uint64_t scratch = 0;  ///< texels and blocks of tiles that are being decoded

    /// Without scratch, as on load.
    std::uint64_t GetSum() const { return atlases + pageTable + feedback; }
};

struct FeedbackStatistics {
    std::uint64_t tiles = 0; ///< of all sets
    std::uint64_t wanted = 0;
    std::uint64_t resident = 0;
    std::uint64_t waiting = 0; ///< requested, without room or not decoded yet
    std::uint64_t evicted = 0; ///< since the start, as the next two
    std::uint64_t thrashed = 0;
    std::uint64_t decoded = 0;
    std::uint64_t passes = 0;                  ///< frames' drawings, each with its feedback
    std::uint64_t passesUntilSettled = 0;      ///< 0: has not been
    bool isComplete = false;                   ///< the last pass found everything
    std::vector<std::uint32_t> decodedPerPass; ///< of the first ones
    TileSeconds seconds;                       ///< of all passes
    std::uint64_t slots = 0, mostSlots = 0;    ///< that there are; that the budget allows
};

class FeedbackStore {
public:
    FeedbackStore(harness::Context& context, ShaderCache& shaders, const RenderOptions& options,
                  const DeviceFeatures& device)
        : context_(context), shaders_(shaders), options_(options),
          decoder_(context, shaders, device, options.tileSize, options.effort) {}

    /// Registers the textures of a set of the scene; returns their numbers, in their order. Throws CommandError.
    std::vector<std::size_t> Add(int set, const TextureSetMetadata& metadata, const tool::DecodeData& data,
                                 const std::vector<StreamedTexture>& textures);
    /// Makes atlases within the budget and decodes the coarsest tiles. Throws CommandError.
    void Start();

    /// Stays where it is after Start.
    const harness::Image& GetAtlas(int set, std::size_t texture) const;
    /// Number of the set in the page table.
    std::uint32_t GetTexture(int set) const { return sets_.at(set).texture; }

    /// What shaders with tiles read and write (shaders/FeedbackTiles.glsl).
    static void AddSlots(std::vector<harness::BufferSlot>& slots);
    void AddBuffers(std::vector<harness::BoundBuffer>& buffers) const;

    /// After a pass: takes its feedback and decodes up to RenderOptions::tilesPerFrame tiles, and adds the time to
    /// `frame`. True if another pass would
    /// show the same. Throws CommandError.
    bool Advance(TileSeconds& frame);

    FeedbackMemory GetMemory() const;
    FeedbackStatistics GetStatistics() const;

private:
    /// Sets whose textures are stored in the same formats: a slot is a tile of each of their atlases.
    struct Pool {
        std::vector<harness::ImageFormat> formats;
        std::vector<harness::Image> atlases;
        std::vector<int> sets;
        std::uint32_t across = 0;     // tiles of a layer's side
        std::uint32_t mostLayers = 0; // by the budget
        std::optional<TileManager> manager;
        std::deque<TileMapOrder> pending;        // not decoded yet
        std::map<std::uint32_t, int> setOfIndex; // of the manager's textures
        std::vector<TextureRegionChange> changes;
    };
    struct Entry {
        StreamedSet set;
        std::size_t pool = 0;
        std::uint32_t texture = 0;
        ManagedTextureId id;
    };

    PoolDemand GetDemand(const Pool& pool) const;
    void StartPool(Pool& pool, std::uint32_t layers);
    void MakeTable();
    std::uint64_t GetTileBytes(const Pool& pool) const;
    /// Atlases with more layers, and what was in them.
    void Grow(Pool& pool, std::uint32_t layers);
    /// Room for what is requested; carries out unmap orders, and keeps map orders.
    void Schedule(Pool& pool);
    /// Decodes up to `most` tiles, of the pools in turn. Returns how many.
    std::size_t DecodePending(std::size_t most, TileSeconds& seconds);
    void Confirm(Pool& pool, const TileMapOrder& order);
    void UploadTable();
    /// Gives the changes of the last pass to the pools; returns how many there were.
    std::size_t Resolve(TileSeconds& seconds);

    harness::Context& context_;
    ShaderCache& shaders_;
    const RenderOptions& options_;
    FeedbackDecoder decoder_;
    std::map<int, Entry> sets_; // by number in the scene
    std::vector<int> setOfTexture_;
    std::deque<Pool> pools_;
    std::optional<PageTable> table_;
    std::optional<FeedbackRing> ring_;
    harness::Buffer tableBuffer_, constants_, feedback_, lastBytes_, changes_;
    harness::ComputePipeline resolve_;
    std::uint64_t passes_ = 0, passesUntilSettled_ = 0, decoded_ = 0;
    std::uint64_t quietPasses_ = 0; // without changes and decoded tiles
    bool isComplete_ = false;
    std::vector<std::uint32_t> decodedPerPass_;
    TileSeconds seconds_;
};

} // namespace openntc::renderer
