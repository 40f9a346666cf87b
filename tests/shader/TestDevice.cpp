// SPDX-License-Identifier: MIT
#include "shader/TestDevice.h"

#include <doctest/doctest.h>

#include <cstdlib>

namespace openntc_tests {

using namespace openntc;
using namespace openntc::harness;

std::string GetTestDeviceName() {
    const char* name = std::getenv("OPENNTC_TEST_DEVICE");
    return name != nullptr ? name : kLavapipe;
}

namespace {

struct TestDevice {
    std::unique_ptr<Context> context;
    std::string reason;
};

TestDevice Open() {
    TestDevice result;
    ContextOptions options;
    options.device = GetTestDeviceName();
    options.validation = true;
    Expected<std::unique_ptr<Context>> context = Context::Create(options);
    if (!context && std::string(context.error().GetText()).find("VK_LAYER") != std::string::npos) {
        MESSAGE("SKIP: validation of Vulkan calls: " << context.error().GetText());
        options.validation = false;
        context = Context::Create(options);
    }
    if (context) {
        result.context = std::move(*context);
        const DeviceInfo& device = result.context->GetDevice();
        MESSAGE("device: " << device.name << ", driver: " << device.driver);
    } else {
        result.reason = context.error().GetText();
    }
    return result;
}

} // namespace

Context* GetTestContext() {
    static const TestDevice device = Open();
    if (device.context == nullptr)
        MESSAGE("SKIP: " << device.reason);
    return device.context.get();
}

std::vector<std::uint32_t> RunOverWords(std::span<const std::uint32_t> spirv,
                                        std::span<const std::span<const std::uint32_t>> inputs,
                                        std::uint32_t count, std::size_t resultWords) {
    Context* const context = GetTestContext();
    REQUIRE(context != nullptr);
    std::vector<Buffer> buffers;
    std::vector<BufferSlot> slots;
    for (std::size_t i = 0; i <= inputs.size(); ++i) {
        Expected<Buffer> buffer =
            i < inputs.size()
                ? context->CreateBuffer(std::as_bytes(inputs[i]), BufferKind::Storage,
                                        BufferMemory::HostVisible)
                : context->CreateBuffer(resultWords * 4, BufferKind::Storage, BufferMemory::HostVisible);
        REQUIRE_MESSAGE(buffer.has_value(), buffer.error().GetText());
        buffers.push_back(std::move(*buffer));
        slots.push_back({static_cast<std::uint32_t>(i), BufferKind::Storage});
    }
    std::vector<BoundBuffer> bound;
    for (std::size_t i = 0; i < buffers.size(); ++i)
        bound.push_back({static_cast<std::uint32_t>(i), &buffers[i]});
    const Expected<ComputePipeline> pipeline = context->CreateComputePipeline(spirv, slots, 4);
    REQUIRE_MESSAGE(pipeline.has_value(), pipeline.error().GetText());
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&count, 1));
    request.groups[0] = (count + 63) / 64;
    const Expected<DispatchTiming> timing = context->Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), timing.error().GetText());
    std::vector<std::uint32_t> result(resultWords);
    const Expected<void> read = context->Read(buffers.back(), 0, std::as_writable_bytes(std::span(result)));
    REQUIRE_MESSAGE(read.has_value(), read.error().GetText());
    return result;
}

} // namespace openntc_tests
