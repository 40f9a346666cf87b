// SPDX-License-Identifier: MIT
// Cooperative matrices: of which types.
#include "CooperativeMatrixTypes.h"
#include "VulkanObjects.h"

#include <algorithm>

namespace openntc::harness {

void DescribeCooperativeMatrices(const vk::raii::Instance& instance, const vk::raii::PhysicalDevice& device,
                                 DeviceInfo& info) {
    const auto query = reinterpret_cast<PFN_vkGetPhysicalDeviceCooperativeMatrixPropertiesKHR>(
        instance.getProcAddr("vkGetPhysicalDeviceCooperativeMatrixPropertiesKHR"));
    if (!info.features.Has(Feature::CooperativeMatrices) || query == nullptr || info.subgroupSize != 32)
        return;
    const auto physical = static_cast<VkPhysicalDevice>(*device);
    std::uint32_t count = 0;
    if (query(physical, &count, nullptr) != VK_SUCCESS)
        return;
    VkCooperativeMatrixPropertiesKHR empty = {};
    empty.sType = VK_STRUCTURE_TYPE_COOPERATIVE_MATRIX_PROPERTIES_KHR;
    std::vector<VkCooperativeMatrixPropertiesKHR> list(count, empty);
    if (query(physical, &count, list.data()) < VK_SUCCESS)
        return;
    list.resize(count);
    const auto has = [&list](std::uint32_t depth, int operands, int sums) {
        constexpr int kSubgroup = 3;
        return std::any_of(list.begin(), list.end(), [=](const VkCooperativeMatrixPropertiesKHR& p) {
            return p.MSize == 16 && p.NSize == 16 && p.KSize == depth &&
                   static_cast<int>(p.AType) == operands && static_cast<int>(p.BType) == operands &&
                   static_cast<int>(p.CType) == sums && static_cast<int>(p.ResultType) == sums &&
                   p.saturatingAccumulation == VK_FALSE && static_cast<int>(p.scope) == kSubgroup;
        });
    };
    constexpr int kHalf = 0, kFloat = 1, kByte = 3, kInt = 5; // VkComponentTypeKHR
    info.hasByteMatrices = has(32, kByte, kInt);
    info.hasHalfMatrices = has(16, kHalf, kFloat) && info.features.Has(Feature::Float16);
}

} // namespace openntc::harness
