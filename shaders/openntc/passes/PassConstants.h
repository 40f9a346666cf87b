// SPDX-License-Identifier: MIT
// Push constants of the passes in this folder, shared by C++, GLSL and HLSL. As in InferenceConstants.h every
// field is a 4-byte scalar at the byte offset that C++ gives it.
#ifndef OPENNTC_PASS_CONSTANTS_H
#define OPENNTC_PASS_CONSTANTS_H

// Invocations in a workgroup of DecodeTexels, along x.
#define NTC_DECODE_TEXELS_GROUP 64
// Blocks of a side of a workgroup of CompressBlocks, one an invocation.
#define NTC_COMPRESS_BLOCKS_GROUP 8

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

/// CompressBlocks: a rectangle of texels and where its blocks go, 60 bytes.
struct NtcCompressBlocksConstants {
    NTC_FIELD_INT left; // of the rectangle in the source, texels
    NTC_FIELD_INT top;
    NTC_FIELD_INT width; // of the rectangle, texels, 1 or more; blocks reach beyond it
    NTC_FIELD_INT height;
    NTC_FIELD_INT sourceMip;        // images: the mip that is read
    NTC_FIELD_UINT sourceWord;      // buffers: the word at which texel (0, 0) begins
    NTC_FIELD_UINT sourceRowWords;  // buffers: words from one row of texels to the next
    NTC_FIELD_UINT destinationLeft; // images: where the first block goes
    NTC_FIELD_UINT destinationTop;
    NTC_FIELD_UINT destinationWord;     // buffers: the word at which the first block begins
    NTC_FIELD_UINT destinationRowWords; // buffers: words from one row of blocks to the next
    NTC_FIELD_INT alphaThreshold; // BC1: alpha at most this is transparent, 0 ... 255; -1: all is opaque
    NTC_FIELD_UINT allowedModes;  // BC7: bit m allows mode m
    NTC_FIELD_UINT hintWord;      // BC7: the word of the first block's hint
    NTC_FIELD_UINT hintRowWords;  // BC7: words from one row of hints to the next
};

/// DecodeBlocks: the rectangle, 20 bytes. Texel (left + i % width, top + i / width) of the mip is the i-th
/// result.
struct NtcDecodeBlocksConstants {
    NTC_FIELD_INT left;
    NTC_FIELD_INT top;
    NTC_FIELD_UINT width; // 1 or more
    NTC_FIELD_UINT height;
    NTC_FIELD_INT mipLevel;
};

#if defined(__cplusplus)
static_assert(sizeof(NtcDecodeBlocksConstants) == 20);
static_assert(offsetof(NtcDecodeBlocksConstants, left) == 0);
static_assert(offsetof(NtcDecodeBlocksConstants, top) == 4);
static_assert(offsetof(NtcDecodeBlocksConstants, width) == 8);
static_assert(offsetof(NtcDecodeBlocksConstants, height) == 12);
static_assert(offsetof(NtcDecodeBlocksConstants, mipLevel) == 16);
static_assert(sizeof(NtcDecodeTexelsConstants) == 24);
static_assert(offsetof(NtcDecodeTexelsConstants, left) == 0);
static_assert(offsetof(NtcDecodeTexelsConstants, top) == 4);
static_assert(offsetof(NtcDecodeTexelsConstants, width) == 8);
static_assert(offsetof(NtcDecodeTexelsConstants, height) == 12);
static_assert(offsetof(NtcDecodeTexelsConstants, mipLevel) == 16);
static_assert(offsetof(NtcDecodeTexelsConstants, convertToLinear) == 20);
static_assert(sizeof(NtcCompressBlocksConstants) == 60);
static_assert(offsetof(NtcCompressBlocksConstants, left) == 0);
static_assert(offsetof(NtcCompressBlocksConstants, top) == 4);
static_assert(offsetof(NtcCompressBlocksConstants, width) == 8);
static_assert(offsetof(NtcCompressBlocksConstants, height) == 12);
static_assert(offsetof(NtcCompressBlocksConstants, sourceMip) == 16);
static_assert(offsetof(NtcCompressBlocksConstants, sourceWord) == 20);
static_assert(offsetof(NtcCompressBlocksConstants, sourceRowWords) == 24);
static_assert(offsetof(NtcCompressBlocksConstants, destinationLeft) == 28);
static_assert(offsetof(NtcCompressBlocksConstants, destinationTop) == 32);
static_assert(offsetof(NtcCompressBlocksConstants, destinationWord) == 36);
static_assert(offsetof(NtcCompressBlocksConstants, destinationRowWords) == 40);
static_assert(offsetof(NtcCompressBlocksConstants, alphaThreshold) == 44);
static_assert(offsetof(NtcCompressBlocksConstants, allowedModes) == 48);
static_assert(offsetof(NtcCompressBlocksConstants, hintWord) == 52);
static_assert(offsetof(NtcCompressBlocksConstants, hintRowWords) == 56);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT

#endif
