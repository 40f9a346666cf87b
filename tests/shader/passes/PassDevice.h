// SPDX-License-Identifier: MIT
// A decompression pass on the device, with the buffers of one texture set and images of one format.
#pragma once

#include "openntc/passes/DecompressionPass.h"
#include "vulkan_harness/Vulkan.h"

#include <doctest/doctest.h>

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace passes_test {

template <typename T>
T Take(openntc::Expected<T> value) {
    REQUIRE_MESSAGE(value.has_value(), std::string(value.error().GetText()));
    return std::move(*value);
}

class PassDevice {
public:
    PassDevice(openntc::harness::Context& context, std::span<const std::byte> latents,
               std::span<const std::byte> weights)
        : context_(context) {
        using namespace openntc::harness;
        latents_ = Take(context.CreateBuffer(latents, BufferKind::Storage, BufferMemory::DeviceLocal));
        weights_ = Take(context.CreateBuffer(weights, BufferKind::Storage, BufferMemory::DeviceLocal));
    }

    std::vector<openntc::harness::Image> MakeImages(std::size_t count, openntc::harness::ImageFormat format,
                                                    int width, int height) {
        std::vector<openntc::harness::Image> images;
        for (std::size_t i = 0; i < count; ++i)
            images.push_back(Take(context_.CreateImage(format, static_cast<std::uint32_t>(width),
                                                       static_cast<std::uint32_t>(height))));
        return images;
    }

    /// Elements of the array that `images` does not have are its first one.
    void Run(const openntc::DecompressionPass& pass, std::span<const std::uint32_t> spirv,
             std::span<const openntc::harness::Image> images) {
        using namespace openntc::harness;
        static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                                {1, BufferKind::Storage},
                                                {2, BufferKind::Storage},
                                                {0, BufferKind::Image, 1, NTC_DECOMPRESS_OUTPUTS}};
        const ComputePipeline pipeline = Take(context_.CreateComputePipeline(spirv, kSlots, 0));
        const Buffer constants = Take(context_.CreateBuffer(std::as_bytes(std::span(&pass.constants, 1)),
                                                            BufferKind::Uniform, BufferMemory::DeviceLocal));
        const BoundBuffer buffers[] = {{0, &constants}, {1, &latents_}, {2, &weights_}};
        std::vector<BoundImage> bound;
        for (std::uint32_t i = 0; i < NTC_DECOMPRESS_OUTPUTS; ++i)
            bound.push_back({0, &images[i < images.size() ? i : 0], 1, i});
        DispatchRequest request;
        request.pipeline = &pipeline;
        request.buffers = buffers;
        request.images = bound;
        std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(request.groups));
        Take(context_.Dispatch(request));
    }

    std::vector<std::byte> Read(const openntc::harness::Image& image) {
        std::vector<std::byte> bytes(image.GetBytes());
        REQUIRE(context_.Read(image, bytes));
        return bytes;
    }

    /// Of an image of format RGBA32F.
    std::vector<std::array<float, 4>> ReadTexels(const openntc::harness::Image& image) {
        const std::vector<std::byte> bytes = Read(image);
        std::vector<std::array<float, 4>> texels(bytes.size() / 16);
        std::memcpy(texels.data(), bytes.data(), bytes.size());
        return texels;
    }

private:
    openntc::harness::Context& context_;
    openntc::harness::Buffer latents_;
    openntc::harness::Buffer weights_;
};

} // namespace passes_test
