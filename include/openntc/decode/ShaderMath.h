// SPDX-License-Identifier: MIT
// From the shaders' maths modes to the decoders'.
#pragma once

#include "openntc/MathModes.h"
#include "openntc/decode/DecodeTypes.h"

namespace openntc {

/// The decoder's arithmetic for a value of NTC_MATH (MathModes.h). Cooperative vectors: that of the mode they are compared
/// with, INT8 or FP8. Anything else: Int8.
constexpr DecodeMath GetDecodeMath(int shaderMath) noexcept {
    switch (shaderMath) {
    case NTC_MATH_INT8_HALF:
        return DecodeMath::Int8Half;
    case NTC_MATH_FP8:
    case NTC_MATH_COOPVEC_FP8:
        return DecodeMath::FP8;
    case NTC_MATH_FP16:
        return DecodeMath::FP16;
    case NTC_MATH_FP32:
        return DecodeMath::FP32;
    default:
        return DecodeMath::Int8;
    }
}

} // namespace openntc
