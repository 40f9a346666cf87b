// SPDX-License-Identifier: MIT
// Whether a device computes what shaders ask for: some drivers offer packed dot products that give other sums.
#pragma once

#include "renderer/gpu/ShaderCache.h"

#include "Decoder.h"
#include "vulkan_harness/Vulkan.h"

namespace openntc::renderer {

/// Decodes some hundred texels of a set with passes/DecodeTexels and compares them with the CPU's: the same bits, as MathModes.h
/// promises of the emulated modes (numbers below the least normal one count as 0). `integerDotProduct`: by OpSDot. Throws CommandError.
bool DecodesAsCpu(harness::Context& context, ShaderCache& shaders, const tool::DecodeData& data,
                  DecodeMath math, bool integerDotProduct);

} // namespace openntc::renderer
