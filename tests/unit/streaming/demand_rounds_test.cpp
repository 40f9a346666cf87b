// SPDX-License-Identifier: MIT
// The demand loader from request to picture: what is read, when it is seen, queues that overflow, rates.
// Numbers are those of the specification's list of cases ("demand loading", 10).
#include "DemandTestKit.h"

#include <algorithm>

using namespace demand_test;

namespace {

/// The whole mip, texel by texel, equals the source's; true if all of it was resident.
bool CheckPicture(Device& device, const Launch& launch, DemandId texture, const NumberSource& source,
                  int mip) {
    bool isResident = true;
    const TileLayout& layout = source.GetLayout();
    for (int y = 0; y < layout.GetMipHeight(mip); ++y)
        for (int x = 0; x < layout.GetMipWidth(mip); ++x)
            isResident = device.FetchChecked(launch, texture, source, mip, x, y).resident && isResident;
    return isResident;
}

} // namespace

TEST_CASE("demand case 1: no texture: no request, a ticket that has ended") {
    const DemandLoaderOptions options = MakeOptions(8);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const Launch launch = device.Prepare(loader);
    const DemandTicket ticket = device.Process(loader, launch);
    CHECK(ticket.IsDone());
    CHECK(ticket.GetTaskCount() == 0);
    ticket.Wait();
    CHECK(loader.GetProgress().state == DemandState::Done);
    CHECK(loader.GetStatistics().requested == 0);
    CheckSums(loader);
}

TEST_CASE("demand case 2: nothing sampled: the tail is read, and nothing else") {
    const DemandLoaderOptions options = MakeOptions(8);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
    AddTexture(loader, source);
    for (int i = 0; i < 5; ++i)
        device.Process(loader, device.Prepare(loader));
    CHECK(source->GetReads() == 1);
    CHECK(source->GetReads(static_cast<std::uint32_t>(source->GetLayout().GetRegularTileCount())) == 1);
    CHECK(loader.GetStatistics().requested == 0);
    CHECK(loader.GetStatistics().tails == 1);
    CheckSums(loader);
}

TEST_CASE("demand case 3: one texel of level 0: one request, resident after one round") {
    DemandLoaderOptions options = MakeOptions(8);
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 2);
    const DemandId id = AddTexture(loader, source);
    Launch launch = device.Prepare(loader);
    const Fetched first = device.FetchChecked(launch, id, *source, 0, 77, 33);
    CHECK_FALSE(first.resident);
    CHECK(first.mip == source->GetLayout().GetTailFirstMip());
    const DemandTicket ticket = device.Process(loader, launch);
    CHECK(device.lastRequests.size() == 1);
    CHECK(ticket.GetTaskCount() == 1);
    CHECK(ticket.IsDone());
    CHECK(source->GetReads() == 2); // with the tail
    launch = device.Prepare(loader);
    const Fetched second = device.FetchChecked(launch, id, *source, 0, 77, 33);
    CHECK(second.resident);
    CHECK(second.value == TexelOf(2, 0, 77, 33));
    device.Process(loader, launch);
    CHECK(device.lastRequests.empty());
    CHECK(loader.GetProgress().state == DemandState::Done);
    CheckSums(loader);
}

TEST_CASE("demand case 3, with ancestors: the coarser tiles over it are read too, the coarsest first") {
    const DemandLoaderOptions options = MakeOptions(8);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 2); // levels 0, 1, 2 and a tail
    const DemandId id = AddTexture(loader, source);
    std::vector<std::uint32_t> order;
    source->onRead = [&](std::uint32_t tile, const TileCancellation&) { order.push_back(tile); };
    const Launch launch = device.Prepare(loader);
    device.FetchChecked(launch, id, *source, 0, 77, 33);
    CHECK(device.Process(loader, launch).GetTaskCount() == 3);
    REQUIRE(order.size() == 3);
    const TileLayout& layout = source->GetLayout();
    CHECK(*layout.GetTilePosition(order[0]) == TilePosition{2, 1, 0});
    CHECK(*layout.GetTilePosition(order[1]) == TilePosition{1, 2, 1});
    CHECK(*layout.GetTilePosition(order[2]) == TilePosition{0, 4, 2});
    CHECK(loader.GetStatistics().taken == 1);
    CHECK(loader.GetStatistics().ancestors == 2);
    CheckSums(loader);
}

TEST_CASE("demand case 4: a view of a whole level asks for its tiles, each once") {
    const DemandLoaderOptions options = MakeOptions(128);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 96, 16), 3);
    const DemandId id = AddTexture(loader, source);
    const Launch launch = device.Prepare(loader);
    CHECK_FALSE(CheckPicture(device, launch, id, *source, 0));
    device.Process(loader, launch);
    CHECK(device.attempts == 48);
    std::set<std::pair<std::uint32_t, std::uint32_t>> unique(device.lastRequests.begin(),
                                                             device.lastRequests.end());
    CHECK(unique.size() == 48);
    CHECK(device.lastRequests.size() == 48);
    CHECK(unique.rbegin()->second == 47); // tiles 0 … 47 are level 0
    CHECK(CheckPicture(device, device.Prepare(loader), id, *source, 0));
    for (std::uint32_t tile = 0; tile < 48; ++tile)
        CHECK(source->GetReads(tile) == 1);
    CheckSums(loader);
}

TEST_CASE("demand case 12: textures smaller than a tile are their tail") {
    for (const auto& size : {std::pair{1, 1}, {1, 16}, {16, 3}, {7, 7}}) {
        const int width = size.first, height = size.second;
        CAPTURE(width);
        const DemandLoaderOptions options = MakeOptions(4);
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(width, height, 16), 4);
        const DemandId id = AddTexture(loader, source);
        const Launch launch = device.Prepare(loader);
        for (int mip = 0; mip < source->GetLayout().GetMips(); ++mip)
            CHECK(CheckPicture(device, launch, id, *source, mip));
        device.Process(loader, launch);
        CHECK(device.lastRequests.empty());
        CHECK(source->GetReads() == 1);
    }
}

TEST_CASE("demand case 13: sizes that are no powers of two converge to the reference") {
    for (const auto& size : {std::pair{257, 33}, {100, 37}, {17, 200}}) {
        const int width = size.first, height = size.second;
        CAPTURE(width);
        const DemandLoaderOptions options = MakeOptions(256);
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(width, height, 16), 5);
        const DemandId id = AddTexture(loader, source);
        const auto render = [&](const Launch& launch) {
            for (int mip = 0; mip < source->GetLayout().GetMips(); ++mip)
                CheckPicture(device, launch, id, *source, mip);
        };
        CHECK(device.Converge(loader, render) == 1);
        const Launch launch = device.Prepare(loader);
        for (int mip = 0; mip < source->GetLayout().GetMips(); ++mip)
            CHECK(CheckPicture(device, launch, id, *source, mip));
        CHECK(source->GetReads() == source->GetLayout().GetTileCount());
    }
}

TEST_CASE("demand case 14: a missing tile is shown by the finest ancestor that is there") {
    const DemandLoaderOptions options = MakeOptions(16);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 6);
    const DemandId id = AddTexture(loader, source);
    Launch launch = device.Prepare(loader);
    device.FetchChecked(launch, id, *source, 1, 20, 20); // level 1 and, over it, level 2
    device.Process(loader, launch);
    launch = device.Prepare(loader);
    const Fetched fetched = device.FetchChecked(launch, id, *source, 0, 40, 40);
    CHECK_FALSE(fetched.resident);
    CHECK(fetched.mip == 1);
    device.Process(loader, launch);
    CHECK(device.lastRequests.size() == 1);
}

TEST_CASE("demand case 15: with the tail alone the tail's value is shown") {
    const DemandLoaderOptions options = MakeOptions(16);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 7);
    const DemandId id = AddTexture(loader, source);
    const Launch launch = device.Prepare(loader);
    const Fetched fetched = device.FetchChecked(launch, id, *source, 0, 127, 0);
    CHECK(fetched.mip == 3);
    CHECK(fetched.value == TexelOf(7, 3, 15, 0));
}

TEST_CASE("demand case 16: reads that depend on three others take as many rounds") {
    DemandLoaderOptions options = MakeOptions(64);
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(256, 256, 16), 8);
    const DemandId id = AddTexture(loader, source);
    std::uint32_t result = 0;
    const auto render = [&](const Launch& launch) {
        std::uint32_t value = 0;
        for (int depth = 0; depth < 3; ++depth) {
            const Fetched fetched = device.FetchChecked(launch, id, *source, 0, static_cast<int>(value % 256),
                                                        static_cast<int>(value / 256 % 256));
            if (!fetched.resident)
                return;
            value = fetched.value;
        }
        result = value;
    };
    CHECK(device.Converge(loader, render) == 3);
    std::uint32_t expected = 0;
    for (int depth = 0; depth < 3; ++depth)
        expected = TexelOf(8, 0, static_cast<int>(expected % 256), static_cast<int>(expected / 256 % 256));
    CHECK(result == expected);
}

TEST_CASE("demand case 17: a queue of 16 and 1000 tiles: overflow is counted, nobody waits for ever") {
    DemandLoaderOptions options = MakeOptions(1100);
    options.table.queueCapacity = 16;
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(640, 400, 16), 9); // 40 × 25 tiles of level 0
    const DemandId id = AddTexture(loader, source);
    int rounds = 0;
    for (;; ++rounds) {
        REQUIRE(rounds < 125); // 2 · 1000 / 16
        const Launch launch = device.Prepare(loader);
        device.attempts = 0;
        const int resident = device.View(launch, id, *source, 0);
        device.Process(loader, launch); // checks the words behind the state
        CHECK(device.lastRequests.size() <= 16);
        CHECK(device.lastOverflow == (device.attempts > 16 ? device.attempts - 16 : 0));
        if (resident == 1000)
            break;
    }
    CHECK(rounds >= 63);
    CHECK(loader.GetStatistics().taken == 1000);
    CheckSums(loader);
}

TEST_CASE("demand case 17: limits of a call serve textures in turns") {
    DemandLoaderOptions options = MakeOptions(1000);
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    std::vector<Shared<NumberSource>> sources;
    std::vector<DemandId> ids;
    for (std::uint32_t i = 0; i < 8; ++i) {
        sources.push_back(MakeSource(MakeLayout(128, 128, 16), i));
        ids.push_back(AddTexture(loader, sources.back()));
    }
    // 512 tiles, four a call: after 64 calls every texture has had its turn 32 times.
    for (int round = 0; round < 64; ++round) {
        const Launch launch = device.Prepare(loader);
        for (std::size_t i = 0; i < ids.size(); ++i)
            device.View(launch, ids[i], *sources[i], 0);
        DemandLimits limits;
        limits.maxTiles = 4;
        CHECK(device.Process(loader, launch, limits).GetTaskCount() == 4);
    }
    int least = 1000, most = 0;
    for (const auto& source : sources) {
        least = std::min(least, source->GetReads() - 1);
        most = std::max(most, source->GetReads() - 1);
    }
    CHECK(least == 32);
    CHECK(most == 32);
    CHECK(loader.GetStatistics().overLimit > 0);
    CheckSums(loader);
}

TEST_CASE("demand case 18: without a queue nothing is asked for") {
    DemandLoaderOptions options = MakeOptions(16);
    options.table.queueCapacity = 0;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(64, 64, 16), 10);
    const DemandId id = AddTexture(loader, source);
    for (int round = 0; round < 3; ++round) {
        const Launch launch = device.Prepare(loader);
        CHECK(device.View(launch, id, *source, 0) == 0);
        device.Process(loader, launch);
        CHECK(device.lastRequests.empty());
        CHECK(device.lastOverflow == 16);
        CHECK(loader.GetProgress().state == DemandState::Working);
    }
    CHECK(source->GetReads() == 1);
    CHECK(loader.GetStatistics().overflow == 48);
}

TEST_CASE("demand case 19: a rate of 1/64 takes more rounds to the same picture") {
    const DemandLoaderOptions options = MakeOptions(256);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 11);
    const DemandId id = AddTexture(loader, source);
    device.rate = 1.0 / 64;
    int rounds = 0;
    for (int resident = 0; resident < 64; ++rounds) { // one texel a tile and round
        REQUIRE(rounds < 5000);                       // (1 - 1/64)^5000 · 64 tiles < 1e-32
        const Launch launch = device.Prepare(loader);
        resident = device.View(launch, id, *source, 0);
        device.Process(loader, launch);
    }
    CHECK(rounds > 64); // one round at rate 1
    CHECK(CheckPicture(device, device.Prepare(loader), id, *source, 0));
}

TEST_CASE("demand case 20: a budget of all tiles evicts nothing") {
    const TileLayout layout = MakeLayout(128, 128, 16);
    const DemandLoaderOptions options = MakeOptions(static_cast<std::uint32_t>(layout.GetTileCount()));
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(layout, 12);
    const DemandId id = AddTexture(loader, source);
    for (int round = 0; round < 20; ++round) {
        const Launch launch = device.Prepare(loader);
        device.View(launch, id, *source, round % layout.GetMips(), round % 3, 0, 2, 2);
        if (round > 10)
            device.View(launch, id, *source, 0);
        device.Process(loader, launch);
    }
    CHECK(loader.GetStatistics().evicted == 0);
    CHECK(source->GetReads() <= layout.GetTileCount());
    CHECK(loader.GetProgress().state == DemandState::Done);
    CheckSums(loader);
}
