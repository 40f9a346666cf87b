// SPDX-License-Identifier: MIT
// Texels of buffers and images as the numbers that block encoders take, for GLSL and HLSL.
#ifndef OPENNTC_BC_TEXEL_NUMBERS_H
#define OPENNTC_BC_TEXEL_NUMBERS_H

#include "openntc/Rounding.h"
#include "openntc/bc/BlockFormats.h"

#if NTC_BC_FORMAT == NTC_BC_BC4_SIGNED || NTC_BC_FORMAT == NTC_BC_BC5_SIGNED
#define NTC_BC_IS_SIGNED 1
#else
#define NTC_BC_IS_SIGNED 0
#endif
/// 32-bit words of a texel in a buffer.
#if NTC_BC_FORMAT == NTC_BC_BC6_UNSIGNED || NTC_BC_FORMAT == NTC_BC_BC6_SIGNED
#define NTC_BC_TEXEL_WORDS 2
#else
#define NTC_BC_TEXEL_WORDS 1
#endif

/// Channel 0 ... 3 of a texel in a buffer: bytes of one word, or halves of two, the lowest first.
int NtcGetTexelNumber(uint first, uint second, uint channel) {
#if NTC_BC_TEXEL_WORDS == 2
    uint word = channel < 2u ? first : second;
    return int(word << (16u - 16u * (channel & 1u))) >> 16;
#elif NTC_BC_IS_SIGNED
    return max(NtcSignedByte(first, channel), -127);
#else
    return int((first >> (8u * channel)) & 255u);
#endif
}

/// The bits of a half, sign-extended, of a number as NtcRoundToHalf leaves it.
int NtcGetHalfBits(float rounded) {
    uint bits = asuint(rounded);
    uint magnitude = bits & 0x7FFFFFFFu;
    uint result = 0x7E00u; // NaN
    if (magnitude <= 0x7F800000u)
        result = magnitude == 0x7F800000u ? 0x7C00u : (magnitude >> 13) - 0x1C000u;
    if (magnitude < 0x38800000u) // subnormal: a multiple of 2^-24
        result = uint(asfloat(magnitude) * 16777216.0f);
    return int(result | ((bits >> 31) << 15)) << 16 >> 16;
}

/// A channel of a texel in an image. UNORM and SNORM: as it is stored, to 8 bits; halves: exact. Numbers of
/// other images are rounded to nearest. NaN is 0 but for BC6H, whose encoders know it.
int NtcGetTexelNumber(float x) {
#if NTC_BC_TEXEL_WORDS == 2
    return NtcGetHalfBits(NtcRoundToHalf(x));
#else
    if (NtcIsNan(x))
        return 0;
#if NTC_BC_IS_SIGNED
    return int(floor(NtcMultiply(clamp(x, -1.0f, 1.0f), 127.0f) + 0.5f));
#else
    return int(NtcMultiply(clamp(x, 0.0f, 1.0f), 255.0f) + 0.5f);
#endif
#endif
}

#endif
