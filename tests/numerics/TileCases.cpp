// SPDX-License-Identifier: MIT
// What is hard about tiles: which belong together, and what a manager may say of them when slots are short.
// Each case counts what differs from the definitions, evaluated tile by tile in fractions.
#include "HardCases.h"

#include "openntc/streaming/TileManager.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace numerics {

namespace {

using namespace openntc;

/// [begin, end) of `size`, along one axis.
struct Interval {
    std::int64_t begin = 0;
    std::int64_t end = 0;
    std::int64_t size = 1;

    bool Meets(const Interval& other) const {
        return begin * other.size < other.end * size && other.begin * size < end * other.size;
    }
};

struct Place {
    int level = 0;
    Interval x, y;

    bool Meets(const Place& other) const { return x.Meets(other.x) && y.Meets(other.y); }
};

Interval Cut(int number, int step, int size) {
    const std::int64_t begin = std::int64_t{number} * step;
    return {begin, std::min<std::int64_t>(begin + step, size), size};
}

/// The regular tiles, by number.
std::vector<Place> ListPlaces(const TileLayout& layout) {
    std::vector<Place> places;
    for (int level = 0; level < layout.GetLevelCount(); ++level) {
        const TileLevel& of = layout.GetLevels()[static_cast<std::size_t>(level)];
        for (int y = 0; y < of.tilesY; ++y) {
            for (int x = 0; x < of.tilesX; ++x)
                places.push_back({level, Cut(x, layout.GetTileWidth(), of.width),
                                  Cut(y, layout.GetTileHeight(), of.height)});
        }
    }
    return places;
}

/// Marks the tiles of a level that meet a place, and the coarser ones that meet those.
void Want(const std::vector<Place>& places, const Place& asked, int level, std::vector<char>& wanted) {
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (places[i].level != level || !places[i].Meets(asked))
            continue;
        for (std::size_t j = 0; j < places.size(); ++j) {
            if (i == j || (places[j].level > level && places[j].Meets(places[i])))
                wanted[j] = 1;
        }
    }
}

std::vector<char> GetWanted(const TileLayout& layout, const std::vector<std::uint8_t>& map) {
    const std::vector<Place> places = ListPlaces(layout);
    std::vector<char> wanted(places.size(), 0);
    for (int region = 0; region < layout.GetRegionCount(); ++region) {
        const int value = map[static_cast<std::size_t>(region)];
        if (value == 255)
            continue;
        const Place asked{0, Cut(region % layout.GetRegionsX(), layout.GetRegionWidth(), layout.GetWidth()),
                          Cut(region / layout.GetRegionsX(), layout.GetRegionHeight(), layout.GetHeight())};
        Want(places, asked, layout.GetLevelOfMip(value), wanted);
    }
    return wanted;
}

bool IsVisible(const TileManager& manager, ManagedTextureId id, std::size_t tile) {
    const ManagedTileState state = *manager.GetTileState(id, static_cast<std::uint32_t>(tile));
    return state == ManagedTileState::Mapped || state == ManagedTileState::Standby;
}

/// Entries of the residency map that are not the definition's.
int CompareResidency(const TileManager& manager, ManagedTextureId id) {
    const TileLayout& layout = **manager.GetLayout(id);
    const std::vector<Place> places = ListPlaces(layout);
    bool hasTail = true;
    for (std::size_t tile = places.size(); tile < static_cast<std::size_t>(layout.GetTileCount()); ++tile)
        hasTail = hasTail && IsVisible(manager, id, tile);
    const auto map = *manager.GetResidencyMap(id);
    int faults = 0;
    for (std::size_t entry = 0; entry < map.size(); ++entry) {
        int finest = layout.GetLevelCount();
        for (int level = finest - 1; level >= 0; --level) {
            bool isComplete = true;
            for (std::size_t tile = 0; tile < places.size(); ++tile)
                isComplete =
                    isComplete && (places[tile].level != level || !places[tile].Meets(places[entry]) ||
                                   IsVisible(manager, id, tile));
            if (!isComplete)
                break;
            finest = level;
        }
        const bool isNothing =
            !hasTail || (finest == layout.GetLevelCount() && layout.GetTailTileCount() == 0);
        faults += map[entry] != (isNothing ? 255 : layout.GetFirstMipOfLevel(finest)) ? 1 : 0;
    }
    return faults;
}

/// Tiles that are wanted or not against the definition. Without a tail the coarsest level always is.
int CompareWanted(const TileManager& manager, ManagedTextureId id, const std::vector<char>& wanted) {
    const TileLayout& layout = **manager.GetLayout(id);
    const std::vector<Place> places = ListPlaces(layout);
    int faults = 0;
    for (std::uint32_t tile = 0; tile < static_cast<std::uint32_t>(layout.GetTileCount()); ++tile) {
        const bool isPinned = tile >= places.size() || (layout.GetTailTileCount() == 0 &&
                                                        places[tile].level == layout.GetLevelCount() - 1);
        faults += *manager.IsTileWanted(id, tile) != (isPinned || wanted[tile] != 0) ? 1 : 0;
    }
    return faults;
}

/// Orders for tiles that a coarser one, or a tail, should have come before.
int CountEarlyOrders(const TileManager& manager, std::span<const TileMapOrder> orders) {
    int faults = 0;
    for (const TileMapOrder& order : orders) {
        const TileLayout& layout = **manager.GetLayout(order.texture);
        const std::vector<Place> places = ListPlaces(layout);
        for (std::uint32_t tile = 0; tile < static_cast<std::uint32_t>(layout.GetTileCount()); ++tile) {
            const bool isAbove = order.tile < places.size() &&
                                 (tile >= places.size() || (places[tile].level > places[order.tile].level &&
                                                            places[tile].Meets(places[order.tile])));
            faults += isAbove && *manager.GetTileState(order.texture, tile) == ManagedTileState::Requested;
        }
    }
    return faults;
}

int TakeTurn(TileManager& manager, const std::vector<ManagedTextureId>& ids) {
    int faults = manager.TrimStandbyTiles() && manager.AllocateRequestedTiles() ? 0 : 1;
    const TileOrders orders = manager.FetchOrders();
    faults += CountEarlyOrders(manager, orders.maps);
    for (const ManagedTextureId id : ids)
        faults += CompareResidency(manager, id);
    faults += static_cast<int>(manager.ConfirmOrders(orders.maps).stale);
    for (const ManagedTextureId id : ids)
        faults += CompareResidency(manager, id);
    const TileManagerStatistics has = manager.GetStatistics();
    return faults + (has.usedSlots > has.slots ? 1 : 0) + (manager.CheckInvariants() ? 0 : 1);
}

TileManager MakeManager(std::uint32_t tilesPerHeap, int heaps) {
    TileManager manager = std::move(*TileManager::Create({.tilesPerHeap = tilesPerHeap, .standbyTarget = 2}));
    for (int heap = 0; heap < heaps; ++heap)
        (void)manager.AddHeap(static_cast<std::uint32_t>(heap));
    return manager;
}

TileLayoutDesc Describe(int width, int height, int tile, int levels, int tailTiles = 1) {
    TileLayoutDesc desc;
    desc.width = width;
    desc.height = height;
    desc.tileWidth = desc.tileHeight = tile;
    desc.levelCount = levels;
    desc.mips = levels + (tailTiles > 0 ? 1 : 0);
    desc.tailTiles = tailTiles;
    return desc;
}

/// Frames of random feedback over textures of these layouts.
Measurement RunFrames(const std::vector<TileLayoutDesc>& descs, std::uint32_t tilesPerHeap, int heaps) {
    std::mt19937 random(20);
    TileManager manager = MakeManager(tilesPerHeap, heaps);
    std::vector<ManagedTextureId> ids;
    std::vector<std::vector<std::uint8_t>> maps;
    for (const TileLayoutDesc& desc : descs) {
        const TileLayout layout = *TileLayout::Create(desc);
        ids.push_back(*manager.AddTexture(layout));
        maps.emplace_back(static_cast<std::size_t>(layout.GetRegionCount()), std::uint8_t{255});
    }
    int faults = TakeTurn(manager, ids);
    for (int frame = 1; frame <= 24; ++frame) {
        std::vector<TextureFeedback> updates;
        for (std::size_t i = 0; i < ids.size(); ++i) {
            for (std::uint8_t& value : maps[i])
                value = random() % 3 != 0 ? std::uint8_t{255} : static_cast<std::uint8_t>(random() % 5);
            updates.push_back({ids[i], maps[i]});
        }
        faults += manager.UpdateWithSamplerFeedback(updates, {.time = double(frame), .timeout = 2}) ? 0 : 1;
        for (std::size_t i = 0; i < ids.size(); ++i)
            faults += CompareWanted(manager, ids[i], GetWanted(**manager.GetLayout(ids[i]), maps[i]));
        faults += TakeTurn(manager, ids);
    }
    return {static_cast<double>(faults),
            std::to_string(manager.GetStatistics().mapOrders) + " tiles were loaded"};
}

Measurement MeasureOddLevels() {
    // The last: levels of a texture set, which serve several mips; sixths, thirds and halves do not nest.
    static const TileLevelDesc kLevels[] = {{60, 24, 0, 1}, {30, 12, 2, 2}, {20, 9, 3, 4}};
    TileLayoutDesc set = Describe(240, 96, 10, 0);
    set.levels = kLevels;
    set.mips = 6;
    return RunFrames({Describe(257, 161, 64, 3), Describe(161, 257, 20, 4), set}, 4, 30);
}

Measurement MeasureTileSlivers() {
    return RunFrames({Describe(1, 700, 64, 3), Describe(700, 1, 64, 3), Describe(1, 1, 8, 1)}, 4, 6);
}

Measurement MeasureTails() {
    return RunFrames({Describe(200, 100, 256, 0, 2), Describe(1, 1, 64, 0, 1), Describe(96, 40, 32, 2, 0)}, 1,
                     7);
}

Measurement MeasureShortHeaps() {
    const std::vector<TileLayoutDesc> descs = {Describe(200, 136, 32, 3), Describe(128, 128, 32, 2, 2)};
    int faults = 0;
    for (int heaps = 0; heaps < 10; ++heaps) // of one slot each; three are for the tails
        faults += static_cast<int>(RunFrames(descs, 1, heaps).worst);
    return {static_cast<double>(faults), {}};
}

/// One follower after the other: smaller, larger, of another shape.
Measurement MeasureFollowers() {
    const TileLayout primary = *TileLayout::Create(Describe(256, 192, 32, 3));
    const struct {
        TileLayoutDesc desc;
        int shift; ///< levels between the two: log2 of the larger ratio of sizes
    } followers[] = {{Describe(256, 192, 32, 3), 0},
                     {Describe(64, 48, 32, 1), -2},
                     {Describe(1024, 768, 64, 4), 2},
                     {Describe(300, 600, 32, 4), 1}};
    std::mt19937 random(21);
    int faults = 0;
    for (const auto& of : followers) {
        TileManager manager = MakeManager(64, 20);
        const TileLayout layout = *TileLayout::Create(of.desc);
        const ManagedTextureId first = *manager.AddTexture(primary);
        const ManagedTextureId second = *manager.AddTexture(layout);
        const std::vector<Place> places = ListPlaces(layout);
        const std::vector<Place> from = ListPlaces(primary);
        for (int frame = 1; frame <= 12; ++frame) {
            std::vector<std::uint8_t> map(static_cast<std::size_t>(primary.GetRegionCount()));
            for (std::uint8_t& value : map)
                value = random() % 6 != 0 ? std::uint8_t{255} : static_cast<std::uint8_t>(random() % 4);
            faults += manager.UpdateWithSamplerFeedback(first, map, {.time = double(frame)}) ? 0 : 1;
            faults += manager.MatchPrimaryTexture(first, second, frame, 0) ? 0 : 1;
            const std::vector<char> asked = GetWanted(primary, map);
            std::vector<char> wanted(places.size(), 0);
            for (std::size_t tile = 0; tile < asked.size(); ++tile) {
                const int level = from[tile].level;
                if (asked[tile] != 0)
                    Want(places, from[tile], level == 0 ? 0 : std::max(level + of.shift, 0), wanted);
            }
            faults += CompareWanted(manager, second, wanted);
            faults += TakeTurn(manager, {first, second});
        }
    }
    return {static_cast<double>(faults), {}};
}

constexpr HardCase kTileCases[] = {
    {"tiles-levels-that-do-not-halve",
     "A tile lies under two tiles of a coarser level, or under one that halving its number does not give.",
     "The published tiled-texture manager: a number beyond the last column is the next row's or level's.",
     "Tiles belong together if their rectangles overlap, compared in integers.", 0, MeasureOddLevels},
    {"tiles-slivers", "Images of one texel across: regions, tiles and levels of one.",
     "The published tiled-texture manager divides by zero at width 1.", "Every size is 1 or more.", 0,
     MeasureTileSlivers},
    {"tiles-all-tail",
     "Images that are all tail have no regular level; others have no tail. Both need tiles that are always "
     "there.",
     "The published tiled-texture manager says that mips can be read before the tail is there.",
     "255 until the whole tail, or without one the coarsest level, is there, which is never given up.", 0,
     MeasureTails},
    {"tiles-short-of-slots",
     "Heaps of one tile, none at all, fewer than the tails need: fine tiles must not take the slots of "
     "coarser "
     "ones.",
     "The published tiled-texture manager serves the finest first, and the picture stays at the tail.",
     "Tails, then a coarser tile before every finer one over it.", 0, MeasureShortHeaps},
    {"tiles-followers",
     "A texture that is sampled with another one of another size wants the same part at the same detail.",
     "The published tiled-texture manager compares texels of both: other areas, or none.",
     "Overlap in fractions of the image, levels by the ratio of the sizes.", 0, MeasureFollowers},
};

} // namespace

std::span<const HardCase> ListTileCases() {
    return kTileCases;
}

} // namespace numerics
