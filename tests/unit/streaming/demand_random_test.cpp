// SPDX-License-Identifier: MIT
// The demand loader under random use, with faults that come and go; its determinism, its cost and its sums.
#include "DemandTestKit.h"

#include "support/CountingAllocator.h"
#include "support/TestSeed.h"

#include <chrono>
#include <random>

using namespace demand_test;

namespace {

std::uint32_t GetDemandSeed() {
    return static_cast<std::uint32_t>(openntc::test::GetTestSeed());
}

/// A walk over textures with a fault rate; returns everything that happened, to compare.
std::vector<std::uint32_t> WalkDetermined(std::uint32_t seed, int rounds) {
    std::mt19937 engine(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
    DemandLoaderOptions options = MakeOptions(48);
    options.framesInFlight = 1 + random() % 3;
    options.table.queueCapacity = 24;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    std::vector<std::uint32_t> log;
    std::vector<Shared<NumberSource>> sources;
    std::vector<DemandId> ids;
    for (std::uint32_t i = 0; i < 3; ++i) {
        sources.push_back(MakeSource(MakeLayout(200 + static_cast<int>(i) * 57, 140, 16), i));
        sources[i]->onRead = [&, i](std::uint32_t tile, const TileCancellation&) {
            log.push_back(1000000 + i * 10000 + tile);
        };
        ids.push_back(AddTexture(loader, sources[i]));
    }
    for (int round = 0; round < rounds; ++round) {
        const Launch launch = device.Prepare(loader);
        const std::size_t which = random() % 3;
        device.View(launch, ids[which], *sources[which], static_cast<int>(random() % 2),
                    static_cast<int>(random() % 10), static_cast<int>(random() % 8), 3, 3);
        device.Process(loader, launch);
        for (const auto& [texture, tile] : device.lastRequests)
            log.push_back(texture * 10000 + tile);
    }
    for (const Device::Uploaded& upload : device.log) {
        log.push_back(upload.tile);
        log.push_back(upload.slot);
    }
    log.push_back(static_cast<std::uint32_t>(loader.GetStatistics().evicted));
    CheckSums(loader);
    return log;
}

struct WalkTexture {
    DemandId id;
    Shared<NumberSource> source;
    Shared<NumberSource> next;    ///< to be shown when its tail is there
    std::uint32_t firstEntry = 0; ///< of `source`, if there is a next one: a replacement moves

    const NumberSource& GetShown(const Device& device, const Launch& launch) const {
        return *(next && device.GetHeader(launch, id.index).firstEntry != firstEntry ? next : source);
    }
};

struct WalkLaunch {
    Launch launch;
    std::vector<WalkTexture> textures; ///< when it was prepared
};

/// Interactive use of several textures for many rounds, with every fault, textures that come, go and change;
/// then without faults: every picture is complete.
void WalkAtRandom(std::uint32_t seed, int rounds, int threads) {
    CAPTURE(seed);
    CAPTURE(threads);
    std::mt19937 engine(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
    const auto below = [&](std::uint32_t end) { return static_cast<int>(random() % end); };
    DemandLoaderOptions options = MakeOptions(60, threads);
    options.framesInFlight = 1 + random() % 3;
    options.table.queueCapacity = 16 + random() % 64;
    options.maxOutstanding = 4 + random() % 60;
    options.retryAfterRounds = random() % 2 * 5;
    std::atomic<std::uint32_t> oneIn{0}; ///< reads that fail; 0: none
    std::atomic<std::uint32_t> counter{seed};
    std::vector<Shared<NumberSource>> sources;
    for (std::uint32_t i = 0; i < 6; ++i) {
        sources.push_back(MakeSource(MakeLayout(16 + below(200), 16 + below(200), 16), i));
        sources[i]->getFault = [&](std::uint32_t tile) {
            const std::uint32_t r = Mix(counter++, tile), in = oneIn;
            constexpr Fault kinds[] = {Fault::Throw, Fault::Error, Fault::Short, Fault::Long, Fault::Later};
            return in != 0 && r % in == 0 ? kinds[r / in % 5] : Fault::None;
        };
        if (threads > 0) {
            sources[i]->onRead = [&](std::uint32_t tile, const TileCancellation&) {
                if (Mix(counter++, tile) % 8 == 0)
                    std::this_thread::yield();
            };
        }
    }
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    device.onUpload = [&](const TileUpload& upload) -> Expected<void> {
        const std::uint32_t in = oneIn;
        if (in != 0 && Mix(counter++, upload.slot) % (2 * in) == 0)
            return Fail(Status::OutOfMemory, "no staging memory");
        return {};
    };
    TiledTextureDesc desc;
    desc.hasFeedback = false;
    std::vector<WalkTexture> textures;
    std::vector<WalkLaunch> inFlight;
    const auto finish = [&] {
        const WalkLaunch first = std::move(inFlight.front());
        inFlight.erase(inFlight.begin());
        for (const WalkTexture& texture : first.textures) {
            device.View(first.launch, texture.id, texture.GetShown(device, first.launch), 0, below(8),
                        below(8), 2, 2);
        }
        DemandLimits limits;
        limits.maxTiles = random() % 2 == 0 ? 4 : 1000;
        if (random() % 16 == 0)
            REQUIRE(loader.AbandonLaunch(first.launch.context).has_value());
        else
            device.Process(loader, first.launch, limits);
    };
    for (int round = 0; round < rounds; ++round) {
        if (random() % 100 == 0)
            oneIn = random() % 2 * (2 + random() % 20);
        if (random() % 20 == 0 && textures.size() < 5) {
            WalkTexture texture;
            texture.source = sources[random() % 6];
            texture.id = AddTexture(loader, texture.source);
            textures.push_back(texture);
        }
        if (random() % 60 == 0 && !textures.empty()) {
            const std::size_t which = random() % textures.size();
            REQUIRE(loader.RemoveTexture(textures[which].id).has_value());
            textures.erase(textures.begin() + static_cast<std::ptrdiff_t>(which));
        }
        if (random() % 60 == 0 && !textures.empty()) {
            WalkTexture& texture = textures[random() % textures.size()];
            const std::uint32_t entry = loader.GetPageTable().GetHeader(texture.id.index)->firstEntry;
            if (texture.next && entry != texture.firstEntry)
                texture.source = texture.next;
            texture.next = sources[random() % 6];
            texture.firstEntry = entry;
            REQUIRE(loader.ReplaceTexture(texture.id, texture.next, desc).has_value());
        }
        if (random() % 200 == 0)
            REQUIRE(loader.SetBudget(20 + random() % 60, ~std::uint64_t{0}).has_value());
        if (random() % 100 == 0)
            REQUIRE(loader.RetryFailed().has_value());
        if (inFlight.size() == options.framesInFlight)
            finish();
        DemandLimits limits;
        limits.maxTiles = random() % 4 == 0 ? 3 : 1000;
        const Launch launch = device.Prepare(loader, limits);
        inFlight.push_back({launch, textures});
        const DemandStatistics s = loader.GetStatistics();
        CHECK(s.slotsInUse <= options.slots);
        CHECK(s.residentTiles >= s.stagedTiles);
        CHECK(s.reading + s.waiting <= options.maxOutstanding);
        CHECK(s.textures == textures.size());
        CheckSums(loader);
        for (DemandError error; loader.TakeError(error);)
            CHECK(error.error.GetStatus() != Status::Ok);
    }
    oneIn = 0;
    REQUIRE(loader.SetBudget(60, ~std::uint64_t{0}).has_value());
    while (!inFlight.empty())
        finish();
    REQUIRE(loader.RetryFailed().has_value());
    for (const WalkTexture& texture : textures) {
        int missing = 1;
        for (int round = 0; missing > 0; ++round) {
            REQUIRE(round < 200);
            const Launch launch = device.Prepare(loader);
            const NumberSource& shown = texture.GetShown(device, launch);
            missing = 0;
            for (int y = 0; y < std::min(48, shown.GetLayout().GetHeight()); y += 3) // 3 × 3 tiles and above
                for (int x = 0; x < std::min(48, shown.GetLayout().GetWidth()); x += 3)
                    missing += device.FetchChecked(launch, texture.id, shown, 0, x, y).resident ? 0 : 1;
            device.Process(loader, launch).Wait();
            loader.WaitIdle();
        }
    }
    for (const WalkTexture& texture : textures)
        REQUIRE(loader.RemoveTexture(texture.id).has_value());
    for (int round = 0; round < 10; ++round) {
        device.Process(loader, device.Prepare(loader));
        loader.WaitIdle();
    }
    CHECK(loader.GetStatistics().slotsInUse == 0);
    CHECK(loader.GetStatistics().pagesInUse == 0);
    CheckSums(loader);
}

} // namespace

TEST_CASE("demand case 44: without threads the same seed gives the same requests, reads and slots") {
    const std::uint32_t seed = GetDemandSeed();
    MESSAGE("seed: " << seed);
    const std::vector<std::uint32_t> first = WalkDetermined(seed, 300);
    CHECK(first.size() > 1000);
    CHECK(first == WalkDetermined(seed, 300));
    CHECK(first != WalkDetermined(seed + 1, 300));
}

TEST_CASE("demand case 45: a random walk of 10 000 rounds with faults that come and go") {
    const std::uint32_t seed = GetDemandSeed();
    MESSAGE("seed: " << seed);
    for (std::uint32_t walk = 0; walk < 10; ++walk)
        WalkAtRandom(seed + walk, 1000, 0);
}

TEST_CASE("demand cases 43 and 45: the random walk with threads") {
    const std::uint32_t seed = GetDemandSeed();
    MESSAGE("seed: " << seed);
    for (const int threads : {1, 2, 8})
        WalkAtRandom(seed + static_cast<std::uint32_t>(threads), 1000, threads);
}

TEST_CASE("demand case 46: the cost of pulling requests does not depend on the number of pages") {
    // Counted, not timed: bytes that the loader takes, and changes that it sends to the device.
    const auto answer = [](void*, std::uint32_t page) -> Expected<PageRead> {
        return PageRead{TileAnswer::Ready, page};
    };
    std::size_t allocations[2] = {}, bytes[2] = {}, changes[2] = {}, fills[2] = {};
    double microseconds[2] = {};
    for (int i = 0; i < 2; ++i) {
        openntc::test::CountingAllocator allocator;
        DemandLoaderOptions options = MakeOptions(4);
        options.table.maxTiles = 10'000'000;
        DemandLoader loader = MakeLoader(options, allocator);
        const std::uint32_t pages = i == 0 ? 100'000 : 10'000'000;
        const auto id = loader.CreateResource(pages, {answer, nullptr});
        REQUIRE(id.has_value());
        Device device(options);
        device.Process(loader, device.Prepare(loader)); // the whole table, once
        const std::size_t before = allocator.GetAllocationCount(), used = allocator.GetUsedBytes();
        double best = 1e9;
        for (std::uint32_t round = 0; round < 20; ++round) {
            // 100 pages, as far from each other as the smaller resource has room for.
            std::vector<NtcTileRequest> requests;
            for (std::uint32_t k = 0; k < 100; ++k)
                requests.push_back({id->index, (k * 1000 + round * 47) % 100'000});
            const auto start = std::chrono::steady_clock::now();
            auto plan = loader.LaunchPrepare(device);
            REQUIRE(plan.has_value());
            for (const PageTable::ByteRange& range : plan->tableChanges)
                changes[i] += range.size;
            for (const StateFill& fill : plan->stateFills)
                fills[i] += fill.words;
            REQUIRE(loader.ProcessRequests(plan->context, {{std::as_bytes(std::span(requests)), 0}, {}})
                        .has_value());
            const std::chrono::duration<double, std::micro> spent = std::chrono::steady_clock::now() - start;
            best = std::min(best, spent.count());
        }
        microseconds[i] = best;
        allocations[i] = allocator.GetAllocationCount() - before;
        bytes[i] = allocator.GetUsedBytes() - used;
        CHECK(loader.GetStatistics().taken == 2000);
    }
    CHECK(allocations[0] == allocations[1]);
    CHECK(bytes[0] == bytes[1]);
    CHECK(changes[0] == changes[1]);
    CHECK(fills[0] == fills[1]);
    MESSAGE("measure: prepare and process 100 requests: " << microseconds[0] << " us among 10^5 pages, "
                                                          << microseconds[1] << " us among 10^7");
}

TEST_CASE("demand case 48: statistics add up") {
    DemandLoaderOptions options = MakeOptions(30);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
    source->getFault = [](std::uint32_t tile) { return tile % 9 == 4 ? Fault::Error : Fault::None; };
    const DemandId id = AddTexture(loader, source);
    std::uint64_t requested = 0, rounds = 0;
    for (int round = 0; round < 100; ++round) {
        const Launch launch = device.Prepare(loader);
        device.View(launch, id, *source, 0, round % 7, round / 7 % 7, 2, 2);
        device.Process(loader, launch);
        requested += device.lastRequests.size();
        ++rounds;
    }
    const DemandStatistics s = loader.GetStatistics();
    CHECK(s.rounds == rounds);
    CHECK(s.processed == rounds);
    CHECK(s.requested == requested);
    CHECK(s.started == static_cast<std::uint64_t>(source->GetReads()));
    CHECK(s.failed > 0);
    CHECK(s.bytesRead == (s.filled - 1) * 1024 + source->GetTileBytes(84));
    CHECK(s.bytesUploaded == s.bytesRead - s.waiting * 1024ull);
    CHECK(s.uploaded == device.log.size());
    CHECK(s.evicted > 0);
    CHECK(s.residentTiles + s.waiting == s.slotsInUse);
    CHECK(s.reading == 0);
    CheckSums(loader);
}
