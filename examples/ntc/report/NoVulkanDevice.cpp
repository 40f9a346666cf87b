// SPDX-License-Identifier: MIT
#include "report/Device.h"

#include "Failure.h"

namespace openntc::report {

std::unique_ptr<MeasuredDevice> MakeVulkanDevice(const VulkanSettings&) {
    throw tool::CommandError(tool::ExitCode::NoDevice, "vulkan",
                             "device or feature absent: built without Vulkan");
}

} // namespace openntc::report
