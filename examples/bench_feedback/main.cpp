// SPDX-License-Identifier: MIT
// `bench_feedback [--device NAME] [--size PIXELS] [--frames N] [--json]`: nanoseconds per sample without
// feedback and with it at rates 1, 1/16, 1/64 and 1/256, one by one and with one atomic per subgroup and
// region; the same with each of the other effects of shaders that read tiles left out; and the time and bytes
// of resolving 10 000 textures of 64 regions, 1 % of which change.
//
// A screen of trilinear samples of 64 resident RGBA8 images of 2048² in tiles of 256². Every frame starts
// with feedback words of 0, as it does behind the resolve pass; times are between timestamps round the
// dispatch, on devices without them the host's, on devices that are processors the process's time on them.
// Frames of all kinds follow each other in turns, so that what disturbs one disturbs all; a first frame of
// each is not counted.
#include "bench_feedback_shaders.h"
#include "bench_resolve_shaders.h"

#include "openntc/streaming/FeedbackRing.h"
#include "openntc/streaming/HostPageTable.h"
#include "vulkan_harness/FrameBench.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::harness;

constexpr FrameBench kBench = {"bench_feedback", 64};

template <typename T>
T Require(Expected<T> result) {
    return RequireOrExit(kBench, std::move(result));
}

struct Seconds {
    double best = 0, median = 0;
};

Seconds Summarise(std::vector<double> seconds) {
    std::sort(seconds.begin(), seconds.end());
    return {seconds.front(), seconds[seconds.size() / 2]};
}

double GetSeconds(const DispatchTiming& timing) {
    return timing.gpuSeconds.value_or(timing.wallSeconds);
}

struct Push {
    NtcStreamingConstants launch;
    std::uint32_t size, cell;
    float texel;
};

constexpr std::uint32_t kCells = 8; // 8 x 8 textures

/// The scene's buffers; all tiles lie in one slot.
struct Scene {
    PageTable table;
    Buffer pageTable, state, feedback, slot, results;
};

Scene MakeScene(Context& context, const FrameOptions& options) {
    constexpr TiledLevel kLevels[] = {{0, 0}, {1, 1}, {2, 2}};
    TiledTextureDesc desc;
    desc.width = desc.height = 2048;
    desc.mips = 12;
    desc.tileWidth = desc.tileHeight = 256;
    desc.levels = kLevels; // 8 x 8, 4 x 4, 2 x 2 tiles
    desc.tailTiles = 2;    // 256² and what is coarser
    desc.slotBytes = 256 * 256 * 4;
    const std::uint32_t textures = kCells * kCells;
    PageTable table = Require(PageTable::Create({textures, textures * 86, 1, 0, 0, textures * 64, 64}));
    for (std::uint32_t i = 0; i < textures; ++i) {
        const std::uint32_t id = Require(table.Add(desc));
        const std::uint32_t tiles = Require(table.GetHeader(id)).tileCount;
        for (std::uint32_t tile = 0; tile < tiles; ++tile)
            Require(table.Map(id, tile, 0));
    }
    std::vector<std::byte> state(table.GetLaunchState().GetBytes());
    Require(ClearLaunchState(table.GetLaunchState(), state));
    const auto make = [&](std::span<const std::byte> bytes) {
        return Require(context.CreateBuffer(bytes, BufferKind::Storage, BufferMemory::DeviceLocal));
    };
    Buffer pageTable = make(table.GetBytes());
    Buffer launchState = make(state);
    const std::vector<std::byte> zeros(std::size_t{textures} * 64 * 4);
    Buffer feedback = make(zeros);
    const std::vector<std::byte> texels(desc.slotBytes, std::byte{0x55});
    Buffer slot = make(texels);
    Buffer results = Require(context.CreateBuffer(std::uint64_t{options.size} * options.size * 4,
                                                  BufferKind::Storage, BufferMemory::DeviceLocal));
    return {std::move(table),    std::move(pageTable), std::move(launchState),
            std::move(feedback), std::move(slot),      std::move(results)};
}

/// One kind of frame.
struct Kind {
    const char* feedback; ///< "none", "plain", "subgroup"; of a kind without an effect its name
    std::string defines;
    double rate = 0;
    std::vector<double> seconds;
    std::size_t words = 0; ///< of feedback, touched by the last frame
};

std::vector<Kind> ListKinds() {
    const std::string plain = "BENCH_FEEDBACK=1 NTC_FEEDBACK_SUBGROUP=0";
    std::vector<Kind> kinds = {{"none", "BENCH_FEEDBACK=0 NTC_FEEDBACK_SUBGROUP=0", 0, {}, 0}};
    for (const double rate : {1.0, 1.0 / 16, 1.0 / 64, 1.0 / 256})
        kinds.push_back({"plain", plain, rate, {}, 0});
    for (const double rate : {1.0, 1.0 / 16, 1.0 / 64, 1.0 / 256})
        kinds.push_back({"subgroup", "BENCH_FEEDBACK=1 NTC_FEEDBACK_SUBGROUP=1", rate, {}, 0});
    // All tiles are there, so that nothing is requested and no coarser mip looked for: what the code costs
    // that could.
    for (const auto& [name, defines] :
         {std::pair{"no fallback", " NTC_TILE_FALLBACK=0"},
          {"no requests", " NTC_TILE_REQUESTS=0"},
          {"no stamps", " NTC_TILE_STAMPS=0"},
          {"no feedback", " NTC_TILE_FEEDBACK=0"},
          {"no rates", " NTC_TILE_RATES=0"},
          {"no effect", " NTC_TILE_FALLBACK=0 NTC_TILE_REQUESTS=0 NTC_TILE_STAMPS=0 NTC_TILE_FEEDBACK=0 "
                        "NTC_TILE_RATES=0"}})
        kinds.push_back({name, plain + defines, 1, {}, 0});
    return kinds;
}

/// Frames of all kinds in turns.
void MeasureFrames(Context& context, Scene& scene, const FrameOptions& options, std::vector<Kind>& kinds) {
    const BufferSlot slots[] = {{0, BufferKind::Storage, 0},
                                {0, BufferKind::Storage, 1},
                                {1, BufferKind::Storage, 1},
                                {2, BufferKind::Storage, 1},
                                {3, BufferKind::Storage, 1}};
    std::vector<ComputePipeline> pipelines;
    for (const Kind& kind : kinds) {
        const auto spirv = Require(bench_feedback_shaders::FindShader("BenchFeedback.comp", kind.defines));
        pipelines.push_back(Require(context.CreateComputePipeline(spirv, slots, sizeof(Push))));
    }
    const BoundBuffer bound[] = {{0, &scene.results, 0},
                                 {0, &scene.pageTable, 1},
                                 {1, &scene.state, 1},
                                 {2, &scene.feedback, 1},
                                 {3, &scene.slot, 1}};
    std::vector<std::uint32_t> touched(scene.feedback.GetSize() / 4);
    for (std::uint32_t frame = 0; frame <= options.frames; ++frame) {
        for (std::size_t i = 0; i < kinds.size(); ++i) {
            Kind& kind = kinds[i];
            std::fill(touched.begin(), touched.end(), 0u);
            Require(context.Write(scene.feedback, 0, std::as_bytes(std::span(touched))));
            const Push push = {scene.table.MakeConstants(frame + 1, 1, kind.rate), options.size,
                               options.size / kCells, 1.0f / 2048};
            DispatchRequest request;
            request.pipeline = &pipelines[i];
            request.buffers = bound;
            request.pushConstants = std::as_bytes(std::span(&push, 1));
            request.groups[0] = request.groups[1] = options.size / 8;
            const std::clock_t start = std::clock();
            const DispatchTiming timing = Require(context.Dispatch(request));
            const double processor = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
            if (frame > 0)
                kind.seconds.push_back(context.GetDevice().isCpu ? processor : GetSeconds(timing));
            Require(context.Read(scene.feedback, 0, std::as_writable_bytes(std::span(touched))));
            kind.words = static_cast<std::size_t>(
                std::count_if(touched.begin(), touched.end(), [](std::uint32_t word) { return word != 0; }));
        }
    }
}

/// 10 000 textures of 64 regions, of which 1 % change in every frame; `bytes` gets the size of a frame's
/// list.
Seconds MeasureResolve(Context& context, const FrameOptions& options, std::size_t& bytes) {
    constexpr std::uint32_t kRegions = 640000;
    const FeedbackRing ring = Require(FeedbackRing::Create(1, 65536));
    const auto spirv = Require(bench_resolve_shaders::FindShader("ResolveFeedback.comp", ""));
    const BufferSlot slots[] = {{0, BufferKind::Storage}, {1, BufferKind::Storage}, {2, BufferKind::Storage}};
    const ComputePipeline pipeline =
        Require(context.CreateComputePipeline(spirv, slots, sizeof(NtcResolveFeedbackConstants)));
    std::vector<std::uint32_t> words(kRegions), last(kRegions / 4, 0);
    for (std::uint32_t& word : words)
        word = 1;
    const auto make = [&](std::uint64_t size) {
        return Require(context.CreateBuffer(size, BufferKind::Storage, BufferMemory::DeviceLocal));
    };
    const Buffer feedback = make(kRegions * 4);
    const Buffer lastBytes = make(kRegions);
    const Buffer changes = make(ring.GetBytes());
    Require(context.Write(lastBytes, 0, std::as_bytes(std::span(last))));
    const BoundBuffer bound[] = {{0, &feedback}, {1, &lastBytes}, {2, &changes}};
    const NtcResolveFeedbackConstants push = {0, 0, kRegions, 0};
    std::vector<double> seconds;
    std::uint32_t random = 1;
    for (std::uint32_t frame = 0; frame <= options.frames; ++frame) {
        for (std::uint32_t i = 0; i < kRegions / 100; ++i) {
            random = random * 1664525u + 1013904223u;
            words[random % kRegions] ^= 3u; // mip 0 or 1
        }
        const NtcFeedbackChangesHead head = ring.MakeHead();
        Require(context.Write(feedback, 0, std::as_bytes(std::span(words))));
        Require(context.Write(changes, 0, std::as_bytes(std::span(&head, 1))));
        DispatchRequest request;
        request.pipeline = &pipeline;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        request.groups[0] =
            (kRegions + 4 * NTC_RESOLVE_FEEDBACK_GROUP - 1) / (4 * NTC_RESOLVE_FEEDBACK_GROUP);
        const DispatchTiming timing = Require(context.Dispatch(request));
        if (frame > 0)
            seconds.push_back(GetSeconds(timing));
        NtcFeedbackChangesHead after;
        Require(context.Read(changes, 0, std::as_writable_bytes(std::span(&after, 1))));
        bytes =
            sizeof(after) + std::size_t{std::min(after.count, after.capacity)} * sizeof(NtcFeedbackChange);
    }
    return Summarise(std::move(seconds));
}

} // namespace

int main(int argc, char** argv) {
    const FrameOptions options = ReadFrameOptions(kBench, argc, argv);
    ContextOptions contextOptions;
    contextOptions.device = options.device;
    const auto context = Require(Context::Create(contextOptions));
    Scene scene = MakeScene(*context, options);
    const double samples = static_cast<double>(options.size) * options.size;
    std::printf(
        options.json
            ? "{\"device\":\"%s\",\"samples\":%.0f,\"frames\":%u,\"rows\":[\n"
            : "%s, %.0f samples, %u frames\n\nfeedback     rate   ns/sample best  median  touched words\n",
        context->GetDevice().name.c_str(), samples, options.frames);
    std::vector<Kind> kinds = ListKinds();
    MeasureFrames(*context, scene, options, kinds);
    for (const Kind& kind : kinds) {
        const Seconds s = Summarise(kind.seconds);
        std::printf(options.json ? "{\"feedback\":\"%s\",\"rate\":%.6g,\"bestNanoseconds\":%.4f,"
                                   "\"medianNanoseconds\":%.4f,\"touchedWords\":%zu},\n"
                                 : "%-11s %8.5f %13.3f %9.3f %9zu\n",
                    kind.feedback, kind.rate, s.best / samples * 1e9, s.median / samples * 1e9, kind.words);
    }
    std::size_t bytes = 0;
    const Seconds resolve = MeasureResolve(*context, options, bytes);
    std::printf(options.json
                    ? "{\"feedback\":\"resolve\",\"regions\":640000,\"bestMilliseconds\":%.4f,"
                      "\"medianMilliseconds\":%.4f,\"listBytes\":%zu}]}\n"
                    : "\nresolve of 640000 regions: best %.3f ms, median %.3f ms, list of %zu bytes\n",
                resolve.best * 1e3, resolve.median * 1e3, bytes);
    return 0;
}
