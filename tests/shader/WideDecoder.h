// SPDX-License-Identifier: MIT
// The networks of FP8, FP16 and FP32 for sixteen texels at a time. Ten times faster than the reference decoder; tests compare both
// on small mips before trusting it.
#pragma once

#include "openntc/decode/DecodeTypes.h"

#include <span>

namespace openntc_tests {

/// As DecodeReference. `math`: NTC_MATH_FP8, NTC_MATH_FP16 or NTC_MATH_FP32.
void DecodeWide(const openntc::DecodeSource& source, int math, int mip, openntc::Rect rect,
                std::span<float> outputs);

} // namespace openntc_tests
