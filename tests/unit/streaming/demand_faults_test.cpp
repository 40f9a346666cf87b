// SPDX-License-Identifier: MIT
// The demand loader with sources that throw, fail, answer short, later, late or never, and uploads that fail.
#include "DemandTestKit.h"

#include "support/TestSeed.h"

#include <chrono>

using namespace demand_test;

namespace {

/// A fault of tile 5 of level 0 while it is on; the other tiles are there in the end, in its place a coarser
/// one, it is reported once, and read once before a retry.
void CheckFault(Fault fault, int threads, const char* text) {
    CAPTURE(text);
    const DemandLoaderOptions options = MakeOptions(128, threads);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
    std::atomic<bool> isOn{true};
    source->getFault = [&](std::uint32_t tile) { return tile == 13 && isOn ? fault : Fault::None; };
    const DemandId id = AddTexture(loader, source);
    const auto render = [&](const Launch& launch) { device.View(launch, id, *source, 0); };
    device.Converge(loader, render);
    CHECK(loader.GetProgress().state == DemandState::Done);
    CHECK(loader.GetProgress().failed == 1);
    for (int round = 0; round < 5; ++round) {
        const Launch launch = device.Prepare(loader);
        CHECK(device.View(launch, id, *source, 0) == 63);
        const Fetched fetched = device.FetchChecked(launch, id, *source, 0, 5 * 16, 16);
        CHECK_FALSE(fetched.resident);
        CHECK(fetched.mip == 1);
        device.Process(loader, launch);
    }
    CHECK(source->GetReads(13) == 1);
    CHECK(loader.GetStatistics().failed == 1);
    DemandError error;
    REQUIRE(loader.TakeError(error));
    CHECK(error.texture == id);
    CHECK(error.tile == 13);
    CHECK(error.position == TilePosition{0, 5, 1});
    CHECK(std::string(error.error.GetText()).find(text) != std::string::npos);
    CHECK_FALSE(loader.TakeError(error));
    // Still broken: reported again. Then repaired: the picture converges.
    REQUIRE(loader.RetryFailed().has_value());
    device.Converge(loader, render);
    REQUIRE(loader.TakeError(error));
    CHECK(source->GetReads(13) == 2);
    isOn = false;
    REQUIRE(loader.RetryFailed().has_value());
    device.Converge(loader, render);
    CHECK(device.View(device.Prepare(loader), id, *source, 0) == 64);
    CHECK(loader.GetProgress().failed == 0);
    CHECK_FALSE(loader.TakeError(error));
    CheckSums(loader);
}

} // namespace

TEST_CASE("demand case 27: a source that throws or fails for one tile") {
    for (const int threads : {0, 1, 4}) {
        CheckFault(Fault::Throw, threads, "threw an exception: disk on fire");
        CheckFault(Fault::ThrowInt, threads, "threw something");
        CheckFault(Fault::Error, threads, "the network is down");
    }
}

TEST_CASE("demand case 28: a source that answers short, or says that it wrote too much") {
    CheckFault(Fault::Short, 2, "tile: 1020 bytes: the source promised 1024");
    CheckFault(Fault::Long, 0, "tile: 1028 bytes: the source promised 1024");
}

TEST_CASE("demand: failed tiles are asked for again after some rounds where the options say so") {
    DemandLoaderOptions options = MakeOptions(16);
    options.retryAfterRounds = 10;
    options.loadAncestors = false;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(32, 32, 16), 1);
    source->getFault = [&](std::uint32_t tile) { return tile == 0 ? Fault::Error : Fault::None; };
    const DemandId id = AddTexture(loader, source);
    for (int round = 0; round < 100; ++round) {
        const Launch launch = device.Prepare(loader);
        device.View(launch, id, *source, 0);
        device.Process(loader, launch);
    }
    CHECK(source->GetReads(0) >= 9);
    CHECK(source->GetReads(0) <= 10);
}

TEST_CASE("demand: a tail that fails is shown by nothing until a retry") {
    const DemandLoaderOptions options = MakeOptions(16);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(32, 32, 16), 1);
    bool isOn = true;
    source->getFault = [&](std::uint32_t tile) { return tile == 4 && isOn ? Fault::Error : Fault::None; };
    const DemandId id = AddTexture(loader, source);
    for (int round = 0; round < 3; ++round) {
        const Launch launch = device.Prepare(loader);
        CHECK(device.FetchChecked(launch, id, *source, 1, 0, 0).mip == -1);
        device.Process(loader, launch);
    }
    CHECK(source->GetReads(4) == 1);
    isOn = false;
    REQUIRE(loader.RetryFailed().has_value());
    CHECK(device.FetchChecked(device.Prepare(loader), id, *source, 1, 0, 0).resident);
    CheckSums(loader);
}

TEST_CASE("demand case 29: a source that says \"later\" k times is asked k + 1 times") {
    for (const int threads : {0, 2}) {
        const DemandLoaderOptions options = MakeOptions(16, threads);
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(32, 32, 16), 1);
        const DemandId id = AddTexture(loader, source);
        loader.WaitIdle();
        constexpr int k = 4;
        source->getFault = [&](std::uint32_t tile) {
            return tile == 2 && source->GetReads(2) <= k ? Fault::Later : Fault::None;
        };
        device.Converge(loader, [&](const Launch& launch) { device.View(launch, id, *source, 0); });
        CHECK(source->GetReads(2) == k + 1);
        CHECK(device.View(device.Prepare(loader), id, *source, 0) == 4);
        CHECK(loader.GetStatistics().deferred == k);
        CHECK(loader.GetStatistics().slotsInUse == 5);
        CheckSums(loader);
    }
}

TEST_CASE("demand: a tail that comes later comes") {
    const DemandLoaderOptions options = MakeOptions(16);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(32, 32, 16), 1);
    source->getFault = [&](std::uint32_t tile) {
        return tile == 4 && source->GetReads(4) <= 3 ? Fault::Later : Fault::None;
    };
    const DemandId id = AddTexture(loader, source);
    int rounds = 0;
    while (!device.FetchChecked(device.Prepare(loader), id, *source, 1, 3, 3).resident)
        REQUIRE(++rounds < 5);
    CHECK(source->GetReads(4) == 4);
}

TEST_CASE("demand case 30: eight threads, random delays, out of order: nothing is seen before its data") {
    const std::uint32_t seed = static_cast<std::uint32_t>(openntc::test::GetTestSeed());
    MESSAGE("seed: " << seed);
    DemandLoaderOptions options = MakeOptions(128, 8);
    options.framesInFlight = 2;
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto source = MakeSource(MakeLayout(128, 128, 16), 1);
    source->onRead = [&](std::uint32_t tile, const TileCancellation&) {
        std::this_thread::sleep_for(std::chrono::milliseconds(Mix(seed, tile) % 51));
    };
    const DemandId id = AddTexture(loader, source);
    int resident = 0;
    for (int frame = 0; resident < 64; ++frame) { // as an interactive program: never waits for a ticket
        REQUIRE(frame < 100000);
        const Launch launch = device.Prepare(loader);
        resident = device.View(launch, id, *source, 0); // checks every value
        DemandLimits limits;
        limits.maxTiles = 8;
        device.Process(loader, launch, limits);
        if (frame % 16 == 15)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    CHECK(source->GetReads() == 64 + 16 + 4 + 1);
    CheckSums(loader);
}

TEST_CASE("demand case 31: destruction asks a source to stop and waits for it; Abort does not wait") {
    for (const bool isAborted : {false, true}) {
        CAPTURE(isAborted);
        const DemandLoaderOptions options = MakeOptions(16, 2);
        const auto source = MakeSource(MakeLayout(32, 32, 16), 1);
        std::atomic<bool> isReleased{false}, sawCancel{false}, isBlocked{false};
        source->onRead = [&](std::uint32_t tile, const TileCancellation& cancellation) {
            if (tile == 4)
                return;
            isBlocked = true;
            while (!cancellation.IsCancelled())
                std::this_thread::yield();
            sawCancel = true;
            while (isAborted && !isReleased) // never mind
                std::this_thread::yield();
        };
        DemandTicket ticket;
        {
            DemandLoader loader = MakeLoader(options);
            Device device(options);
            const DemandId id = AddTexture(loader, source);
            loader.WaitIdle();
            const Launch launch = device.Prepare(loader);
            device.View(launch, id, *source, 0);
            ticket = device.Process(loader, launch);
            CHECK(ticket.GetTaskCount() == 4);
            CHECK_FALSE(ticket.WaitFor(1));
            while (!isBlocked)
                std::this_thread::yield();
            if (isAborted) {
                std::thread waiter([&] { ticket.Wait(); }); // returns when the loader is aborted
                loader.Abort();
                waiter.join();
                CHECK(loader.LaunchPrepare(device).error().GetStatus() == Status::InvalidState);
                CHECK(loader.RemoveTexture(id).error().GetStatus() == Status::InvalidState);
                CHECK(source->running > 0);
            }
        }
        CHECK(ticket.IsDone());
        while (!sawCancel) // the thread may be anywhere
            std::this_thread::yield();
        isReleased = true;
        while (source->running > 0)
            std::this_thread::yield();
    }
}

TEST_CASE("demand case 31: a source that never answers holds one thread; the others go on") {
    const DemandLoaderOptions options = MakeOptions(64, 2);
    const auto source = MakeSource(MakeLayout(64, 64, 16), 1);
    source->onRead = [&](std::uint32_t tile, const TileCancellation& cancellation) {
        while (tile == 7 && !cancellation.IsCancelled())
            std::this_thread::yield();
    };
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const DemandId id = AddTexture(loader, source);
    int resident = 0;
    while (resident < 15) {
        const Launch launch = device.Prepare(loader);
        resident = device.View(launch, id, *source, 0);
        device.Process(loader, launch);
        std::this_thread::yield();
    }
    CHECK(loader.GetProgress().outstanding == 1);
    CHECK(loader.GetProgress().state == DemandState::Working);
}

TEST_CASE("demand case 32: an upload that fails or throws is an error of the tile, its slot is given back") {
    for (const bool isThrown : {false, true}) {
        DemandLoaderOptions options = MakeOptions(16);
        DemandLoader loader = MakeLoader(options);
        Device device(options);
        const auto source = MakeSource(MakeLayout(64, 64, 16), 1);
        const DemandId id = AddTexture(loader, source);
        bool isOn = true;
        device.onUpload = [&](const TileUpload& upload) -> Expected<void> {
            if (upload.tile != 3 || !isOn)
                return {};
            if (isThrown)
                throw std::runtime_error("out of staging memory");
            return Fail(Status::OutOfMemory, "out of staging memory");
        };
        const auto render = [&](const Launch& launch) { device.View(launch, id, *source, 0, 2, 0, 2, 1); };
        device.Converge(loader, render);
        Launch launch = device.Prepare(loader);
        CHECK(device.View(launch, id, *source, 0, 2, 0, 1, 1) == 1);
        CHECK(device.View(launch, id, *source, 0, 3, 0, 1, 1) == 0);
        device.Process(loader, launch);
        CHECK(loader.GetStatistics().slotsInUse == 3); // tail, one of level 1, one of level 0
        DemandError error;
        REQUIRE(loader.TakeError(error));
        CHECK(error.tile == 3);
        CHECK(std::string(error.error.GetText()).find("out of staging memory") != std::string::npos);
        CHECK(source->GetReads(3) == 1);
        isOn = false;
        REQUIRE(loader.RetryFailed().has_value());
        device.Converge(loader, render);
        CHECK(device.View(device.Prepare(loader), id, *source, 0, 2, 0, 2, 1) == 2);
        CheckSums(loader);
    }
}
