// SPDX-License-Identifier: MIT
// Which tile holds a texel: one function for shaders and C++. It needs no other header and declares no
// resource; all numbers fit 32 bits for images of up to 2^20 texels a side.
#ifndef OPENNTC_STREAMING_TILE_ADDRESS_H
#define OPENNTC_STREAMING_TILE_ADDRESS_H

#if defined(__cplusplus)
#define NTC_TILE_FUNCTION constexpr
namespace openntc {
#else
#define NTC_TILE_FUNCTION
#endif

/// Column of the tile that holds texel `texel` (0 … mipSize - 1) of a mip with `mipSize` texels along this
/// axis; or its row, with the other axis' numbers. The level that serves the mip has the size of the mip
/// `shift` steps coarser, max(mipSize >> shift, 1), and is cut into tiles of `tileSize` of its texels. With
/// one mip a level, shift is 0 and this is texel / tileSize.
///
/// Tile t holds the texels whose centres lie in [t, t + 1) · tileSize / levelSize of the image, for every mip
/// that the level serves: (2 texel + 1) · levelSize >= 2 · mipSize · tileSize · t. The centre is less than
/// one texel of the level left of where texel >> shift puts it, so that only a tile's first 2^shift texels
/// need that comparison, from which the multiple (t · tileSize) << shift has been taken off on both sides.
NTC_TILE_FUNCTION int NtcTileOfTexel(int texel, int mipSize, int shift, int tileSize) {
    int levelSize = mipSize >> shift;
    if (levelSize == 0)
        return 0;
    int inLevel = texel >> shift;
    if (inLevel >= levelSize) // texels that the rounding of sizes left over
        inLevel = levelSize - 1;
    int tile = inLevel / tileSize;
    int offset = texel - ((tile * tileSize) << shift);
    int leftOver = mipSize - (levelSize << shift);
    if (offset < (1 << shift) && (2 * offset + 1) * levelSize < 2 * leftOver * (tile * tileSize))
        tile -= 1;
    return tile;
}

#if defined(__cplusplus)
} // namespace openntc
#endif

#endif
