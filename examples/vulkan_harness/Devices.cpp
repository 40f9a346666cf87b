// SPDX-License-Identifier: MIT
// The loader, the instance, and which device of it.
#include "VulkanObjects.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <string_view>

#if defined(_WIN32)
#include <windows.h>
#else
#include <dlfcn.h>
#endif

namespace openntc::harness {

namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

/// The Vulkan loader. It is never closed: drivers leave threads and exit handlers behind in it.
PFN_vkGetInstanceProcAddr OpenLoader(const std::string& library) {
#if defined(_WIN32)
    const HMODULE module = LoadLibraryA(library.empty() ? "vulkan-1.dll" : library.c_str());
    if (module == nullptr)
        return nullptr;
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(
        reinterpret_cast<void*>(GetProcAddress(module, "vkGetInstanceProcAddr")));
#else
    void* module = nullptr;
    if (!library.empty()) {
        module = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    } else {
        for (const char* name : {"libvulkan.so.1", "libvulkan.so"}) {
            if (module == nullptr)
                module = dlopen(name, RTLD_NOW | RTLD_LOCAL);
        }
    }
    if (module == nullptr)
        return nullptr;
    return reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(module, "vkGetInstanceProcAddr"));
#endif
}

VKAPI_ATTR VkBool32 VKAPI_CALL OnMessage(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                         VkDebugUtilsMessageTypeFlagsEXT,
                                         const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    ValidationLog& log = *static_cast<ValidationLog*>(user);
    try {
        const std::string text = data->pMessage != nullptr ? data->pMessage : "(no text)";
        if ((severity & VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT) != 0)
            log.errors.push_back(text);
        else
            log.warnings.push_back(text);
    } catch (const std::exception&) {
        std::abort(); // no memory left to keep the message, and it must not be lost
    }
    return VK_FALSE;
}

bool HasName(const std::vector<vk::ExtensionProperties>& list, const char* name) {
    return std::any_of(list.begin(), list.end(),
                       [name](const auto& item) { return std::strcmp(item.extensionName, name) == 0; });
}

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

Expected<std::unique_ptr<Instance>> MakeInstance(const std::string& loaderLibrary, ValidationLog* log) {
    const PFN_vkGetInstanceProcAddr loader = OpenLoader(loaderLibrary);
    if (loader == nullptr) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan loader %s: cannot be opened",
                    loaderLibrary.empty() ? "(system)" : loaderLibrary.c_str());
    }
    auto result = std::make_unique<Instance>(loader);
    result->apiVersion = result->context.enumerateInstanceVersion();
    if (result->apiVersion < VK_API_VERSION_1_1)
        return Fail(Status::Unsupported, "device or feature absent: Vulkan 1.1: the loader offers 1.0 only");

    const vk::ApplicationInfo application("openntc", 1, "openntc", 1,
                                          std::min<std::uint32_t>(result->apiVersion, VK_API_VERSION_1_3));
    std::vector<const char*> layers;
    std::vector<const char*> extensions;
    vk::DebugUtilsMessengerCreateInfoEXT messages(
        {},
        vk::DebugUtilsMessageSeverityFlagBitsEXT::eError | vk::DebugUtilsMessageSeverityFlagBitsEXT::eWarning,
        vk::DebugUtilsMessageTypeFlagBitsEXT::eValidation | vk::DebugUtilsMessageTypeFlagBitsEXT::eGeneral,
        OnMessage, log);
    vk::InstanceCreateInfo info({}, &application);
    if (log != nullptr) {
        const auto available = result->context.enumerateInstanceLayerProperties();
        const bool found = std::any_of(available.begin(), available.end(), [](const auto& layer) {
            return std::strcmp(layer.layerName, kValidationLayer) == 0;
        });
        if (!found)
            return Fail(Status::Unsupported, "device or feature absent: %s: layer not installed",
                        kValidationLayer);
        const std::string layerName = kValidationLayer;
        if (!HasName(result->context.enumerateInstanceExtensionProperties(layerName),
                     VK_EXT_DEBUG_UTILS_EXTENSION_NAME) &&
            !HasName(result->context.enumerateInstanceExtensionProperties(),
                     VK_EXT_DEBUG_UTILS_EXTENSION_NAME))
            return Fail(Status::Unsupported,
                        "device or feature absent: VK_EXT_debug_utils: needed for validation");
        layers.push_back(kValidationLayer);
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        info.setPNext(&messages);
    }
    info.setPEnabledLayerNames(layers);
    info.setPEnabledExtensionNames(extensions);
    result->instance = vk::raii::Instance(result->context, info);
    if (log != nullptr)
        result->messenger = vk::raii::DebugUtilsMessengerEXT(result->instance, messages);
    return result;
}

std::optional<std::uint32_t> FindComputeQueue(const vk::raii::PhysicalDevice& device) {
    const auto families = device.getQueueFamilyProperties();
    for (std::uint32_t i = 0; i < families.size(); ++i) {
        if (families[i].queueFlags & vk::QueueFlagBits::eCompute)
            return i;
    }
    return std::nullopt;
}

Features GetFeatures(const vk::raii::PhysicalDevice& device) {
    Features features;
    features.bufferArrays = device.getFeatures().shaderStorageBufferArrayDynamicIndexing == VK_TRUE;
    if (device.getProperties().apiVersion >= VK_API_VERSION_1_3) {
        const auto chain =
            device.getFeatures2<vk::PhysicalDeviceFeatures2, vk::PhysicalDeviceVulkan12Features,
                                vk::PhysicalDeviceVulkan13Features>();
        const auto& core12 = chain.get<vk::PhysicalDeviceVulkan12Features>();
        features.float16 = core12.shaderFloat16 == VK_TRUE;
        features.bufferDeviceAddress = core12.bufferDeviceAddress == VK_TRUE;
        features.nonUniformIndexing =
            core12.shaderStorageBufferArrayNonUniformIndexing == VK_TRUE && features.bufferArrays;
        const auto& core = chain.get<vk::PhysicalDeviceVulkan13Features>();
        features.integerDotProduct = core.shaderIntegerDotProduct == VK_TRUE;
        features.maintenance4 = core.maintenance4 == VK_TRUE;
    }
    return features;
}

DeviceInfo Describe(const vk::raii::PhysicalDevice& device, std::uint32_t index) {
    const vk::PhysicalDeviceProperties properties = device.getProperties();
    DeviceInfo info;
    info.index = index;
    info.name = properties.deviceName.data();
    info.apiVersion = properties.apiVersion;
    info.isCpu = properties.deviceType == vk::PhysicalDeviceType::eCpu;
    if (properties.apiVersion >= VK_API_VERSION_1_2) {
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
    const Features features = GetFeatures(device);
    info.hasIntegerDotProduct = features.integerDotProduct;
    info.hasFloat16 = features.float16;
    info.hasBufferDeviceAddress = features.bufferDeviceAddress;
    info.hasBufferArrays = features.bufferArrays;
    info.hasNonUniformIndexing = features.nonUniformIndexing;
    if (const auto family = FindComputeQueue(device)) {
        info.timestampValidBits = device.getQueueFamilyProperties()[*family].timestampValidBits;
        info.timestampPeriodNanoseconds = static_cast<double>(properties.limits.timestampPeriod);
        info.hasTimestamps = info.timestampValidBits > 0 && info.timestampPeriodNanoseconds > 0;
    }
    info.maxStorageBufferBytes = properties.limits.maxStorageBufferRange;
    info.maxUniformBufferBytes = properties.limits.maxUniformBufferRange;
    info.maxPushConstantBytes = properties.limits.maxPushConstantsSize;
    std::copy_n(properties.limits.maxComputeWorkGroupCount.begin(), 3, info.maxWorkgroupCount);
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

Expected<std::vector<DeviceInfo>> Context::ListDevices(const std::string& loaderLibrary) {
    try {
        OPENNTC_ASSIGN(const std::unique_ptr<Instance> instance, MakeInstance(loaderLibrary, nullptr));
        std::vector<DeviceInfo> list;
        for (const vk::raii::PhysicalDevice& device : EnumerateDevices(instance->instance))
            list.push_back(Describe(device, static_cast<std::uint32_t>(list.size())));
        return list;
    } catch (const std::exception& error) {
        return Fail(Status::Unsupported, "device or feature absent: Vulkan instance: %s", error.what());
    }
}

} // namespace openntc::harness
