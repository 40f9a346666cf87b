// SPDX-License-Identifier: MIT
// The loader, which device, and what it can do.
#include "DeviceObjects.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace openntc::bench {

void Device::Impl::QueryCooperativeVectors() {
    const auto query = Get<PFN_vkGetPhysicalDeviceCooperativeVectorPropertiesNV>(
        "vkGetPhysicalDeviceCooperativeVectorPropertiesNV");
    if (query == nullptr)
        return;
    std::uint32_t count = 0;
    Check(query(physical, &count, nullptr), "vkGetPhysicalDeviceCooperativeVectorPropertiesNV");
    VkCooperativeVectorPropertiesNV empty = {};
    empty.sType = VK_STRUCTURE_TYPE_COOPERATIVE_VECTOR_PROPERTIES_NV;
    std::vector<VkCooperativeVectorPropertiesNV> list(count, empty);
    Check(query(physical, &count, list.data()), "vkGetPhysicalDeviceCooperativeVectorPropertiesNV");
    const auto has = [&](int input, int interpretation, int matrix, int bias, int result) {
        return std::any_of(list.begin(), list.end(), [&](const VkCooperativeVectorPropertiesNV& p) {
            return static_cast<int>(p.inputType) == input &&
                   static_cast<int>(p.inputInterpretation) == interpretation &&
                   static_cast<int>(p.matrixInterpretation) == matrix &&
                   static_cast<int>(p.biasInterpretation) == bias && static_cast<int>(p.resultType) == result;
        });
    };
    constexpr int kHalf = 0, kFloat = 1, kByte = 3, kInt = 5, kUint = 9, kPacked = 1000491000,
                  kE4M3 = 1000491002;
    facts.cooperativeVectors.hasInt8 =
        (has(kUint, kPacked, kByte, kInt, kInt) || has(kPacked, kPacked, kByte, kInt, kInt)) &&
        has(kFloat, kByte, kByte, kInt, kInt);
    facts.cooperativeVectors.hasE4M3 = has(kHalf, kE4M3, kE4M3, kHalf, kHalf);
    for (const VkCooperativeVectorPropertiesNV& p : list) {
        char line[128];
        std::snprintf(line, sizeof line, "input %d as %d, matrix %d, bias %d, result %d",
                      static_cast<int>(p.inputType), static_cast<int>(p.inputInterpretation),
                      static_cast<int>(p.matrixInterpretation), static_cast<int>(p.biasInterpretation),
                      static_cast<int>(p.resultType));
        facts.cooperativeVectorTypes.push_back(line);
    }
}

void Device::Impl::Open(const std::string& name) {
    void* loader = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
    if (loader == nullptr)
        throw DeviceFailure("device or feature absent: libvulkan.so.1");
    getInstance = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(loader, "vkGetInstanceProcAddr"));
    VkApplicationInfo application = {};
    application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
    application.apiVersion = VK_API_VERSION_1_3;
    VkInstanceCreateInfo instanceInfo = {};
    instanceInfo.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
    instanceInfo.pApplicationInfo = &application;
    Check(Get<PFN_vkCreateInstance>("vkCreateInstance")(&instanceInfo, nullptr, &instance),
          "vkCreateInstance");

    const auto getProperties = Get<PFN_vkGetPhysicalDeviceProperties2>("vkGetPhysicalDeviceProperties2");
    std::uint32_t count = 16;
    VkPhysicalDevice devices[16];
    const auto enumerate = Get<PFN_vkEnumeratePhysicalDevices>("vkEnumeratePhysicalDevices");
    Check(enumerate(instance, &count, devices), "vkEnumeratePhysicalDevices");
    VkPhysicalDeviceSubgroupProperties subgroup = {};
    subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
    VkPhysicalDeviceDriverProperties driver = {};
    driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
    driver.pNext = &subgroup;
    VkPhysicalDeviceProperties2 properties = {};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &driver;
    for (std::uint32_t i = 0; i < count; ++i) {
        getProperties(devices[i], &properties);
        const bool fits = name.empty()
                              ? physical == VK_NULL_HANDLE ||
                                    properties.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU
                              : std::strstr(properties.properties.deviceName, name.c_str()) != nullptr;
        if (fits)
            physical = devices[i];
    }
    if (physical == VK_NULL_HANDLE)
        throw DeviceFailure("device or feature absent: " + (name.empty() ? "no Vulkan device" : name));
    getProperties(physical, &properties);
    nanosecondsPerTick = static_cast<double>(properties.properties.limits.timestampPeriod);
    facts.name = properties.properties.deviceName;
    facts.isCpu = properties.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    facts.driver = std::string(driver.driverName) + " " + driver.driverInfo;
    facts.subgroupSize = subgroup.subgroupSize;
    facts.maxUniformBytes = properties.properties.limits.maxUniformBufferRange;
    Get<PFN_vkGetPhysicalDeviceMemoryProperties>("vkGetPhysicalDeviceMemoryProperties")(physical, &memory);

    std::uint32_t extensionCount = 0;
    const auto enumerateExtensions =
        Get<PFN_vkEnumerateDeviceExtensionProperties>("vkEnumerateDeviceExtensionProperties");
    Check(enumerateExtensions(physical, nullptr, &extensionCount, nullptr), "extensions");
    std::vector<VkExtensionProperties> available(extensionCount);
    Check(enumerateExtensions(physical, nullptr, &extensionCount, available.data()), "extensions");
    std::vector<const char*> enabled;
    const auto enable = [&](const char* extension) {
        const bool found =
            std::any_of(available.begin(), available.end(), [&](const VkExtensionProperties& e) {
                return std::strcmp(e.extensionName, extension) == 0;
            });
        if (found)
            enabled.push_back(extension);
        return found;
    };
    VkPhysicalDeviceVulkan13Features features13 = {};
    features13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    VkPhysicalDeviceVulkan12Features features12 = {};
    features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    features12.pNext = &features13;
    VkPhysicalDeviceFeatures2 features = {};
    features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    features.pNext = &features12;
    void** next = &features13.pNext;
    VkPhysicalDeviceCooperativeVectorFeaturesNV vectors = {};
    vectors.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_VECTOR_FEATURES_NV;
    if (enable("VK_NV_cooperative_vector")) {
        *next = &vectors;
        next = &vectors.pNext;
    }
    VkPhysicalDeviceShaderReplicatedCompositesFeaturesEXT replicated = {};
    replicated.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_REPLICATED_COMPOSITES_FEATURES_EXT;
    if (enable("VK_EXT_shader_replicated_composites")) {
        *next = &replicated;
        next = &replicated.pNext;
    }
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR statistics = {};
    statistics.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR;
    if (enable("VK_KHR_pipeline_executable_properties")) {
        *next = &statistics;
        next = &statistics.pNext;
    }
    Get<PFN_vkGetPhysicalDeviceFeatures2>("vkGetPhysicalDeviceFeatures2")(physical, &features);
    facts.hasIntegerDotProduct = features13.shaderIntegerDotProduct == VK_TRUE;
    facts.cooperativeVectors.hasCooperativeVectors = vectors.cooperativeVector == VK_TRUE &&
                                                     features12.shaderFloat16 == VK_TRUE &&
                                                     features12.vulkanMemoryModel == VK_TRUE;
    if (facts.cooperativeVectors.hasCooperativeVectors)
        QueryCooperativeVectors();
    features.features.robustBufferAccess = VK_FALSE;
    vectors.cooperativeVectorTraining = VK_FALSE;

    std::uint32_t familyCount = 16;
    VkQueueFamilyProperties families[16];
    Get<PFN_vkGetPhysicalDeviceQueueFamilyProperties>("vkGetPhysicalDeviceQueueFamilyProperties")(
        physical, &familyCount, families);
    std::uint32_t family = 0;
    while (family < familyCount && ((families[family].queueFlags & VK_QUEUE_COMPUTE_BIT) == 0 ||
                                    families[family].timestampValidBits == 0))
        ++family;
    const float priority = 1.0f;
    VkDeviceQueueCreateInfo queueInfo = {};
    queueInfo.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
    queueInfo.queueFamilyIndex = family;
    queueInfo.queueCount = 1;
    queueInfo.pQueuePriorities = &priority;
    VkDeviceCreateInfo deviceInfo = {};
    deviceInfo.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
    deviceInfo.pNext = &features;
    deviceInfo.queueCreateInfoCount = 1;
    deviceInfo.pQueueCreateInfos = &queueInfo;
    deviceInfo.enabledExtensionCount = static_cast<std::uint32_t>(enabled.size());
    deviceInfo.ppEnabledExtensionNames = enabled.data();
    Check(Get<PFN_vkCreateDevice>("vkCreateDevice")(physical, &deviceInfo, nullptr, &device),
          "vkCreateDevice");
    const auto getDevice = Get<PFN_vkGetDeviceProcAddr>("vkGetDeviceProcAddr");
#define X(function) function = reinterpret_cast<PFN_##function>(getDevice(device, #function));
    OPENNTC_VULKAN_FUNCTIONS(X)
#undef X
    convert = reinterpret_cast<PFN_vkConvertCooperativeVectorMatrixNV>(
        getDevice(device, "vkConvertCooperativeVectorMatrixNV"));
    getStatistics = reinterpret_cast<PFN_vkGetPipelineExecutableStatisticsKHR>(
        getDevice(device, "vkGetPipelineExecutableStatisticsKHR"));
    hasStatistics = statistics.pipelineExecutableInfo == VK_TRUE && getStatistics != nullptr;

    vkGetDeviceQueue(device, family, 0, &queue);
    VkCommandPoolCreateInfo poolInfo = {};
    poolInfo.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
    poolInfo.flags = VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT;
    poolInfo.queueFamilyIndex = family;
    Check(vkCreateCommandPool(device, &poolInfo, nullptr, &pool), "vkCreateCommandPool");
    VkCommandBufferAllocateInfo commandInfo = {};
    commandInfo.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
    commandInfo.commandPool = pool;
    commandInfo.commandBufferCount = 1;
    Check(vkAllocateCommandBuffers(device, &commandInfo, &commands), "vkAllocateCommandBuffers");
    const VkDescriptorPoolSize sizes[] = {{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 2},
                                          {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 3}};
    VkDescriptorPoolCreateInfo descriptorInfo = {};
    descriptorInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
    descriptorInfo.maxSets = 1;
    descriptorInfo.poolSizeCount = 2;
    descriptorInfo.pPoolSizes = sizes;
    Check(vkCreateDescriptorPool(device, &descriptorInfo, nullptr, &descriptors), "vkCreateDescriptorPool");
    VkQueryPoolCreateInfo queryInfo = {};
    queryInfo.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO;
    queryInfo.queryType = VK_QUERY_TYPE_TIMESTAMP;
    queryInfo.queryCount = 2 * kBatch;
    Check(vkCreateQueryPool(device, &queryInfo, nullptr, &queries), "vkCreateQueryPool");
}

Device::Device(const std::string& name) : impl_(std::make_unique<Impl>()) {
    impl_->Open(name);
}

Device::~Device() {
    impl_->vkDestroyQueryPool(impl_->device, impl_->queries, nullptr);
    impl_->vkDestroyDescriptorPool(impl_->device, impl_->descriptors, nullptr);
    impl_->vkDestroyCommandPool(impl_->device, impl_->pool, nullptr);
    impl_->vkDestroyDevice(impl_->device, nullptr);
}

const DeviceFacts& Device::GetFacts() const noexcept {
    return impl_->facts;
}

} // namespace openntc::bench
