// SPDX-License-Identifier: MIT
// Squared errors of two images in whole numbers, which sum to the same on every device and in any order. C++
// includes this file too (passes/ImageDifferenceReference.h).
#ifndef OPENNTC_IMAGE_DIFFERENCE_TEXEL_H
#define OPENNTC_IMAGE_DIFFERENCE_TEXEL_H

#include "ImageDifferenceConstants.h"
#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

/// The value in steps, to the nearest; ties go up. At most 2^22 in magnitude; 0 for NaN.
NTC_FUNCTION int NtcGetSteps(float value, float steps) {
    if (NtcIsNan(value))
        return 0;
    NTC_PRECISE float scaled = NtcMultiply(value, steps);
    float bounded = scaled < -4194304.0f ? -4194304.0f : (scaled > 4194304.0f ? 4194304.0f : scaled);
    NTC_PRECISE float raised = NtcKeep(bounded) + 0.5f; // exact but for the smallest numbers
    return int(floor(raised));
}

/// True for NaN, infinities, and numbers beyond 2^22 steps.
NTC_FUNCTION bool NtcIsUnmeasurable(float value, float steps) {
    if (NtcIsNan(value))
        return true;
    NTC_PRECISE float scaled = NtcMultiply(value, steps);
    return scaled < -4194304.0f || scaled > 4194304.0f;
}

/// The difference in steps.
NTC_FUNCTION uint NtcSubtractSteps(int a, int b) {
    return uint(a < b ? b - a : a - b);
}

/// The squared difference in steps^2; a difference counts as 65535 at most.
NTC_FUNCTION uint NtcSquareSteps(uint difference) {
    uint bounded = difference > 65535u ? 65535u : difference;
    return bounded * bounded;
}

/// What the difference is taken of.
NTC_FUNCTION float NtcGetDifferenceValue(float value, uint flags) {
    if ((flags & NTC_DIFFERENCE_LOGARITHM) == 0u || NtcIsNan(value))
        return value;
    return log(abs(value) + 1.0f);
}

/// A sum of 64 bits.
struct NtcWideSum {
    uint low;
    uint high;
};

NTC_FUNCTION NtcWideSum NtcAddWide(NtcWideSum sum, uint low, uint high) {
    NtcWideSum result;
    result.low = sum.low + low;
    result.high = sum.high + high + (result.low < low ? 1u : 0u);
    return result;
}

/// Squared errors of a texel, red to alpha; the fifth is 1 if one of the components or differences
/// cannot be measured.
NTC_FUNCTION void NtcMeasureTexel(float4 a, float4 b, float steps, float alphaThreshold, uint flags,
                                  NTC_OUT_ARRAY(uint, errors, NTC_DIFFERENCE_SUMS)) {
    float first[4];
    float second[4];
    first[0] = a.x;
    first[1] = a.y;
    first[2] = a.z;
    first[3] = a.w;
    second[0] = b.x;
    second[1] = b.y;
    second[2] = b.z;
    second[3] = b.w;
    bool isHidden = (flags & NTC_DIFFERENCE_ALPHA) != 0u && a.w < alphaThreshold && b.w < alphaThreshold;
    errors[4] = 0u;
    NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
        float x = NtcGetDifferenceValue(first[k], flags);
        float y = NtcGetDifferenceValue(second[k], flags);
        uint difference = NtcSubtractSteps(NtcGetSteps(x, steps), NtcGetSteps(y, steps));
        errors[k] = NtcSquareSteps(difference);
        if (isHidden && k < 3u)
            errors[k] = 0u;
        else if (difference > 65535u || NtcIsUnmeasurable(x, steps) || NtcIsUnmeasurable(y, steps))
            errors[4] = 1u;
    }
}

NTC_NAMESPACE_END

#endif
