// SPDX-License-Identifier: MIT
// The demand loader's textures, resources, launches and tickets: what comes, goes, is shared, dropped and left.
#include "DemandTestKit.h"

#include "support/CountingAllocator.h"

using namespace demand_test;

namespace {

/// Counts live bytes; for several threads.
class LockedAllocator final : public Allocator {
public:
    void* Allocate(std::size_t bytes) noexcept override {
        const std::lock_guard<std::mutex> lock(mutex_);
        return inner_.Allocate(bytes);
    }
    void Deallocate(void* block, std::size_t bytes) noexcept override {
        const std::lock_guard<std::mutex> lock(mutex_);
        inner_.Deallocate(block, bytes);
    }
    std::size_t GetUsedBytes() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return inner_.GetUsedBytes();
    }

private:
    std::mutex mutex_;
    openntc::test::CountingAllocator inner_;
};

struct Pages {
    std::map<std::uint32_t, int> calls;
    std::uint32_t version = 1;
    std::uint32_t laterPage = NTC_TILE_MISSING;
    std::uint32_t badPage = NTC_TILE_MISSING;

    static Expected<PageRead> Call(void* user, std::uint32_t page) {
        Pages& self = *static_cast<Pages*>(user);
        const int call = ++self.calls[page];
        if (page == self.laterPage && call < 3)
            return PageRead{TileAnswer::Later, 0};
        if (page == self.badPage)
            throw std::runtime_error("page torn out");
        return PageRead{TileAnswer::Ready, page * 2 + self.version};
    }
};

} // namespace

TEST_CASE("demand case 33: a texture goes with requests queued, reads running, tiles resident and staged") {
    for (const int threads : {0, 3}) {
        CAPTURE(threads);
        DemandLoaderOptions options = MakeOptions(12, threads);
        options.framesInFlight = 2;
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
        const auto other = MakeSource(MakeLayout(64, 64, 16), 2);
        const DemandId otherId = AddTexture(loader, other);
        DemandId id = AddTexture(loader, source);
        for (int round = 0; round < 12; ++round) { // fills the pool, and stages
            const Launch launch = device.Prepare(loader);
            device.View(launch, id, *source, 0, round % 6, round % 5, 2, 1);
            device.Process(loader, launch);
            loader.WaitIdle();
        }
        CHECK(loader.GetStatistics().evicted > 0);
        std::atomic<bool> isHeld{threads > 0};
        std::atomic<int> held{0};
        source->onRead = [&](std::uint32_t, const TileCancellation& cancellation) {
            ++held;
            while (isHeld && !cancellation.IsCancelled())
                std::this_thread::yield();
        };
        Launch asked = device.Prepare(loader); // in flight while the texture goes
        const Launch second = device.Prepare(loader);
        device.View(asked, id, *source, 0, 0, 6, 8, 2);
        DemandTicket ticket = device.Process(loader, asked);
        device.View(second, id, *source, 1);
        const DemandReadback late = device.Read(loader);
        std::vector<std::uint32_t> copy(device.GetState()); // what the second launch asked for
        REQUIRE(loader.RemoveTexture(id).has_value());
        CHECK(loader.RemoveTexture(id).error().GetStatus() == Status::InvalidArgument);
        ticket.Wait(); // cancelled
        const DemandId again = AddTexture(loader, other);
        CHECK(again.index == id.index); // used again
        CHECK(again != id);
        const std::uint64_t stale = loader.GetStatistics().stale;
        REQUIRE(loader.ProcessRequests(second.context, late).has_value());
        CHECK(loader.GetStatistics().stale == stale + late.requests.GetCount()); // not for the new one
        isHeld = false;
        loader.WaitIdle();
        device.Converge(loader, [&](const Launch& launch) {
            device.View(launch, again, *other, 1);
            device.View(launch, otherId, *other, 1);
        });
        CHECK(loader.GetStatistics().residentTiles - loader.GetStatistics().stagedTiles ==
              5); // shared by both
        REQUIRE(loader.RemoveTexture(again).has_value());
        REQUIRE(loader.RemoveTexture(otherId).has_value());
        for (int round = 0; round < 4; ++round)
            device.Process(loader, device.Prepare(loader));
        const DemandStatistics statistics = loader.GetStatistics();
        CHECK(statistics.slotsInUse == 0);
        CHECK(statistics.bytesInUse == 0);
        CHECK(statistics.residentTiles == 0);
        CHECK(statistics.tailTiles == 0);
        CHECK(statistics.stagedTiles == 0);
        CHECK(statistics.textures == 0);
        CHECK(statistics.pagesInUse == 0);
        CheckSums(loader);
    }
}

TEST_CASE(
    "demand case 34: a texture is replaced by one of another size: the old one until the new tail is in") {
    const DemandLoaderOptions options = MakeOptions(64, 1);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto before = MakeSource(MakeLayout(128, 128, 16), 1);
    const auto after = MakeSource(MakeLayout(100, 260, 16), 2);
    const DemandId id = AddTexture(loader, before);
    device.Converge(loader, [&](const Launch& launch) { device.View(launch, id, *before, 0, 0, 0, 4, 1); });
    std::atomic<bool> isHeld{true};
    after->onRead = [&](std::uint32_t, const TileCancellation& cancellation) {
        while (isHeld && !cancellation.IsCancelled())
            std::this_thread::yield();
    };
    TiledTextureDesc desc;
    desc.hasFeedback = false;
    REQUIRE(loader.ReplaceTexture(id, after, desc).has_value());
    for (int round = 0; round < 5; ++round) {
        const Launch launch = device.Prepare(loader);
        CHECK(device.View(launch, id, *before, 0, 0, 0, 4, 1) == 4);
        device.Process(loader, launch);
    }
    isHeld = false;
    loader.WaitIdle();
    Launch launch = device.Prepare(loader);
    CHECK(device.GetHeader(launch, id.index).height == 260);
    CHECK(device.View(launch, id, *after, after->GetLayout().GetTailFirstMip()) == 1);
    device.Process(loader, launch);
    device.Converge(loader, [&](const Launch& l) { device.View(l, id, *after, 0, 0, 0, 2, 2); });
    CHECK(loader.GetStatistics().textures == 1);
    CHECK(loader.GetStatistics().pagesInUse == static_cast<std::uint32_t>(after->GetLayout().GetTileCount()));
    CHECK(before.Get()->running == 0);
    // A replacement whose tail fails is reported, and the old one stays. Another one takes its place.
    const auto broken = MakeSource(MakeLayout(64, 64, 16), 3);
    broken->getFault = [](std::uint32_t) { return Fault::Error; };
    REQUIRE(loader.ReplaceTexture(id, broken, desc).has_value());
    loader.WaitIdle();
    for (int round = 0; round < 3; ++round) {
        launch = device.Prepare(loader);
        CHECK(device.View(launch, id, *after, 0, 0, 0, 2, 2) == 4);
        device.Process(loader, launch);
    }
    DemandError error;
    REQUIRE(loader.TakeError(error));
    CHECK(error.texture == id);
    REQUIRE(loader.ReplaceTexture(id, before, desc).has_value());
    loader.WaitIdle();
    launch = device.Prepare(loader);
    CHECK(device.GetHeader(launch, id.index).width == 128);
    CHECK(device.View(launch, id, *before, 3) == 1);
    device.Process(loader, launch);
    for (int round = 0; round < 3; ++round)
        device.Process(loader, device.Prepare(loader));
    CHECK(loader.GetStatistics().slotsInUse == 1);
    CheckSums(loader);
    CHECK(loader.ReplaceTexture({7, 7}, before, desc).error().GetStatus() == Status::InvalidArgument);
}

TEST_CASE("demand case 35: two textures of one source read each tile once, or twice without coalescing") {
    for (const bool isCoalescing : {true, false}) {
        DemandLoaderOptions options = MakeOptions(64);
        options.coalesce = isCoalescing;
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(64, 64, 16), 1);
        const DemandId first = AddTexture(loader, source);
        const DemandId second = AddTexture(loader, source);
        const auto render = [&](const Launch& launch) {
            device.View(launch, first, *source, 0);
            device.View(launch, second, *source, 0);
        };
        device.Converge(loader, render);
        for (std::uint32_t tile = 0; tile < 21; ++tile)
            CHECK(source->GetReads(tile) == (isCoalescing ? 1 : 2));
        CHECK(loader.GetStatistics().slotsInUse == (isCoalescing ? 21 : 42));
        // A third one sees at once what is there; without one of them the others stay.
        const DemandId third = AddTexture(loader, source);
        Launch launch = device.Prepare(loader);
        CHECK(device.View(launch, third, *source, 0) == (isCoalescing ? 16 : 0));
        device.Process(loader, launch);
        REQUIRE(loader.RemoveTexture(first).has_value());
        launch = device.Prepare(loader);
        CHECK(device.View(launch, second, *source, 0) == 16);
        CHECK(device.FetchChecked(launch, first, *source, 0, 0, 0).mip == -1);
        device.Process(loader, launch);
        CheckSums(loader);
    }
}

TEST_CASE("demand: two sources of one identity, cut up alike, are one source") {
    DemandLoaderOptions options = MakeOptions(128);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const TileLayout layout = MakeLayout(64, 64, 16);
    const auto first = MakeSource(layout, 1), same = MakeSource(layout, 1), other = MakeSource(layout, 2),
               unnamed = MakeSource(layout, 3), cut = MakeSource(MakeLayout(64, 64, 8), 1);
    first->identity = same->identity = cut->identity = "brick.ntc";
    other->identity = "brick.ntd";
    CHECK(IsSameSource(*first, *same));
    CHECK(IsSameSource(*unnamed, *unnamed));
    for (const auto& different : {other, unnamed, cut})
        CHECK_FALSE(IsSameSource(*first, *different));
    CHECK_FALSE(IsSameSource(*unnamed, *MakeSource(layout, 3)));
    const DemandId firstId = AddTexture(loader, first), sameId = AddTexture(loader, same),
                   otherId = AddTexture(loader, other);
    device.Converge(loader, [&](const Launch& launch) {
        device.View(launch, firstId, *first, 0);
        device.View(launch, sameId, *same, 0);
        device.View(launch, otherId, *other, 0);
    });
    CHECK(first->GetReads() == 21); // each tile once, by the source that came first
    CHECK(same->GetReads() == 0);
    CHECK(other->GetReads() == 21);
    CHECK(loader.GetStatistics().slotsInUse == 42);
    REQUIRE(loader.RemoveTexture(firstId).has_value());
    const Launch launch = device.Prepare(loader);
    CHECK(device.View(launch, sameId, *same, 0) == 16);
    device.Process(loader, launch);
    CheckSums(loader);
}

TEST_CASE("demand: two loaders share sources and threads") {
    auto workers = WorkerPool::Create(2);
    REQUIRE(workers.has_value());
    DemandLoaderOptions options = MakeOptions(64);
    options.workers = *workers;
    const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
    DemandLoader loaders[] = {MakeLoader(options), MakeLoader(options)};
    for (DemandLoader& loader : loaders) {
        Device device(options);
        const DemandId id = AddTexture(loader, source);
        loader.WaitIdle();
        const auto render = [&](const Launch& launch) { device.View(launch, id, *source, 0, 0, 0, 4, 4); };
        device.Converge(loader, render);
        CHECK(device.View(device.Prepare(loader), id, *source, 0, 0, 0, 4, 4) == 16);
    }
    CHECK(source->GetReads() == 2 * (16 + 4 + 1 + 1));
}

TEST_CASE("demand case 37: two launches in flight: requests of both are handled, none twice") {
    DemandLoaderOptions options = MakeOptions(64, 2);
    options.framesInFlight = 2;
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
    const DemandId id = AddTexture(loader, source);
    loader.WaitIdle();
    // A queue each, as an engine with frames in flight has; here the device's one is taken apart.
    const Launch first = device.Prepare(loader);
    device.View(first, id, *source, 0, 0, 0, 4, 1);
    const std::vector<std::uint32_t> queue = device.GetState();
    const Launch second = device.Prepare(loader); // empties the queue, keeps the bits
    device.View(second, id, *source, 0, 2, 0, 4, 1);
    auto requests = ReadRequests(loader.GetPageTable().GetLaunchState(), std::as_bytes(std::span(queue)));
    REQUIRE(requests.has_value());
    CHECK(requests->GetCount() == 4);
    auto ticket = loader.ProcessRequests(first.context, {*requests, {}});
    REQUIRE(ticket.has_value());
    CHECK(ticket->GetTaskCount() == 4);
    const DemandTicket other = device.Process(loader, second);
    CHECK(other.GetTaskCount() == 2);
    other.Wait();
    ticket->Wait();
    CHECK(device.View(device.Prepare(loader), id, *source, 0, 0, 0, 6, 1) == 6);
    CHECK(source->GetReads() == 7);
    CheckSums(loader);
}

TEST_CASE("demand case 38: tickets: poll, wait, two who wait, no task, dropped") {
    const DemandLoaderOptions options = MakeOptions(64, 2);
    const auto source = MakeSource(MakeLayout(64, 64, 16), 1);
    std::atomic<bool> isHeld{true};
    source->onRead = [&](std::uint32_t, const TileCancellation&) {
        while (isHeld)
            std::this_thread::yield();
    };
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    isHeld = false;
    const DemandId id = AddTexture(loader, source);
    loader.WaitIdle();
    isHeld = true;
    Launch launch = device.Prepare(loader);
    device.View(launch, id, *source, 1);
    const DemandTicket ticket = device.Process(loader, launch);
    CHECK(ticket.GetTaskCount() == 4);
    CHECK(ticket.GetRemainingCount() == 4);
    CHECK_FALSE(ticket.IsDone());
    CHECK_FALSE(ticket.WaitFor(1));
    launch = device.Prepare(loader);
    {
        const DemandTicket none = device.Process(loader, launch); // all is being read
        CHECK(none.IsDone());
        none.Wait();
    }
    launch = device.Prepare(loader);
    device.View(launch, id, *source, 0, 0, 0, 2, 1);
    static_cast<void>(device.Process(loader, launch)); // dropped
    std::thread waiters[] = {std::thread([&] { ticket.Wait(); }),
                             std::thread([copy = ticket] { copy.Wait(); })};
    isHeld = false;
    for (std::thread& waiter : waiters)
        waiter.join();
    CHECK(ticket.GetRemainingCount() == 0);
    CHECK(ticket.GetFailedCount() == 0);
    CHECK(ticket.GetTaskCount() == 4);
    loader.WaitIdle();
    CHECK(device.View(device.Prepare(loader), id, *source, 0, 0, 0, 2, 1) == 2);
    CHECK(DemandTicket().IsDone());
    CheckSums(loader);
}

TEST_CASE("demand case 39: a thousand launches without waiting take no more memory than a hundred") {
    LockedAllocator allocator;
    std::size_t used = 0;
    {
        DemandLoaderOptions options = MakeOptions(40, 2);
        options.framesInFlight = 2;
        DemandLoader loader = MakeLoader(options, allocator);
        Device device(options);
        const auto source = MakeSource(MakeLayout(256, 256, 16), 1);
        const DemandId id = AddTexture(loader, source);
        std::size_t early = 0;
        for (int frame = 0; frame < 1000; ++frame) {
            const Launch launch = device.Prepare(loader);
            device.View(launch, id, *source, 0, frame * 7 % 15, frame / 16 % 15, 2, 2);
            if (frame % 10 == 9)
                REQUIRE(loader.AbandonLaunch(launch.context).has_value());
            else
                device.Process(loader, launch);
            if (frame == 400)
                early = allocator.GetUsedBytes();
        }
        loader.WaitIdle();
        used = allocator.GetUsedBytes();
        // The tiles read at a time vary with the threads: up to what may be outstanding, once. Each has a buffer, a
        // ticket, and places in lists whose capacity doubles.
        constexpr std::size_t kPlaces =
            2 * (sizeof(detail::ReadTask) + 2 * sizeof(detail::FilledTile) + sizeof(detail::StagedTile) +
                 sizeof(Shared<detail::TicketState>));
        CHECK(used <= early + options.slots * (options.slotBytes + kPlaces + sizeof(detail::TicketState)));
        CHECK(loader.GetStatistics().hostBytes <= std::size_t{options.slots} * options.slotBytes);
        CHECK(loader.GetStatistics().abandoned == 100);
        CheckSums(loader);
    }
    CHECK(allocator.GetUsedBytes() == 0);
}

TEST_CASE("demand case 40: launches and their processing in any order are defined, and nothing is lost") {
    DemandLoaderOptions options = MakeOptions(64);
    options.framesInFlight = 2;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(64, 64, 16), 1);
    const DemandId id = AddTexture(loader, source);
    CHECK(loader.ProcessRequests({}, {}).error().GetStatus() == Status::InvalidState);
    CHECK(loader.ProcessRequests({1}, {}).error().GetStatus() == Status::InvalidState);
    CHECK(loader.AbandonLaunch({1}).error().GetStatus() == Status::InvalidState);
    const Launch dropped = device.Prepare(loader); // its requests are never processed
    device.View(dropped, id, *source, 0);
    device.Prepare(loader);
    Launch launch = device.Prepare(loader); // the first one is too old now
    CHECK(loader.ProcessRequests(dropped.context, {}).error().GetStatus() == Status::InvalidState);
    device.View(launch, id, *source, 0);
    device.Process(loader, launch);
    CHECK(loader.ProcessRequests(launch.context, {}).error().GetStatus() == Status::InvalidState);
    CHECK(device.View(device.Prepare(loader), id, *source, 0) == 16);
    CHECK(loader.GetStatistics().abandoned == 2);
    CheckSums(loader);
}

TEST_CASE("demand case 42: a resource of 100 000 pages") {
    for (const int threads : {0, 1}) {
        DemandLoaderOptions options = MakeOptions(4, threads);
        options.table.maxTiles = 200000;
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        Pages pages;
        pages.laterPage = 77;
        pages.badPage = 78;
        const auto id = loader.CreateResource(100000, {&Pages::Call, &pages});
        REQUIRE(id.has_value());
        const auto get = [&](const Launch& launch, std::uint32_t page) {
            const std::uint32_t value = device.GetEntry(launch, id->index, page);
            if (value == NTC_TILE_MISSING)
                device.Request(launch, id->index, page);
            return value;
        };
        const auto render = [&](const Launch& launch) {
            for (const std::uint32_t page : {0u, 77u, 78u, 5000u, 99999u})
                get(launch, page);
        };
        device.Converge(loader, render);
        Launch launch = device.Prepare(loader);
        CHECK(get(launch, 0) == 1);
        CHECK(get(launch, 77) == 155);
        CHECK(get(launch, 5000) == 10001);
        CHECK(get(launch, 99999) == 199999);
        CHECK(get(launch, 78) == NTC_TILE_MISSING);
        CHECK(get(launch, 1) == NTC_TILE_MISSING);
        device.Process(loader, launch).Wait();
        CHECK(pages.calls[77] == 3);
        CHECK(pages.calls[78] == 1);
        DemandError error;
        REQUIRE(loader.TakeError(error));
        CHECK(error.tile == 78);
        CHECK(error.position.x == 78);
        CHECK(error.texture == *id);
        pages.version = 5;
        REQUIRE(loader.InvalidatePage(*id, 5000).has_value());
        launch = device.Prepare(loader);
        CHECK(get(launch, 5000) == NTC_TILE_MISSING);
        CHECK(get(launch, 0) == 1);
        device.Process(loader, launch).Wait();
        CHECK(get(device.Prepare(loader), 5000) == 10005);
        CHECK(loader.InvalidatePage(*id, 100000).error().GetStatus() == Status::OutOfRange);
        CHECK(loader.RemoveTexture(*id).error().GetStatus() == Status::InvalidArgument);
        CHECK(loader.CreateResource(0, {&Pages::Call, &pages}).error().GetStatus() == Status::OutOfRange);
        CHECK(loader.CreateResource(10, {}).error().GetStatus() == Status::InvalidArgument);
        CHECK(loader.CreateResource(1000000, {&Pages::Call, &pages}).error().GetStatus() ==
              Status::OutOfMemory);
        CHECK(loader.GetStatistics().slotsInUse == 0);
        REQUIRE(loader.RemoveResource(*id).has_value());
        CHECK(loader.GetStatistics().pagesInUse == 0);
        CheckSums(loader);
    }
}

TEST_CASE("demand: options and textures out of range are refused with their field, value and limit") {
    const auto refuse = [](const DemandLoaderOptions& options, Status status, const char* field) {
        const auto loader = DemandLoader::Create(options);
        REQUIRE_FALSE(loader.has_value());
        CHECK(loader.error().GetStatus() == status);
        CHECK_MESSAGE(std::string(loader.error().GetText()).find(field) != std::string::npos,
                      std::string(loader.error().GetText()));
    };
    DemandLoaderOptions options = MakeOptions(8);
    options.slots = 0;
    refuse(options, Status::OutOfRange, "slots: 0");
    options = MakeOptions(8);
    options.table.maxSlots = 10; // firstSlot 3 and 8 slots
    refuse(options, Status::OutOfRange, "maxSlots: 10");
    options = MakeOptions(8);
    options.slotBytes = 1000;
    refuse(options, Status::InvalidArgument, "slotBytes");
    options = MakeOptions(8);
    options.framesInFlight = 17;
    refuse(options, Status::OutOfRange, "framesInFlight: 17");
    options = MakeOptions(8);
    options.threads = -1;
    refuse(options, Status::OutOfRange, "threads: -1");
    options = MakeOptions(8);
    options.maxOutstanding = 0;
    refuse(options, Status::OutOfRange, "maxOutstanding: 0");

    DemandLoader loader = MakeLoader(MakeOptions(8));
    const auto large = loader.CreateTexture(MakeSource(MakeLayout(64, 64, 32), 1), {});
    REQUIRE_FALSE(large.has_value());
    CHECK(std::string(large.error().GetText()).find("slots have 1536") != std::string::npos);
    CHECK(loader.CreateTexture({}, {}).error().GetStatus() == Status::InvalidArgument);
    CHECK(loader.GetStatistics().slotsInUse == 0);
    CHECK(loader.GetStatistics().textures == 0);
    // The refused textures hold no part of the budget.
    for (std::uint32_t i = 0; i < 8; ++i)
        AddTexture(loader, MakeSource(MakeLayout(64, 64, 16), i));
}

TEST_CASE(
    "demand: without memory every call answers with a status, and the loader goes on when there is some") {
    openntc::test::CountingAllocator allocator;
    const DemandLoaderOptions options = MakeOptions(32);
    {
        bool isMade = false;
        for (std::size_t fail = 0; !isMade; ++fail) {
            openntc::test::CountingAllocator scarce;
            scarce.FailAt(fail);
            const auto loader = DemandLoader::Create(options, scarce);
            isMade = loader.has_value();
            if (!isMade)
                CHECK(loader.error().GetStatus() == Status::OutOfMemory);
            REQUIRE(fail < 100);
        }
        DemandLoader loader = MakeLoader(options, allocator);
        Device device(options);
        const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
        TiledTextureDesc desc;
        desc.hasFeedback = false;
        Expected<DemandId> id = Fail(Status::OutOfMemory, "not yet");
        for (std::size_t fail = 0; !id && fail < 100; ++fail) {
            allocator.FailAt(allocator.GetAllocationCount() + fail);
            id = loader.CreateTexture(source, desc);
            if (!id)
                CHECK(id.error().GetStatus() == Status::OutOfMemory);
        }
        REQUIRE(id.has_value());
        for (std::size_t frame = 0; frame < 300; ++frame) {
            allocator.FailAt(allocator.GetAllocationCount() + frame % 7);
            const Launch launch = device.Prepare(loader); // does with less
            allocator.FailAt(allocator.GetAllocationCount() + frame % 5);
            device.View(launch, *id, *source, 0, static_cast<int>(frame % 7), static_cast<int>(frame / 7 % 7),
                        2, 2);
            const auto ticket = loader.ProcessRequests(launch.context, device.Read(loader));
            if (!ticket) {
                CHECK(ticket.error().GetStatus() == Status::OutOfMemory);
                static_cast<void>(loader.AbandonLaunch(launch.context));
            }
        }
        allocator.FailAt(static_cast<std::size_t>(-1));
        device.Converge(loader,
                        [&](const Launch& launch) { device.View(launch, *id, *source, 0, 3, 3, 3, 3); });
        CHECK(device.View(device.Prepare(loader), *id, *source, 0, 3, 3, 3, 3) == 9);
        CheckSums(loader);
    }
    CHECK(allocator.GetUsedBytes() == 0);
}
