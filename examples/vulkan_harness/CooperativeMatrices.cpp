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
    constexpr int kByte = 3, kInt = 5, kSubgroup = 3;
    info.hasByteMatrices =
        std::any_of(list.begin(), list.end(), [](const VkCooperativeMatrixPropertiesKHR& p) {
            return p.MSize == 16 && p.NSize == 16 && p.KSize == 32 && static_cast<int>(p.AType) == kByte &&
                   static_cast<int>(p.BType) == kByte && static_cast<int>(p.CType) == kInt &&
                   static_cast<int>(p.ResultType) == kInt && p.saturatingAccumulation == VK_FALSE &&
                   static_cast<int>(p.scope) == kSubgroup;
        });
}

} // namespace openntc::harness
