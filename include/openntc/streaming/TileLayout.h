// SPDX-License-Identifier: MIT
// Stability: experimental
// How a texture is cut into tiles: levels, tile numbers, feedback regions, and which tiles of different
// levels
// belong together. Exact integers throughout; nothing here allocates.
//
// A layout has regular levels 0 … L - 1, each cut into tiles of the same size in its own texels (the last
// column and row may be smaller), and a tail: all coarser mips together, in P tiles. By default level k is
// mip
// k. The latents of a texture set serve several mips at once, so there a level serves mips firstMip … lastMip
// and has the size of the coarsest of them. Tiles are numbered level by level, row by row, the tail's last.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/streaming/TileAddress.h"
#include "openntc/streaming/TileLayoutTypes.h"
#include "openntc/streaming/detail/TileMath.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Immutable geometry of one tiled texture. Copies are cheap enough to keep (under a kilobyte).
class TileLayout {
public:
    /// Errors: OutOfRange for numbers outside the ranges stated at the members and at kMaxTile…;
    /// InvalidArgument for mips that are skipped or served twice, levels that grow, a tail without tiles,
    /// tail tiles without mips.
    static Expected<TileLayout> Create(const TileLayoutDesc& desc) noexcept;

    int GetWidth() const noexcept { return width_; } ///< texels of mip 0
    int GetHeight() const noexcept { return height_; }
    int GetMips() const noexcept { return mips_; }
    int GetTileWidth() const noexcept { return tileWidth_; } ///< texels of every level
    int GetTileHeight() const noexcept { return tileHeight_; }
    int GetLevelCount() const noexcept { return levelCount_; } ///< regular levels; 0: all is tail
    std::span<const TileLevel> GetLevels() const noexcept {
        return {levels_.data(), static_cast<std::size_t>(levelCount_)};
    }

    /// The first mip of the tail; GetMips() if there is none.
    int GetTailFirstMip() const noexcept { return tailFirstMip_; }
    /// Tiles that hold the tail together. Never assume 1.
    int GetTailTileCount() const noexcept { return tailTiles_; }
    int GetRegularTileCount() const noexcept {
        return regularTiles_;
    } ///< = the number of the first tail tile
    int GetTileCount() const noexcept { return regularTiles_ + tailTiles_; }

    /// Texels of mip 0 per region, regions per axis and in all: the size of a feedback map, row by row.
    int GetRegionWidth() const noexcept { return regionWidth_; }
    int GetRegionHeight() const noexcept { return regionHeight_; }
    int GetRegionsX() const noexcept { return regionsX_; }
    int GetRegionsY() const noexcept { return regionsY_; }
    int GetRegionCount() const noexcept { return regionsX_ * regionsY_; }

    /// Size of the residency map: a byte per tile of level 0, or one byte if all is tail.
    int GetResidencyWidth() const noexcept { return levelCount_ > 0 ? levels_[0].tilesX : 1; }
    int GetResidencyHeight() const noexcept { return levelCount_ > 0 ? levels_[0].tilesY : 1; }

    /// The level that serves a mip >= 0; GetLevelCount() for the tail and everything beyond the last mip.
    int GetLevelOfMip(int mip) const noexcept {
        int level = 0;
        while (level < levelCount_ && levels_[static_cast<std::size_t>(level)].lastMip < mip)
            ++level;
        return level;
    }

    /// Finest mip of a level 0 … GetLevelCount(): what the residency map says where that level is complete.
    int GetFirstMipOfLevel(int level) const noexcept {
        return level < levelCount_ ? levels_[static_cast<std::size_t>(level)].firstMip : tailFirstMip_;
    }

    /// Number of a tile. Errors: OutOfRange.
    Expected<std::uint32_t> GetTileNumber(const TilePosition& position) const noexcept;

    /// Place of a tile. Errors: OutOfRange.
    Expected<TilePosition> GetTilePosition(std::uint32_t tile) const noexcept;

    /// Tiles of a regular level that overlap feedback region (x, y). Not checked.
    TileRect GetTilesOfRegion(int x, int y, int level) const noexcept;

    /// Tiles of a regular level that overlap tile (x, y) of another one, finer or coarser. Not checked.
    TileRect GetRelatedTiles(const TilePosition& tile, int level) const noexcept;

    /// Tiles of a regular level that overlap a rectangle of tiles of a level of another layout (or of this
    /// one) in normalised coordinates. Not checked.
    TileRect GetOverlappingTiles(const TileLayout& other, int otherLevel, const TileRect& tiles,
                                 int level) const noexcept;

    /// The tile that holds a texel of a mip. In shaders: NtcTileOfTexel per axis. Errors: OutOfRange for a
    /// texel outside the mip; a mip of the tail gives its first tile.
    Expected<TilePosition> GetTileOfTexel(int mip, int x, int y) const noexcept;

    /// The slice to load for a tile of a regular level: all texels that GetTileOfTexel gives it, of all the
    /// mips that the level serves. For a tile of the tail: the whole image at the tail's mips. Errors:
    /// OutOfRange.
    Expected<TileSlice> GetTileSlice(std::uint32_t tile) const noexcept;

    /// Largest width and height (not always of one tile) among the slices of a regular level: what slots are
    /// sized for. Errors: OutOfRange.
    Expected<TileSlice> GetLargestTileSlice(int level) const noexcept;

    /// Size of a mip: max(width >> mip, 1).
    int GetMipWidth(int mip) const noexcept { return detail::GetTiledMipSize(width_, mip); }
    int GetMipHeight(int mip) const noexcept { return detail::GetTiledMipSize(height_, mip); }

    friend bool operator==(const TileLayout&, const TileLayout&) noexcept = default;

private:
    TileLayout() noexcept = default;

    Expected<void> SetLevels(const TileLayoutDesc& desc) noexcept;
    Expected<void> AddLevel(const TileLevelDesc& level) noexcept;
    Expected<void> SetRegions(const TileLayoutDesc& desc) noexcept;
    const TileLevel& GetLevel(int level) const noexcept { return levels_[static_cast<std::size_t>(level)]; }
    detail::TileAxis GetAxisX(int level) const noexcept { return {GetLevel(level).width, tileWidth_}; }
    detail::TileAxis GetAxisY(int level) const noexcept { return {GetLevel(level).height, tileHeight_}; }

    int width_ = 0;
    int height_ = 0;
    int mips_ = 0;
    int tileWidth_ = 0;
    int tileHeight_ = 0;
    int levelCount_ = 0;
    int tailFirstMip_ = 0;
    int tailTiles_ = 0;
    int regularTiles_ = 0;
    int regionWidth_ = 0;
    int regionHeight_ = 0;
    int regionsX_ = 0;
    int regionsY_ = 0;
    std::array<TileLevel, kMaxTileLevels> levels_ = {};
};

inline Expected<TileLayout> TileLayout::Create(const TileLayoutDesc& desc) noexcept {
    const struct {
        const char* name;
        int value;
        int least;
        int most;
    } numbers[] = {
        {"width", desc.width, 1, kMaxImageDimension},
        {"height", desc.height, 1, kMaxImageDimension},
        {"tileWidth", desc.tileWidth, 1, kMaxImageDimension},
        {"tileHeight", desc.tileHeight, 1, kMaxImageDimension},
        {"mips", desc.mips, 1, kMaxTiledMips},
        {"tailTiles", desc.tailTiles, 0, kMaxTileCount},
        {"regionWidth", desc.regionWidth, 0, kMaxImageDimension},
        {"regionHeight", desc.regionHeight, 0, kMaxImageDimension},
    };
    for (const auto& number : numbers) {
        if (number.value < number.least || number.value > number.most)
            return Fail(Status::OutOfRange, "%s: %d: must be %d … %d", number.name, number.value,
                        number.least, number.most);
    }
    TileLayout layout;
    layout.width_ = desc.width;
    layout.height_ = desc.height;
    layout.mips_ = desc.mips;
    layout.tileWidth_ = desc.tileWidth;
    layout.tileHeight_ = desc.tileHeight;
    layout.tailTiles_ = desc.tailTiles;
    OPENNTC_CHECK(layout.SetLevels(desc));
    if (layout.tailFirstMip_ == desc.mips && desc.tailTiles != 0)
        return Fail(Status::InvalidArgument, "tailTiles: %d: the levels serve all %d mips", desc.tailTiles,
                    desc.mips);
    if (layout.tailFirstMip_ < desc.mips && desc.tailTiles == 0)
        return Fail(Status::InvalidArgument, "tailTiles: 0: mips %d … %d are in no level",
                    layout.tailFirstMip_, desc.mips - 1);
    if (layout.GetTileCount() > kMaxTileCount)
        return Fail(Status::OutOfRange, "tiles: %d: must be 1 … %d", layout.GetTileCount(), kMaxTileCount);
    OPENNTC_CHECK(layout.SetRegions(desc));
    return layout;
}

inline Expected<void> TileLayout::SetLevels(const TileLayoutDesc& desc) noexcept {
    if (!desc.levels.empty()) {
        if (desc.levels.size() > kMaxTileLevels)
            return Fail(Status::OutOfRange, "levels: %zu: must be 0 … %d", desc.levels.size(),
                        kMaxTileLevels);
        for (const TileLevelDesc& level : desc.levels)
            OPENNTC_CHECK(AddLevel(level));
        return {};
    }
    int count = desc.levelCount;
    if (count == kLevelsAboveOneTile) {
        count = 0;
        while (count < desc.mips &&
               (GetMipWidth(count) > desc.tileWidth || GetMipHeight(count) > desc.tileHeight))
            ++count;
    }
    const int most = std::min(desc.mips, kMaxTileLevels);
    if (count < 0 || count > most)
        return Fail(Status::OutOfRange, "levelCount: %d: must be 0 … %d", count, most);
    for (int mip = 0; mip < count; ++mip)
        OPENNTC_CHECK(AddLevel({GetMipWidth(mip), GetMipHeight(mip), mip, mip}));
    return {};
}

inline Expected<void> TileLayout::AddLevel(const TileLevelDesc& level) noexcept {
    const int index = levelCount_;
    const int widest = index > 0 ? GetLevel(index - 1).width : kMaxImageDimension;
    const int highest = index > 0 ? GetLevel(index - 1).height : kMaxImageDimension;
    if (level.width < 1 || level.width > widest || level.height < 1 || level.height > highest)
        return Fail(Status::OutOfRange, "levels[%d]: %d × %d: must be 1 × 1 … %d × %d", index, level.width,
                    level.height, widest, highest);
    if (level.firstMip != tailFirstMip_ || level.lastMip < level.firstMip || level.lastMip >= mips_)
        return Fail(Status::InvalidArgument, "levels[%d]: mips %d … %d: must begin with %d and end before %d",
                    index, level.firstMip, level.lastMip, tailFirstMip_, mips_);
    TileLevel& added = levels_[static_cast<std::size_t>(index)];
    added = {level.width, level.height, level.firstMip, level.lastMip};
    added.tilesX = detail::TileAxis{level.width, tileWidth_}.GetTiles();
    added.tilesY = detail::TileAxis{level.height, tileHeight_}.GetTiles();
    added.firstTile = static_cast<std::uint32_t>(regularTiles_);
    if (added.tilesX > kMaxTilesPerSide || added.tilesY > kMaxTilesPerSide)
        return Fail(Status::OutOfRange, "levels[%d]: %d × %d tiles: at most %d a side", index, added.tilesX,
                    added.tilesY, kMaxTilesPerSide);
    const std::int64_t tiles = regularTiles_ + std::int64_t{added.tilesX} * added.tilesY;
    if (tiles > kMaxTileCount)
        return Fail(Status::OutOfRange, "levels[%d]: %lld tiles up to here: at most %d", index,
                    static_cast<long long>(tiles), kMaxTileCount);
    regularTiles_ = static_cast<int>(tiles);
    tailFirstMip_ = level.lastMip + 1;
    ++levelCount_;
    return {};
}

inline Expected<void> TileLayout::SetRegions(const TileLayoutDesc& desc) noexcept {
    const int shift = levelCount_ > 0 ? GetLevel(0).lastMip : 0;
    const auto pick = [&](int given, int tileSize, int imageSize) {
        // A level that serves mip 20 is one texel wide for every image.
        return given != 0 ? given : GetRegionSize(imageSize, std::int64_t{tileSize} << std::min(shift, 20));
    };
    regionWidth_ = pick(desc.regionWidth, tileWidth_, width_);
    regionHeight_ = pick(desc.regionHeight, tileHeight_, height_);
    regionsX_ = detail::TileAxis{width_, regionWidth_}.GetTiles();
    regionsY_ = detail::TileAxis{height_, regionHeight_}.GetTiles();
    if (regionsX_ > kMaxTilesPerSide || regionsY_ > kMaxTilesPerSide ||
        std::int64_t{regionsX_} * regionsY_ > kMaxTileCount)
        return Fail(Status::OutOfRange, "regions: %d × %d: at most %d a side and %d in all", regionsX_,
                    regionsY_, kMaxTilesPerSide, kMaxTileCount);
    return {};
}

inline Expected<std::uint32_t> TileLayout::GetTileNumber(const TilePosition& position) const noexcept {
    if (position.level < 0 || position.level > levelCount_)
        return Fail(Status::OutOfRange, "level: %d: must be 0 … %d", position.level, levelCount_);
    const bool isTail = position.level == levelCount_;
    const int tilesX = isTail ? tailTiles_ : GetLevel(position.level).tilesX;
    const int tilesY = isTail ? 1 : GetLevel(position.level).tilesY;
    if (position.x < 0 || position.x >= tilesX || position.y < 0 || position.y >= tilesY)
        return Fail(Status::OutOfRange, "tile: (%d, %d): level %d has %d × %d", position.x, position.y,
                    position.level, tilesX, tilesY);
    const std::uint32_t first =
        isTail ? static_cast<std::uint32_t>(regularTiles_) : GetLevel(position.level).firstTile;
    return first + static_cast<std::uint32_t>(position.y * tilesX + position.x);
}

inline Expected<TilePosition> TileLayout::GetTilePosition(std::uint32_t tile) const noexcept {
    if (tile >= static_cast<std::uint32_t>(GetTileCount()))
        return Fail(Status::OutOfRange, "tile: %u: must be 0 … %d", tile, GetTileCount() - 1);
    if (tile >= static_cast<std::uint32_t>(regularTiles_))
        return TilePosition{levelCount_, static_cast<int>(tile) - regularTiles_, 0};
    int level = levelCount_ - 1;
    while (GetLevel(level).firstTile > tile)
        --level;
    const int inLevel = static_cast<int>(tile - GetLevel(level).firstTile);
    return TilePosition{level, inLevel % GetLevel(level).tilesX, inLevel / GetLevel(level).tilesX};
}

inline TileRect TileLayout::GetTilesOfRegion(int x, int y, int level) const noexcept {
    const auto overlap = [](int region, int regionSize, int imageSize, const detail::TileAxis& axis) {
        const std::int64_t begin = std::int64_t{region} * regionSize;
        return detail::GetOverlap(begin, std::min<std::int64_t>(begin + regionSize, imageSize), imageSize,
                                  axis);
    };
    const detail::TileSpan columns = overlap(x, regionWidth_, width_, GetAxisX(level));
    const detail::TileSpan rows = overlap(y, regionHeight_, height_, GetAxisY(level));
    return {columns.first, rows.first, columns.last, rows.last};
}

inline TileRect TileLayout::GetOverlappingTiles(const TileLayout& other, int otherLevel,
                                                const TileRect& tiles, int level) const noexcept {
    const detail::TileSpan columns =
        detail::GetOverlap({tiles.left, tiles.right}, other.GetAxisX(otherLevel), GetAxisX(level));
    const detail::TileSpan rows =
        detail::GetOverlap({tiles.top, tiles.bottom}, other.GetAxisY(otherLevel), GetAxisY(level));
    return {columns.first, rows.first, columns.last, rows.last};
}

inline TileRect TileLayout::GetRelatedTiles(const TilePosition& tile, int level) const noexcept {
    return GetOverlappingTiles(*this, tile.level, {tile.x, tile.y, tile.x, tile.y}, level);
}

inline Expected<TilePosition> TileLayout::GetTileOfTexel(int mip, int x, int y) const noexcept {
    if (mip < 0 || mip >= mips_)
        return Fail(Status::OutOfRange, "mip: %d: must be 0 … %d", mip, mips_ - 1);
    if (x < 0 || x >= GetMipWidth(mip) || y < 0 || y >= GetMipHeight(mip))
        return Fail(Status::OutOfRange, "texel: (%d, %d): mip %d has %d × %d", x, y, mip, GetMipWidth(mip),
                    GetMipHeight(mip));
    const int level = GetLevelOfMip(mip);
    if (level == levelCount_)
        return TilePosition{level, 0, 0};
    return TilePosition{level, detail::GetTileOfTexel(x, GetMipWidth(mip), GetAxisX(level)),
                        detail::GetTileOfTexel(y, GetMipHeight(mip), GetAxisY(level))};
}

inline Expected<TileSlice> TileLayout::GetTileSlice(std::uint32_t tile) const noexcept {
    OPENNTC_ASSIGN(const TilePosition position, GetTilePosition(tile));
    if (position.level == levelCount_)
        return TileSlice{tailFirstMip_,
                         mips_ - tailFirstMip_,
                         0,
                         0,
                         GetMipWidth(tailFirstMip_),
                         GetMipHeight(tailFirstMip_)};
    const TileLevel& level = GetLevel(position.level);
    const detail::TexelSpan x =
        detail::GetTexelsOfTile(position.x, width_, level.firstMip, level.lastMip, GetAxisX(position.level));
    const detail::TexelSpan y =
        detail::GetTexelsOfTile(position.y, height_, level.firstMip, level.lastMip, GetAxisY(position.level));
    return TileSlice{level.firstMip, level.lastMip - level.firstMip + 1, x.begin, y.begin, x.end - x.begin,
                     y.end - y.begin};
}

inline Expected<TileSlice> TileLayout::GetLargestTileSlice(int level) const noexcept {
    if (level < 0 || level >= levelCount_)
        return Fail(Status::OutOfRange, "level: %d: must be 0 … %d", level, levelCount_ - 1);
    const TileLevel& of = GetLevel(level);
    const auto largest = [&](int tiles, int imageSize, const detail::TileAxis& axis) {
        int size = 0;
        for (int tile = 0; tile < tiles; ++tile) {
            const detail::TexelSpan span =
                detail::GetTexelsOfTile(tile, imageSize, of.firstMip, of.lastMip, axis);
            size = std::max(size, span.end - span.begin);
        }
        return size;
    };
    return TileSlice{of.firstMip,
                     of.lastMip - of.firstMip + 1,
                     0,
                     0,
                     largest(of.tilesX, width_, GetAxisX(level)),
                     largest(of.tilesY, height_, GetAxisY(level))};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
