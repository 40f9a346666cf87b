// SPDX-License-Identifier: MIT
// Push constants of the passes in this folder, shared by C++, GLSL and HLSL. As in InferenceConstants.h every
// field is a 4-byte scalar at the byte offset that C++ gives it.
#ifndef OPENNTC_PASS_CONSTANTS_H
#define OPENNTC_PASS_CONSTANTS_H

// Invocations in a workgroup of DecodeTexels, along x.
#define NTC_DECODE_TEXELS_GROUP 64

#if defined(__cplusplus)
#include <cstddef>
#include <cstdint>
namespace openntc {
#define NTC_FIELD_INT std::int32_t
#define NTC_FIELD_UINT std::uint32_t
#else
#define NTC_FIELD_INT int
#define NTC_FIELD_UINT uint
#endif

/// DecodeTexels: the rectangle and what is wanted of it, 24 bytes. Texel (left + i % width, top + i / width)
/// of the mip is the i-th result.
struct NtcDecodeTexelsConstants {
    NTC_FIELD_INT left; // of the rectangle, texels of the mip
    NTC_FIELD_INT top;
    NTC_FIELD_INT width; // 1 or more
    NTC_FIELD_INT height;
    NTC_FIELD_INT mipLevel;
    NTC_FIELD_UINT convertToLinear; // 0 or 1
};

#if defined(__cplusplus)
static_assert(sizeof(NtcDecodeTexelsConstants) == 24);
static_assert(offsetof(NtcDecodeTexelsConstants, left) == 0);
static_assert(offsetof(NtcDecodeTexelsConstants, top) == 4);
static_assert(offsetof(NtcDecodeTexelsConstants, width) == 8);
static_assert(offsetof(NtcDecodeTexelsConstants, height) == 12);
static_assert(offsetof(NtcDecodeTexelsConstants, mipLevel) == 16);
static_assert(offsetof(NtcDecodeTexelsConstants, convertToLinear) == 20);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT

#endif
