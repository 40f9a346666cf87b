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

/// Runs the items on the device, with the scene's launch state and feedback, which stay as they are.
inline DeviceRun RunOnDevice(openntc::harness::Context& context, StreamingScene& scene,
                             std::span<const openntc::StreamingItem> items,
                             const openntc::NtcStreamingConstants& launch,
                             std::span<const std::uint32_t> spirv) {
    using namespace openntc::harness;
    const std::uint32_t count = static_cast<std::uint32_t>(items.size());
    const auto make = [&](std::span<const std::byte> bytes, BufferKind kind) {
        auto buffer = context.CreateBuffer(bytes, kind, BufferMemory::HostVisible);
        REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
        return std::move(*buffer);
    };
    const auto words = [](const std::vector<std::uint32_t>& v) { return std::as_bytes(std::span(v)); };
    const Buffer constants = make(std::as_bytes(std::span(&launch, 1)), BufferKind::Uniform);
    const Buffer slots = make(words(scene.slots), BufferKind::Storage);
    const Buffer weights = make(scene.GetWeights(), BufferKind::Storage);
    const Buffer input = make(std::as_bytes(items), BufferKind::Storage);
    const Buffer residency = make(words(scene.residency), BufferKind::Storage);
    const Buffer table = make(scene.GetTable().GetBytes(), BufferKind::Storage);
    const Buffer state = make(words(scene.state), BufferKind::Storage);
    const Buffer feedback = make(words(scene.feedback), BufferKind::Storage);
    const Buffer sets = make(std::as_bytes(std::span(&scene.constants, 1)), BufferKind::Storage);
    const auto output = context.CreateBuffer(std::size_t{count} * CASE_WORDS * 4, BufferKind::Storage,
                                             BufferMemory::HostVisible);
    REQUIRE(output);
    const BufferSlot bindings[] = {
        {0, BufferKind::Uniform, 0}, {1, BufferKind::Storage, 0}, {2, BufferKind::Storage, 0},
        {3, BufferKind::Storage, 0}, {4, BufferKind::Storage, 0}, {5, BufferKind::Storage, 0},
        {0, BufferKind::Storage, 1}, {1, BufferKind::Storage, 1}, {2, BufferKind::Storage, 1},
        {3, BufferKind::Storage, 1}, {4, BufferKind::Storage, 1}};
    const auto pipeline = context.CreateComputePipeline(spirv, bindings, 4);
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const BoundBuffer bound[] = {{0, &constants, 0}, {1, &slots, 0},     {2, &weights, 0}, {3, &input, 0},
                                 {4, &*output, 0},   {5, &residency, 0}, {0, &table, 1},   {1, &state, 1},
                                 {2, &feedback, 1},  {3, &slots, 1},     {4, &sets, 1}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&count, 1));
    request.groups[0] = (count + 63) / 64;
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    DeviceRun run;
    run.results.resize(std::size_t{count} * CASE_WORDS);
    run.state.resize(scene.state.size());
    run.feedback.resize(scene.feedback.size());
    REQUIRE(context.Read(*output, 0, std::as_writable_bytes(std::span(run.results))));
    REQUIRE(context.Read(state, 0, std::as_writable_bytes(std::span(run.state))));
    REQUIRE(context.Read(feedback, 0, std::as_writable_bytes(std::span(run.feedback))));
    return run;
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

} // namespace openntc_tests
