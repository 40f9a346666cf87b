// SPDX-License-Identifier: MIT
// How a slot's texture is made from a texture set, on load and on feedback. Needs no device.
#pragma once

#include "renderer/gpu/MaterialPlan.h"

#include "openntc/bc/CompressionPass.h"
#include "openntc/passes/DecompressionPass.h"
#include "vulkan_harness/Images.h"

#include <string>
#include <string_view>
#include <vector>

namespace openntc::renderer {

std::vector<std::string> SplitDefines(std::string_view text);

/// Of DecompressToTextures.comp.
std::vector<std::string> ListDefines(const DecompressionPass& pass);

/// How a slot's texture is stored: what a set holds of colours as sRGB codes, all else as it is.
DecompressionOutput MakeOutput(const SlotPlan& slot, bool isColor);

/// Of texels before they are compressed.
harness::ImageFormat GetTexelFormat(const SlotPlan& slot);

/// Of what is kept: blocks, or the texels.
harness::ImageFormat GetStoredFormat(const SlotPlan& slot);

/// The compression of a slot's texels, which has blocks; where they are is left to be said.
bc::BlockCompressionDesc MakeBlockDesc(const SlotPlan& slot, tool::BlockEffort effort,
                                       const DeviceFeatures& device);

} // namespace openntc::renderer
