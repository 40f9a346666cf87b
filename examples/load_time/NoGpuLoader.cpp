// SPDX-License-Identifier: MIT
#include "GpuLoader.h"

#include "Failure.h"

namespace openntc::load_time {

std::unique_ptr<GpuLoader> GpuLoader::Create(const std::string&) {
    throw tool::CommandError(tool::ExitCode::NoDevice, "--backend",
                             "vulkan: device or feature absent: this build has no Vulkan headers");
}

} // namespace openntc::load_time
