// SPDX-License-Identifier: MIT
#include "TileModel.h"

#include <algorithm>
#include <set>

namespace openntc_tests {

using namespace openntc;

namespace {

int DivideUp(int a, int b) {
    return (a + b - 1) / b;
}

/// Do a … b of c and d … e of f overlap?
bool Overlap(long long a, long long b, long long c, long long d, long long e, long long f) {
    return a * f < e * c && d * c < b * f;
}

int PickRegion(long long wanted, int size) {
    while (wanted > 1 && wanted * 2 > size) {
        long long smaller = 1;
        while (smaller * 2 < wanted)
            smaller *= 2;
        wanted = smaller;
    }
    return static_cast<int>(wanted);
}

bool HasSlot(ManagedTileState state) {
    return state == ManagedTileState::Allocated || state == ManagedTileState::Mapped ||
           state == ManagedTileState::Standby;
}

} // namespace

void TileModel::Add(const TileLayoutDesc& desc) {
    ++operation_;
    const auto layout = TileLayout::Create(desc);
    const auto id = layout ? manager_.AddTexture(*layout) : Expected<ManagedTextureId>(ManagedTextureId{});
    Expect(layout && id, "texture is refused");
    if (!layout || !id)
        return;
    ModelTexture texture;
    texture.id = *id;
    texture.width = desc.width;
    texture.height = desc.height;
    texture.mips = desc.mips;
    texture.tailTiles = desc.tailTiles;
    texture.levels.assign(desc.levels.begin(), desc.levels.end());
    const int levels = static_cast<int>(texture.levels.size());
    const int shift = levels > 0 ? texture.levels[0].lastMip : 0;
    texture.regionWidth = PickRegion(static_cast<long long>(desc.tileWidth) << shift, desc.width);
    texture.regionHeight = PickRegion(static_cast<long long>(desc.tileHeight) << shift, desc.height);
    texture.regionsX = DivideUp(desc.width, texture.regionWidth);
    texture.regionsY = DivideUp(desc.height, texture.regionHeight);
    for (int level = 0; level < levels; ++level) {
        const TileLevelDesc& of = texture.levels[static_cast<std::size_t>(level)];
        for (int y = 0; y < of.height; y += desc.tileHeight) {
            for (int x = 0; x < of.width; x += desc.tileWidth) {
                ModelTile tile;
                tile.level = level;
                tile.left = x;
                tile.top = y;
                tile.right = std::min(x + desc.tileWidth, of.width);
                tile.bottom = std::min(y + desc.tileHeight, of.height);
                tile.isPinned = desc.tailTiles == 0 && level == levels - 1;
                texture.tiles.push_back(tile);
            }
        }
    }
    if (levels > 0) {
        texture.mapX = DivideUp(texture.levels[0].width, desc.tileWidth);
        texture.mapY = DivideUp(texture.levels[0].height, desc.tileHeight);
    }
    const auto overlaps = [&](const ModelTile& a, const ModelTile& b) {
        const TileLevelDesc& of = texture.levels[static_cast<std::size_t>(a.level)];
        const TileLevelDesc& other = texture.levels[static_cast<std::size_t>(b.level)];
        return Overlap(a.left, a.right, of.width, b.left, b.right, other.width) &&
               Overlap(a.top, a.bottom, of.height, b.top, b.bottom, other.height);
    };
    for (std::size_t i = 0; i < texture.tiles.size(); ++i) {
        texture.related.emplace_back();
        for (std::size_t j = 0; j < texture.tiles.size(); ++j) {
            if (i == j || (texture.tiles[j].level > texture.tiles[i].level &&
                           overlaps(texture.tiles[i], texture.tiles[j])))
                texture.related[i].push_back(static_cast<int>(j));
        }
    }
    for (int region = 0; region < texture.regionsX * texture.regionsY; ++region) {
        const int left = region % texture.regionsX * texture.regionWidth;
        const int top = region / texture.regionsX * texture.regionHeight;
        texture.ofRegion.emplace_back(static_cast<std::size_t>(levels));
        for (int level = 0; level < levels; ++level) {
            const TileLevelDesc& of = texture.levels[static_cast<std::size_t>(level)];
            std::set<int> wanted;
            for (std::size_t i = 0; i < texture.tiles.size(); ++i) {
                const ModelTile& tile = texture.tiles[i];
                if (tile.level == level &&
                    Overlap(left, std::min(left + texture.regionWidth, desc.width), desc.width, tile.left,
                            tile.right, of.width) &&
                    Overlap(top, std::min(top + texture.regionHeight, desc.height), desc.height, tile.top,
                            tile.bottom, of.height))
                    wanted.insert(texture.related[i].begin(), texture.related[i].end());
            }
            texture.ofRegion.back()[static_cast<std::size_t>(level)].assign(wanted.begin(), wanted.end());
        }
    }
    for (int i = 0; i < desc.tailTiles; ++i) {
        ModelTile tile;
        tile.level = levels;
        tile.isPinned = true;
        texture.tiles.push_back(tile);
    }
    for (ModelTile& tile : texture.tiles) {
        if (tile.isPinned) {
            tile.state = ManagedTileState::Requested;
            tile.isWanted = true;
            tile.requested = operation_;
        }
    }
    texture.feedback.assign(texture.ofRegion.size(), 255);
    texture.shadow.assign(static_cast<std::size_t>(texture.mapX * texture.mapY), 255);
    Expect(layout->GetRegionCount() == static_cast<int>(texture.feedback.size()), "regions");
    Expect(layout->GetTileCount() == static_cast<int>(texture.tiles.size()), "tiles of the layout");
    textures_.push_back(std::move(texture));
}

void TileModel::Remove(std::size_t number) {
    ++operation_;
    const ManagedTextureId id = textures_[number].id;
    Expect(manager_.RemoveTexture(id).has_value(), "removal is refused");
    std::erase_if(unmaps_, [&](const TileUnmapOrder& order) { return order.texture == id; });
    textures_.erase(textures_.begin() + static_cast<std::ptrdiff_t>(number));
}

int TileModel::GetLevel(const ModelTexture& texture, int value) {
    const int levels = static_cast<int>(texture.levels.size());
    if (value == 255)
        return levels;
    int mip = std::max(value + texture.bias, 0);
    if (texture.streamedMips > 0)
        mip = std::max(mip, texture.mips - texture.streamedMips);
    for (int level = 0; level < levels; ++level) {
        if (mip <= texture.levels[static_cast<std::size_t>(level)].lastMip)
            return level;
    }
    return levels;
}

std::vector<char> TileModel::GetWanted(const ModelTexture& texture) const {
    std::vector<char> wanted(texture.tiles.size(), 0);
    for (std::size_t region = 0; region < texture.feedback.size(); ++region) {
        const int level = GetLevel(texture, texture.feedback[region]);
        if (level == static_cast<int>(texture.levels.size()))
            continue;
        for (const int tile : texture.ofRegion[region][static_cast<std::size_t>(level)])
            wanted[static_cast<std::size_t>(tile)] = 1;
    }
    return wanted;
}

void TileModel::SetWanted(ModelTexture& texture, const std::vector<char>& wanted, double time,
                          double timeout) {
    for (std::size_t i = 0; i < texture.tiles.size(); ++i) {
        ModelTile& tile = texture.tiles[i];
        if (tile.isPinned)
            continue;
        tile.isWanted = wanted[i] != 0;
        if (tile.isWanted) {
            tile.lastWanted = time;
            if (tile.state == ManagedTileState::Free) {
                tile.state = ManagedTileState::Requested;
                tile.requested = operation_;
            } else if (tile.state == ManagedTileState::Standby) {
                tile.state = ManagedTileState::Mapped;
            }
        } else if (tile.state == ManagedTileState::Requested) {
            tile.state = ManagedTileState::Free;
        } else if (tile.state == ManagedTileState::Mapped && time - tile.lastWanted >= timeout) {
            tile.state = ManagedTileState::Standby;
            tile.inStandby = operation_;
        }
    }
}

void TileModel::Update(std::size_t number, const std::vector<std::uint8_t>& map,
                       const TileUpdateOptions& options) {
    ++operation_;
    ModelTexture& texture = textures_[number];
    Expect(manager_.UpdateWithSamplerFeedback(texture.id, map, options).has_value(), "update is refused");
    TakeMap(texture, map, options);
}

void TileModel::UpdateMany(const std::vector<std::pair<std::size_t, std::vector<std::uint8_t>>>& maps,
                           const TileUpdateOptions& options) {
    std::vector<TextureFeedback> list;
    for (const auto& [number, map] : maps)
        list.push_back({textures_[number].id, map});
    Expect(manager_.UpdateWithSamplerFeedback(list, options).has_value(), "update of many is refused");
    for (const auto& [number, map] : maps) {
        ++operation_; // requests and expiries of one texture are older than those of the next
        TakeMap(textures_[number], map, options);
    }
}

void TileModel::TakeMap(ModelTexture& texture, const std::vector<std::uint8_t>& map,
                        const TileUpdateOptions& options) {
    if (texture.levels.empty())
        return;
    texture.isFollowing = false;
    texture.bias = options.bias;
    texture.streamedMips = options.streamedMips;
    texture.feedback = map;
    if (map.empty())
        texture.feedback.assign(texture.ofRegion.size(), 255);
    SetWanted(texture, GetWanted(texture), options.time, options.timeout);
}

void TileModel::UpdateChanges(std::size_t number, const std::vector<RegionChange>& changes,
                              const TileUpdateOptions& options) {
    ++operation_;
    ModelTexture& texture = textures_[number];
    const auto updated = manager_.UpdateWithRegionChanges(texture.id, changes, options);
    if (texture.isFollowing) {
        Expect(!updated && updated.error().GetStatus() == Status::InvalidState, "follower without a map");
        return;
    }
    Expect(updated.has_value(), "update with changes is refused");
    if (texture.levels.empty())
        return;
    texture.bias = options.bias;
    texture.streamedMips = options.streamedMips;
    for (const RegionChange& change : changes)
        texture.feedback[change.region] = change.value;
    SetWanted(texture, GetWanted(texture), options.time, options.timeout);
}

void TileModel::UpdateAll(const std::vector<std::pair<std::size_t, RegionChange>>& changes, double time,
                          double timeout) {
    ++operation_;
    std::vector<TextureRegionChange> list;
    bool isRefused = false;
    for (const auto& [number, change] : changes) {
        list.push_back({textures_[number].id, change.region, change.value});
        isRefused = isRefused || textures_[number].isFollowing;
    }
    const auto updated = manager_.UpdateAllWithRegionChanges(list, time, timeout);
    Expect(updated.has_value() != isRefused, "update of all");
    if (isRefused)
        return;
    for (const auto& [number, change] : changes)
        textures_[number].feedback[change.region] = change.value;
    for (ModelTexture& texture : textures_) {
        std::vector<char> wanted(texture.tiles.size());
        if (texture.isFollowing)
            std::transform(texture.tiles.begin(), texture.tiles.end(), wanted.begin(),
                           [](const ModelTile& tile) { return static_cast<char>(tile.isWanted); });
        else
            wanted = GetWanted(texture);
        SetWanted(texture, wanted, time, timeout);
    }
}

void TileModel::Match(std::size_t primaryNumber, std::size_t followerNumber, double time, double timeout) {
    ++operation_;
    const ModelTexture& primary = textures_[primaryNumber];
    ModelTexture& follower = textures_[followerNumber];
    const auto matched = manager_.MatchPrimaryTexture(primary.id, follower.id, time, timeout);
    if (primaryNumber == followerNumber) {
        Expect(!matched, "a texture follows itself");
        return;
    }
    Expect(matched.has_value(), "match is refused");
    if (follower.levels.empty())
        return;
    follower.isFollowing = true;
    // log2 of the larger ratio, towards zero.
    int shift = 0;
    const auto isAtLeast = [&](int steps) { // is one of the ratios 2^steps or more?
        return follower.width >= static_cast<long long>(primary.width) << steps ||
               follower.height >= static_cast<long long>(primary.height) << steps;
    };
    const auto isAtMost = [&](int steps) { // are both 2^-steps or less?
        return static_cast<long long>(follower.width) << steps <= primary.width &&
               static_cast<long long>(follower.height) << steps <= primary.height;
    };
    while (isAtLeast(shift + 1))
        ++shift;
    while (shift <= 0 && isAtMost(1 - shift))
        --shift;
    std::vector<char> wanted(follower.tiles.size(), 0);
    for (const ModelTile& tile : primary.tiles) {
        if (!tile.isWanted || tile.level == static_cast<int>(primary.levels.size()))
            continue;
        const TileLevelDesc& of = primary.levels[static_cast<std::size_t>(tile.level)];
        const int mip = tile.level == 0 ? 0 : std::max(of.firstMip + shift, 0);
        for (std::size_t i = 0; i < follower.tiles.size(); ++i) {
            const ModelTile& other = follower.tiles[i];
            if (other.level == static_cast<int>(follower.levels.size()))
                continue;
            const TileLevelDesc& level = follower.levels[static_cast<std::size_t>(other.level)];
            if (mip < level.firstMip || mip > level.lastMip ||
                !Overlap(tile.left, tile.right, of.width, other.left, other.right, level.width) ||
                !Overlap(tile.top, tile.bottom, of.height, other.top, other.bottom, level.height))
                continue;
            for (const int coarser : follower.related[i])
                wanted[static_cast<std::size_t>(coarser)] = 1;
        }
    }
    follower.feedback.assign(follower.feedback.size(), 255);
    SetWanted(follower, wanted, time, timeout);
}

void TileModel::AddHeap(std::uint32_t heap) {
    ++operation_;
    const bool isKnown = std::find(heaps_.begin(), heaps_.end(), heap) != heaps_.end();
    Expect(manager_.AddHeap(heap).has_value() != isKnown, "adding a heap");
    if (!isKnown)
        heaps_.push_back(heap);
}

void TileModel::RemoveHeap(std::uint32_t heap) {
    ++operation_;
    const auto known = std::find(heaps_.begin(), heaps_.end(), heap);
    bool isUsed = false, isUncertain = false;
    for (const ModelTexture& texture : textures_) {
        for (const ModelTile& tile : texture.tiles) {
            isUsed = isUsed || (HasSlot(tile.state) && tile.slot.first == heap) ||
                     (tile.isMoving && tile.isMoveFetched && tile.moveTo.first == heap);
            isUncertain = isUncertain || (tile.isMoving && !tile.isMoveFetched);
        }
    }
    if (isUncertain) // where a tile moves to is only known from the order
        isUsed = isUsed || manager_.GetHeapUse(heap).value_or(0) > 0;
    const bool isGood = known != heaps_.end() && !isUsed;
    Expect(manager_.RemoveHeap(heap).has_value() == isGood, "removing a heap");
    if (isGood)
        heaps_.erase(known);
}

void TileModel::SetStandbyTarget(std::uint32_t tiles) {
    ++operation_;
    manager_.SetStandbyTarget(tiles);
    standbyTarget_ = tiles;
}

std::uint64_t TileModel::Count(ManagedTileState state) const {
    std::uint64_t count = 0;
    for (const ModelTexture& texture : textures_) {
        for (const ModelTile& tile : texture.tiles)
            count += tile.state == state ? 1 : 0;
    }
    return count;
}

std::uint64_t TileModel::CountSlots() const {
    std::uint64_t count = 0;
    for (const ModelTexture& texture : textures_) {
        for (const ModelTile& tile : texture.tiles)
            count += (HasSlot(tile.state) ? 1u : 0u) + (tile.isMoving ? 1u : 0u);
    }
    return count;
}

ModelTexture* TileModel::Find(ManagedTextureId id) {
    for (ModelTexture& texture : textures_) {
        if (texture.id == id)
            return &texture;
    }
    return nullptr;
}

std::size_t TileModel::GetHeapNumber(std::uint32_t heap) const {
    return static_cast<std::size_t>(std::find(heaps_.begin(), heaps_.end(), heap) - heaps_.begin());
}

} // namespace openntc_tests
