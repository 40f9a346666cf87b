// SPDX-License-Identifier: MIT
// The context: which device, with which features.
#include "FeatureChain.h"

#include <algorithm>

namespace openntc::harness {

namespace {

/// Takes off what the caller wants to do without, and looks for what it cannot do without.
Expected<void> Negotiate(const ContextOptions& options, DeviceInfo& info) {
    for (const Feature feature : options.withheld) {
        info.features.SetAbsence(feature, "left off by the caller");
        if (feature == Feature::CooperativeVectors) {
            info.cooperativeVectors = {};
            info.hasFragmentVectors = false;
        }
    }
    if (options.surfaceExtensions.empty() && info.features.Has(Feature::Swapchain))
        info.features.SetAbsence(Feature::Swapchain, "no surfaces were asked for");
    AddNeeds(info.features);
    for (const Feature feature : options.required) {
        if (!info.features.Has(feature)) {
            return Fail(Status::Unsupported, "device or feature absent: %s: %s: %s", GetFeatureName(feature),
                        info.features.GetAbsence(feature).c_str(), info.name.c_str());
        }
    }
    return {};
}

} // namespace

Context::Context(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Context::~Context() = default;
const DeviceInfo& Context::GetDevice() const noexcept {
    return impl_->info;
}
const ValidationLog& Context::GetValidationLog() const noexcept {
    return *impl_->log;
}

Expected<std::unique_ptr<Context>> Context::Create(const ContextOptions& options) {
    try {
        auto impl = std::make_unique<Impl>();
        impl->log = options.log ? options.log : std::make_shared<ValidationLog>();
        impl->validation = options.validation;
        OPENNTC_ASSIGN(impl->instance,
                       MakeInstance(options.loaderLibrary, options.validation ? impl->log.get() : nullptr,
                                    options.surfaceExtensions));
        impl->faults = options.faults;

        std::vector<vk::raii::PhysicalDevice> devices = EnumerateDevices(impl->instance->instance);
        const std::optional<std::size_t> chosen = ChooseDevice(devices, options.device);
        if (!chosen) {
            return Fail(Status::Unsupported,
                        "device or feature absent: Vulkan device \"%s\": %zu devices found",
                        options.device.c_str(), devices.size());
        }
        impl->physicalDevice = std::move(devices[*chosen]);
        impl->info = Describe(*impl->instance, impl->physicalDevice, static_cast<std::uint32_t>(*chosen));
        impl->memory = impl->physicalDevice.getMemoryProperties();
        if (impl->info.apiVersion < VK_API_VERSION_1_1)
            return Fail(Status::Unsupported, "device or feature absent: Vulkan 1.1: %s",
                        impl->info.name.c_str());
        const std::optional<std::uint32_t> family = FindComputeQueue(impl->physicalDevice);
        if (!family)
            return Fail(Status::Unsupported, "device or feature absent: compute queue: %s",
                        impl->info.name.c_str());
        impl->queueFamily = *family;
        OPENNTC_CHECK(Negotiate(options, impl->info));

        const float priority = 1.0f;
        const vk::DeviceQueueCreateInfo queueInfo({}, *family, 1, &priority);
        const FeatureSet& features = impl->info.features;
        FeatureChain wanted(GetUsableVersion(*impl->instance, impl->physicalDevice),
                            ListExtensions(impl->physicalDevice, features));
        const std::vector<const char*> extensions = SwitchOn(features, wanted);
        vk::DeviceCreateInfo deviceInfo({}, queueInfo);
        deviceInfo.setPEnabledExtensionNames(extensions);
        deviceInfo.setPNext(&wanted.core);
        impl->device = vk::raii::Device(impl->physicalDevice, deviceInfo);
        impl->queue = vk::raii::Queue(impl->device, *family, 0);
        impl->commandPool = vk::raii::CommandPool(
            impl->device,
            vk::CommandPoolCreateInfo(vk::CommandPoolCreateFlagBits::eResetCommandBuffer, *family));
        vk::raii::CommandBuffers commands(
            impl->device,
            vk::CommandBufferAllocateInfo(*impl->commandPool, vk::CommandBufferLevel::ePrimary, 1));
        impl->commands = std::move(commands.front());
        impl->fence = vk::raii::Fence(impl->device, vk::FenceCreateInfo());
        if (impl->info.hasTimestamps)
            impl->queries = vk::raii::QueryPool(
                impl->device, vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, 2 * kTimedBatch));
        impl->sampler = vk::raii::Sampler(
            impl->device,
            vk::SamplerCreateInfo({}, vk::Filter::eLinear, vk::Filter::eLinear,
                                  vk::SamplerMipmapMode::eNearest, {}, {}, {}, 0.0f, VK_FALSE, 1.0f, VK_FALSE,
                                  vk::CompareOp::eNever, 0.0f, VK_LOD_CLAMP_NONE));
        const std::vector<vk::DescriptorPoolSize> sizes = {{vk::DescriptorType::eStorageBuffer, 64},
                                                           {vk::DescriptorType::eUniformBuffer, 8},
                                                           {vk::DescriptorType::eStorageImage, 32},
                                                           {vk::DescriptorType::eSampledImage, 8},
                                                           {vk::DescriptorType::eCombinedImageSampler, 8}};
        impl->descriptorPool = vk::raii::DescriptorPool(
            impl->device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                                       kMaxDescriptorSets, sizes));
        if (options.validation && !impl->log->errors.empty())
            return Fail(Status::InternalError, "device: validation layer: %s",
                        impl->log->errors.front().c_str());
        return std::unique_ptr<Context>(new Context(std::move(impl)));
    } catch (const std::exception& error) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan device: %s", error.what());
    }
}

} // namespace openntc::harness
