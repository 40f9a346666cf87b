// SPDX-License-Identifier: MIT
// The Vulkan back end; in builds without Vulkan headers a refusal.
#pragma once

#include "Decoder.h"

namespace openntc::tool {

/// `device` is an index, part of a name, or empty for a GPU if there is one. Errors: Status::Unsupported
/// ("device or feature absent: ...").
Expected<std::unique_ptr<Decoder>> MakeVulkanDecoder(const DecodeData& data, const std::string& device);

} // namespace openntc::tool
