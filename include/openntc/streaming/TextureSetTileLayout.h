// SPDX-License-Identifier: MIT
// Stability: experimental
// The tile layout of a texture set: its latents, cut into slices.
#pragma once

#include "openntc/inference/PartialInference.h"
#include "openntc/streaming/TileLayout.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Layout of a texture set, whose tiles are slices of latents: a level for each run of mips that one latent
/// image serves (of generations 2 and 3 a latent mip and the next), of the size of the coarsest of them, and
/// a tail of all from the first that fits one tile. A set whose coarsest level does not fit one tile has no
/// tail. `tailTiles` is how many slots of the tile's size the tail's latents take; it counts only where there
/// is a tail. Errors: as TileLayout::Create.
inline Expected<TileLayout> MakeTextureSetTileLayout(const TextureSetMetadata& set, int tileWidth,
                                                     int tileHeight, int tailTiles = 1) noexcept {
    const std::span<const ColorMip> mips = set.GetColorMips();
    std::array<TileLevelDesc, NTC_MAX_MIPS> levels = {};
    std::size_t count = 0;
    std::size_t mip = 0;
    while (mip < mips.size()) {
        std::size_t last = mip;
        while (last + 1 < mips.size() && mips[last + 1].neuralMip == mips[mip].neuralMip)
            ++last;
        if (mips[last].width <= tileWidth && mips[last].height <= tileHeight)
            break;
        levels[count++] = {mips[last].width, mips[last].height, static_cast<int>(mip),
                           static_cast<int>(last)};
        mip = last + 1;
    }
    TileLayoutDesc desc;
    desc.width = set.GetDesc().width;
    desc.height = set.GetDesc().height;
    desc.tileWidth = tileWidth;
    desc.tileHeight = tileHeight;
    desc.mips = set.GetDesc().mips;
    desc.levelCount = 0;
    desc.levels = {levels.data(), count};
    desc.tailTiles = mip < mips.size() ? tailTiles : 0;
    return TileLayout::Create(desc);
}

/// The slice that a tile is.
constexpr SliceDesc MakeSliceDesc(const TileSlice& tile) noexcept {
    return {tile.firstMip, tile.mips, {tile.left, tile.top, tile.width, tile.height}};
}

/// The slice rows of a tile of such a layout, as TileSource::GetSliceRows: one, of the tail one for each of
/// its mips. Returns how many; 0 for a tile that does not exist.
inline std::uint32_t MakeTileSliceRows(const TextureSetMetadata& set, const TileLayout& layout,
                                       std::uint32_t tile, std::span<NtcSliceConstants> rows) noexcept {
    const Expected<TileSlice> slice = layout.GetTileSlice(tile);
    if (!slice)
        return 0;
    const bool isTail = tile >= static_cast<std::uint32_t>(layout.GetRegularTileCount());
    std::uint32_t count = 0;
    for (int i = 0; i < (isTail ? slice->mips : 1) && count < rows.size(); ++i) {
        const ColorMip& mip = set.GetColorMips()[static_cast<std::size_t>(slice->firstMip + i)];
        const Expected<NtcSliceConstants> row = MakeSliceConstants(set, MakeSliceDesc(*slice), mip.neuralMip);
        if (!row)
            return 0;
        rows[count++] = *row;
    }
    return count;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
