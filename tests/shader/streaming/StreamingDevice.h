// SPDX-License-Identifier: MIT
// A scene's buffers on the device, and items run there.
#pragma once

#include "shader/TestDevice.h"
#include "support/streaming/StreamingItems.h"

#include "vulkan_harness/Vulkan.h"

#include <doctest/doctest.h>

namespace openntc_tests {

/// What a launch left behind.
struct DeviceRun {
    std::vector<std::uint32_t> results, state, feedback;
};

/// A scene's buffers on the device, and what streaming shaders bind: `input` at binding 3 of set 0, results at 4.
class SceneOnDevice {
public:
    SceneOnDevice(openntc::harness::Context& context, StreamingScene& scene,
                  const openntc::NtcStreamingConstants& launch, std::span<const std::byte> input,
                  std::size_t resultWords)
        : context_(context), resultWords_(resultWords) {
        using openntc::harness::BufferKind;
        const auto words = [](const std::vector<std::uint32_t>& v) { return std::as_bytes(std::span(v)); };
        Add(0, 0, std::as_bytes(std::span(&launch, 1)), BufferKind::Uniform);
        Add(1, 0, words(scene.slots));
        Add(2, 0, scene.GetWeights());
        Add(3, 0, input);
        Add(4, 0, words(std::vector<std::uint32_t>(resultWords)));
        Add(5, 0, words(scene.residency));
        Add(0, 1, scene.GetTable().GetBytes());
        Add(1, 1, words(scene.state));
        Add(2, 1, words(scene.feedback));
        Add(3, 1, words(scene.slots));
        Add(4, 1, std::as_bytes(std::span(&scene.constants, 1)));
    }

    std::span<const openntc::harness::BufferSlot> GetSlots() const { return slots_; }
    std::vector<openntc::harness::BoundBuffer> GetBound() const {
        std::vector<openntc::harness::BoundBuffer> bound;
        for (std::size_t i = 0; i < slots_.size(); ++i)
            bound.push_back({slots_[i].binding, &buffers_[i], slots_[i].set});
        return bound;
    }

    DeviceRun Read(const StreamingScene& scene) const {
        DeviceRun run;
        run.results.resize(resultWords_);
        run.state.resize(scene.state.size());
        run.feedback.resize(scene.feedback.size());
        REQUIRE(context_.Read(buffers_[4], 0, std::as_writable_bytes(std::span(run.results))));
        REQUIRE(context_.Read(buffers_[7], 0, std::as_writable_bytes(std::span(run.state))));
        REQUIRE(context_.Read(buffers_[8], 0, std::as_writable_bytes(std::span(run.feedback))));
        return run;
    }

private:
    void Add(std::uint32_t binding, std::uint32_t set, std::span<const std::byte> bytes,
             openntc::harness::BufferKind kind = openntc::harness::BufferKind::Storage) {
        auto buffer = context_.CreateBuffer(bytes, kind, openntc::harness::BufferMemory::HostVisible);
        REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
        buffers_.push_back(std::move(*buffer));
        slots_.push_back({binding, kind, set});
    }

    openntc::harness::Context& context_;
    std::size_t resultWords_;
    std::vector<openntc::harness::Buffer> buffers_;
    std::vector<openntc::harness::BufferSlot> slots_;
};

/// How items are run: by a compute shader, or by a ray-generation shader.
enum class DeviceStage { Compute, Rays };

/// Runs the items on the device, with the scene's launch state and feedback, which stay as they are.
inline DeviceRun RunOnDevice(openntc::harness::Context& context, StreamingScene& scene,
                             std::span<const openntc::StreamingItem> items,
                             const openntc::NtcStreamingConstants& launch,
                             std::span<const std::uint32_t> spirv, DeviceStage stage = DeviceStage::Compute) {
    using namespace openntc::harness;
    const std::uint32_t count = static_cast<std::uint32_t>(items.size());
    const SceneOnDevice buffers(context, scene, launch, std::as_bytes(items),
                                std::size_t{count} * CASE_WORDS);
    const std::vector<BoundBuffer> bound = buffers.GetBound();
    const auto pipeline = stage == DeviceStage::Rays
                              ? context.CreateRayPipeline(spirv, buffers.GetSlots(), 4)
                              : context.CreateComputePipeline(spirv, buffers.GetSlots(), 4);
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const auto push = std::as_bytes(std::span(&count, 1));
    if (stage == DeviceStage::Rays) {
        const std::uint32_t width = 64;
        const auto traced = context.TraceRays({&*pipeline, bound, push, width, (count + width - 1) / width});
        REQUIRE_MESSAGE(traced.has_value(), std::string(traced.error().GetText()));
    } else {
        DispatchRequest request;
        request.pipeline = &*pipeline;
        request.buffers = bound;
        request.pushConstants = push;
        request.groups[0] = (count + 63) / 64;
        const auto timing = context.Dispatch(request);
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    }
    return buffers.Read(scene);
}

/// The queue of a launch state as a set; each entry once.
inline TileSet GetQueue(const StreamingScene& scene, const std::vector<std::uint32_t>& state) {
    const auto list = ReadRequests(scene.GetTable().GetLaunchState(), std::as_bytes(std::span(state)));
    REQUIRE(list);
    TileSet tiles;
    for (std::size_t i = 0; i < list->GetCount(); ++i)
        tiles.insert({(*list)[i].textureId, (*list)[i].tile});
    CHECK(tiles.size() == list->GetCount());
    return tiles;
}

inline std::uint32_t GetComparable(std::uint32_t bits) {
    return (bits & 0x7FFFFFFFu) > 0x7F800000u ? 0x7FC00000u : bits; // NaN has no fixed payload
}

/// Compares all that a launch left behind with what the C++ build makes of the items, from a clean state.
inline void CheckRun(StreamingScene& scene, std::span<const openntc::StreamingItem> items,
                     const openntc::NtcStreamingConstants& launch, const DeviceRun& run) {
    scene.ClearState();
    std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
    const std::vector<std::uint32_t> expected = scene.Run(items, launch);
    std::size_t different = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const openntc::StreamingItem& item = items[i / CASE_WORDS];
        // sRGB goes through pow, which no device rounds alike: as far apart as Vulkan's precision of pow
        // allows (2^-13 for exponent 2.4 and bases down to 1/255).
        const bool isSrgb = item.kind == CASE_DEMAND && item.textureId < scene.textures.size() &&
                            scene.textures[item.textureId].desc.format == openntc::TileFormat::RGBA8Srgb &&
                            i % CASE_WORDS < 3;
        const bool isSame = isSrgb ? std::fabs(std::bit_cast<float>(expected[i]) -
                                               std::bit_cast<float>(run.results[i])) < 0x1p-13f
                                   : GetComparable(expected[i]) == GetComparable(run.results[i]);
        if (!isSame && ++different <= 5) {
            MESSAGE("item " << i / CASE_WORDS << " (kind " << item.kind << ", texture " << item.textureId
                            << ", " << item.u << ", " << item.v << ") word " << i % CASE_WORDS << ": device "
                            << std::hex << run.results[i] << ", C++ " << expected[i]);
        }
    }
    CHECK(different == 0);
    CHECK(run.feedback == scene.feedback);
    // The queue's order is the device's; all else of the state is equal, guard words too.
    CHECK(GetQueue(scene, run.state) == GetQueue(scene, scene.state));
    const std::size_t bits = launch.bitsWord;
    CHECK(std::equal(run.state.begin() + static_cast<std::ptrdiff_t>(bits), run.state.end(),
                     scene.state.begin() + static_cast<std::ptrdiff_t>(bits)));
    CHECK(run.state[0] == scene.state[0]);
    CHECK(run.state[1] == scene.state[1]);
    CHECK(run.state[2] == scene.state[2]);
}

} // namespace openntc_tests
