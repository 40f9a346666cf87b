// SPDX-License-Identifier: MIT
// Whether a device computes what shaders ask for: some drivers offer packed dot products that give other sums, and cooperative
// vectors are few drivers' yet.
#pragma once

#include "renderer/gpu/ShaderCache.h"

#include "Decoder.h"
#include "vulkan_harness/Vulkan.h"

#include "openntc/core/Rect.h"

#include <span>

namespace openntc::renderer {

/// Whether a rectangle of decoded texels, 16 values each, is what a maths mode (NTC_MATH_*, whose weights `data` has) promises: the
/// CPU's bits (MathModes.h; numbers below the least normal one count as 0), or with COOPVEC_FP8 numbers within the intervals of
/// FP8 hardware (docs/benchmarks/fp8-intervals.md). Throws CommandError.
bool AreAsPromised(const tool::DecodeData& data, int math, int mip, Rect rect, std::span<const float> texels);

/// Decodes some hundred texels of a set with passes/DecodeTexels, and asks AreAsPromised. `integerDotProduct`: by OpSDot. Throws
/// CommandError.
bool DecodesAsPromised(harness::Context& context, ShaderCache& shaders, const tool::DecodeData& data,
                       int math, bool integerDotProduct);

} // namespace openntc::renderer
