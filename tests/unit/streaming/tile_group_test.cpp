// SPDX-License-Identifier: MIT
// One update of many textures does what an update of each, one after the other, does: with more textures than
// go through it together, more changes than one texture may have there, and everything that ends a group.
#include "openntc/streaming/TileManager.h"

#include "support/TestSeed.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

using namespace openntc;

namespace {

TileLayout MakeGroupLayout(int width, int height, int tile, int levels) {
    TileLayoutDesc desc;
    desc.width = width;
    desc.height = height;
    desc.tileWidth = desc.tileHeight = tile;
    desc.mips = levels + 2;
    desc.levelCount = levels;
    return *TileLayout::Create(desc);
}

/// The same textures twice, updated in two ways.
struct Twins {
    TileManager single;
    TileManager many;
    std::vector<ManagedTextureId> ids;
    std::vector<std::vector<std::uint8_t>> maps;

    void Add(const TileLayout& layout) {
        ids.push_back(*single.AddTexture(layout));
        REQUIRE(*many.AddTexture(layout) == ids.back());
        maps.emplace_back(static_cast<std::size_t>(layout.GetRegionCount()), std::uint8_t{255});
    }

    void Update(const std::vector<std::size_t>& textures, const TileUpdateOptions& options) {
        std::vector<TextureFeedback> list;
        for (const std::size_t i : textures) {
            REQUIRE(single.UpdateWithSamplerFeedback(ids[i], maps[i], options));
            list.push_back({ids[i], maps[i]});
        }
        REQUIRE(many.UpdateWithSamplerFeedback(list, options));
    }

    void Follow(std::size_t primary, std::size_t follower, double time) {
        REQUIRE(single.MatchPrimaryTexture(ids[primary], ids[follower], time, 1));
        REQUIRE(many.MatchPrimaryTexture(ids[primary], ids[follower], time, 1));
    }

    /// Orders must be the same, in the same sequence; so must be what shaders may read. The number of orders.
    std::size_t TakeTurn() {
        REQUIRE(single.TrimStandbyTiles());
        REQUIRE(many.TrimStandbyTiles());
        REQUIRE(single.AllocateRequestedTiles());
        REQUIRE(many.AllocateRequestedTiles());
        const TileOrders a = single.FetchOrders();
        const TileOrders b = many.FetchOrders();
        CHECK(std::equal(a.unmaps.begin(), a.unmaps.end(), b.unmaps.begin(), b.unmaps.end(),
                         [](const TileUnmapOrder& x, const TileUnmapOrder& y) {
                             return x.texture == y.texture && x.tile == y.tile && x.from == y.from;
                         }));
        CHECK(std::equal(a.maps.begin(), a.maps.end(), b.maps.begin(), b.maps.end(),
                         [](const TileMapOrder& x, const TileMapOrder& y) {
                             return x.texture == y.texture && x.tile == y.tile && x.to == y.to;
                         }));
        CHECK(single.ConfirmOrders(a.maps).stale == 0);
        CHECK(many.ConfirmOrders(b.maps).stale == 0);
        for (const ManagedTextureId id : ids) {
            const auto x = *single.GetResidencyMap(id);
            const auto y = *many.GetResidencyMap(id);
            CHECK(std::equal(x.begin(), x.end(), y.begin(), y.end()));
        }
        const auto checked = many.CheckInvariants();
        CHECK_MESSAGE(checked, (checked ? "" : checked.error().GetText()));
        return a.maps.size() + a.unmaps.size();
    }
};

Twins MakeTwins(std::uint32_t tilesPerHeap, std::uint32_t standby) {
    TileManagerDesc desc;
    desc.tilesPerHeap = tilesPerHeap;
    desc.standbyTarget = standby;
    Twins twins{std::move(*TileManager::Create(desc)), std::move(*TileManager::Create(desc)), {}, {}};
    REQUIRE(twins.single.AddHeap(0));
    REQUIRE(twins.many.AddHeap(0));
    return twins;
}

} // namespace

TEST_CASE("tile manager: an update of many textures does what an update of each does") {
    const std::uint64_t seed = test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    std::mt19937_64 random(seed);
    Twins twins = MakeTwins(3000, 100); // too few slots for what is wanted: requests wait
    for (int i = 0; i < 90; ++i)
        twins.Add(MakeGroupLayout(i % 3 == 0 ? 100 : 128, i % 5 == 0 ? 77 : 128, 16, 3));
    twins.Add(MakeGroupLayout(40 * 16, 40 * 16, 16, 4)); // 1600 regions: more than a group takes
    twins.Add(MakeGroupLayout(31 * 16, 31 * 16, 16, 4)); // 961: with those of any other, too many
    twins.Add(MakeGroupLayout(16, 16, 64, 0));           // all tail
    std::size_t orders = 0;
    for (int frame = 0; frame < 40; ++frame) {
        std::vector<std::size_t> textures(twins.ids.size());
        for (std::size_t i = 0; i < textures.size(); ++i) {
            textures[i] = i;
            for (std::uint8_t& value : twins.maps[i]) {
                if (random() % 20 == 0)
                    value = random() % 6 == 0 ? std::uint8_t{255} : static_cast<std::uint8_t>(random() % 5);
            }
        }
        std::shuffle(textures.begin(), textures.end(), random);
        textures.resize(random() % (textures.size() + 1));
        if (frame % 4 == 1)
            twins.Follow(random() % 90, 90 + random() % 2, frame);
        TileUpdateOptions options;
        options.time = frame;
        options.timeout = static_cast<double>(random() % 4);
        options.bias = frame / 10 % 2;
        options.streamedMips = frame / 15 % 2 * 4;
        twins.Update(textures, options);
        orders += twins.TakeTurn();
    }
    CHECK(orders > 3000); // not a walk of nothing
    const TileManagerStatistics a = twins.single.GetStatistics();
    const TileManagerStatistics b = twins.many.GetStatistics();
    CHECK(a.requestedTiles == b.requestedTiles);
    CHECK(a.cancelledRequests == b.cancelledRequests);
    CHECK(a.restoredTiles == b.restoredTiles);
    CHECK(a.cancelledRequests + a.restoredTiles > 0);
}

TEST_CASE("tile manager: an update of many with one bad entry changes nothing") {
    Twins twins = MakeTwins(100, 0);
    twins.Add(MakeGroupLayout(128, 128, 16, 3));
    twins.Add(MakeGroupLayout(128, 128, 16, 3));
    const std::vector<std::uint8_t> wanted(64, 0);
    const std::vector<std::uint8_t> wrong(63, 0);
    const auto refuses = [&](std::vector<TextureFeedback> list, const TileUpdateOptions& options) {
        const auto updated = twins.many.UpdateWithSamplerFeedback(list, options);
        REQUIRE(!updated);
        CHECK(updated.error().GetStatus() == Status::InvalidArgument);
        CHECK(twins.many.GetStatistics().wantedTiles == 2); // the tails
    };
    refuses({{twins.ids[0], wanted}, {twins.ids[1], wrong}}, {});
    refuses({{twins.ids[0], wanted}, {{7, 1}, wanted}}, {});
    refuses({{twins.ids[0], wanted}}, {.time = 0, .timeout = -1});
    REQUIRE(twins.many.UpdateWithSamplerFeedback(std::span<const TextureFeedback>{}, {}));
    REQUIRE(twins.many.UpdateWithSamplerFeedback(std::vector<TextureFeedback>{{twins.ids[0], wanted}}, {}));
    CHECK(twins.many.GetStatistics().wantedTiles == 2 + 64 + 16 + 4);
}
