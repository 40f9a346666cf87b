// SPDX-License-Identifier: MIT
#include "DeviceTiles.h"

namespace openntc::bench {

std::unique_ptr<DeviceTiles> DeviceTiles::Create(const std::string&, bool, std::string& reason) {
    reason = "this build has no Vulkan headers";
    return nullptr;
}

} // namespace openntc::bench
