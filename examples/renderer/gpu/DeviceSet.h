// SPDX-License-Identifier: MIT
// A texture set on the device, for shaders that decode it.
#pragma once

#include "Decoder.h"
#include "vulkan_harness/Vulkan.h"

namespace openntc::renderer {

struct DeviceSet {
    harness::Buffer constants;
    harness::Buffer latents;
    harness::Buffer weights;
};

/// `math`: NTC_MATH_*, whose weights `data` has; those of cooperative vectors are converted to the device's own layout. Throws
/// CommandError.
DeviceSet UploadDecodeData(harness::Context& context, const tool::DecodeData& data, int math);

} // namespace openntc::renderer
