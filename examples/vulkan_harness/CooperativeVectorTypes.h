// SPDX-License-Identifier: MIT
// VK_NV_cooperative_vector and VK_EXT_shader_replicated_composites for Vulkan headers that are older than they.
#pragma once

#include <vulkan/vulkan.h>

#include <cstddef>
#include <cstdint>

#ifndef VK_NV_cooperative_vector // headers before 1.4.306; the extension's published values and structures
constexpr VkStructureType VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_VECTOR_FEATURES_NV =
    static_cast<VkStructureType>(1000491000);
constexpr VkStructureType VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_VECTOR_PROPERTIES_NV =
    static_cast<VkStructureType>(1000491001);
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
struct VkPhysicalDeviceCooperativeVectorPropertiesNV {
    VkStructureType sType;
    void* pNext;
    VkShaderStageFlags cooperativeVectorSupportedStages;
    VkBool32 cooperativeVectorTrainingFloat16Accumulation, cooperativeVectorTrainingFloat32Accumulation;
    std::uint32_t maxCooperativeVectorComponents;
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
