// SPDX-License-Identifier: MIT
// The objects behind Device.h, for its own sources.
#pragma once

#include "Device.h"

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include <bit>

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

// Handles travel through the interface as numbers.
template <typename Handle>
std::uint64_t ToNumber(Handle handle) {
    return std::bit_cast<std::uint64_t>(handle);
}
template <typename Handle>
Handle FromNumber(std::uint64_t number) {
    return std::bit_cast<Handle>(number);
}

inline constexpr std::uint32_t kBatch = 32; // dispatches of one submission

inline void Check(VkResult result, const char* what) {
    if (result != VK_SUCCESS)
        throw DeviceFailure(std::string(what) + ": " + std::to_string(result));
}

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

} // namespace openntc::bench
