// SPDX-License-Identifier: MIT
// Constants of DecompressToTextures, shared by C++, GLSL and HLSL; passes/DecompressionPass.h makes them. A
// uniform buffer of 448 bytes; the same offsets in C++, std140 and HLSL.
#ifndef OPENNTC_DECOMPRESS_CONSTANTS_H
#define OPENNTC_DECOMPRESS_CONSTANTS_H

#include "openntc/InferenceConstants.h"

// Invocations of a workgroup. An invocation decodes NTC_TEXELS_PER_INVOCATION texels beside each other.
#define NTC_DECOMPRESS_GROUP_WIDTH 16
#define NTC_DECOMPRESS_GROUP_HEIGHT 8
// Textures that one dispatch writes at most.
#define NTC_DECOMPRESS_OUTPUTS 16

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

/// One texture that is written.
struct NtcDecompressOutput {
    /// Bits 0-3: first channel; 4-6: number of channels, 1 ... 4; 8-9: colour space (NTC_COLOR_SPACE_*)
    /// of the first three components in the texture; 10-11: of the fourth; 12-16: bits of a code of a
    /// normalised texture, 1 ... 16, to which components are rounded; 0: they are not.
    NTC_FIELD_UINT channels;
    NTC_FIELD_FLOAT ditherScale; // distance of two codes of the texture's format; 0: no dither
    NTC_FIELD_UINT noise;        // number of the output's noise, 1 for the first output
    NTC_FIELD_UINT image;        // element of the array of images, with NTC_DECOMPRESS_IMAGES
};

/// Texel (left + x, top + y) of the mip is written at (destinationLeft + x, destinationTop + y).
struct NtcDecompressConstants {
    NtcSingleMipConstants desc; // of the mip, as if it were the only one
    NTC_FIELD_INT left;         // of the rectangle, texels of the mip
    NTC_FIELD_INT top;
    NTC_FIELD_INT width; // 1 or more
    NTC_FIELD_INT height;
    NTC_FIELD_INT destinationLeft;
    NTC_FIELD_INT destinationTop;
    NTC_FIELD_INT outputCount; // 1 ... NTC_DECOMPRESS_OUTPUTS
    NTC_FIELD_INT padding;
    NtcDecompressOutput outputs[NTC_DECOMPRESS_OUTPUTS];
};

#if defined(__cplusplus)
static_assert(sizeof(NtcDecompressOutput) == 16);
static_assert(offsetof(NtcDecompressOutput, channels) == 0);
static_assert(offsetof(NtcDecompressOutput, ditherScale) == 4);
static_assert(offsetof(NtcDecompressOutput, noise) == 8);
static_assert(offsetof(NtcDecompressOutput, image) == 12);
static_assert(sizeof(NtcDecompressConstants) == 448);
static_assert(offsetof(NtcDecompressConstants, desc) == 0);
static_assert(offsetof(NtcDecompressConstants, left) == 160);
static_assert(offsetof(NtcDecompressConstants, top) == 164);
static_assert(offsetof(NtcDecompressConstants, width) == 168);
static_assert(offsetof(NtcDecompressConstants, height) == 172);
static_assert(offsetof(NtcDecompressConstants, destinationLeft) == 176);
static_assert(offsetof(NtcDecompressConstants, destinationTop) == 180);
static_assert(offsetof(NtcDecompressConstants, outputCount) == 184);
static_assert(offsetof(NtcDecompressConstants, outputs) == 192);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT
#undef NTC_FIELD_FLOAT

#endif
