// SPDX-License-Identifier: MIT
// Stability: experimental
// The tile layout of a texture set: its latents, cut into slices.
#pragma once

#include "openntc/streaming/TileLayout.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Layout of a texture set, whose tiles are slices of latents: a level for each run of mips that one latent
/// image serves, of the size of the coarsest of them, and a tail of all from the first that fits one tile. A
/// set whose coarsest level does not fit one tile has no tail. `tailTiles` is how many slots of the tile's
/// size the tail's latents take; it counts only where there is a tail. Errors: as TileLayout::Create.
inline Expected<TileLayout> MakeTextureSetTileLayout(const TextureSetMetadata& set, int tileWidth,
                                                     int tileHeight, int tailTiles = 1) noexcept {
    OPENNTC_CHECK(set.CheckHasGrids("tiles"));
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

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
