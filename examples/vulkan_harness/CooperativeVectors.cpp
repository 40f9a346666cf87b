// SPDX-License-Identifier: MIT
// Cooperative vectors: of which types, and weights in the device's own layout.
#include "CooperativeVectorTypes.h"
#include "VulkanObjects.h"

#include <algorithm>
#include <cstdio>
#include <cstring>

namespace openntc::harness {

void DescribeCooperativeVectors(const vk::raii::Instance& instance, const vk::raii::PhysicalDevice& device,
                                DeviceInfo& info) {
    const auto query = reinterpret_cast<PFN_vkGetPhysicalDeviceCooperativeVectorPropertiesNV>(
        instance.getProcAddr("vkGetPhysicalDeviceCooperativeVectorPropertiesNV"));
    if (!info.features.Has(Feature::CooperativeVectors) || query == nullptr)
        return;
    const auto physical = static_cast<VkPhysicalDevice>(*device);
    std::uint32_t count = 0;
    if (query(physical, &count, nullptr) != VK_SUCCESS)
        return;
    VkCooperativeVectorPropertiesNV empty = {};
    empty.sType = VK_STRUCTURE_TYPE_COOPERATIVE_VECTOR_PROPERTIES_NV;
    std::vector<VkCooperativeVectorPropertiesNV> list(count, empty);
    if (query(physical, &count, list.data()) < VK_SUCCESS)
        return;
    list.resize(count);
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
    info.cooperativeVectors.hasCooperativeVectors = true;
    info.cooperativeVectors.hasInt8 =
        (has(kUint, kPacked, kByte, kInt, kInt) || has(kPacked, kPacked, kByte, kInt, kInt)) &&
        has(kFloat, kByte, kByte, kInt, kInt);
    info.cooperativeVectors.hasE4M3 = has(kHalf, kE4M3, kE4M3, kHalf, kHalf);
    VkPhysicalDeviceCooperativeVectorPropertiesNV stages = {};
    stages.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_COOPERATIVE_VECTOR_PROPERTIES_NV;
    VkPhysicalDeviceProperties2 properties = {};
    properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
    properties.pNext = &stages;
    device.getDispatcher()->vkGetPhysicalDeviceProperties2(physical, &properties);
    info.hasFragmentVectors = (stages.cooperativeVectorSupportedStages & VK_SHADER_STAGE_FRAGMENT_BIT) != 0;
    for (const VkCooperativeVectorPropertiesNV& p : list) {
        char line[128];
        std::snprintf(line, sizeof line, "input %d as %d, matrix %d, bias %d, result %d",
                      static_cast<int>(p.inputType), static_cast<int>(p.inputInterpretation),
                      static_cast<int>(p.matrixInterpretation), static_cast<int>(p.biasInterpretation),
                      static_cast<int>(p.resultType));
        info.cooperativeVectorTypes.push_back(line);
    }
}

Expected<std::vector<std::byte>> Context::ConvertWeights(CoopVecWeights& weights) {
    const auto call = reinterpret_cast<PFN_vkConvertCooperativeVectorMatrixNV>(
        impl_->device.getProcAddr("vkConvertCooperativeVectorMatrixNV"));
    if (!impl_->info.features.Has(Feature::CooperativeVectors) || call == nullptr) {
        return Fail(Status::Unsupported, "device or feature absent: %s: %s",
                    GetFeatureName(Feature::CooperativeVectors),
                    impl_->info.features.GetAbsence(Feature::CooperativeVectors).c_str());
    }
    return Guard("weights", [&]() -> Expected<std::vector<std::byte>> {
        const auto convert = [&](CoopVecMatrix& matrix, void* destination) -> Expected<void> {
            VkConvertCooperativeVectorMatrixInfoNV info = {};
            info.sType = VK_STRUCTURE_TYPE_CONVERT_COOPERATIVE_VECTOR_MATRIX_INFO_NV;
            FillCoopVecConversion(matrix, info);
            info.srcData.hostAddress = weights.matrices.data() + matrix.sourceOffset;
            info.dstData.hostAddress = destination;
            const VkResult result = call(static_cast<VkDevice>(*impl_->device), &info);
            if (result != VK_SUCCESS)
                return Fail(Status::UnknownError, "weights: vkConvertCooperativeVectorMatrixNV: %d",
                            static_cast<int>(result));
            return {};
        };
        for (CoopVecMatrix& matrix : weights.layers)
            OPENNTC_CHECK(convert(matrix, nullptr));
        OPENNTC_CHECK(LayOutCoopVecWeights(weights));
        std::vector<std::byte> bytes(weights.size);
        for (CoopVecMatrix& matrix : weights.layers)
            OPENNTC_CHECK(convert(matrix, bytes.data() + matrix.destinationOffset));
        std::memcpy(bytes.data() + weights.tailOffset, weights.tail.data(), weights.tail.size());
        return bytes;
    });
}

} // namespace openntc::harness
