// SPDX-License-Identifier: MIT
// Rounding to smaller formats, by bit operations and the spacing of floats: to nearest, ties to even.
#ifndef OPENNTC_ROUNDING_H
#define OPENNTC_ROUNDING_H

#include "Portability.h"
#include "Switches.h"

NTC_NAMESPACE_BEGIN

/// Rounds to the nearest binary16, ties to even, kept in a float. From 65520 on: infinity. NaN stays NaN.
NTC_FUNCTION float NtcRoundToHalf(float x) {
    uint bits = asuint(x);
    uint magnitude = bits & 0x7FFFFFFFu;
    uint rounded = (magnitude + 0xFFFu + ((magnitude >> 13) & 1u)) & 0xFFFFE000u;
    if (magnitude >= 0x477FF000u)
        rounded = magnitude > 0x7F800000u ? 0x7FC00000u : 0x7F800000u;
    if (magnitude < 0x38800000u) { // below 2^-14 halves are multiples of 2^-24, the spacing of floats at 1/2
        NTC_PRECISE float raised = asfloat(magnitude) + 0.5f;
        NTC_PRECISE float multiple = NtcKeep(raised) - 0.5f;
        rounded = asuint(multiple);
    }
    return asfloat(rounded | (bits & 0x80000000u));
}

/// Rounds a number in -128 ... 127 to the nearest integer, ties to even, as a byte in two's complement: the
/// spacing of floats at 1.5 * 2^23 is 1, so the addition does the rounding.
NTC_FUNCTION uint NtcRoundToByte(float x) {
    NTC_PRECISE float integer = NtcKeep(x) + 12582912.0f;
    return asuint(integer) & 255u;
}

#if NTC_WITH_REAL_INPUTS
/// Rounds to the nearest E4M3 number, ties to even, kept in a float; beyond +-448: +-448. NaN stays NaN.
NTC_FUNCTION float NtcRoundToE4M3(float x) {
    uint bits = asuint(x);
    uint magnitude = bits & 0x7FFFFFFFu;
    uint rounded = (magnitude + 0x7FFFFu + ((magnitude >> 20) & 1u)) & 0xFFF00000u;
    if (magnitude >= 0x43E00000u)
        rounded = magnitude > 0x7F800000u ? 0x7FC00000u : 0x43E00000u;
    if (magnitude < 0x3C800000u) { // below 2^-6 multiples of 2^-9, the spacing of floats at 2^14
        NTC_PRECISE float raised = asfloat(magnitude) + 16384.0f;
        NTC_PRECISE float multiple = NtcKeep(raised) - 16384.0f;
        rounded = asuint(multiple);
    }
    return asfloat(rounded | (bits & 0x80000000u));
}
#endif

NTC_NAMESPACE_END

#endif
