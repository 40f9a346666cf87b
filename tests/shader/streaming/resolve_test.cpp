// SPDX-License-Identifier: MIT
// passes/ResolveFeedback on the device: feedback to lists of changes, what is cleared and what is not (C4), lists that
// are too short, and a still camera at a low rate, which asks for the same as at rate 1 after a while (C8).
#include "StreamingDevice.h"

#include "openntc/streaming/FeedbackRing.h"

#include "resolve_hlsl_shaders.h"
#include "resolve_shaders.h"
#include "streaming_shaders.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr std::uint32_t kGuardWord = 0xA5A5A5A5u;

/// The pass's buffers; calls run it once.
struct Resolver {
    Context& context;
    std::span<const std::uint32_t> spirv;
    std::vector<std::uint32_t> feedback; ///< words in front of the map and behind it are guards
    std::vector<std::uint32_t> last;
    std::vector<std::uint32_t> changes;

    FeedbackChanges Run(const FeedbackRing& ring, const NtcResolveFeedbackConstants& push) {
        changes.assign(ring.GetBytes() / 4 + 16, kGuardWord);
        const NtcFeedbackChangesHead head = ring.MakeHead();
        std::memcpy(changes.data(), &head, sizeof(head));
        std::vector<Buffer> buffers;
        for (const auto* words : {&feedback, &last, &changes}) {
            auto buffer = context.CreateBuffer(std::as_bytes(std::span(*words)), BufferKind::Storage,
                                               BufferMemory::HostVisible);
            REQUIRE(buffer);
            buffers.push_back(std::move(*buffer));
        }
        const BufferSlot slots[] = {
            {0, BufferKind::Storage}, {1, BufferKind::Storage}, {2, BufferKind::Storage}};
        const auto pipeline = context.CreateComputePipeline(spirv, slots, sizeof(push));
        REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
        const BoundBuffer bound[] = {{0, &buffers[0]}, {1, &buffers[1]}, {2, &buffers[2]}};
        DispatchRequest request;
        request.pipeline = &*pipeline;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        request.groups[0] = std::max(
            (push.regionCount + 4 * NTC_RESOLVE_FEEDBACK_GROUP - 1) / (4 * NTC_RESOLVE_FEEDBACK_GROUP), 1u);
        const auto timing = context.Dispatch(request);
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        std::size_t i = 0;
        for (auto* words : {&feedback, &last, &changes})
            REQUIRE(context.Read(buffers[i++], 0, std::as_writable_bytes(std::span(*words))));
        for (std::size_t guard = ring.GetBytes() / 4; guard < changes.size(); ++guard)
            REQUIRE(changes[guard] == kGuardWord);
        FeedbackRing reader = *FeedbackRing::Create(1, changes[2]);
        REQUIRE(reader.Begin());
        REQUIRE(reader.Submit(0, 1));
        REQUIRE(reader.Poll(1));
        return *reader.Read(0, std::as_bytes(std::span(changes)));
    }
};

std::span<const std::uint32_t> GetResolveShader(bool isHlsl) {
    const auto words = isHlsl ? resolve_hlsl_shaders::FindShader("ResolveFeedback.hlsl", "")
                              : resolve_shaders::FindShader("ResolveFeedback.comp", "");
    REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
    return *words;
}

std::uint32_t GetLowest(std::uint32_t bits) {
    for (std::uint32_t bit = 0; bit < 32; ++bit) {
        if ((bits >> bit & 1u) != 0)
            return bit;
    }
    return 255;
}

} // namespace

TEST_CASE("resolving feedback: changes of a part of the map, the rest of it and guard words untouched (C4)") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::mt19937 random(31);
    for (const bool isHlsl : {false, true}) {
        constexpr std::uint32_t kMapWord = 24, kRegions = 2000;
        const FeedbackRing ring = *FeedbackRing::Create(1, 600);
        Resolver resolver{*context, GetResolveShader(isHlsl), {}, {}, {}};
        resolver.feedback.assign(kMapWord + kRegions + 40, kGuardWord);
        for (std::uint32_t i = 0; i < kRegions; ++i)
            resolver.feedback[kMapWord + i] = 0;
        resolver.last.assign(kRegions / 4, 0xFFFFFFFFu);
        std::vector<std::uint32_t> known(kRegions, 255); // the host's bytes, by changes alone
        std::size_t dropped = 0;
        for (int frame = 0; frame < 12; ++frame) {
            std::vector<std::uint32_t> words(kRegions);
            for (std::uint32_t i = 0; i < kRegions; ++i) {
                // Half of the regions change every frame; bits up to the highest.
                const bool isTouched = random() % 3 != 0;
                words[i] = !isTouched          ? 0
                           : random() % 2 == 0 ? 8u << (i % 8)
                                               : static_cast<std::uint32_t>(random());
                resolver.feedback[kMapWord + i] = words[i];
            }
            NtcResolveFeedbackConstants push = {kMapWord, 0, kRegions, 0};
            if (frame % 3 == 1)
                push = {kMapWord, 4 * (random() % 100 == 0 ? 0u : 25u), 777, 0};
            const auto changes = resolver.Run(ring, push);
            std::set<std::uint32_t> reported;
            for (std::size_t i = 0; i < changes.GetCount(); ++i) {
                const NtcFeedbackChange change = changes[i];
                REQUIRE(change.region >= push.firstRegion);
                REQUIRE(change.region < push.firstRegion + push.regionCount);
                CHECK(reported.insert(change.region).second); // each once
                CHECK(change.mip == GetLowest(words[change.region]));
                CHECK(change.mip != known[change.region]);
                known[change.region] = change.mip;
            }
            std::size_t missing = 0;
            for (std::uint32_t i = 0; i < kRegions; ++i) {
                const bool isInside = i >= push.firstRegion && i < push.firstRegion + push.regionCount;
                CHECK(resolver.feedback[kMapWord + i] == (isInside ? 0 : words[i]));
                missing += isInside && known[i] != GetLowest(words[i]) ? 1u : 0u;
                CHECK((resolver.last[i / 4] >> (8 * (i % 4)) & 255u) == known[i]); // both sides know the same
            }
            CHECK(missing == changes.dropped); // counted exactly
            CHECK((changes.dropped == 0 || changes.GetCount() == 600));
            dropped += changes.dropped;
            for (std::uint32_t i = 0; i < kMapWord; ++i)
                CHECK(resolver.feedback[i] == kGuardWord);
            for (std::size_t i = kMapWord + kRegions; i < resolver.feedback.size(); ++i)
                CHECK(resolver.feedback[i] == kGuardWord);
        }
        CHECK(dropped > 0);
        // After a loss all last bytes are 0xFE: everything comes again, in as many rounds as the list needs.
        std::fill(resolver.last.begin(), resolver.last.end(), 0xFEFEFEFEu);
        std::set<std::uint32_t> again;
        for (int round = 0; round < 4; ++round) {
            const auto changes = resolver.Run(ring, {kMapWord, 0, kRegions, 0});
            for (std::size_t i = 0; i < changes.GetCount(); ++i)
                again.insert(changes[i].region);
        }
        CHECK(again.size() == kRegions);
        CHECK(resolver.Run(ring, {kMapWord, 0, kRegions, 0}).GetCount() == 0);
    }
}

TEST_CASE("feedback C8: a still camera at rate 1/16 asks for what it asks for at rate 1, after 5 / (p n) "
          "frames and more") {
    OPENNTC_REQUIRE_DEVICE(context);
    StreamingScene scene;
    const SceneTexture& texture = scene.AddImage(512, 512, 32, 32, TileFormat::RGBA8, TileFilter::Trilinear,
                                                 TileWrap::Repeat, TileWrap::Repeat);
    std::vector<StreamingItem> pixels; // 64 x 64, some of them minified: at least 4 quads a region
    for (int y = 0; y < 64; ++y) {
        for (int x = 0; x < 64; ++x) {
            StreamingItem item{};
            item.kind = CASE_RECORD;
            item.textureId = texture.id;
            item.u = (static_cast<float>(x) + 0.5f) / 64;
            item.v = (static_cast<float>(y) + 0.5f) / 64;
            item.dudx = item.dvdy = (y < 32 ? 1.0f : 2.5f) / 512;
            item.seed = shader::NtcGetQuadSeed(shader::int2(x, y));
            pixels.push_back(item);
        }
    }
    const auto spirv = streaming_shaders::FindShader("Streaming.comp",
                                                     "NETWORK_VERSION=1 NTC_MATH=1 NTC_FEEDBACK_SUBGROUP=0");
    REQUIRE(spirv);
    scene.feedback = RunOnDevice(*context, scene, pixels, scene.GetTable().MakeConstants(1), *spirv).feedback;
    const std::vector<std::uint32_t> full = scene.feedback;
    CHECK(ReadFeedback(scene, full).size() == 256);
    std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
    // 4 quads a region at least; a footprint over an edge may be that of one quad: 5 / (1/16) = 80 frames leave
    // each of the words unseen with probability e^-5, 320 frames all of 512 bits with 512 e^-20.
    for (std::uint32_t frame = 1; frame <= 320; ++frame) {
        scene.Run(pixels, scene.GetTable().MakeConstants(frame, 1, 1.0 / 16));
        if (frame == 1)
            CHECK(scene.feedback != full);
    }
    CHECK(scene.feedback == full);
}

TEST_CASE("requests of the device: one entry for 64 threads on a tile; a full queue counts what it drops") {
    OPENNTC_REQUIRE_DEVICE(context);
    const auto spirv = streaming_shaders::FindShader("Streaming.comp",
                                                     "NETWORK_VERSION=1 NTC_MATH=1 NTC_FEEDBACK_SUBGROUP=0");
    REQUIRE(spirv);
    for (const std::uint32_t capacity : {16u, 0u, 4096u}) {
        StreamingScene scene(capacity);
        const SceneTexture& texture = scene.AddImage(1024, 1024, 32, 32, TileFormat::RGBA8, TileFilter::Point,
                                                     TileWrap::Clamp, TileWrap::Clamp);
        scene.MapTail(texture);
        std::vector<StreamingItem> items;
        for (int i = 0; i < 64 * 1000; ++i) { // 64 threads for each of 1000 tiles
            StreamingItem item{};
            item.kind = CASE_DEMAND;
            item.textureId = texture.id;
            const int tile = i / 64;
            item.u = (static_cast<float>(tile % 32) + 0.5f) / 32;
            item.v = (static_cast<float>(tile / 32) + 0.5f) / 32;
            items.push_back(item);
        }
        const DeviceRun run = RunOnDevice(*context, scene, items, scene.GetTable().MakeConstants(1), *spirv);
        CHECK(GetQueue(scene, run.state).size() == std::min(capacity, 1000u));
        CHECK(run.state[0] == 1000); // attempts
        CHECK(run.state[1] == 1000 - std::min(capacity, 1000u));
        for (std::size_t i = scene.GetTable().GetLaunchState().words; i < run.state.size(); ++i)
            REQUIRE(run.state[i] == StreamingScene::kGuard);
        for (std::size_t i = 0; i < items.size(); ++i) { // the tail's colour meanwhile
            REQUIRE(run.results[i * CASE_WORDS + 4] == 0);
            REQUIRE(run.results[i * CASE_WORDS + 5] == 5);
        }
        // The same launch again before the host has cleared the bits: nothing new.
        scene.state = run.state;
        const DeviceRun second =
            RunOnDevice(*context, scene, items, scene.GetTable().MakeConstants(2), *spirv);
        CHECK(second.state[0] == 1000);
    }
}
