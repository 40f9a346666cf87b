// SPDX-License-Identifier: MIT
// Stands in for VulkanDecoder.cpp where the Vulkan headers were missing at build time.
#include "VulkanDecoder.h"

namespace openntc::tool {

Expected<std::unique_ptr<Decoder>> MakeVulkanDecoder(const DecodeData&, const std::string&, bool) {
    return Fail(Status::Unsupported, "vulkan: device or feature absent: built without Vulkan headers");
}

} // namespace openntc::tool
