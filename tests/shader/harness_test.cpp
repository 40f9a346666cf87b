// SPDX-License-Identifier: MIT
// The harness itself: what is missing is an error with a reason, what is there computes, mistakes are
// reported.
#include "shader/TestDevice.h"

#include "harness_shaders.h"

#include <doctest/doctest.h>

#include <numeric>
#include <span>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr BufferSlot kFillSlots[] = {
    {0, BufferKind::Storage}, {1, BufferKind::Storage}, {2, BufferKind::Uniform}};

} // namespace

TEST_CASE("a missing loader is an error that says so") {
    ContextOptions options;
    options.loaderLibrary = "libno-such-vulkan-loader.so.7";
    const auto context = Context::Create(options);
    REQUIRE_FALSE(context);
    CHECK(context.error().GetStatus() == Status::Unsupported);
    CHECK(std::string(context.error().GetText()).find("device or feature absent: Vulkan loader libno-such") ==
          0);
    CHECK_FALSE(ListDevices(options.loaderLibrary));
}

TEST_CASE("a missing device is an error that says so") {
    if (!ListDevices()) {
        MESSAGE("SKIP: no Vulkan loader");
        return;
    }
    for (const char* name : {"a device that nobody makes", "4000000000"}) {
        ContextOptions options;
        options.device = name;
        const auto context = Context::Create(options);
        REQUIRE_FALSE(context);
        CHECK(context.error().GetStatus() == Status::Unsupported);
        CHECK(std::string(context.error().GetText()).find(name) != std::string::npos);
    }
}

TEST_CASE("a device can be chosen by index and by name") {
    OPENNTC_REQUIRE_DEVICE(shared);
    const auto devices = ListDevices();
    REQUIRE(devices);
    REQUIRE_FALSE(devices->empty());
    for (const DeviceInfo& device : *devices) {
        ContextOptions options;
        options.device = std::to_string(device.index);
        const auto context = Context::Create(options);
        REQUIRE_MESSAGE(context.has_value(), std::string(context.error().GetText()));
        CHECK((*context)->GetDevice().name == device.name);
    }
    CHECK(shared->GetDevice().maxStorageBufferBytes >= (1u << 27)); // the least that Vulkan allows
}

TEST_CASE("permutations are found by their defines, and missing ones named") {
    CHECK(harness_shaders::GetShaders().size() == 2);
    const auto three = harness_shaders::FindShader("Fill.comp", "FACTOR=3 OFFSET=1");
    const auto five = harness_shaders::FindShader("Fill.comp", " OFFSET=1  FACTOR=5");
    REQUIRE(three);
    REQUIRE(five);
    CHECK(three->data() != five->data());
    CHECK((*three)[0] == 0x07230203); // the magic number of SPIR-V
    for (const char* defines : {"FACTOR=3", "FACTOR=4 OFFSET=1", "FACTOR=3 OFFSET=1 MORE=1", ""}) {
        const auto missing = harness_shaders::FindShader("Fill.comp", defines);
        REQUIRE_FALSE(missing);
        CHECK(missing.error().GetStatus() == Status::ShaderUnavailable);
        CHECK(std::string(missing.error().GetText()).find(std::string("Fill.comp ") + defines) !=
              std::string::npos);
    }
    CHECK_FALSE(harness_shaders::FindShader("Other.comp", "FACTOR=3 OFFSET=1"));
}

TEST_CASE("buffers, push constants, dispatch, read-back and timing") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr std::uint32_t kCount = 1000;
    std::vector<std::uint32_t> input(kCount);
    std::iota(input.begin(), input.end(), 7u);
    const std::uint32_t uniform[4] = {1, 20, 3, 4};
    const std::uint32_t push[2] = {kCount - 1, 100};
    for (const BufferMemory memory : {BufferMemory::HostVisible, BufferMemory::DeviceLocal}) {
        const auto source =
            context->CreateBuffer(std::as_bytes(std::span(input)), BufferKind::Storage, memory);
        const auto result = context->CreateBuffer(kCount * 4, BufferKind::Storage, memory);
        const auto constants =
            context->CreateBuffer(std::as_bytes(std::span(uniform)), BufferKind::Uniform, memory);
        REQUIRE(source);
        REQUIRE(result);
        REQUIRE(constants);
        const auto pipeline = context->CreateComputePipeline(
            *harness_shaders::FindShader("Fill.comp", "FACTOR=3 OFFSET=1"), kFillSlots, sizeof push);
        REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
        CHECK(pipeline->GetCreationSeconds() > 0);
        const BoundBuffer bound[] = {{0, &*source}, {1, &*result}, {2, &*constants}};
        DispatchRequest request;
        request.pipeline = &*pipeline;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(push));
        request.groups[0] = (kCount + 63) / 64;
        const auto timing = context->Dispatch(request);
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        CHECK(timing->wallSeconds > 0);
        CHECK(timing->gpuSeconds.has_value() == context->GetDevice().hasTimestamps);
        if (timing->gpuSeconds)
            CHECK(*timing->gpuSeconds < timing->wallSeconds + 1.0);

        std::vector<std::uint32_t> read(kCount);
        REQUIRE(context->Read(*result, 0, std::as_writable_bytes(std::span(read))));
        int wrong = 0;
        for (std::uint32_t i = 0; i + 1 < kCount; ++i)
            wrong += read[i] != input[i] * 3 + 1 + 100 + 20;
        CHECK(wrong == 0);
        CHECK(read[kCount - 1] == 0); // beyond the count: as created

        CHECK_FALSE(context->Read(*result, 4, std::as_writable_bytes(std::span(read)))); // past the end
        request.buffers = std::span(bound).first(2);
        CHECK_FALSE(context->Dispatch(request)); // an unbound slot
        request.buffers = bound;
        request.groups[0] = 0;
        CHECK_FALSE(context->Dispatch(request));
    }
}

TEST_CASE("limits of the device are errors") {
    OPENNTC_REQUIRE_DEVICE(context);
    const DeviceInfo& device = context->GetDevice();
    CHECK_FALSE(context->CreateBuffer(0, BufferKind::Storage, BufferMemory::HostVisible));
    const auto tooLarge = context->CreateBuffer(device.maxStorageBufferBytes + 1, BufferKind::Storage,
                                                BufferMemory::HostVisible);
    REQUIRE_FALSE(tooLarge);
    CHECK(tooLarge.error().GetStatus() == Status::Unsupported);
    CHECK_FALSE(context->CreateBuffer(device.maxUniformBufferBytes + 1, BufferKind::Uniform,
                                      BufferMemory::HostVisible));
    CHECK_FALSE(context->CreateComputePipeline(*harness_shaders::FindShader("Fill.comp", "FACTOR=3 OFFSET=1"),
                                               kFillSlots, device.maxPushConstantBytes + 4));
}

TEST_CASE("an error of the validation layer fails the call, and a clean context reports none") {
    OPENNTC_REQUIRE_DEVICE(shared);
    ContextOptions options;
    options.device = openntc_tests::GetTestDeviceName();
    options.validation = true;
    options.log = std::make_shared<ValidationLog>();
    {
        auto context = Context::Create(options);
        if (!context) {
            MESSAGE("SKIP: " << std::string(context.error().GetText()));
            return;
        }
        const auto buffer = (*context)->CreateBuffer(64, BufferKind::Storage, BufferMemory::DeviceLocal);
        CHECK(buffer);
    }
    CHECK(options.log->errors.empty());
    {
        auto context = Context::Create(options);
        REQUIRE(context);
        // Binding 2 of the shader is not in the layout.
        const auto pipeline =
            (*context)->CreateComputePipeline(*harness_shaders::FindShader("Fill.comp", "FACTOR=3 OFFSET=1"),
                                              std::span(kFillSlots).first(2), 8);
        REQUIRE_FALSE(pipeline);
        CHECK(pipeline.error().GetStatus() == Status::InternalError);
        CHECK(std::string(pipeline.error().GetText()).find("validation layer") != std::string::npos);
    }
    CHECK_FALSE(options.log->errors.empty());
}

TEST_CASE("a required feature that is absent is an error with its name and the reason") {
    OPENNTC_REQUIRE_DEVICE(shared);
    for (std::size_t i = 0; i < kFeatureCount; ++i) {
        const auto feature = static_cast<Feature>(i);
        const std::string name = GetFeatureName(feature);
        CAPTURE(name);
        CHECK(name != "?");
        ContextOptions options;
        options.device = openntc_tests::GetTestDeviceName();
        options.required = {feature};
        const bool has = shared->GetDevice().features.Has(feature);
        if (has)
            options.withheld = {feature};
        const auto context = Context::Create(options);
        REQUIRE_FALSE(context);
        CHECK(context.error().GetStatus() == Status::Unsupported);
        CHECK(std::string(context.error().GetText()) ==
              "device or feature absent: " + name + ": " +
                  (has ? "left off by the caller" : shared->GetDevice().features.GetAbsence(feature)) + ": " +
                  shared->GetDevice().name);
    }
}

TEST_CASE("without optional features a device still computes, and what needs them says so") {
    OPENNTC_REQUIRE_DEVICE(shared);
    ContextOptions options;
    options.device = openntc_tests::GetTestDeviceName();
    for (std::size_t i = 0; i < kFeatureCount; ++i)
        options.withheld.push_back(static_cast<Feature>(i));
    const auto context = Context::Create(options);
    REQUIRE_MESSAGE(context.has_value(), std::string(context.error().GetText()));
    const auto buffer = (*context)->CreateBuffer(64, BufferKind::Storage, BufferMemory::DeviceLocal);
    REQUIRE(buffer);
    CHECK(buffer->GetDeviceAddress() == 0);
    CHECK((*context)->CreateComputePipeline(*harness_shaders::FindShader("Fill.comp", "FACTOR=3 OFFSET=1"),
                                            kFillSlots, 8));
    CoopVecWeights weights;
    const auto converted = (*context)->ConvertWeights(weights);
    REQUIRE_FALSE(converted);
    CHECK(converted.error().GetStatus() == Status::Unsupported);
    CHECK(std::string(converted.error().GetText()).find("cooperativeVector: left off by the caller") !=
          std::string::npos);
}

TEST_CASE("timed dispatches: one time each, over several submissions") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().hasTimestamps) {
        MESSAGE("SKIP: no timestamps");
        return;
    }
    const std::uint32_t uniform[4] = {1, 20, 3, 4};
    const std::uint32_t input[64] = {5};
    const std::uint32_t push[2] = {64, 100};
    const auto source = context->CreateBuffer(std::as_bytes(std::span(input)), BufferKind::Storage,
                                              BufferMemory::DeviceLocal);
    const auto result = context->CreateBuffer(sizeof input, BufferKind::Storage, BufferMemory::DeviceLocal);
    const auto constants = context->CreateBuffer(std::as_bytes(std::span(uniform)), BufferKind::Uniform,
                                                 BufferMemory::DeviceLocal);
    REQUIRE(source);
    REQUIRE(result);
    REQUIRE(constants);
    const auto code = harness_shaders::FindShader("Fill.comp", "FACTOR=3 OFFSET=1");
    const auto kept = context->CreateComputePipeline(*code, kFillSlots, sizeof push);
    const auto again = context->CreateComputePipeline(*code, kFillSlots, sizeof push);
    const auto apart = context->CreateComputePipeline(*code, kFillSlots, sizeof push, {.isKept = false});
    REQUIRE(kept);
    REQUIRE(again);
    REQUIRE(apart);
    CHECK(kept->GetImpl() == again->GetImpl());
    CHECK(apart->GetImpl() != kept->GetImpl());
    const BoundBuffer bound[] = {{0, &*source}, {1, &*result}, {2, &*constants}};
    DispatchRequest request;
    request.pipeline = &*apart;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(push));
    for (const std::uint32_t repetitions : {1u, 32u, 33u, 70u}) {
        const auto seconds = context->TimeDispatches(request, repetitions);
        REQUIRE_MESSAGE(seconds.has_value(), std::string(seconds.error().GetText()));
        CHECK(seconds->size() == repetitions);
        for (const double time : *seconds)
            CHECK((time >= 0 && time < 3600));
    }
    std::uint32_t read[1] = {};
    REQUIRE(context->Read(*result, 0, std::as_writable_bytes(std::span(read))));
    CHECK(read[0] == 5 * 3 + 1 + 100 + 20);
    request.buffers = std::span(bound).first(2);
    CHECK_FALSE(context->TimeDispatches(request, 1)); // an unbound slot

    // In a batch the second overlaps the first; the third reads what both wrote, and is a group of its own.
    const auto other = context->CreateBuffer(sizeof input, BufferKind::Storage, BufferMemory::DeviceLocal);
    const auto third = context->CreateBuffer(sizeof input, BufferKind::Storage, BufferMemory::DeviceLocal);
    REQUIRE(other);
    REQUIRE(third);
    request.buffers = bound;
    const BoundBuffer toOther[] = {{0, &*source}, {1, &*other}, {2, &*constants}};
    const BoundBuffer toThird[] = {{0, &*other}, {1, &*third}, {2, &*constants}};
    std::vector<DispatchRequest> batch(3, request);
    batch[1].buffers = toOther;
    batch[1].overlapsPrevious = true;
    batch[2].buffers = toThird;
    const auto timing = context->DispatchBatch(batch);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    if (context->GetDevice().hasTimestamps)
        CHECK(timing->gpuSeconds.size() == 2);
    REQUIRE(context->Read(*third, 0, std::as_writable_bytes(std::span(read))));
    CHECK(read[0] == (5 * 3 + 121) * 3 + 121);
}

TEST_CASE("layers of an image array take rectangles of buffers and of other images") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::vector<std::uint32_t> texels(2 * 8 * 8);
    std::iota(texels.begin(), texels.end(), 1u);
    const auto buffer = context->CreateBuffer(std::as_bytes(std::span(texels)), BufferKind::Storage,
                                              BufferMemory::DeviceLocal);
    REQUIRE(buffer);
    const auto array = context->CreateImageArray(ImageFormat::RGBA8, 8, 8, 2);
    const auto plain = context->CreateImage(ImageFormat::RGBA8, 8, 8);
    REQUIRE(array);
    REQUIRE(plain);
    CHECK(array->GetLayers() == 2);
    CHECK(array->GetBytes() == 4 * texels.size());
    // 3 x 2 texels from the sixth one on, to (1, 4) of layer 1; from there to (5, 0) of an image, and back to layer 0.
    const BufferToImage fill{20, {1, 4, 1, 3, 2}};
    REQUIRE(context->Copy(*buffer, *array, std::span(&fill, 1)));
    const ImageToImage out{1, 4, 1, {5, 0, 0, 3, 2}}, back{5, 0, 0, {0, 0, 0, 3, 2}};
    REQUIRE(context->Copy(*array, *plain, std::span(&out, 1)));
    REQUIRE(context->Copy(*plain, *array, std::span(&back, 1)));
    std::vector<std::uint32_t> expected(texels.size()), result(texels.size());
    for (std::uint32_t i = 0; i < 6; ++i) {
        expected[64 + 8 * (4 + i / 3) + 1 + i % 3] = 6 + i;
        expected[8 * (i / 3) + i % 3] = 6 + i;
    }
    REQUIRE(context->Read(*array, std::as_writable_bytes(std::span(result))));
    CHECK(result == expected);
    const BufferToImage outside{0, {6, 0, 0, 3, 1}}, noLayer{0, {0, 0, 2, 1, 1}},
        beyond{508, {0, 0, 0, 2, 1}};
    for (const BufferToImage& wrong : {outside, noLayer, beyond}) {
        const auto refused = context->Copy(*buffer, *array, std::span(&wrong, 1));
        REQUIRE_FALSE(refused);
        CHECK(refused.error().GetStatus() == Status::OutOfRange);
    }
    CHECK_FALSE(context->CreateImageArray(ImageFormat::RGBA8, 8, 8, 0));
}
