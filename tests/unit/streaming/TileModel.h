// SPDX-License-Identifier: MIT
// A second, slow tile manager to compare the first with. It shares no code with it: overlaps are compared as
// fractions, tile by tile, everything is recounted, and where a manager is free to choose (which request,
// which
// slot, which of several old tiles) it looks what ours chose and judges whether that was allowed.
#pragma once

#include "openntc/streaming/TileManager.h"

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace openntc_tests {

struct ModelTile {
    int level = 0;                                      ///< the number of levels: tail
    long long left = 0, top = 0, right = 0, bottom = 0; ///< texels of the level
    openntc::ManagedTileState state = openntc::ManagedTileState::Free;
    bool isPinned = false;
    bool isWanted = false;
    double lastWanted = 0;
    long requested = 0;                                ///< operation in which it was requested
    long inStandby = 0;                                ///< operation in which it went to standby
    std::pair<std::uint32_t, std::uint32_t> slot = {}; ///< heap, number
    bool isFetched = false;                            ///< its map order
    bool isMoving = false;
    bool isMoveFetched = false;
    std::uint32_t ticket = 0; ///< of the map order; of the move order, while moving
    std::pair<std::uint32_t, std::uint32_t> moveTo = {};
};

struct ModelTexture {
    int width = 0, height = 0, mips = 0, tailTiles = 0;
    int regionWidth = 0, regionHeight = 0, regionsX = 0, regionsY = 0;
    int mapX = 1, mapY = 1;
    std::vector<openntc::TileLevelDesc> levels;
    std::vector<ModelTile> tiles;
    std::vector<std::vector<int>> related;               ///< tiles of coarser levels, and itself
    std::vector<std::vector<std::vector<int>>> ofRegion; ///< [region][level]: tiles that it wants
    std::vector<std::uint8_t> feedback;
    int bias = 0, streamedMips = 0;
    bool isFollowing = false;
    std::vector<std::uint8_t> shadow; ///< the residency map by its changes
    openntc::ManagedTextureId id;
};

class TileModel {
public:
    TileModel(openntc::TileManager& manager, std::uint32_t tilesPerHeap)
        : manager_(manager), perHeap_(tilesPerHeap) {}

    /// What went wrong first; empty as long as everything is right.
    const std::string& GetFinding() const { return finding_; }

    // Each carries the operation out on the manager and on the model. Texture numbers are places in
    // GetTextures.
    void Add(const openntc::TileLayoutDesc& desc);
    void Remove(std::size_t texture);
    void Update(std::size_t texture, const std::vector<std::uint8_t>& map, const openntc::TileUpdateOptions&);
    /// One call for all; textures may come twice.
    void UpdateMany(const std::vector<std::pair<std::size_t, std::vector<std::uint8_t>>>& maps,
                    const openntc::TileUpdateOptions&);
    void UpdateChanges(std::size_t texture, const std::vector<openntc::RegionChange>& changes,
                       const openntc::TileUpdateOptions&);
    void UpdateAll(const std::vector<std::pair<std::size_t, openntc::RegionChange>>& changes, double time,
                   double timeout);
    void Match(std::size_t primary, std::size_t follower, double time, double timeout);
    void AddHeap(std::uint32_t heap);
    void RemoveHeap(std::uint32_t heap);
    void SetStandbyTarget(std::uint32_t tiles);
    void Trim();
    void Allocate();
    void Defragment(std::uint32_t count);
    void Fetch();
    void FetchResidency();
    void ConfirmMaps(const std::vector<openntc::TileMapOrder>& orders);
    void ConfirmMoves(const std::vector<openntc::TileMoveOrder>& orders);
    void ConfirmTiles(std::size_t texture, const std::vector<std::uint32_t>& tiles);

    /// Compares all that can be asked for.
    void Compare();

    const std::vector<ModelTexture>& GetTextures() const { return textures_; }
    const std::vector<std::uint32_t>& GetHeaps() const { return heaps_; }
    /// All orders ever fetched, also of textures that are gone.
    const std::vector<openntc::TileMapOrder>& GetMapOrders() const { return mapOrders_; }
    const std::vector<openntc::TileMoveOrder>& GetMoveOrders() const { return moveOrders_; }
    long GetOperations() const { return operation_; }

private:
    void Expect(bool isGood, const std::string& text) {
        if (!isGood && finding_.empty())
            finding_ = text;
    }
    void TakeMap(ModelTexture& texture, const std::vector<std::uint8_t>& map,
                 const openntc::TileUpdateOptions& options);
    void SetWanted(ModelTexture& texture, const std::vector<char>& wanted, double time, double timeout);
    std::vector<char> GetWanted(const ModelTexture& texture) const;
    static int GetLevel(const ModelTexture& texture, int value);
    std::uint8_t GetResidency(const ModelTexture& texture, std::size_t finest) const;
    ModelTexture* Find(openntc::ManagedTextureId id);
    std::uint64_t CountSlots() const;
    std::uint64_t Count(openntc::ManagedTileState state) const;
    std::size_t GetHeapNumber(std::uint32_t heap) const;
    std::uint32_t FollowEvictions();
    void Evict(ModelTexture& texture, std::uint32_t tile);
    void CheckEvicted(const std::vector<std::pair<ModelTexture*, std::uint32_t>>& evicted);
    void CheckServed(const std::vector<std::pair<ModelTexture*, std::uint32_t>>& served);

    openntc::TileManager& manager_;
    std::uint32_t perHeap_;
    std::uint32_t standbyTarget_ = 1000;
    std::vector<ModelTexture> textures_;
    std::vector<std::uint32_t> heaps_;            ///< in the order in which they were added
    std::vector<openntc::TileUnmapOrder> unmaps_; ///< not fetched
    std::vector<openntc::TileMapOrder> mapOrders_;
    std::vector<openntc::TileMoveOrder> moveOrders_;
    std::uint64_t stale_ = 0;
    long operation_ = 0;
    std::string finding_;
};

} // namespace openntc_tests
