// SPDX-License-Identifier: MIT
// Errors of the Vulkan harness as the program's.
#pragma once

#include "Failure.h"

#include "openntc/core/Expected.h"

#include <utility>

namespace openntc::renderer {

/// The value, or CommandError: NoDevice for what the device lacks and for memory that it refuses, else Failed.
template <typename T>
T RequireDevice(Expected<T>&& value) {
    const bool isDevice = !value && (value.error().GetStatus() == Status::Unsupported ||
                                     value.error().GetStatus() == Status::OutOfMemory);
    if (isDevice)
        throw tool::CommandError(tool::ExitCode::NoDevice, "vulkan", value.error().GetText());
    return tool::Require(std::move(value), tool::ExitCode::Failed, "vulkan");
}

} // namespace openntc::renderer
