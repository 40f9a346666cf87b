// SPDX-License-Identifier: MIT
// How textures that are decoded on demand are cut into tiles, and how a budget is shared. Needs no device.
#pragma once

#include "openntc/core/Rect.h"
#include "openntc/streaming/TileLayout.h"
#include "openntc/texture_set/MipChain.h"

#include <cstdint>
#include <span>
#include <vector>

namespace openntc::renderer {

inline constexpr int kSmallestTile = 16, kLargestTile = 1024;

/// A rectangle of a mip, and the texel of the tile at which it begins. All but `rect`'s size are multiples of 4, so that
/// its blocks are those of the whole mip.
struct TilePart {
    int mip = 0;
    Rect rect;
    int left = 0;
    int top = 0;
};

/// Mips larger than half a tile are levels; the others share the one tile of the tail (shaders/FeedbackTail.h). `tileSize`:
/// kSmallestTile ... kLargestTile, a power of two. Errors: those of TileLayout::Create.
Expected<TileLayout> MakeFeedbackLayout(const TextureSetDesc& set, int tileSize);

/// What a tile holds. The tile is one of the layout's.
std::vector<TilePart> GetTileParts(const TileLayout& layout, std::uint32_t tile);

/// Tiles that are never given up: the tail, or without one the coarsest level.
std::uint32_t CountPinnedTiles(const TileLayout& layout);

/// Tiles of a side of an atlas layer, such that at most 256 layers, which every device has, hold `tiles` where that is
/// possible: 2 ... 16.
std::uint32_t ChooseTilesAcross(std::uint64_t tiles, int tileSize);

inline constexpr std::uint32_t kMostLayers = 256;

/// Atlas layers that a pool of textures cannot do without, and can use at most.
struct PoolDemand {
    std::uint64_t layerBytes = 0;
    std::uint32_t fewest = 0;
    std::uint32_t most = 0;
};

/// Layers of each pool: the fewest, and of what is left over a share by what it lacks. `bytes` 0: no limit. Throws
/// CommandError(Usage) for a budget that does not hold the fewest.
std::vector<std::uint32_t> ShareBudget(std::span<const PoolDemand> pools, std::uint64_t bytes);

} // namespace openntc::renderer
