// SPDX-License-Identifier: MIT
// Stands in for VulkanTraining.cpp where the Vulkan headers were missing at build time.
#include "encode/DeviceTraining.h"

namespace openntc::tool {

Expected<encode::EncodeResult> TrainOnVulkan(const std::string&, const encode::Material&,
                                             const encode::EncodeOptions&, const encode::ProgressCallback&) {
    return Fail(Status::Unsupported, "vulkan: device or feature absent: built without Vulkan headers");
}

Expected<encode::EncodeResult> TrainOnVulkan(const std::string&, encode::Material&&,
                                             const encode::EncodeOptions&, const encode::ProgressCallback&) {
    return Fail(Status::Unsupported, "vulkan: device or feature absent: built without Vulkan headers");
}

} // namespace openntc::tool
