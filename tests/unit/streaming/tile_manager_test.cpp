// SPDX-License-Identifier: MIT
// What a tile manager answers in situations written down by hand, every misuse, and exhausted memory.
#include "openntc/streaming/TileManager.h"

#include "support/CountingAllocator.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

using namespace openntc;

namespace {

/// 256 × 256 in tiles of 64: 16 + 4 + 1 tiles, a tail of one: number 21.
TileLayout MakeSquare(int size = 256) {
    TileLayoutDesc desc;
    desc.width = desc.height = size;
    desc.tileWidth = desc.tileHeight = 64;
    desc.mips = 16;
    desc.levelCount = 0;
    while (size >> desc.levelCount >= 64)
        ++desc.levelCount;
    return *TileLayout::Create(desc);
}

TileManager MakeManager(std::uint32_t tilesPerHeap, std::uint32_t standby) {
    TileManagerDesc desc;
    desc.tilesPerHeap = tilesPerHeap;
    desc.standbyTarget = standby;
    return std::move(*TileManager::Create(desc));
}

TileUpdateOptions AtTime(double time, double timeout = 0) {
    TileUpdateOptions options;
    options.time = time;
    options.timeout = timeout;
    return options;
}

std::vector<std::uint8_t> OneRegion(std::size_t region, std::uint8_t value, std::size_t count = 16) {
    std::vector<std::uint8_t> map(count, 255);
    map[region] = value;
    return map;
}

/// Trims, allocates, fetches and confirms; what was ordered.
struct Turn {
    std::vector<std::uint32_t> unmaps, maps;
};
Turn TakeTurn(TileManager& manager) {
    REQUIRE(manager.TrimStandbyTiles());
    REQUIRE(manager.AllocateRequestedTiles());
    const TileOrders orders = manager.FetchOrders();
    Turn turn;
    for (const TileUnmapOrder& order : orders.unmaps)
        turn.unmaps.push_back(order.tile);
    for (const TileMapOrder& order : orders.maps)
        turn.maps.push_back(order.tile);
    const TileConfirmations confirmed = manager.ConfirmOrders(orders.maps);
    CHECK(confirmed.confirmed == orders.maps.size());
    CHECK(manager.ConfirmOrders(orders.moves).confirmed == orders.moves.size());
    const auto checked = manager.CheckInvariants();
    CHECK_MESSAGE(checked, (checked ? "" : checked.error().GetText()));
    std::sort(turn.unmaps.begin(), turn.unmaps.end());
    return turn;
}

template <typename T>
Status StatusOf(const Expected<T>& result) {
    return result ? Status::Ok : result.error().GetStatus();
}

using Tiles = std::vector<std::uint32_t>;

} // namespace

TEST_CASE("tile manager: a region brings its tile and all above it, coarse before fine; they go after the "
          "timeout") {
    TileManager manager = MakeManager(8, 0);
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    CHECK(manager.GetNumDesiredHeaps() == 1);
    REQUIRE(manager.AddHeap(5));
    CHECK(TakeTurn(manager).maps == Tiles{21});
    CHECK((*manager.GetResidencyMap(id))[6] == 3);

    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(6, 0), AtTime(1)));
    CHECK(TakeTurn(manager).maps == Tiles{20, 17, 6}); // levels 2, 1, 0
    CHECK((*manager.GetResidencyMap(id))[6] == 0);
    CHECK((*manager.GetResidencyMap(id))[7] == 1);
    CHECK((*manager.GetResidencyMap(id))[0] == 2);

    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(6, 1), AtTime(2, 2)));
    CHECK(*manager.GetTileState(id, 6) == ManagedTileState::Mapped); // last wanted at 1
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(6, 1), AtTime(3, 2)));
    CHECK(*manager.GetTileState(id, 6) == ManagedTileState::Standby); // equality expires
    CHECK((*manager.GetResidencyMap(id))[6] == 0);                    // and it is still there
    CHECK(TakeTurn(manager).unmaps == Tiles{6});
    CHECK((*manager.GetResidencyMap(id))[6] == 1);
}

TEST_CASE("tile manager: a tile in standby is back at once, without an order") {
    TileManager manager = MakeManager(8, 4);
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.AddHeap(0));
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(0, 0), AtTime(1)));
    TakeTurn(manager);
    REQUIRE(manager.UpdateWithSamplerFeedback(id, {}, AtTime(2)));
    CHECK(manager.GetStatistics().standbyTiles == 3);
    CHECK(TakeTurn(manager).unmaps.empty());
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(0, 0), AtTime(3)));
    const Turn turn = TakeTurn(manager);
    CHECK(turn.maps.empty());
    CHECK(turn.unmaps.empty());
    CHECK(manager.GetStatistics().restoredTiles == 3);
}

TEST_CASE(
    "tile manager: under a short budget tails come first, and requests that are not renewed are dropped") {
    TileManager manager = MakeManager(3, 0);
    const ManagedTextureId first = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.UpdateWithSamplerFeedback(first, std::vector<std::uint8_t>(16, 0), AtTime(1)));
    const ManagedTextureId second = *manager.AddTexture(MakeSquare()); // its tail waits behind 22 requests
    REQUIRE(manager.AddHeap(0));
    CHECK(TakeTurn(manager).maps == Tiles{21, 21, 20});
    CHECK((*manager.GetResidencyMap(second))[0] == 3);
    CHECK(manager.GetStatistics().requestedTiles == 20);
    CHECK(manager.GetNumDesiredHeaps() == 8); // 22 + 1 tiles
    REQUIRE(manager.UpdateWithSamplerFeedback(first, std::vector<std::uint8_t>(16, 2), AtTime(2)));
    CHECK(manager.GetStatistics().requestedTiles == 0);
    CHECK(manager.GetStatistics().cancelledRequests == 20);
}

TEST_CASE("tile manager: tiles that idle make requests wait, and a second count of heaps says so") {
    TileManager manager = MakeManager(4, 0);
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.AddHeap(0));
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(0, 0), AtTime(1)));
    TakeTurn(manager);
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(15, 0), AtTime(2, 10)));
    CHECK(TakeTurn(manager).maps.empty());
    CHECK(manager.GetNumDesiredHeaps() == 1);         // tail, 20, 19, 15
    CHECK(manager.GetNumDesiredHeapsWithIdle() == 2); // and 0, 16
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(15, 0), AtTime(11, 10)));
    const Turn turn = TakeTurn(manager);
    CHECK(turn.unmaps == Tiles{0, 16});
    CHECK(turn.maps == Tiles{19, 15});
}

TEST_CASE("tile manager: a tile evicted and wanted again soon counts as thrashed") {
    TileManagerDesc desc;
    desc.tilesPerHeap = 4;
    desc.standbyTarget = 0;
    desc.thrashWindow = 2;
    TileManager manager = std::move(*TileManager::Create(desc));
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.AddHeap(0));
    double time = 0;
    const auto show = [&](std::size_t region) {
        REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(region, 0), AtTime(++time)));
        TakeTurn(manager);
    };
    show(0);
    show(15); // 0 and 16 go
    show(0);
    CHECK(manager.GetStatistics().thrashedTiles == 2);
    show(15);
    CHECK(manager.GetStatistics().thrashedTiles == 4);
    for (int i = 0; i < 4; ++i)
        show(15);
    show(0); // long ago
    CHECK(manager.GetStatistics().thrashedTiles == 4);
}

TEST_CASE("tile manager: confirmations that are late, doubled, early or for something else change nothing") {
    TileManager manager = MakeManager(8, 8);
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.AddHeap(0));
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(0, 2), AtTime(1)));
    REQUIRE(manager.AllocateRequestedTiles());
    const std::uint32_t tail = 21;
    CHECK(manager.UpdateTilesMapping(id, {&tail, 1})->stale == 1); // its order was not fetched
    const TileOrders orders = manager.FetchOrders();
    const std::vector<TileMapOrder> maps(orders.maps.begin(), orders.maps.end());
    REQUIRE(maps.size() == 2);
    CHECK(manager.ConfirmOrders(orders.maps).confirmed == 2);
    CHECK(manager.ConfirmOrders(std::span<const TileMapOrder>(maps)).stale == 2); // again
    const Tiles others = {20, 3, 3};
    CHECK(manager.UpdateTilesMapping(id, others)->stale == 3); // mapped, free, free

    // Tile 20 goes, is ordered anew, and the old confirmation arrives before the new data.
    REQUIRE(manager.UpdateWithSamplerFeedback(id, {}, AtTime(2)));
    manager.SetStandbyTarget(0);
    REQUIRE(manager.TrimStandbyTiles());
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(0, 2), AtTime(3)));
    REQUIRE(manager.AllocateRequestedTiles());
    const TileOrders later = manager.FetchOrders();
    REQUIRE(later.maps.size() == 1);
    REQUIRE(later.unmaps.size() == 1);
    CHECK(manager.ConfirmOrders(std::span<const TileMapOrder>(maps)).stale == 2);
    CHECK(*manager.GetTileState(id, 20) == ManagedTileState::Allocated);
    CHECK(manager.ConfirmOrders(later.maps).confirmed == 1);

    // A texture goes, another gets its index, and a confirmation of the first arrives.
    REQUIRE(manager.RemoveTexture(id));
    const ManagedTextureId next = *manager.AddTexture(MakeSquare());
    CHECK(next.index == id.index);
    CHECK(next.generation != id.generation);
    REQUIRE(manager.AllocateRequestedTiles());
    (void)manager.FetchOrders();
    CHECK(manager.ConfirmOrders(std::span<const TileMapOrder>(maps)).stale == 2);
    CHECK(manager.UpdateTilesMapping(id, {&tail, 1})->stale == 1);
    CHECK(*manager.GetTileState(next, 21) == ManagedTileState::Allocated);
    CHECK(manager.UpdateTilesMapping(next, {&tail, 1})->confirmed == 1);
    CHECK(manager.GetStatistics().staleConfirmations == 1 + 2 + 3 + 2 + 2 + 1);
}

TEST_CASE("tile manager: orders wait until they are fetched, and those of a removed texture vanish") {
    TileManager manager = MakeManager(64, 0);
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    const ManagedTextureId other = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.AddHeap(0));
    REQUIRE(manager.AllocateRequestedTiles());
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(0, 0), AtTime(1)));
    REQUIRE(manager.UpdateWithSamplerFeedback(other, OneRegion(0, 2), AtTime(1)));
    REQUIRE(manager.AllocateRequestedTiles());
    REQUIRE(manager.UpdateWithSamplerFeedback(id, {}, AtTime(2)));
    const TileOrders orders = manager.FetchOrders();
    CHECK(orders.maps.size() == 2 + 3 + 1);
    CHECK(manager.FetchOrders().maps.empty());

    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(5, 0), AtTime(3)));
    REQUIRE(manager.UpdateWithSamplerFeedback(other, OneRegion(5, 1), AtTime(3)));
    REQUIRE(manager.AllocateRequestedTiles());
    REQUIRE(manager.RemoveTexture(id));
    const TileOrders rest = manager.FetchOrders();
    REQUIRE(rest.maps.size() == 1);
    CHECK(rest.maps[0].texture == other);
    CHECK(manager.GetStatistics().usedSlots == 3);
    CHECK(manager.CheckInvariants());
}

TEST_CASE("tile manager: a follower of another size wants the same part at the same detail") {
    TileManager manager = MakeManager(256, 0);
    const ManagedTextureId primary = *manager.AddTexture(MakeSquare(256));
    const ManagedTextureId smaller = *manager.AddTexture(MakeSquare(128)); // 4 + 1 tiles
    const ManagedTextureId larger = *manager.AddTexture(MakeSquare(512));  // 64 + 16 + 4 + 1
    REQUIRE(manager.AddHeap(0));
    const auto getWanted = [&](ManagedTextureId id) {
        Tiles wanted;
        for (std::uint32_t tile = 0;
             tile < static_cast<std::uint32_t>((*manager.GetLayout(id))->GetTileCount()); ++tile) {
            if (*manager.IsTileWanted(id, tile))
                wanted.push_back(tile);
        }
        return wanted;
    };
    REQUIRE(manager.UpdateWithSamplerFeedback(primary, OneRegion(15, 1), AtTime(1)));
    REQUIRE(manager.MatchPrimaryTexture(primary, smaller, 1, 0));
    REQUIRE(manager.MatchPrimaryTexture(primary, larger, 1, 0));
    CHECK(getWanted(primary) == Tiles{19, 20, 21});
    CHECK(getWanted(smaller) == Tiles{3, 4, 5});   // level 1 is its level 0
    CHECK(getWanted(larger) == Tiles{83, 84, 85}); // its level 2
    REQUIRE(manager.UpdateWithSamplerFeedback(primary, OneRegion(15, 0), AtTime(2)));
    REQUIRE(manager.MatchPrimaryTexture(primary, larger, 2, 0));
    CHECK(getWanted(larger) == Tiles{54, 55, 62, 63, 79, 83, 84, 85}); // level 0: nothing finer can be said
    CHECK(StatusOf(manager.MatchPrimaryTexture(primary, primary, 2, 0)) == Status::InvalidArgument);
    const RegionChange change = {0, 0};
    CHECK(StatusOf(manager.UpdateWithRegionChanges(larger, {&change, 1}, AtTime(3))) == Status::InvalidState);
    REQUIRE(manager.UpdateWithSamplerFeedback(larger, {}, AtTime(3)));
    CHECK(getWanted(larger) == Tiles{85});
    CHECK(manager.CheckInvariants());
}

TEST_CASE("tile manager: changes of one texture and of all do what whole maps do") {
    TileManager whole = MakeManager(16, 2);
    TileManager listed = MakeManager(16, 2);
    TileManager all = MakeManager(16, 2);
    const ManagedTextureId id = *whole.AddTexture(MakeSquare());
    REQUIRE(listed.AddTexture(MakeSquare()));
    REQUIRE(all.AddTexture(MakeSquare()));
    std::vector<std::uint8_t> map(16, 255);
    for (TileManager* manager : {&whole, &listed, &all})
        REQUIRE(manager->AddHeap(0));
    for (std::uint32_t step = 0; step < 200; ++step) {
        const RegionChange change = {step * 7 % 16,
                                     static_cast<std::uint8_t>(step * 5 % 7 < 4 ? step * 5 % 7 : 255)};
        const TextureRegionChange same = {id, change.region, change.value};
        map[change.region] = change.value;
        REQUIRE(whole.UpdateWithSamplerFeedback(id, map, AtTime(step, 3)));
        REQUIRE(listed.UpdateWithRegionChanges(id, {&change, 1}, AtTime(step, 3)));
        REQUIRE(all.UpdateAllWithRegionChanges({&same, 1}, step, 3));
        const Turn turn = TakeTurn(whole);
        for (TileManager* manager : {&listed, &all}) {
            const Turn other = TakeTurn(*manager);
            CHECK(other.maps == turn.maps);
            CHECK(other.unmaps == turn.unmaps);
            const auto a = *whole.GetResidencyMap(id);
            const auto b = *manager->GetResidencyMap(id);
            CHECK(std::equal(a.begin(), a.end(), b.begin()));
        }
    }
}

TEST_CASE("tile manager: defragmentation moves what stays readable until heaps are empty") {
    TileManager manager = MakeManager(4, 100);
    const ManagedTextureId id = *manager.AddTexture(MakeSquare());
    for (std::uint32_t heap = 10; heap < 16; ++heap)
        REQUIRE(manager.AddHeap(heap));
    REQUIRE(manager.UpdateWithSamplerFeedback(id, std::vector<std::uint8_t>(16, 0), AtTime(1)));
    CHECK(TakeTurn(manager).maps.size() == 22);
    manager.SetStandbyTarget(2);
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(15, 0), AtTime(2)));
    TakeTurn(manager); // tail, 20, 19, 15 and two in standby are left
    const std::vector<std::uint8_t> before((*manager.GetResidencyMap(id)).begin(),
                                           (*manager.GetResidencyMap(id)).end());
    CHECK_FALSE(*manager.IsMovableTile(id, 21));
    const auto moved = manager.DefragmentTiles(100);
    REQUIRE(moved);
    CHECK(*moved > 0);
    const auto isSame = [&] {
        const auto map = *manager.GetResidencyMap(id);
        return std::equal(map.begin(), map.end(), before.begin());
    };
    CHECK(isSame());
    const TileOrders orders = manager.FetchOrders();
    CHECK(orders.moves.size() == *moved);
    CHECK(orders.maps.empty());
    CHECK(orders.unmaps.empty());
    for (const TileMoveOrder& order : orders.moves) {
        CHECK(order.to.heap < order.from.heap);
        CHECK(*manager.GetTileSlot(id, order.tile) == order.from);
        CHECK_FALSE(*manager.IsMovableTile(id, order.tile));
    }
    CHECK(manager.ConfirmOrders(orders.moves).confirmed == *moved);
    CHECK(isSame());
    CHECK(manager.GetStatistics().standbyTiles == 2);
    CHECK(*manager.DefragmentTiles(100) == 0); // nothing is left to gain
    Array<std::uint32_t> empty;
    REQUIRE(manager.GetEmptyHeaps(empty));
    CHECK(empty.size() == 4);
    for (const std::uint32_t heap : empty)
        CHECK(manager.RemoveHeap(heap));
    CHECK(manager.CheckInvariants());
}

TEST_CASE("tile manager: levels that serve several mips: feedback and residency are in mips") {
    const TileLevelDesc levels[] = {{256, 256, 0, 3}, {64, 64, 4, 5}};
    TileLayoutDesc desc;
    desc.width = desc.height = 2048;
    desc.tileWidth = desc.tileHeight = 32;
    desc.mips = 12;
    desc.levels = levels;
    TileManager manager = MakeManager(100, 0);
    const ManagedTextureId id = *manager.AddTexture(*TileLayout::Create(desc));
    REQUIRE(manager.AddHeap(0));
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(9, 5, 64), AtTime(1)));
    CHECK(TakeTurn(manager).maps == Tiles{68, 64}); // the tail, the tile of mips 4 and 5
    CHECK((*manager.GetResidencyMap(id))[9] == 4);
    CHECK((*manager.GetResidencyMap(id))[4] == 6);
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(9, 3, 64), AtTime(2)));
    CHECK(TakeTurn(manager).maps == Tiles{9});
    CHECK((*manager.GetResidencyMap(id))[9] == 0);
    TileUpdateOptions limited = AtTime(3);
    limited.streamedMips = 8; // mips 4 … 11
    REQUIRE(manager.UpdateWithSamplerFeedback(id, OneRegion(9, 0, 64), limited));
    CHECK(TakeTurn(manager).unmaps == Tiles{9});
}

TEST_CASE("tile manager: where levels do not nest, a coarser tile that was requested later is served first") {
    // In columns: sixths, thirds, halves. The middle third lies under both halves, the third sixth under one.
    const TileLevelDesc levels[] = {{60, 10, 0, 0}, {30, 10, 1, 1}, {20, 10, 2, 2}};
    TileLayoutDesc desc;
    desc.width = 60;
    desc.height = 10;
    desc.tileWidth = desc.tileHeight = 10;
    desc.levels = levels;
    desc.levelCount = 0;
    desc.mips = 4;
    desc.tailTiles = 1;
    desc.regionWidth = desc.regionHeight = 10;
    const TileLayout layout = *TileLayout::Create(desc);
    REQUIRE(layout.GetRegionCount() == 6);
    constexpr std::uint32_t kSixth = 2, kThird = 7, kLeftHalf = 9, kRightHalf = 10, kTail = 11;
    TileManager manager = MakeManager(1, 0);
    const ManagedTextureId id = *manager.AddTexture(layout);
    std::vector<std::uint8_t> map = OneRegion(2, 0, 6);
    REQUIRE(manager.UpdateWithSamplerFeedback(id, map, AtTime(1)));
    CHECK(*manager.GetTileState(id, kThird) == ManagedTileState::Requested);
    CHECK(*manager.GetTileState(id, kRightHalf) == ManagedTileState::Free);
    map[3] = 2; // behind the request of the third, one of a half above it
    REQUIRE(manager.UpdateWithSamplerFeedback(id, map, AtTime(2)));
    CHECK(*manager.GetTileState(id, kRightHalf) == ManagedTileState::Requested);
    const auto addHeap = [&] {
        REQUIRE(manager.AddHeap(manager.GetHeapCount()));
        return TakeTurn(manager).maps;
    };
    CHECK(addHeap() == Tiles{kTail});
    CHECK(addHeap() == Tiles{kLeftHalf});
    CHECK(addHeap() == Tiles{kRightHalf});
    CHECK(addHeap() == Tiles{kThird});
    CHECK(addHeap() == Tiles{kSixth});
}

TEST_CASE("tile manager: every misuse has a status and changes nothing") {
    TileManagerDesc none;
    none.tilesPerHeap = 0;
    CHECK(StatusOf(TileManager::Create(none)) == Status::OutOfRange);
    none.tilesPerHeap = TileManager::kMaxTilesPerHeap + 1;
    CHECK(StatusOf(TileManager::Create(none)) == Status::OutOfRange);

    TileManager manager = MakeManager(4, 0);
    const ManagedTextureId good = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.AddHeap(7));
    TakeTurn(manager);
    const ManagedTextureId removed = *manager.AddTexture(MakeSquare());
    REQUIRE(manager.RemoveTexture(removed));
    const std::vector<std::uint8_t> map(16, 0);
    for (const ManagedTextureId bad :
         {removed, ManagedTextureId{}, ManagedTextureId{5, 1}, ManagedTextureId{0, 9}}) {
        CHECK(StatusOf(manager.UpdateWithSamplerFeedback(bad, map, AtTime(1))) == Status::InvalidArgument);
        CHECK(StatusOf(manager.UpdateWithRegionChanges(bad, {}, AtTime(1))) == Status::InvalidArgument);
        CHECK(StatusOf(manager.MatchPrimaryTexture(bad, good, 1, 0)) == Status::InvalidArgument);
        CHECK(StatusOf(manager.MatchPrimaryTexture(good, bad, 1, 0)) == Status::InvalidArgument);
        CHECK(StatusOf(manager.RemoveTexture(bad)) == Status::InvalidArgument);
        CHECK(StatusOf(manager.GetLayout(bad)) == Status::InvalidArgument);
        CHECK(StatusOf(manager.GetResidencyMap(bad)) == Status::InvalidArgument);
        CHECK(StatusOf(manager.GetTileState(bad, 0)) == Status::InvalidArgument);
        const TextureRegionChange change = {bad, 0, 0};
        CHECK(StatusOf(manager.UpdateAllWithRegionChanges({&change, 1}, 1, 0)) == Status::InvalidArgument);
    }
    const std::uint32_t tile = 0;
    CHECK(StatusOf(manager.UpdateTilesMapping({5, 1}, {&tile, 1})) == Status::InvalidArgument);
    CHECK(StatusOf(manager.UpdateTilesMapping({0, 9}, {&tile, 1})) == Status::InvalidArgument); // not yet
    const Tiles tooLarge = {21, 22};
    CHECK(StatusOf(manager.UpdateTilesMapping(good, tooLarge)) == Status::OutOfRange);

    const auto update = [&](std::span<const std::uint8_t> bytes, double time, double timeout) {
        return StatusOf(manager.UpdateWithSamplerFeedback(good, bytes, AtTime(time, timeout)));
    };
    const double infinity = std::numeric_limits<double>::infinity();
    CHECK(update(std::span(map).first(15), 1, 0) == Status::InvalidArgument);
    CHECK(update(std::vector<std::uint8_t>(17, 0), 1, 0) == Status::InvalidArgument);
    CHECK(update(map, std::nan(""), 0) == Status::InvalidArgument);
    CHECK(update(map, infinity, 0) == Status::InvalidArgument);
    CHECK(update(map, 1, -1) == Status::InvalidArgument);
    CHECK(update(map, 1, std::nan("")) == Status::InvalidArgument);
    TileUpdateOptions negative = AtTime(1);
    negative.streamedMips = -1;
    CHECK(StatusOf(manager.UpdateWithSamplerFeedback(good, map, negative)) == Status::InvalidArgument);
    const RegionChange changes[] = {{0, 0}, {16, 0}};
    CHECK(StatusOf(manager.UpdateWithRegionChanges(good, changes, AtTime(1))) == Status::OutOfRange);
    const TextureRegionChange listed[] = {{good, 0, 0}, {good, 16, 0}};
    CHECK(StatusOf(manager.UpdateAllWithRegionChanges(listed, 1, 0)) == Status::OutOfRange);

    CHECK(StatusOf(manager.AddHeap(7)) == Status::InvalidArgument);
    CHECK(StatusOf(manager.RemoveHeap(8)) == Status::InvalidArgument);
    CHECK(StatusOf(manager.RemoveHeap(7)) == Status::InvalidState);
    CHECK(StatusOf(manager.GetHeapUse(8)) == Status::InvalidArgument);
    std::uint8_t bytes[17];
    CHECK(StatusOf(manager.WriteMinMipData(good, bytes)) == Status::InvalidArgument);
    CHECK(StatusOf(manager.WriteMinMipData(good, std::span(bytes).first(16))) == Status::Ok);
    CHECK(bytes[15] == 3);
    CHECK(StatusOf(manager.GetTileState(good, 22)) == Status::OutOfRange);
    CHECK(StatusOf(manager.IsMovableTile(good, 22)) == Status::OutOfRange);
    CHECK(StatusOf(manager.GetTileSlot(good, 0)) == Status::InvalidState);

    // Extremes that are allowed.
    TileUpdateOptions far = AtTime(1, infinity);
    far.bias = std::numeric_limits<int>::max();
    CHECK(manager.UpdateWithSamplerFeedback(good, map, far));
    CHECK(manager.GetStatistics().wantedTiles == 1);
    far.bias = std::numeric_limits<int>::min();
    far.streamedMips = std::numeric_limits<int>::max();
    CHECK(manager.UpdateWithSamplerFeedback(good, map, far));
    CHECK(manager.GetStatistics().wantedTiles == 22);
    CHECK(manager.UpdateWithSamplerFeedback(good, {}, AtTime(2)));
    CHECK(manager.GetStatistics().wantedTiles == 1);
    CHECK(manager.GetStatistics().staleConfirmations == 0);
    CHECK(manager.CheckInvariants());
}

TEST_CASE("tile manager: without memory every call says so, keeps its promises, and works again with it") {
    // The same turns with the allocation of each number refused, until a run needs no more.
    std::size_t failures = 0;
    for (std::size_t number = 0;; ++number) {
        test::CountingAllocator allocator;
        bool hasFailed = false;
        {
            allocator.FailAt(number);
            TileManagerDesc desc;
            desc.tilesPerHeap = 3;
            desc.standbyTarget = 1;
            auto manager = TileManager::Create(desc, allocator);
            REQUIRE(manager);
            // Whatever fails once is done again.
            const auto insist = [&](auto call) {
                auto result = call();
                if (!result) {
                    CHECK(result.error().GetStatus() == Status::OutOfMemory);
                    hasFailed = true;
                    const auto checked = manager->CheckInvariants();
                    CHECK_MESSAGE(checked, (checked ? "" : checked.error().GetText()));
                    result = call();
                }
                REQUIRE(result);
                return result;
            };
            const TileLayout square = MakeSquare();
            const TileLayout large = MakeSquare(512);
            const ManagedTextureId first = *insist([&] { return manager->AddTexture(square); });
            const ManagedTextureId second = *insist([&] { return manager->AddTexture(large); });
            for (std::uint32_t heap = 0; heap < 20; ++heap)
                insist([&] { return manager->AddHeap(heap); });
            for (int turn = 0; turn < 6; ++turn) {
                REQUIRE(manager->UpdateWithSamplerFeedback(
                    first, std::vector<std::uint8_t>(16, static_cast<std::uint8_t>(turn % 3)), AtTime(turn)));
                REQUIRE(manager->UpdateWithSamplerFeedback(
                    second, OneRegion(static_cast<std::size_t>(turn), 0, 64), AtTime(turn)));
                insist([&] { return manager->TrimStandbyTiles(); });
                insist([&] { return manager->AllocateRequestedTiles(); });
                insist([&] { return manager->DefragmentTiles(2); });
                const TileOrders orders = manager->FetchOrders();
                manager->ConfirmOrders(orders.maps);
                manager->ConfirmOrders(orders.moves);
                insist([&] { return manager->FetchResidencyChanges(); });
            }
            REQUIRE(manager->RemoveTexture(first));
            insist([&] { return manager->AddTexture(square); });
            insist([&] { return manager->CheckInvariants(); });
        }
        CHECK(allocator.GetUsedBytes() == 0);
        failures += hasFailed ? 1 : 0;
        if (!hasFailed)
            break;
    }
    CHECK(failures > 20);
}

TEST_CASE("tile manager: of many layouts each is kept once and forgotten with its last texture") {
    test::CountingAllocator allocator;
    auto manager = TileManager::Create({}, allocator);
    REQUIRE(manager);
    std::vector<ManagedTextureId> ids;
    const auto add = [&](int width) {
        TileLayoutDesc desc;
        desc.width = width;
        desc.height = 300;
        desc.tileWidth = desc.tileHeight = 64;
        desc.mips = 9;
        ids.push_back(*manager->AddTexture(*TileLayout::Create(desc)));
    };
    const auto cycle = [&] {
        for (int round = 0; round < 2; ++round) {
            for (int i = 0; i < 300; ++i)
                add(100 + i);
        }
        CHECK(manager->CheckInvariants());
        for (std::size_t i = 0; i < ids.size(); ++i)
            CHECK(manager->RemoveTexture(ids[(i * 7) % ids.size()]));
        ids.clear();
    };
    cycle();
    const std::size_t used = allocator.GetUsedBytes();
    for (int i = 0; i < 3; ++i)
        cycle();
    CHECK(allocator.GetUsedBytes() == used); // nothing piles up
    CHECK(manager->GetStatistics().tiles == 0);
}
