// SPDX-License-Identifier: MIT
// Stability: internal
// Integer geometry of tiles along one axis. With sizes up to 2^20 no product exceeds 2^42.
#pragma once

#include <algorithm>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// Tiles first … last along one axis, both inclusive.
struct TileSpan {
    int first = 0;
    int last = 0;

    friend constexpr bool operator==(const TileSpan&, const TileSpan&) noexcept = default;
};

/// Where one axis of a level begins and ends: `size` texels in tiles of `tileSize`.
struct TileAxis {
    int size = 1;
    int tileSize = 1;

    constexpr int GetTiles() const noexcept { return (size - 1) / tileSize + 1; }
};

constexpr int GetTiledMipSize(int size, int mip) noexcept {
    return mip < 31 ? std::max(size >> mip, 1) : 1;
}

/// Tiles of an axis that overlap texels begin … end - 1 of one with `size` texels, both laid over the same
/// image: floor and ceiling of the ends, cross-multiplied.
constexpr TileSpan GetOverlap(std::int64_t begin, std::int64_t end, std::int64_t size,
                              const TileAxis& axis) noexcept {
    const std::int64_t divisor = size * axis.tileSize;
    const std::int64_t first = begin * axis.size / divisor;
    const std::int64_t last = (end * axis.size + divisor - 1) / divisor - 1;
    return {static_cast<int>(first), static_cast<int>(last)};
}

/// Tiles of `axis` that overlap tiles `tiles` of `other`.
constexpr TileSpan GetOverlap(const TileSpan& tiles, const TileAxis& other, const TileAxis& axis) noexcept {
    const std::int64_t begin = std::int64_t{tiles.first} * other.tileSize;
    const std::int64_t end = (std::int64_t{tiles.last} + 1) * other.tileSize;
    return GetOverlap(begin, std::min<std::int64_t>(end, other.size), other.size, axis);
}

/// The tile of `axis` that holds the centre of a texel of a mip with `mipSize` texels.
constexpr int GetTileOfTexel(std::int64_t texel, std::int64_t mipSize, const TileAxis& axis) noexcept {
    return static_cast<int>((2 * texel + 1) * axis.size / (2 * mipSize * axis.tileSize));
}

/// The first texel of a mip whose centre lies at or behind the beginning of a tile (or of the one behind the
/// last): (2 x + 1) · size >= 2 · mipSize · tileSize · tile.
constexpr int GetFirstTexelOfTile(std::int64_t tile, std::int64_t mipSize, const TileAxis& axis) noexcept {
    const std::int64_t begin = std::min<std::int64_t>(tile * axis.tileSize, axis.size);
    const std::int64_t doubled = 2 * mipSize * begin - axis.size; // 2 x · size >= this
    return doubled <= 0 ? 0 : static_cast<int>((doubled + 2 * axis.size - 1) / (2 * axis.size));
}

/// Texels of mip `firstMip` whose area holds the texels of a tile at each mip firstMip … lastMip: [begin,
/// end). `imageSize` is that of mip 0.
struct TexelSpan {
    int begin = 0;
    int end = 0;
};
constexpr TexelSpan GetTexelsOfTile(int tile, int imageSize, int firstMip, int lastMip,
                                    const TileAxis& axis) noexcept {
    const std::int64_t fineSize = GetTiledMipSize(imageSize, firstMip);
    std::int64_t begin = fineSize;
    std::int64_t end = 0;
    for (int mip = firstMip; mip <= lastMip; ++mip) {
        const std::int64_t mipSize = GetTiledMipSize(imageSize, mip);
        const int first = GetFirstTexelOfTile(tile, mipSize, axis);
        const int behind = GetFirstTexelOfTile(std::int64_t{tile} + 1, mipSize, axis);
        if (first == behind) // no texel of this mip: sizes of levels are the caller's
            continue;
        begin = std::min(begin, std::int64_t{first} << (mip - firstMip));
        end = std::max(end, behind == mipSize ? fineSize : std::int64_t{behind} << (mip - firstMip));
    }
    if (begin >= end) { // a level finer than its mips: the nearest texel
        begin = std::min<std::int64_t>(GetFirstTexelOfTile(tile, fineSize, axis), fineSize - 1);
        end = begin + 1;
    }
    return {static_cast<int>(begin), static_cast<int>(std::min(end, fineSize))};
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
