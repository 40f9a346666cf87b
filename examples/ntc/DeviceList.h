// SPDX-License-Identifier: MIT
// The Vulkan devices of the machine, for `ntc devices`; in builds without Vulkan headers a refusal.
#pragma once

#include "openntc/core/Expected.h"

#include <cstdint>
#include <string>
#include <vector>

namespace openntc::tool {

/// Something that some shaders of OpenNTC use where it is there.
struct DeviceFeature {
    std::string name;   ///< Vulkan's, or in words
    std::string use;    ///< what it is good for
    std::string reason; ///< why the device does not have it; empty: it has
};

struct DeviceEntry {
    std::uint32_t index = 0; ///< as --device takes it
    std::string name;
    std::string driver;
    std::string apiVersion; ///< `1.3.230`
    bool isCpu = false;
    std::uint32_t subgroupSize = 0;
    std::vector<std::string> math; ///< names of maths modes that run on it
    std::vector<DeviceFeature> features;
};

/// Errors: Status::Unsupported ("device or feature absent: ...") without a Vulkan loader.
Expected<std::vector<DeviceEntry>> ListVulkanDevices();

} // namespace openntc::tool
