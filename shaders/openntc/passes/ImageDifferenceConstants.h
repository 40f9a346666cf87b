// SPDX-License-Identifier: MIT
// Constants of ImageDifference, shared by C++, GLSL and HLSL.
#ifndef OPENNTC_IMAGE_DIFFERENCE_CONSTANTS_H
#define OPENNTC_IMAGE_DIFFERENCE_CONSTANTS_H

// Invocations of a workgroup, in both directions, and texels of each.
#define NTC_DIFFERENCE_GROUP 16
#define NTC_DIFFERENCE_TEXELS 4
// Bits of NtcImageDifferenceConstants::flags.
#define NTC_DIFFERENCE_ALPHA 1u
#define NTC_DIFFERENCE_LOGARITHM 2u
// 64-bit sums of a result: four channels, texels that cannot be measured.
#define NTC_DIFFERENCE_SUMS 5

#if defined(__cplusplus)
#include <cstddef>
#include <cstdint>
namespace openntc {
#define NTC_FIELD_INT std::int32_t
#define NTC_FIELD_UINT std::uint32_t
#define NTC_FIELD_FLOAT float
#else
#define NTC_FIELD_INT int
#define NTC_FIELD_UINT uint
#define NTC_FIELD_FLOAT float
#endif

/// Push constants of ImageDifference, 40 bytes.
struct NtcImageDifferenceConstants {
    NTC_FIELD_INT firstLeft; // of the rectangle in the first image, texels
    NTC_FIELD_INT firstTop;
    NTC_FIELD_INT secondLeft; // and in the second
    NTC_FIELD_INT secondTop;
    NTC_FIELD_INT width; // 1 or more; width * height at most 2^31
    NTC_FIELD_INT height;
    NTC_FIELD_FLOAT steps; // errors are in units of 1 / steps
    NTC_FIELD_FLOAT alphaThreshold;
    NTC_FIELD_UINT flags; // NTC_DIFFERENCE_*
    NTC_FIELD_UINT word;  // of the result buffer, where the result begins
};

#if defined(__cplusplus)
static_assert(sizeof(NtcImageDifferenceConstants) == 40);
static_assert(offsetof(NtcImageDifferenceConstants, secondLeft) == 8);
static_assert(offsetof(NtcImageDifferenceConstants, width) == 16);
static_assert(offsetof(NtcImageDifferenceConstants, steps) == 24);
static_assert(offsetof(NtcImageDifferenceConstants, alphaThreshold) == 28);
static_assert(offsetof(NtcImageDifferenceConstants, flags) == 32);
static_assert(offsetof(NtcImageDifferenceConstants, word) == 36);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT
#undef NTC_FIELD_FLOAT

#endif
