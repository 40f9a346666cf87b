// SPDX-License-Identifier: MIT
// Cooperative matrices of a device, as inference/CooperativeMatrices.h needs to know them.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/permutation/SceneNeeds.h"

#include <optional>

namespace openntc::harness {

/// Runs passes/ProbeCoopMat. Empty: the lanes' form is not possible, because of the accumulator's layout or of what
/// workgroups may have. Errors: Unsupported ("device or feature absent: ...") where there are no matrices of signed bytes,
/// ShaderUnavailable where there is no SPIR-V of the probe (docs/shaders.md).
Expected<std::optional<CoopMatLayout>> ProbeCoopMat(Context& context);

/// Sets what SceneNeeds::device says of matrices by the result of the probe. False if there are none, or no probe.
bool DescribeMatrices(const Expected<std::optional<CoopMatLayout>>& layout, DeviceFeatures& features);

} // namespace openntc::harness
