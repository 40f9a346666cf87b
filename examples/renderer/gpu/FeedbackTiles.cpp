// SPDX-License-Identifier: MIT
#include "renderer/gpu/FeedbackTiles.h"

#include "Failure.h"
#include "Output.h"
#include "renderer/shaders/FeedbackTail.h"

#include <algorithm>

namespace openntc::renderer {

Expected<TileLayout> MakeFeedbackLayout(const TextureSetDesc& set, int tileSize) {
    TileLayoutDesc desc;
    desc.width = set.width;
    desc.height = set.height;
    desc.mips = set.mips;
    desc.tileWidth = desc.tileHeight = tileSize;
    desc.levelCount = 0;
    while (desc.levelCount < set.mips &&
           std::max(set.width >> desc.levelCount, set.height >> desc.levelCount) > tileSize / 2)
        ++desc.levelCount;
    desc.tailTiles = desc.levelCount < set.mips ? 1 : 0;
    return TileLayout::Create(desc);
}

std::vector<TilePart> GetTileParts(const TileLayout& layout, std::uint32_t tile) {
    const TilePosition position = tool::Require(layout.GetTilePosition(tile), tool::ExitCode::Failed, "tile");
    const int size = layout.GetTileWidth();
    if (position.level < layout.GetLevelCount()) {
        const int left = position.x * size, top = position.y * size;
        return {{position.level,
                 {left, top, std::min(size, layout.GetMipWidth(position.level) - left),
                  std::min(size, layout.GetMipHeight(position.level) - top)},
                 0,
                 0}};
    }
    std::vector<TilePart> parts;
    for (int mip = layout.GetTailFirstMip(); mip < layout.GetMips(); ++mip) {
        const auto place = shader::NtcrGetTailPlace(size, mip - layout.GetTailFirstMip());
        parts.push_back({mip, {0, 0, layout.GetMipWidth(mip), layout.GetMipHeight(mip)}, place.x, place.y});
    }
    return parts;
}

std::uint32_t CountPinnedTiles(const TileLayout& layout) {
    if (layout.GetTailTileCount() > 0)
        return static_cast<std::uint32_t>(layout.GetTailTileCount());
    const TileLevel& coarsest = layout.GetLevels().back();
    return static_cast<std::uint32_t>(coarsest.tilesX * coarsest.tilesY);
}

std::uint32_t ChooseTilesAcross(std::uint64_t tiles, int tileSize) {
    constexpr std::uint32_t kLargestSide = 4096; // texels, which every device has
    const std::uint32_t most = std::min(16u, kLargestSide / static_cast<std::uint32_t>(tileSize));
    std::uint32_t across = 2;
    while (across < most && std::uint64_t{across} * across * kMostLayers < tiles)
        across *= 2;
    return across;
}

std::vector<std::uint32_t> ShareBudget(std::span<const PoolDemand> pools, std::uint64_t bytes) {
    std::uint64_t fewest = 0, most = 0;
    for (const PoolDemand& pool : pools) {
        fewest += pool.fewest * pool.layerBytes;
        most += pool.most * pool.layerBytes;
    }
    if (bytes != 0 && bytes < fewest)
        throw tool::CommandError(tool::ExitCode::Usage, "--budget",
                                 tool::Format("%.3f MiB: the coarsest tiles alone take %.3f",
                                              static_cast<double>(bytes) / 1048576.0,
                                              static_cast<double>(fewest) / 1048576.0));
    const bool isLimited = bytes != 0 && bytes < most;
    const double share =
        isLimited ? static_cast<double>(bytes - fewest) / static_cast<double>(most - fewest) : 1.0;
    std::vector<std::uint32_t> layers;
    for (const PoolDemand& pool : pools)
        layers.push_back(pool.fewest +
                         static_cast<std::uint32_t>(share * static_cast<double>(pool.most - pool.fewest)));
    return layers;
}

} // namespace openntc::renderer
