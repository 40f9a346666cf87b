// SPDX-License-Identifier: MIT
#include "Device.h"

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include <dlfcn.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstdio>
#include <cstring>

#ifndef VK_NV_cooperative_vector // headers before 1.4.306; the extension's published values and structures
constexpr VkStructureType VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_VECTOR_FEATURES_NV =
    static_cast<VkStructureType>(1000491000);
constexpr VkStructureType VK_STRUCTURE_TYPE_COOPERATIVE_VECTOR_PROPERTIES_NV =
    static_cast<VkStructureType>(1000491002);
constexpr VkStructureType VK_STRUCTURE_TYPE_CONVERT_COOPERATIVE_VECTOR_MATRIX_INFO_NV =
    static_cast<VkStructureType>(1000491004);
struct VkPhysicalDeviceCooperativeVectorFeaturesNV {
    VkStructureType sType;
    void* pNext;
    VkBool32 cooperativeVector;
    VkBool32 cooperativeVectorTraining;
};
struct VkCooperativeVectorPropertiesNV {
    VkStructureType sType;
    void* pNext;
    std::int32_t inputType, inputInterpretation, matrixInterpretation, biasInterpretation, resultType;
    VkBool32 transpose;
};
struct VkConvertCooperativeVectorMatrixInfoNV {
    VkStructureType sType;
    const void* pNext;
    std::size_t srcSize;
    VkDeviceOrHostAddressConstKHR srcData;
    std::size_t* pDstSize;
    VkDeviceOrHostAddressKHR dstData;
    std::int32_t srcComponentType, dstComponentType;
    std::uint32_t numRows, numColumns;
    std::int32_t srcLayout;
    std::size_t srcStride;
    std::int32_t dstLayout;
    std::size_t dstStride;
};
using PFN_vkGetPhysicalDeviceCooperativeVectorPropertiesNV =
    VkResult(VKAPI_PTR*)(VkPhysicalDevice, std::uint32_t*, VkCooperativeVectorPropertiesNV*);
using PFN_vkConvertCooperativeVectorMatrixNV =
    VkResult(VKAPI_PTR*)(VkDevice, const VkConvertCooperativeVectorMatrixInfoNV*);
#endif
#ifndef VK_EXT_shader_replicated_composites
constexpr VkStructureType VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_REPLICATED_COMPOSITES_FEATURES_EXT =
    static_cast<VkStructureType>(1000564000);
struct VkPhysicalDeviceShaderReplicatedCompositesFeaturesEXT {
    VkStructureType sType;
    void* pNext;
    VkBool32 shaderReplicatedComposites;
};
#endif

namespace openntc::bench {

namespace {

// Handles travel through the interface as numbers.
template <typename Handle>
std::uint64_t ToNumber(Handle handle) {
    return std::bit_cast<std::uint64_t>(handle);
}
template <typename Handle>
Handle FromNumber(std::uint64_t number) {
    return std::bit_cast<Handle>(number);
}

constexpr std::uint32_t kBatch = 32; // dispatches of one submission

void Check(VkResult result, const char* what) {
    if (result != VK_SUCCESS)
        throw DeviceFailure(std::string(what) + ": " + std::to_string(result));
}

} // namespace

// Version 14 moves this list a little at every run.
// clang-format off
#define OPENNTC_VULKAN_FUNCTIONS(X)                                                                          \
    X(vkGetDeviceQueue)                                                                                      \
    X(vkCreateBuffer)                                                                                        \
    X(vkDestroyBuffer)                                                                                       \
    X(vkGetBufferMemoryRequirements)                                                                         \
    X(vkAllocateMemory)                                                                                      \
    X(vkFreeMemory)                                                                                          \
    X(vkBindBufferMemory)                                                                                    \
    X(vkMapMemory)                                                                                           \
    X(vkUnmapMemory) X(vkCreateShaderModule) X(vkDestroyShaderModule) X(vkCreateDescriptorSetLayout)         \
        X(vkDestroyDescriptorSetLayout) X(vkCreatePipelineLayout) X(vkDestroyPipelineLayout)                 \
            X(vkCreateComputePipelines) X(vkDestroyPipeline) X(vkCreateDescriptorPool)                       \
                X(vkResetDescriptorPool) X(vkDestroyDescriptorPool) X(vkAllocateDescriptorSets)              \
                    X(vkUpdateDescriptorSets) X(vkCreateCommandPool) X(vkDestroyCommandPool)                 \
                        X(vkAllocateCommandBuffers) X(vkBeginCommandBuffer) X(vkEndCommandBuffer)            \
                            X(vkCmdBindPipeline) X(vkCmdBindDescriptorSets) X(vkCmdPushConstants)            \
                                X(vkCmdDispatch) X(vkCmdCopyBuffer) X(vkCmdResetQueryPool)                   \
                                    X(vkCmdWriteTimestamp) X(vkCmdPipelineBarrier) X(vkQueueSubmit)          \
                                        X(vkQueueWaitIdle) X(vkCreateQueryPool) X(vkDestroyQueryPool)        \
                                            X(vkGetQueryPoolResults) X(vkDestroyDevice)
// clang-format on

struct Device::Impl {
    PFN_vkGetInstanceProcAddr getInstance = nullptr;
    VkInstance instance = VK_NULL_HANDLE;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    VkDevice device = VK_NULL_HANDLE;
    VkQueue queue = VK_NULL_HANDLE;
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkDescriptorPool descriptors = VK_NULL_HANDLE;
    VkQueryPool queries = VK_NULL_HANDLE;
    VkPhysicalDeviceMemoryProperties memory = {};
    double nanosecondsPerTick = 0;
    bool hasStatistics = false;
    DeviceFacts facts;
    PFN_vkConvertCooperativeVectorMatrixNV convert = nullptr;
    PFN_vkGetPipelineExecutableStatisticsKHR getStatistics = nullptr;
#define X(name) PFN_##name name = nullptr;
    OPENNTC_VULKAN_FUNCTIONS(X)
#undef X

    template <typename F>
    F Get(const char* name) const {
        return reinterpret_cast<F>(getInstance(instance, name));
    }
    void Open(const std::string& name);
    void QueryCooperativeVectors();
    DeviceBuffer Allocate(std::uint64_t size, VkMemoryPropertyFlags wanted);
    void Begin();
    void EndAndWait();
    void Copy(std::uint64_t from, std::uint64_t to, std::uint64_t size);
};

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

DeviceBuffer Device::Impl::Allocate(std::uint64_t size, VkMemoryPropertyFlags wanted) {
    VkBufferCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    info.size = size;
    info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    VkBuffer buffer = VK_NULL_HANDLE;
    Check(vkCreateBuffer(device, &info, nullptr, &buffer), "vkCreateBuffer");
    VkMemoryRequirements needs = {};
    vkGetBufferMemoryRequirements(device, buffer, &needs);
    std::uint32_t type = 0;
    while (type < memory.memoryTypeCount && ((needs.memoryTypeBits >> type & 1u) == 0 ||
                                             (memory.memoryTypes[type].propertyFlags & wanted) != wanted))
        ++type;
    VkMemoryAllocateInfo allocation = {};
    allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
    allocation.allocationSize = needs.size;
    allocation.memoryTypeIndex = type;
    VkDeviceMemory block = VK_NULL_HANDLE;
    Check(vkAllocateMemory(device, &allocation, nullptr, &block), "vkAllocateMemory");
    Check(vkBindBufferMemory(device, buffer, block, 0), "vkBindBufferMemory");
    return {ToNumber(buffer), ToNumber(block), size};
}

void Device::Impl::Begin() {
    VkCommandBufferBeginInfo begin = {};
    begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
    Check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
}

void Device::Impl::EndAndWait() {
    Check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
    VkSubmitInfo submit = {};
    submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    Check(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
    Check(vkQueueWaitIdle(queue), "vkQueueWaitIdle");
}

void Device::Impl::Copy(std::uint64_t from, std::uint64_t to, std::uint64_t size) {
    Begin();
    const VkBufferCopy region = {0, 0, size};
    vkCmdCopyBuffer(commands, FromNumber<VkBuffer>(from), FromNumber<VkBuffer>(to), 1, &region);
    EndAndWait();
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

namespace {
constexpr VkMemoryPropertyFlags kStaging =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
}

DeviceBuffer Device::CreateBuffer(std::uint64_t size, std::span<const std::byte> contents) {
    DeviceBuffer buffer = impl_->Allocate(size, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    if (!contents.empty()) {
        DeviceBuffer staging = impl_->Allocate(contents.size(), kStaging);
        void* mapped = nullptr;
        Check(impl_->vkMapMemory(impl_->device, FromNumber<VkDeviceMemory>(staging.memory), 0, VK_WHOLE_SIZE,
                                 0, &mapped),
              "vkMapMemory");
        std::memcpy(mapped, contents.data(), contents.size());
        impl_->Copy(staging.handle, buffer.handle, contents.size());
        DestroyBuffer(staging);
    }
    return buffer;
}

void Device::DestroyBuffer(DeviceBuffer& buffer) {
    impl_->vkDestroyBuffer(impl_->device, FromNumber<VkBuffer>(buffer.handle), nullptr);
    impl_->vkFreeMemory(impl_->device, FromNumber<VkDeviceMemory>(buffer.memory), nullptr);
    buffer = {};
}

std::vector<std::byte> Device::Read(const DeviceBuffer& buffer, std::uint64_t size) {
    DeviceBuffer staging = impl_->Allocate(size, kStaging);
    impl_->Copy(buffer.handle, staging.handle, size);
    void* mapped = nullptr;
    Check(impl_->vkMapMemory(impl_->device, FromNumber<VkDeviceMemory>(staging.memory), 0, VK_WHOLE_SIZE, 0,
                             &mapped),
          "vkMapMemory");
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    std::memcpy(bytes.data(), mapped, bytes.size());
    DestroyBuffer(staging);
    return bytes;
}

Kernel Device::CreateKernel(std::span<const std::uint32_t> spirv, bool uniformWeights) {
    Kernel kernel;
    kernel.uniformWeights = uniformWeights;
    VkDescriptorSetLayoutBinding bindings[4] = {};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const bool uniform = i == 0 || (i == 2 && uniformWeights);
        bindings[i].binding = i;
        bindings[i].descriptorType =
            uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        bindings[i].descriptorCount = 1;
        bindings[i].stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
    }
    VkDescriptorSetLayoutCreateInfo setInfo = {};
    setInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    setInfo.bindingCount = 4;
    setInfo.pBindings = bindings;
    VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
    Check(impl_->vkCreateDescriptorSetLayout(impl_->device, &setInfo, nullptr, &setLayout), "set layout");
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 4};
    VkPipelineLayoutCreateInfo layoutInfo = {};
    layoutInfo.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layoutInfo.setLayoutCount = 1;
    layoutInfo.pSetLayouts = &setLayout;
    layoutInfo.pushConstantRangeCount = 1;
    layoutInfo.pPushConstantRanges = &range;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    Check(impl_->vkCreatePipelineLayout(impl_->device, &layoutInfo, nullptr, &layout), "pipeline layout");
    VkShaderModuleCreateInfo moduleInfo = {};
    moduleInfo.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    moduleInfo.codeSize = spirv.size_bytes();
    moduleInfo.pCode = spirv.data();
    VkShaderModule module = VK_NULL_HANDLE;
    Check(impl_->vkCreateShaderModule(impl_->device, &moduleInfo, nullptr, &module), "shader module");
    VkComputePipelineCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    if (impl_->hasStatistics)
        info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    const auto start = std::chrono::steady_clock::now();
    const VkResult result =
        impl_->vkCreateComputePipelines(impl_->device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
    kernel.creationSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    impl_->vkDestroyShaderModule(impl_->device, module, nullptr);
    kernel.layout = ToNumber(layout);
    kernel.setLayout = ToNumber(setLayout);
    if (result != VK_SUCCESS) {
        kernel.error = "vkCreateComputePipelines: " + std::to_string(result);
        return kernel;
    }
    kernel.pipeline = ToNumber(pipeline);
    if (impl_->hasStatistics) {
        VkPipelineExecutableInfoKHR executable = {};
        executable.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR;
        executable.pipeline = pipeline;
        VkPipelineExecutableStatisticKHR empty = {};
        empty.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
        std::vector<VkPipelineExecutableStatisticKHR> list(32, empty);
        std::uint32_t count = 32;
        if (impl_->getStatistics(impl_->device, &executable, &count, list.data()) >= 0) {
            for (std::uint32_t i = 0; i < count; ++i)
                kernel.statistics +=
                    (i > 0 ? ", " : "") + std::string(list[i].name) + " " +
                    std::to_string(list[i].value.u64 & 0xFFFFFFFFu); // NVIDIA's driver sets bits above
        }
    }
    return kernel;
}

void Device::DestroyKernel(Kernel& kernel) {
    impl_->vkDestroyPipeline(impl_->device, FromNumber<VkPipeline>(kernel.pipeline), nullptr);
    impl_->vkDestroyPipelineLayout(impl_->device, FromNumber<VkPipelineLayout>(kernel.layout), nullptr);
    impl_->vkDestroyDescriptorSetLayout(impl_->device, FromNumber<VkDescriptorSetLayout>(kernel.setLayout),
                                        nullptr);
    kernel = {};
}

std::vector<double> Device::Run(const Kernel& kernel, std::span<const DeviceBuffer> buffers,
                                std::uint32_t width, std::uint32_t groupsX, std::uint32_t groupsY,
                                int repetitions) {
    Check(impl_->vkResetDescriptorPool(impl_->device, impl_->descriptors, 0), "vkResetDescriptorPool");
    VkDescriptorSetLayout setLayout = FromNumber<VkDescriptorSetLayout>(kernel.setLayout);
    VkDescriptorSetAllocateInfo allocation = {};
    allocation.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocation.descriptorPool = impl_->descriptors;
    allocation.descriptorSetCount = 1;
    allocation.pSetLayouts = &setLayout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    Check(impl_->vkAllocateDescriptorSets(impl_->device, &allocation, &set), "vkAllocateDescriptorSets");
    for (std::uint32_t i = 0; i < buffers.size(); ++i) {
        const VkDescriptorBufferInfo bound = {FromNumber<VkBuffer>(buffers[i].handle), 0, VK_WHOLE_SIZE};
        VkWriteDescriptorSet write = {};
        write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write.dstSet = set;
        write.dstBinding = i;
        write.descriptorCount = 1;
        const bool uniform = i == 0 || (i == 2 && kernel.uniformWeights);
        write.descriptorType =
            uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        write.pBufferInfo = &bound;
        impl_->vkUpdateDescriptorSets(impl_->device, 1, &write, 0, nullptr);
    }
    std::vector<double> milliseconds;
    // A batch is one submission, so that the device does not idle and lower its clocks between dispatches.
    while (milliseconds.size() < static_cast<std::size_t>(repetitions)) {
        const std::uint32_t batch = static_cast<std::uint32_t>(
            std::min<std::size_t>(kBatch, static_cast<std::size_t>(repetitions) - milliseconds.size()));
        impl_->Begin();
        impl_->vkCmdResetQueryPool(impl_->commands, impl_->queries, 0, 2 * kBatch);
        impl_->vkCmdBindPipeline(impl_->commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                 FromNumber<VkPipeline>(kernel.pipeline));
        VkPipelineLayout layout = FromNumber<VkPipelineLayout>(kernel.layout);
        impl_->vkCmdBindDescriptorSets(impl_->commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0,
                                       nullptr);
        impl_->vkCmdPushConstants(impl_->commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &width);
        VkMemoryBarrier barrier = {};
        barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
        barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
        barrier.dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_SHADER_READ_BIT;
        for (std::uint32_t i = 0; i < batch; ++i) {
            impl_->vkCmdPipelineBarrier(impl_->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                        VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, nullptr, 0,
                                        nullptr);
            impl_->vkCmdWriteTimestamp(impl_->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, impl_->queries,
                                       2 * i);
            impl_->vkCmdDispatch(impl_->commands, groupsX, groupsY, 1);
            impl_->vkCmdWriteTimestamp(impl_->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, impl_->queries,
                                       2 * i + 1);
        }
        impl_->EndAndWait();
        std::uint64_t ticks[2 * kBatch] = {};
        Check(impl_->vkGetQueryPoolResults(impl_->device, impl_->queries, 0, 2 * batch, sizeof ticks, ticks,
                                           8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
              "vkGetQueryPoolResults");
        for (std::uint32_t i = 0; i < batch; ++i)
            milliseconds.push_back(static_cast<double>(ticks[2 * i + 1] - ticks[2 * i]) *
                                   impl_->nanosecondsPerTick * 1e-6);
    }
    return milliseconds;
}

std::vector<std::byte> Device::ConvertWeights(CoopVecWeights& weights) {
    const auto convert = [&](CoopVecMatrix& matrix, void* destination) {
        VkConvertCooperativeVectorMatrixInfoNV info = {};
        info.sType = VK_STRUCTURE_TYPE_CONVERT_COOPERATIVE_VECTOR_MATRIX_INFO_NV;
        FillCoopVecConversion(matrix, info);
        info.srcData.hostAddress = weights.matrices.data() + matrix.sourceOffset;
        info.dstData.hostAddress = destination;
        Check(impl_->convert(impl_->device, &info), "vkConvertCooperativeVectorMatrixNV");
    };
    for (CoopVecMatrix& matrix : weights.layers)
        convert(matrix, nullptr);
    if (const Expected<void> done = LayOutCoopVecWeights(weights); !done)
        throw DeviceFailure(done.error().GetText());
    std::vector<std::byte> bytes(weights.size);
    for (CoopVecMatrix& matrix : weights.layers)
        convert(matrix, bytes.data() + matrix.destinationOffset);
    std::memcpy(bytes.data() + weights.tailOffset, weights.tail.data(), weights.tail.size());
    return bytes;
}

} // namespace openntc::bench
