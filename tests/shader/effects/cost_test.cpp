// SPDX-License-Identifier: MIT
// What the effects cost: SPIR-V size, time to create a pipeline, time per texel. Prints the table of
// docs/benchmarks/effects-2026-11-22.md. A measurement, which asserts nothing of what it measures, and therefore runs only when
// OPENNTC_MEASURE is set.
#include "shader/TestDevice.h"
#include "shader/effects/EffectShader.h"

#include "effect_linear.h"
#include "effect_masks.h"

#include "openntc/Effects.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr int kRepetitions = 3;

/// Texels per side: enough to fill the device.
int GetSide(const Context& context) {
    return context.GetDevice().isCpu ? 96 : 2048;
}

struct Resources {
    Buffer constants, latents, weights, results;
};

Resources Upload(Context& context, int networkVersion, int side) {
    SynthesisDesc synthesis;
    synthesis.desc = {side, side, 16, 1};
    synthesis.networkVersion = networkVersion;
    synthesis.shape = {4, 4 * networkVersion, 16, 2, 4};
    synthesis.channelColorSpaces = 0x80040021;
    MemoryStream stream;
    REQUIRE(SynthesizeTextureSet(stream, synthesis));
    REQUIRE(stream.Seek(0));
    const auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE(metadata);
    const auto range = metadata->GetStreamRangeForLatents(0, 1);
    REQUIRE(range);
    const auto constants = MakeInferenceData(*metadata, *range, InferenceWeightType::GenericInt8);
    const auto weights = metadata->GetInferenceWeights(InferenceWeightType::GenericInt8);
    REQUIRE(constants);
    REQUIRE(weights);
    const auto latents = stream.GetBytes().subspan(static_cast<std::size_t>(range->offset),
                                                   static_cast<std::size_t>(range->size));
    const auto create = [&](std::span<const std::byte> bytes, BufferKind kind) {
        auto buffer = context.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal);
        REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
        return std::move(*buffer);
    };
    const std::uint64_t texels = static_cast<std::uint64_t>(side) * static_cast<std::uint64_t>(side);
    auto results = context.CreateBuffer(4 * (NTC_EFFECT_COUNT + 17 * texels), BufferKind::Storage,
                                        BufferMemory::DeviceLocal);
    REQUIRE(results);
    return {create(std::as_bytes(std::span(&*constants, 1)), BufferKind::Uniform),
            create(latents, BufferKind::Storage), create(*weights, BufferKind::Storage), std::move(*results)};
}

void Measure(Context& context, const Resources& resources, int side, std::span<const std::uint32_t> words,
             const std::string& name, bool linear) {
    constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                     {1, BufferKind::Storage},
                                     {2, BufferKind::Storage},
                                     {3, BufferKind::Storage}};
    const std::clock_t before = std::clock();
    auto pipeline = context.CreateComputePipeline(words, kSlots, sizeof(EffectPush));
    const double cpuSeconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const EffectPush push = {0, 0, side, side, 0, linear ? 1u : 0u, 0, 0};
    const BoundBuffer bound[] = {
        {0, &resources.constants}, {1, &resources.latents}, {2, &resources.weights}, {3, &resources.results}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&push, 1));
    request.groups[0] = static_cast<std::uint32_t>((side * side + 63) / 64);
    std::vector<double> seconds;
    for (int i = 0; i < kRepetitions; ++i) {
        const std::clock_t start = std::clock();
        const auto timing = context.Dispatch(request);
        const double processor = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        // A device on the CPU: processor time of all its threads, which the load of the machine disturbs less.
        seconds.push_back(context.GetDevice().isCpu ? processor
                                                    : timing->gpuSeconds.value_or(timing->wallSeconds));
    }
    std::sort(seconds.begin(), seconds.end());
    const double texels = static_cast<double>(side) * side;
    std::printf("%-52s %7zu bytes  pipeline %5.2f s (%5.2f s of processor)  %9.3f ns/texel, median %9.3f\n",
                name.c_str(), words.size_bytes(), pipeline->GetCreationSeconds(), cpuSeconds,
                seconds.front() / texels * 1e9, seconds[kRepetitions / 2] / texels * 1e9);
}

const char* GetMaskDefine(unsigned mask) {
    switch (mask) {
    case 0x1:
        return " NTC_OUTPUT_MASK=0x1";
    case 0x7:
        return " NTC_OUTPUT_MASK=0x7";
    case 0x1FF:
        return " NTC_OUTPUT_MASK=0x1FF";
    default:
        return "";
    }
}

} // namespace

TEST_CASE("cost of output masks and linear light") {
    if (std::getenv("OPENNTC_MEASURE") == nullptr) {
        MESSAGE("SKIP: cost of output masks and linear light: a measurement, no test; OPENNTC_MEASURE=1 "
                "makes it");
        return;
    }
    OPENNTC_REQUIRE_DEVICE(context);
    const int side = GetSide(*context);
    for (const int version : {NTC_NETWORK_SMALL, NTC_NETWORK_XLARGE}) {
        const Resources resources = Upload(*context, version, side);
        for (const unsigned mask : {0xFFFFu, 0x1FFu, 0x7u, 0x1u}) {
            const std::string name = "network " + std::to_string(version) + GetMaskDefine(mask);
            const std::string base = "NETWORK_VERSION=" + std::to_string(version) + " NTC_MATH=1";
            Measure(*context, resources, side,
                    FindEffectShader(effect_masks::FindShader, base + GetMaskDefine(mask) +
                                                                   " NTC_LINEARISE=0 NTC_SINGLE_MIP=1 "
                                                                   "NTC_LATENT_SLICES=0"),
                    name + " stored", false);
            if (version != NTC_NETWORK_SMALL)
                continue;
            const std::string spaces = " NTC_CHANNEL_COLOR_SPACES=0x80040021";
            Measure(*context, resources, side,
                    FindEffectShader(effect_linear::FindShader, base + GetMaskDefine(mask) + spaces),
                    name + " linear at run time", true);
            Measure(*context, resources, side,
                    FindEffectShader(effect_linear::FindShader,
                                     base + GetMaskDefine(mask) + " NTC_LINEARISE=2" + spaces),
                    name + " linear, compiled", true);
        }
    }
}
