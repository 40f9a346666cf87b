// SPDX-License-Identifier: MIT
// Which devices there are, and what they can do.
#include "VulkanObjects.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>

namespace openntc::harness {

namespace {

int GetPreference(vk::PhysicalDeviceType type) {
    switch (type) {
    case vk::PhysicalDeviceType::eDiscreteGpu:
        return 4;
    case vk::PhysicalDeviceType::eIntegratedGpu:
        return 3;
    case vk::PhysicalDeviceType::eVirtualGpu:
        return 2;
    case vk::PhysicalDeviceType::eCpu:
        return 1;
    case vk::PhysicalDeviceType::eOther:
        break;
    }
    return 0;
}

} // namespace

std::uint32_t GetUsableVersion(const Instance& instance, const vk::raii::PhysicalDevice& device) {
    return std::min({instance.apiVersion, device.getProperties().apiVersion, VK_API_VERSION_1_3});
}

std::optional<std::uint32_t> FindComputeQueue(const vk::raii::PhysicalDevice& device) {
    // One that draws as well, if there is one.
    const auto families = device.getQueueFamilyProperties();
    for (const vk::QueueFlags wanted : {vk::QueueFlagBits::eCompute | vk::QueueFlagBits::eGraphics,
                                        vk::QueueFlags(vk::QueueFlagBits::eCompute)}) {
        for (std::uint32_t i = 0; i < families.size(); ++i) {
            if ((families[i].queueFlags & wanted) == wanted)
                return i;
        }
    }
    return std::nullopt;
}

DeviceInfo Describe(const Instance& instance, const vk::raii::PhysicalDevice& device, std::uint32_t index) {
    const vk::PhysicalDeviceProperties properties = device.getProperties();
    DeviceInfo info;
    info.index = index;
    info.name = properties.deviceName.data();
    info.apiVersion = properties.apiVersion;
    info.isCpu = properties.deviceType == vk::PhysicalDeviceType::eCpu;
    if (GetUsableVersion(instance, device) >= VK_API_VERSION_1_2) {
        const auto chain =
            device.getProperties2<vk::PhysicalDeviceProperties2, vk::PhysicalDeviceDriverProperties,
                                  vk::PhysicalDeviceSubgroupProperties,
                                  vk::PhysicalDeviceFloatControlsProperties>();
        const auto& controls = chain.get<vk::PhysicalDeviceFloatControlsProperties>();
        info.hasDenormPreserve = controls.shaderDenormPreserveFloat32 == VK_TRUE;
        info.hasDenormFlushToZero = controls.shaderDenormFlushToZeroFloat32 == VK_TRUE;
        info.hasSignedZeroInfNanPreserve = controls.shaderSignedZeroInfNanPreserveFloat32 == VK_TRUE;
        info.hasRoundToNearestEven = controls.shaderRoundingModeRTEFloat32 == VK_TRUE;
        info.hasRoundTowardZero = controls.shaderRoundingModeRTZFloat32 == VK_TRUE;
        const auto& subgroups = chain.get<vk::PhysicalDeviceSubgroupProperties>();
        info.subgroupSize = subgroups.subgroupSize;
        info.hasSubgroupShuffle = (subgroups.supportedOperations & vk::SubgroupFeatureFlagBits::eShuffle) &&
                                  (subgroups.supportedStages & vk::ShaderStageFlagBits::eCompute);
        const auto& driver = chain.get<vk::PhysicalDeviceDriverProperties>();
        info.driver = std::string(driver.driverName.data()) + " " + driver.driverInfo.data();
    }
    info.features = GetFeatures(device, GetUsableVersion(instance, device));
    DescribeCooperativeVectors(instance.instance, device, info);
    DescribeCooperativeMatrices(instance.instance, device, info);
    if (const auto family = FindComputeQueue(device)) {
        info.timestampValidBits = device.getQueueFamilyProperties()[*family].timestampValidBits;
        info.timestampPeriodNanoseconds = static_cast<double>(properties.limits.timestampPeriod);
        info.hasTimestamps = info.timestampValidBits > 0 && info.timestampPeriodNanoseconds > 0;
    }
    info.maxStorageBufferBytes = properties.limits.maxStorageBufferRange;
    info.maxUniformBufferBytes = properties.limits.maxUniformBufferRange;
    info.subTexelPrecisionBits = properties.limits.subTexelPrecisionBits;
    info.maxPushConstantBytes = properties.limits.maxPushConstantsSize;
    std::copy_n(properties.limits.maxComputeWorkGroupCount.begin(), 3, info.maxWorkgroupCount);
    info.maxWorkgroupInvocations = properties.limits.maxComputeWorkGroupInvocations;
    info.maxSharedBytes = properties.limits.maxComputeSharedMemorySize;
    return info;
}

std::vector<vk::raii::PhysicalDevice> EnumerateDevices(const vk::raii::Instance& instance) {
    try {
        vk::raii::PhysicalDevices found(instance);
        std::vector<vk::raii::PhysicalDevice> devices;
        for (auto& device : found)
            devices.push_back(std::move(device));
        return devices;
    } catch (const vk::InitializationFailedError&) {
        return {};
    }
}

std::optional<std::size_t> ChooseDevice(const std::vector<vk::raii::PhysicalDevice>& devices,
                                        const std::string& wanted) {
    std::optional<std::size_t> best;
    if (!wanted.empty() &&
        std::all_of(wanted.begin(), wanted.end(), [](char c) { return c >= '0' && c <= '9'; })) {
        const unsigned long index = std::strtoul(wanted.c_str(), nullptr, 10);
        if (index < devices.size())
            best = index;
        return best;
    }
    for (std::size_t i = 0; i < devices.size(); ++i) {
        const vk::PhysicalDeviceProperties properties = devices[i].getProperties();
        if (!wanted.empty()) {
            if (std::string_view(properties.deviceName.data()).find(wanted) != std::string_view::npos)
                return i;
        } else if (!best || GetPreference(properties.deviceType) >
                                GetPreference(devices[*best].getProperties().deviceType)) {
            best = i;
        }
    }
    return best;
}

Expected<std::vector<DeviceInfo>> ListDevices(const std::string& loaderLibrary) {
    try {
        OPENNTC_ASSIGN(const std::unique_ptr<Instance> instance, MakeInstance(loaderLibrary, nullptr));
        std::vector<DeviceInfo> list;
        for (const vk::raii::PhysicalDevice& device : EnumerateDevices(instance->instance))
            list.push_back(Describe(*instance, device, static_cast<std::uint32_t>(list.size())));
        return list;
    } catch (const std::exception& error) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan instance: %s", error.what());
    }
}

} // namespace openntc::harness
