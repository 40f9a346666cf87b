// SPDX-License-Identifier: MIT
// One texture set and one build of shaders/openntc/passes/DecodeTexels on the device, and the comparison of its results.
#pragma once

#include "support/DeviceBits.h"

#include "openntc/decode/DecodeTypes.h"
#include "openntc/passes/PassConstants.h"
#include "vulkan_harness/Vulkan.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace openntc_tests {

inline openntc::Rect GetMipRect(const openntc::DecodeSource& source, int mip) {
    return {0, 0, std::max(source.constants->imageWidth >> mip, 1),
            std::max(source.constants->imageHeight >> mip, 1)};
}

/// One set and one build of the pass on the device.
class PassRunner {
public:
    PassRunner(openntc::harness::Context& context, const openntc::DecodeSource& source,
               std::span<const std::uint32_t> spirv)
        : context_(context) {
        static constexpr openntc::harness::BufferSlot kSlots[] = {{0, openntc::harness::BufferKind::Uniform},
                                                                  {1, openntc::harness::BufferKind::Storage},
                                                                  {2, openntc::harness::BufferKind::Storage},
                                                                  {3, openntc::harness::BufferKind::Storage}};
        auto pipeline =
            context.CreateComputePipeline(spirv, kSlots, sizeof(openntc::NtcDecodeTexelsConstants));
        REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
        pipeline_ = std::move(*pipeline);
        const std::span<const std::byte> contents[] = {std::as_bytes(std::span(source.constants, 1)),
                                                       source.latents, source.weights};
        for (std::size_t i = 0; i < 3; ++i) {
            auto buffer = context.CreateBuffer(contents[i], kSlots[i].kind,
                                               openntc::harness::BufferMemory::DeviceLocal);
            REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
            buffers_[i] = std::move(*buffer);
        }
    }

    /// The whole rectangle in one dispatch.
    std::vector<float> Decode(int mip, openntc::Rect rect) {
        const std::uint32_t texels = static_cast<std::uint32_t>(rect.width * rect.height);
        std::vector<float> outputs(std::size_t{texels} * 16);
        auto results = context_.CreateBuffer(outputs.size() * 4, openntc::harness::BufferKind::Storage,
                                             openntc::harness::BufferMemory::HostVisible);
        REQUIRE_MESSAGE(results.has_value(), std::string(results.error().GetText()));
        const openntc::NtcDecodeTexelsConstants push = {rect.left, rect.top, rect.width, rect.height, mip, 0};
        const openntc::harness::BoundBuffer bound[] = {
            {0, &buffers_[0]}, {1, &buffers_[1]}, {2, &buffers_[2]}, {3, &*results}};
        openntc::harness::DispatchRequest request;
        request.pipeline = &pipeline_;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        request.groups[0] = (texels + NTC_DECODE_TEXELS_GROUP - 1) / NTC_DECODE_TEXELS_GROUP;
        const auto timing = context_.Dispatch(request);
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        // The first dispatch of a pipeline is left out: lavapipe generates its machine code there, for tenths of a
        // second. Divided by the few texels of a small mip, that once looked like a slow shader.
        if (isWarm_) {
            seconds_ += timing->wallSeconds;
            timedTexels_ += texels;
        }
        isWarm_ = true;
        REQUIRE(context_.Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
        return outputs;
    }

    double GetSecondsOfDispatches() const { return seconds_; }
    std::size_t GetTimedTexels() const { return timedTexels_; }
    double GetCreationSeconds() const { return pipeline_.GetCreationSeconds(); }

private:
    openntc::harness::Context& context_;
    openntc::harness::ComputePipeline pipeline_;
    openntc::harness::Buffer buffers_[3];
    bool isWarm_ = false;
    double seconds_ = 0;
    std::size_t timedTexels_ = 0;
};

inline std::size_t CountDifferent(const std::vector<float>& a, const std::vector<float>& b) {
    REQUIRE(a.size() == b.size());
    std::size_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
        different += GetDeviceBits(a[i]) != GetDeviceBits(b[i]) ? 1u : 0u;
    return different;
}

} // namespace openntc_tests
