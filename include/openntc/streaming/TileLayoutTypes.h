// SPDX-License-Identifier: MIT
// Stability: experimental
// What tile layouts are described with, and what they say.
#pragma once

#include "openntc/format/Limits.h"

#include <bit>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

inline constexpr int kMaxTileLevels = 21;           ///< regular levels of a layout
inline constexpr int kMaxTiledMips = 64;            ///< mips of a layout, those of the tail included
inline constexpr int kMaxTilesPerSide = 65536;      ///< of one level; also feedback regions per side
inline constexpr int kMaxTileCount = (1 << 24) - 1; ///< of one layout; also its feedback regions
inline constexpr int kNoTilesFeedback = 255;        ///< the byte for "nothing sampled" and "nothing resident"
inline constexpr int kLevelsAboveOneTile = -1;      ///< TileLayoutDesc::levelCount: see there

/// One regular level as it is described: its size in texels and the mips it serves, both inclusive.
struct TileLevelDesc {
    int width = 0;
    int height = 0;
    int firstMip = 0;
    int lastMip = 0;
};

/// What a layout is made from.
struct TileLayoutDesc {
    int width = 0; ///< texels of mip 0, 1 … kMaxImageDimension
    int height = 0;
    int tileWidth = 0; ///< texels of a level, 1 … kMaxImageDimension; need not be powers of two
    int tileHeight = 0;
    int mips = 1; ///< mips of the texture, tail included, 1 … kMaxTiledMips
    /// Regular levels, one mip each and sizes halving (rounded down); or kLevelsAboveOneTile: the mips that
    /// do not fit one tile. Not read where `levels` is given.
    int levelCount = kLevelsAboveOneTile;
    int tailTiles = 1; ///< tiles that hold the other mips together; 0 exactly if there are none
    /// Levels that do not halve, finest first. The first serves mip 0 first, each goes on where the one
    /// before
    /// it ends, and none is larger than the one before it.
    std::span<const TileLevelDesc> levels;
    /// Texels of mip 0 that one byte of feedback stands for. 0: a tile of level 0, as GetRegionSize says.
    int regionWidth = 0;
    int regionHeight = 0;
};

/// One regular level of a layout.
struct TileLevel {
    int width = 0; ///< texels
    int height = 0;
    int firstMip = 0; ///< of those it serves
    int lastMip = 0;
    int tilesX = 0;
    int tilesY = 0;
    std::uint32_t firstTile = 0; ///< number of its tile (0, 0)

    friend constexpr bool operator==(const TileLevel&, const TileLevel&) noexcept = default;
};

/// Where a tile is. For a tile of the tail: level = GetLevelCount(), x its number in the tail, y = 0.
struct TilePosition {
    int level = 0;
    int x = 0;
    int y = 0;

    friend constexpr bool operator==(const TilePosition&, const TilePosition&) noexcept = default;
};

/// Tiles left … right × top … bottom of one level, all inclusive.
struct TileRect {
    int left = 0;
    int top = 0;
    int right = 0;
    int bottom = 0;

    friend constexpr bool operator==(const TileRect&, const TileRect&) noexcept = default;
};

/// A rectangle of a mip and the same area of the mips - 1 coarser ones: what holds a tile's texels.
struct TileSlice {
    int firstMip = 0;
    int mips = 0;
    int left = 0; ///< texels of firstMip
    int top = 0;
    int width = 0;
    int height = 0;

    friend constexpr bool operator==(const TileSlice&, const TileSlice&) noexcept = default;
};

/// Texels of mip 0 along one axis of a feedback region: those of a tile, and while that is more than half the
/// texture the next smaller power of two; at least 1.
constexpr int GetRegionSize(int textureSize, std::int64_t tileSize) noexcept {
    std::int64_t region = tileSize;
    while (region > 1 && 2 * region > textureSize)
        region = static_cast<std::int64_t>(std::bit_floor(static_cast<std::uint64_t>(region - 1)));
    return static_cast<int>(region);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
