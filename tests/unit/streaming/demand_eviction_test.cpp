// SPDX-License-Identifier: MIT
// The demand loader with less room than it is asked for: what leaves, when slots are used again, what never
// leaves, and slots that several tiles share.
#include "DemandTestKit.h"

using namespace demand_test;

namespace {

/// Bytes that the tiles of a source take.
std::uint64_t BytesOf(const NumberSource& source, std::uint32_t tile) {
    return source.GetTileBytes(tile);
}

} // namespace

TEST_CASE("demand case 21: half the room, a camera that swings: never over budget, each pose converges") {
    const TileLayout layout = MakeLayout(256, 256, 16); // 256 + 64 + 16 + 4 tiles and the tail
    DemandLoaderOptions options = MakeOptions(400);
    options.budgetTiles = static_cast<std::uint32_t>(layout.GetTileCount()) / 2;
    options.budgetBytes = options.budgetTiles * 1024ull + 400;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(layout, 1);
    const DemandId id = AddTexture(loader, source);
    const auto checkBudget = [&] {
        const DemandStatistics statistics = loader.GetStatistics();
        CHECK(statistics.slotsInUse <= options.budgetTiles);
        CHECK(statistics.bytesInUse <= options.budgetBytes);
    };
    for (int swing = 0; swing < 6; ++swing) {
        for (int pose = 0; pose < 4; ++pose) { // 64 tiles of level 0 and their 21 ancestors
            bool isThere = false;
            for (int round = 0; round < 20 && !isThere; ++round) {
                const Launch launch = device.Prepare(loader);
                checkBudget();
                isThere = device.View(launch, id, *source, 0, pose % 2 * 8, pose / 2 * 8, 8, 8) == 64;
                device.Process(loader, launch);
                checkBudget();
            }
            CHECK(isThere);
        }
    }
    CHECK(loader.GetStatistics().evicted > 0);
    CHECK(loader.GetStatistics().freed > 0);
    CheckSums(loader);
}

TEST_CASE("demand: what is freed and read again within 64 rounds counts as thrashed, and later not") {
    const TileLayout layout = MakeLayout(256, 256, 16); // 256 + 64 + 16 + 4 tiles and the tail
    DemandLoaderOptions options = MakeOptions(400);
    options.budgetTiles = static_cast<std::uint32_t>(layout.GetTileCount()) / 2; // two of the four poses fit
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(layout, 1);
    const DemandId id = AddTexture(loader, source);
    const auto lookAt = [&](int pose) {
        int there = 0;
        device.Converge(loader, [&](const Launch& launch) {
            there = static_cast<int>(device.View(launch, id, *source, 0, pose % 2 * 8, pose / 2 * 8, 8, 8));
        });
        CHECK(there == 64);
    };
    for (int pose = 0; pose < 4; ++pose)
        lookAt(pose);
    CHECK(loader.GetStatistics().freed > 0);
    CHECK(loader.GetStatistics().thrashed == 0);

    const std::uint64_t started = loader.GetStatistics().started;
    lookAt(0); // all that is read now was there some rounds ago
    CHECK(loader.GetStatistics().thrashed > 0);
    CHECK(loader.GetStatistics().thrashed == loader.GetStatistics().started - started);

    for (int pose = 1; pose < 4; ++pose)
        lookAt(pose);
    for (int round = 0; round < 64; ++round)
        lookAt(3);
    const DemandStatistics before = loader.GetStatistics();
    lookAt(0);
    CHECK(loader.GetStatistics().started > before.started);
    CHECK(loader.GetStatistics().thrashed == before.thrashed);
    CheckSums(loader);
}

TEST_CASE("demand case 22: a pose that does not fit: over budget, the coarse levels complete, no hanging") {
    for (const std::uint32_t frames : {1u, 3u}) {
        for (const bool isSmallQueue : {false, true}) {
            CAPTURE(frames);
            CAPTURE(isSmallQueue);
            DemandLoaderOptions options = MakeOptions(40); // of 256 + 64 + 16 + 4 + 1
            options.table.queueCapacity = isSmallQueue ? 8 : 1024;
            options.framesInFlight = frames;
            DemandLoader loader = MakeLoader(options);
            Device device(options);
            const auto source = MakeSource(MakeLayout(256, 256, 16), 2);
            const DemandId id = AddTexture(loader, source);
            // A device's threads come in any order, so that in the end everything gets into a small queue.
            const auto render = [&](const Launch& launch) {
                const std::uint32_t first = Mix(launch.context.round, 1);
                for (std::uint32_t i = 0; i < 256; ++i) {
                    const int tile = static_cast<int>((first + i * 77) % 256);
                    device.FetchChecked(launch, id, *source, 0, tile % 16 * 16, tile / 16 * 16);
                }
            };
            if (!isSmallQueue)
                device.Converge(loader, render);
            for (int round = 0; round < (isSmallQueue ? 500 : 10); ++round) {
                const Launch launch = device.Prepare(loader);
                render(launch);
                device.Process(loader, launch);
            }
            CHECK(loader.GetProgress().state == DemandState::OverBudget);
            CHECK(loader.GetProgress().unserved > 0);
            // Tail, 4 and 16 are complete, 19 of the 64 are there, and it stays like that: nothing leaves for
            // something as fine.
            const std::uint64_t evicted = loader.GetStatistics().evicted;
            for (int round = 0; round < 20; ++round) {
                const Launch launch = device.Prepare(loader);
                CHECK(device.View(launch, id, *source, 3) == 4);
                CHECK(device.View(launch, id, *source, 2) == 16);
                CHECK(device.View(launch, id, *source, 1) == 19);
                render(launch);
                device.Process(loader, launch);
                CHECK(loader.GetProgress().state == DemandState::OverBudget);
            }
            CHECK(loader.GetStatistics().evicted == evicted);
            CheckSums(loader);
        }
    }
}

TEST_CASE("demand case 23: the tile that was not used for longest leaves") {
    DemandLoaderOptions options = MakeOptions(4); // tail, A, B, C
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(64, 64, 16), 3);
    const DemandId id = AddTexture(loader, source);
    Launch launch = device.Prepare(loader);
    device.View(launch, id, *source, 0, 0, 0, 3, 1); // A, B, C
    device.Process(loader, launch);
    const int orders[2][3] = {{0, 1, 2}, {2, 0, 1}};
    for (const auto& order : orders) {
        for (const int tile : order) {
            launch = device.Prepare(loader);
            CHECK(device.View(launch, id, *source, 0, tile, 0, 1, 1) == 1);
            device.Process(loader, launch);
        }
        int rounds = 0;
        for (;; ++rounds) { // another one, beside the two used last
            REQUIRE(rounds < 5);
            launch = device.Prepare(loader);
            device.View(launch, id, *source, 0, order[1], 0, 1, 1);
            device.View(launch, id, *source, 0, order[2], 0, 1, 1);
            const int resident = device.View(launch, id, *source, 0, 3, 3, 1, 1);
            device.Process(loader, launch);
            if (resident == 1)
                break;
        }
        launch = device.Prepare(loader);
        CHECK(device.GetEntry(launch, id.index, static_cast<std::uint32_t>(order[0])) == NTC_TILE_MISSING);
        CHECK(device.GetEntry(launch, id.index, static_cast<std::uint32_t>(order[1])) != NTC_TILE_MISSING);
        CHECK(device.GetEntry(launch, id.index, static_cast<std::uint32_t>(order[2])) != NTC_TILE_MISSING);
        device.Process(loader, launch);
        for (int back = 0; back < 5; ++back) { // the first one again, in the place of the other one
            launch = device.Prepare(loader);
            device.View(launch, id, *source, 0, 0, 0, 3, 1);
            device.Process(loader, launch);
        }
        CHECK(loader.GetProgress().state == DemandState::Done);
    }
    CheckSums(loader);
}

TEST_CASE("demand case 24: a staged tile that is asked for is back without a read") {
    DemandLoaderOptions options = MakeOptions(3); // tail, A, B
    options.loadAncestors = false;
    options.framesInFlight = 3;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(64, 64, 16), 4);
    const DemandId id = AddTexture(loader, source);
    Launch launch = device.Prepare(loader);
    device.View(launch, id, *source, 0, 0, 0, 2, 1);
    device.Process(loader, launch);
    for (int round = 0; round < 4; ++round) { // A is not used, then C is wanted
        launch = device.Prepare(loader);
        device.View(launch, id, *source, 0, 1, 0, 1, 1);
        if (round == 3)
            device.View(launch, id, *source, 0, 2, 0, 1, 1);
        device.Process(loader, launch);
    }
    CHECK(loader.GetStatistics().stagedTiles == 1);
    launch = device.Prepare(loader);
    CHECK(device.View(launch, id, *source, 0, 0, 0, 1, 1) == 0); // hidden
    device.Process(loader, launch);
    CHECK(loader.GetStatistics().restored == 1);
    CHECK(loader.GetStatistics().stagedTiles == 0);
    launch = device.Prepare(loader);
    CHECK(device.View(launch, id, *source, 0, 0, 0, 1, 1) == 1);
    device.Process(loader, launch);
    CHECK(source->GetReads(0) == 1);
    CheckSums(loader);
}

TEST_CASE("demand case 25: a slot is used again when no launch can read it any more") {
    for (const std::uint32_t frames : {1u, 2u, 3u, 5u}) {
        CAPTURE(frames);
        DemandLoaderOptions options = MakeOptions(40);
        options.framesInFlight = frames;
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(256, 256, 16), 5);
        const DemandId id = AddTexture(loader, source);
        // Uploads go to the slots at once, and a launch runs as late as it may: FetchChecked sees whether its
        // page table's slots still have what it says.
        std::vector<Launch> inFlight;
        int resident = 0;
        for (int frame = 0; frame < 200; ++frame) {
            if (inFlight.size() == frames) {
                const Launch launch = inFlight.front();
                inFlight.erase(inFlight.begin());
                resident += device.View(launch, id, *source, frame % 2, frame * 3 % 14, frame % 13, 2, 2);
                device.Process(loader, launch);
            }
            inFlight.push_back(device.Prepare(loader));
        }
        CHECK(resident > 0);
        CHECK(loader.GetStatistics().freed > 20);
        CheckSums(loader);
    }
}

TEST_CASE("demand case 26: tails never leave, and a budget without room for them is refused") {
    DemandLoaderOptions options = MakeOptions(6);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    std::vector<Shared<NumberSource>> sources;
    std::vector<DemandId> ids;
    for (std::uint32_t i = 0; i < 4; ++i) {
        sources.push_back(MakeSource(MakeLayout(256, 256, 16), i));
        ids.push_back(AddTexture(loader, sources[i]));
    }
    for (int frame = 0; frame < 100; ++frame) {
        const Launch launch = device.Prepare(loader);
        for (std::size_t i = 0; i < ids.size(); ++i) {
            device.View(launch, ids[i], *sources[i], 0, frame % 16, 0, 2, 2);
            if (frame > 0)
                CHECK(device.View(launch, ids[i], *sources[i], 4) == 1);
        }
        device.Process(loader, launch);
        CHECK(loader.GetStatistics().tailTiles == 4);
    }
    CHECK(loader.SetBudget(3, ~std::uint64_t{0}).error().GetStatus() == Status::OutOfRange);
    CHECK(loader.SetBudget(6, 4 * BytesOf(*sources[0], 340) - 1).error().GetStatus() == Status::OutOfRange);
    REQUIRE(loader.SetBudget(4, ~std::uint64_t{0}).has_value());
    for (int frame = 0; frame < 10; ++frame) { // nobody looks at more
        const Launch launch = device.Prepare(loader);
        device.Process(loader, launch);
    }
    CHECK(loader.GetStatistics().slotsInUse == 4);
    TiledTextureDesc desc;
    const auto refused = loader.CreateTexture(MakeSource(MakeLayout(256, 256, 16), 9), desc);
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().GetStatus() == Status::OutOfRange);
    MESSAGE(std::string(refused.error().GetText()));
    CheckSums(loader);
}

TEST_CASE("demand: a texture without a tail keeps its coarsest level") {
    TileLayoutDesc desc;
    desc.width = desc.height = 128;
    desc.tileWidth = desc.tileHeight = 16;
    desc.mips = 2;
    desc.levelCount = 2;
    desc.tailTiles = 0;
    const auto layout = TileLayout::Create(desc);
    REQUIRE(layout.has_value());
    DemandLoaderOptions options = MakeOptions(18); // 16 of level 1
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(*layout, 3);
    const DemandId id = AddTexture(loader, source);
    for (int frame = 0; frame < 30; ++frame) {
        const Launch launch = device.Prepare(loader);
        CHECK(device.View(launch, id, *source, 1) == 16);
        device.View(launch, id, *source, 0, frame % 8, frame / 8, 1, 1);
        device.Process(loader, launch);
    }
    CHECK(loader.GetStatistics().tailTiles == 16);
    CHECK(loader.GetStatistics().freed > 0);
    CheckSums(loader);
}

TEST_CASE("demand case 36: uniform tiles share a slot, which stays while one of them does") {
    for (const bool isShared : {true, false}) {
        DemandLoaderOptions options = MakeOptions(24);
        options.shareUniform = isShared;
        options.loadAncestors = false;
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto flat = MakeSource(MakeLayout(64, 64, 16), 1);
        const auto other = MakeSource(MakeLayout(64, 64, 16), 2);
        flat->isUniform = true;
        const DemandId flatId = AddTexture(loader, flat);
        const DemandId otherId = AddTexture(loader, other);
        const auto checkFlat = [&](const Launch& launch, int tile) {
            const Fetched fetched =
                device.Fetch(launch, flatId.index, flat->GetLayout(), 0, tile % 4 * 16, tile / 4 * 16);
            if (fetched.mip >= 0)
                CHECK(fetched.value == 7);
            return fetched.resident;
        };
        Launch launch = device.Prepare(loader);
        for (int tile = 0; tile < 4; ++tile)
            checkFlat(launch, tile);
        device.Process(loader, launch);
        launch = device.Prepare(loader);
        for (int tile = 0; tile < 4; ++tile)
            CHECK(checkFlat(launch, tile));
        device.Process(loader, launch);
        CHECK(loader.GetStatistics().slotsInUse == (isShared ? 3 : 6)); // with two tails
        CHECK(loader.GetStatistics().shared == (isShared ? 3 : 0));
        CHECK(loader.GetStatistics().residentTiles == 6);
        // Tile 0 alone stays in use while the other texture takes all the room there is.
        for (int frame = 0; frame < 40; ++frame) {
            launch = device.Prepare(loader);
            CHECK(checkFlat(launch, 0));
            device.View(launch, otherId, *other, 0);
            device.View(launch, otherId, *other, 1);
            device.Process(loader, launch);
        }
        for (int frame = 0; frame < 10; ++frame) { // 20 tiles and 2 tails and tile 0: 23 of 24
            launch = device.Prepare(loader);
            CHECK(checkFlat(launch, 0));
            CHECK(device.View(launch, otherId, *other, 0) == 16);
            device.Process(loader, launch);
        }
        REQUIRE(loader.RemoveTexture(flatId).has_value());
        REQUIRE(loader.RemoveTexture(otherId).has_value());
        for (int frame = 0; frame < 3; ++frame)
            device.Process(loader, device.Prepare(loader));
        CHECK(loader.GetStatistics().slotsInUse == 0);
        CHECK(loader.GetStatistics().bytesInUse == 0);
        CheckSums(loader);
    }
}
