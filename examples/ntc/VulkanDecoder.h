// SPDX-License-Identifier: MIT
// The Vulkan back end; in builds without Vulkan headers a refusal.
#pragma once

#include "Decoder.h"

namespace openntc::tool {

/// `device` is an index, part of a name, or empty for a GPU if there is one. Errors: Status::Unsupported
/// ("device or feature absent: ..."); ShaderUnavailable if the build has no SPIR-V for matrices.
Expected<std::unique_ptr<Decoder>> MakeVulkanDecoder(const DecodeData& data, const std::string& device,
                                                     bool onMatrices);

} // namespace openntc::tool
