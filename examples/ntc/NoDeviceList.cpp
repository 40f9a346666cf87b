// SPDX-License-Identifier: MIT
// Stands in for DeviceList.cpp where the Vulkan headers were missing at build time.
#include "DeviceList.h"

namespace openntc::tool {

Expected<std::vector<DeviceEntry>> ListVulkanDevices() {
    return Fail(Status::Unsupported, "vulkan: device or feature absent: built without Vulkan headers");
}

} // namespace openntc::tool
