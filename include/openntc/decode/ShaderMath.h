// SPDX-License-Identifier: MIT
// Stability: stable
// From the shaders' maths modes to the decoders'.
#pragma once

#include "openntc/MathModes.h"
#include "openntc/decode/DecodeTypes.h"

#include "openntc/core/HideMacros.h"

namespace openntc {

static_assert(static_cast<int>(DecodeMath::Int8) == NTC_MATH_INT8);
static_assert(static_cast<int>(DecodeMath::Int8Half) == NTC_MATH_INT8_HALF);
static_assert(static_cast<int>(DecodeMath::FP8) == NTC_MATH_FP8);
static_assert(static_cast<int>(DecodeMath::FP16) == NTC_MATH_FP16);
static_assert(static_cast<int>(DecodeMath::FP32) == NTC_MATH_FP32);

/// The decoder's arithmetic for a value of NTC_MATH (MathModes.h). Cooperative vectors and matrices: that of
/// the mode they are compared with, INT8, INT8_HALF or FP8. Anything else: Int8.
constexpr DecodeMath GetDecodeMath(int shaderMath) noexcept {
    if (shaderMath == NTC_MATH_COOPVEC_FP8)
        return DecodeMath::FP8;
    if (shaderMath == NTC_MATH_COOPMAT_INT8_HALF)
        return DecodeMath::Int8Half;
    if (shaderMath < NTC_MATH_INT8 || shaderMath > NTC_MATH_FP32)
        return DecodeMath::Int8;
    return static_cast<DecodeMath>(shaderMath);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
