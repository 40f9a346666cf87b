// SPDX-License-Identifier: MIT
// A million random operations on small managers, each compared in everything with the model and with the
// manager's own recount: odd sizes, levels that do not halve, no tail and two tiles of it, heaps of one slot,
// removal in every state, confirmations that come late, twice or for nothing.
#include "TileModel.h"

#include "support/TestSeed.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

class RandomWalk {
public:
    RandomWalk(std::uint64_t seed, TileManager& manager, std::uint32_t tilesPerHeap)
        : random_(seed), model_(manager, tilesPerHeap) {}

    TileModel& GetModel() { return model_; }

    /// One operation of any kind.
    void Step() {
        const auto& textures = model_.GetTextures();
        const int kind = Pick(0, 99);
        if (textures.size() < 2 || (kind < 3 && textures.size() < 4))
            Add();
        else if (kind < 5)
            model_.Remove(PickTexture());
        else if (kind < 25)
            Update();
        else if (kind < 35)
            UpdateMany();
        else if (kind < 40)
            UpdateChanges();
        else if (kind < 45)
            UpdateAll();
        else if (kind < 50)
            Match();
        else if (kind < 54 && model_.GetHeaps().size() < 5)
            model_.AddHeap(static_cast<std::uint32_t>(Pick(0, 9)) * 77);
        else if (kind < 56)
            model_.RemoveHeap(static_cast<std::uint32_t>(Pick(0, 9)) * 77);
        else if (kind < 58)
            model_.SetStandbyTarget(static_cast<std::uint32_t>(Pick(0, 8)));
        else if (kind < 64)
            model_.Trim();
        else if (kind < 74)
            model_.Allocate();
        else if (kind < 77)
            model_.Defragment(static_cast<std::uint32_t>(Pick(0, 4)));
        else if (kind < 85)
            model_.Fetch();
        else if (kind < 87)
            model_.FetchResidency();
        else if (kind < 96)
            ConfirmMaps();
        else if (kind < 98)
            ConfirmMoves();
        else
            ConfirmTiles();
    }

private:
    int Pick(int least, int most) {
        return least + static_cast<int>(random_() % static_cast<unsigned>(most - least + 1));
    }
    std::size_t PickTexture() { return random_() % model_.GetTextures().size(); }

    void Add() {
        TileLayoutDesc desc;
        desc.width = Pick(1, 40);
        desc.height = Pick(1, 40);
        const bool isSquare = Pick(0, 2) == 0; // sizes that halve, too
        if (isSquare)
            desc.width = desc.height = 8 << Pick(0, 2);
        desc.tileWidth = isSquare ? 8 : Pick(6, 18);
        desc.tileHeight = isSquare ? 8 : Pick(6, 18);
        const bool isFree = !isSquare && Pick(0, 1) == 0; // levels of any size
        levels_.clear();
        int mip = 0;
        for (int level = Pick(0, 3); level > 0; --level) {
            const int last = mip + (isSquare ? 0 : Pick(0, 3) / 2);
            TileLevelDesc of{std::max(desc.width >> last, 1), std::max(desc.height >> last, 1), mip, last};
            if (isFree) { // a tile then lies under several coarser ones, these under others
                of.width = Pick(of.width, levels_.empty() ? desc.width : levels_.back().width);
                of.height = Pick(of.height, levels_.empty() ? desc.height : levels_.back().height);
            }
            levels_.push_back(of);
            mip = last + 1;
        }
        desc.levels = levels_;
        desc.levelCount = 0;
        desc.tailTiles = levels_.empty() ? Pick(1, 2) : Pick(0, 2);
        desc.mips = mip + (desc.tailTiles > 0 ? Pick(1, 4) : 0);
        model_.Add(desc);
    }

    std::uint8_t PickValue() {
        const int value = Pick(0, 9);
        return static_cast<std::uint8_t>(value < 5 ? value : value < 9 ? 255 : Pick(5, 254));
    }

    TileUpdateOptions PickOptions() {
        TileUpdateOptions options;
        options.time = PickTime();
        options.timeout = Pick(0, 3);
        if (Pick(0, 9) == 0) {
            options.bias = Pick(-3, 3);
            options.streamedMips = Pick(0, 6);
        }
        return options;
    }

    double PickTime() {
        time_ += Pick(0, 19) == 0 ? -Pick(0, 5) : Pick(0, 1); // also backwards
        return time_;
    }

    std::vector<std::uint8_t> PickMap(std::size_t texture) {
        std::vector<std::uint8_t> map = model_.GetTextures()[texture].feedback;
        const int kind = Pick(0, 9);
        if (kind == 0)
            map.clear();
        else if (kind == 1)
            std::fill(map.begin(), map.end(), std::uint8_t{255});
        for (std::uint8_t& value : map) {
            if (kind < 3 || Pick(0, 3) == 0)
                value = PickValue();
        }
        return map;
    }

    void Update() {
        const std::size_t texture = PickTexture();
        const std::vector<std::uint8_t> map = PickMap(texture);
        model_.Update(texture, map, PickOptions());
    }

    void UpdateMany() {
        std::vector<std::pair<std::size_t, std::vector<std::uint8_t>>> maps;
        for (int i = Pick(0, 5); i > 0; --i) {
            const std::size_t texture = PickTexture();
            maps.emplace_back(texture, PickMap(texture));
        }
        model_.UpdateMany(maps, PickOptions());
    }

    RegionChange PickChange(std::size_t texture) {
        return {static_cast<std::uint32_t>(random_() % model_.GetTextures()[texture].feedback.size()),
                PickValue()};
    }

    void UpdateChanges() {
        const std::size_t texture = PickTexture();
        std::vector<RegionChange> changes;
        for (int i = Pick(0, 3); i > 0; --i)
            changes.push_back(PickChange(texture));
        model_.UpdateChanges(texture, changes, PickOptions());
    }

    void UpdateAll() {
        std::vector<std::pair<std::size_t, RegionChange>> changes;
        for (int i = Pick(0, 5); i > 0; --i) {
            const std::size_t texture = PickTexture();
            if (!model_.GetTextures()[texture].isFollowing || Pick(0, 9) == 0)
                changes.emplace_back(texture, PickChange(texture));
        }
        model_.UpdateAll(changes, PickTime(), Pick(0, 3));
    }

    void Match() {
        const std::size_t primary = PickTexture();
        model_.Match(primary, PickTexture(), PickTime(), Pick(0, 3));
    }

    /// The last few orders, and now and then any that ever was, in any order.
    template <typename Order>
    std::vector<Order> PickOrders(const std::vector<Order>& all) {
        std::vector<Order> picked;
        const std::size_t recent = std::min<std::size_t>(all.size(), 12);
        for (std::size_t i = all.size() - recent; i < all.size(); ++i) {
            if (Pick(0, 3) > 0)
                picked.push_back(all[i]);
        }
        if (!all.empty() && Pick(0, 3) == 0)
            picked.push_back(all[random_() % all.size()]);
        std::shuffle(picked.begin(), picked.end(), random_);
        return picked;
    }
    void ConfirmMaps() { model_.ConfirmMaps(PickOrders(model_.GetMapOrders())); }
    void ConfirmMoves() { model_.ConfirmMoves(PickOrders(model_.GetMoveOrders())); }

    void ConfirmTiles() {
        const std::size_t texture = PickTexture();
        std::vector<std::uint32_t> tiles;
        for (int i = Pick(0, 4); i > 0; --i)
            tiles.push_back(
                static_cast<std::uint32_t>(random_() % model_.GetTextures()[texture].tiles.size()));
        model_.ConfirmTiles(texture, tiles);
    }

    std::mt19937_64 random_;
    TileModel model_;
    std::vector<TileLevelDesc> levels_;
    double time_ = 0;
};

/// OPENNTC_TILE_OPERATIONS, else a million.
long GetOperationCount() {
    const char* text = std::getenv("OPENNTC_TILE_OPERATIONS");
    return text != nullptr ? std::strtol(text, nullptr, 10) : 1000000;
}

} // namespace

TEST_CASE("tile manager: random operations do what the model does, and all invariants hold after each") {
    const std::uint64_t seed = test::GetTestSeed();
    const long wanted = GetOperationCount();
    MESSAGE("OPENNTC_TEST_SEED=" << seed << ", operations: " << wanted);
    long operations = 0;
    TileManagerStatistics sum;
    for (std::uint64_t episode = 0; operations < wanted; ++episode) {
        std::mt19937_64 random(seed + episode);
        TileManagerDesc desc;
        desc.tilesPerHeap = 1 + static_cast<std::uint32_t>(random() % 8);
        desc.standbyTarget = 1000;
        auto manager = TileManager::Create(desc);
        REQUIRE(manager);
        RandomWalk walk(random(), *manager, desc.tilesPerHeap);
        for (int i = 0; i < 400 && operations < wanted; ++i, ++operations) {
            walk.Step();
            walk.GetModel().Compare();
            if (!walk.GetModel().GetFinding().empty())
                FAIL("OPENNTC_TEST_SEED=" << seed << ", episode " << episode << ", operation " << i << ": "
                                          << walk.GetModel().GetFinding());
        }
        const TileManagerStatistics has = manager->GetStatistics();
        sum.mapOrders += has.mapOrders;
        sum.unmapOrders += has.unmapOrders;
        sum.moveOrders += has.moveOrders;
        sum.cancelledRequests += has.cancelledRequests;
        sum.restoredTiles += has.restoredTiles;
        sum.thrashedTiles += has.thrashedTiles;
    }
    // The walk comes by everything.
    CHECK(sum.mapOrders > 0);
    CHECK(sum.unmapOrders > 0);
    CHECK(sum.moveOrders > 0);
    CHECK(sum.cancelledRequests > 0);
    CHECK(sum.restoredTiles > 0);
    CHECK(sum.thrashedTiles > 0);
    MESSAGE("maps " << sum.mapOrders << ", unmaps " << sum.unmapOrders << ", moves " << sum.moveOrders
                    << ", cancelled " << sum.cancelledRequests << ", restored " << sum.restoredTiles
                    << ", thrashed " << sum.thrashedTiles);
}
