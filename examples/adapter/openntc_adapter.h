/* SPDX-License-Identifier: MIT */
/* The interface between `ntc conformance run --adapter ./your_library.so` and a decoder under test. Implement these
 * functions in a shared library and export them with C linkage. Plain C, no dependencies.
 *
 * The library runs in a process of its own: a crash or a hang fails the case at hand and nothing else. All calls come
 * from one thread. Functions that return int return one of the OPENNTC_ADAPTER_ results; after any but OK,
 * openntc_adapter_error() says why in a line of text.
 */
#ifndef OPENNTC_ADAPTER_H
#define OPENNTC_ADAPTER_H

#include <stdint.h>

#if defined(_WIN32)
#define OPENNTC_ADAPTER_EXPORT __declspec(dllexport)
#else
#define OPENNTC_ADAPTER_EXPORT __attribute__((visibility("default")))
#endif

#define OPENNTC_ADAPTER_VERSION 1

/* Maths modes (shaders/openntc/MathModes.h defines what each computes). */
#define OPENNTC_ADAPTER_INT8 1
#define OPENNTC_ADAPTER_INT8_HALF 2
#define OPENNTC_ADAPTER_FP8 3
#define OPENNTC_ADAPTER_FP16 4
#define OPENNTC_ADAPTER_FP32 5

/* Bits of openntc_adapter_capabilities(): 1 << maths mode for every mode, and: */
#define OPENNTC_ADAPTER_CAN_LINEAR (1u << 16)            /* outputs converted to linear colour */
#define OPENNTC_ADAPTER_CAN_DECODE_MIP (1u << 17)        /* openntc_adapter_decode_mip() */
#define OPENNTC_ADAPTER_CAN_DECODE_OUTSIDE (1u << 18)    /* texels outside the mip, negative ones too */
#define OPENNTC_ADAPTER_CAN_DECODE_SLICE (1u << 19)      /* openntc_adapter_decode_slice() */
#define OPENNTC_ADAPTER_CAN_DECODE_SLICE_MIPS (1u << 20) /* openntc_adapter_decode_slice_mips() */

#define OPENNTC_ADAPTER_CAN_ENCODE_BLOCKS (1u << 21) /* openntc_adapter_encode_blocks() */

#define OPENNTC_ADAPTER_CAN_DECODE_TEXTURES (1u << 22) /* openntc_adapter_decode_textures() */
#define OPENNTC_ADAPTER_CAN_FILTER (1u << 23)          /* openntc_adapter_filter() */

/* Block formats and levels of openntc_adapter_encode_blocks(). */
#define OPENNTC_ADAPTER_BC1 0
#define OPENNTC_ADAPTER_BC2 1
#define OPENNTC_ADAPTER_BC3 2
#define OPENNTC_ADAPTER_BC4 3
#define OPENNTC_ADAPTER_BC4_SIGNED 4
#define OPENNTC_ADAPTER_BC5 5
#define OPENNTC_ADAPTER_BC5_SIGNED 6
#define OPENNTC_ADAPTER_BC6 7
#define OPENNTC_ADAPTER_BC6_SIGNED 8
#define OPENNTC_ADAPTER_BC7 9
#define OPENNTC_ADAPTER_LEVEL_FAST 0
#define OPENNTC_ADAPTER_LEVEL_NORMAL 1
#define OPENNTC_ADAPTER_LEVEL_BEST 2

/* Colour spaces of openntc_adapter_decode_textures(). */
#define OPENNTC_ADAPTER_SPACE_LINEAR 0
#define OPENNTC_ADAPTER_SPACE_SRGB 1
#define OPENNTC_ADAPTER_SPACE_HLG 2

/* Which texels openntc_adapter_filter() is asked for. */
#define OPENNTC_ADAPTER_FILTER_ONE 0  /* NtcStfSample: one tap */
#define OPENNTC_ADAPTER_FILTER_PAIR 1 /* NtcStfSamplePair: two, the second all 0 where its factor is 0 */
#define OPENNTC_ADAPTER_FILTER_ALL                                                                           \
    2 /* NtcStfGetTap of every index: each texel with its weight, in any order */
#define OPENNTC_ADAPTER_MOST_TAPS 2048

#define OPENNTC_ADAPTER_OK 0
#define OPENNTC_ADAPTER_NOT_SUPPORTED 1 /* counts as "not supported", not as a failure */
#define OPENNTC_ADAPTER_FAILED 2

typedef struct OpenntcAdapterSet OpenntcAdapterSet; /* yours: one opened texture set */

typedef struct OpenntcAdapterTexel {
    int32_t mip, x,
        y; /* texel coordinates of that mip; inside it without OPENNTC_ADAPTER_CAN_DECODE_OUTSIDE */
} OpenntcAdapterTexel;

/* A rectangle of a mip, and where its first texel is written in textures of textureWidth * textureHeight texels. */
typedef struct OpenntcAdapterRect {
    int32_t mip, left, top, width, height;
    int32_t destinationLeft, destinationTop, textureWidth, textureHeight;
} OpenntcAdapterRect;

/* A texture of four components: channels firstChannel ... firstChannel + channels - 1, then 0, the fourth 1. In the
 * colour spaces that are given, each channel from its own. bits: 0 for binary32, 8 or 16 for codes: the nearest ones,
 * without dither. */
typedef struct OpenntcAdapterOutput {
    int32_t firstChannel, channels, rgbColorSpace, alphaColorSpace, bits;
} OpenntcAdapterOutput;

/* The members of NtcStfSampler and NtcStfExtent. */
typedef struct OpenntcAdapterSampler {
    int32_t kernel, mips, wrapX, wrapY; /* NTC_KERNEL_*, NTC_MIPS_*, NTC_WRAP_* */
    float sigma;
    int32_t radius, maxAnisotropy, lodBias;
    int32_t width, height, levels;
} OpenntcAdapterSampler;

typedef struct OpenntcAdapterLookup {
    float uv[2], ddx[2], ddy[2]; /* coordinates, their derivatives along x and y of the screen */
    uint32_t random[4];          /* 16 bits each */
} OpenntcAdapterLookup;

typedef struct OpenntcAdapterTap {
    int32_t x, y, mip;
    float scale;
    int32_t isBorder; /* 1: outside; x and y are not looked at */
} OpenntcAdapterTap;

#ifdef __cplusplus
extern "C" {
#endif

/* OPENNTC_ADAPTER_VERSION of the header that you compiled with. */
OPENNTC_ADAPTER_EXPORT uint32_t openntc_adapter_version(void);
/* One line, for reports: engine, version, device. Valid until the library is unloaded. */
OPENNTC_ADAPTER_EXPORT const char* openntc_adapter_name(void);
OPENNTC_ADAPTER_EXPORT uint32_t openntc_adapter_capabilities(void);
/* Why the last call failed. Valid until the next call. */
OPENNTC_ADAPTER_EXPORT const char* openntc_adapter_error(void);

/* Opens a texture set from the bytes of a .ntc file, which stay valid until it is destroyed. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_create(const void* file, uint64_t bytes, OpenntcAdapterSet** set);
OPENNTC_ADAPTER_EXPORT void openntc_adapter_destroy(OpenntcAdapterSet* set);

/* Decodes `count` texels. `outputs` receives 16 floats a texel: all network outputs, not clamped, undeclared
 * channels too. `linear`: 0 for the storage colour space of each channel, 1 for linear. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_decode_texels(OpenntcAdapterSet* set, int math, int linear,
                                                         const OpenntcAdapterTexel* texels, uint32_t count,
                                                         float* outputs);

/* Decodes every texel of a mip, row by row; `texels` is width * height. Only called with
 * OPENNTC_ADAPTER_CAN_DECODE_MIP; without it the suite asks for the same texels as a list. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_decode_mip(OpenntcAdapterSet* set, int math, int linear, int mip,
                                                      uint32_t texels, float* outputs);

/* Decodes a rectangle of a mip, row by row, from the latents of that rectangle alone if the engine streams them so.
 * Texels are those of the whole mip. The rectangle lies inside it. Only called with OPENNTC_ADAPTER_CAN_DECODE_SLICE. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_decode_slice(OpenntcAdapterSet* set, int math, int linear, int mip,
                                                        int32_t left, int32_t top, int32_t width,
                                                        int32_t height, float* outputs);

/* Decodes a slice of several mips: a rectangle of mip `firstMip`, in texels of it, and what lies below it in the next
 * mips, `mips` of them in all. Of mip firstMip + k these are the texels left >> k up to ceil((left + width) / 2^k) - 1
 * across and likewise down, as far as the mip has them: none where the mip ends before. Outputs are mip by mip from
 * firstMip on, each row by row; `texels` says of how many. Only called with OPENNTC_ADAPTER_CAN_DECODE_SLICE_MIPS. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_decode_slice_mips(OpenntcAdapterSet* set, int math, int linear,
                                                             int firstMip, int mips, int32_t left,
                                                             int32_t top, int32_t width, int32_t height,
                                                             uint32_t texels, float* outputs);

/* Compresses a picture with OpenNTC's block encoders, as the engine has compiled them: CompressBlocks.comp or bc/ as C++.
 * `texels`: width * height texels of four channels, R first, rows one after the other: unsigned bytes, signed ones for the
 * signed forms of BC4 and BC5, for BC6 binary16. Beyond the edge texels repeat. `alphaThreshold`: of BC1, alpha at most
 * this is transparent; -1: nothing is. `blocks` receives the blocks, row by row. Every bit is compared. No set need be
 * there. Only called with OPENNTC_ADAPTER_CAN_ENCODE_BLOCKS. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_encode_blocks(int format, int level, int alphaThreshold,
                                                         const void* texels, uint32_t width, uint32_t height,
                                                         void* blocks);

/* Writes a rectangle of a mip into `count` textures, 1 to 16, as DecompressToTextures does. texels[n] is texture n:
 * rows one after the other, little-endian components, all 0 before: what lies outside the rectangle stays so. The
 * rectangle lies inside the mip and, at its destination, inside the textures. Only called with
 * OPENNTC_ADAPTER_CAN_DECODE_TEXTURES. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_decode_textures(OpenntcAdapterSet* set, int math,
                                                           const OpenntcAdapterRect* rect,
                                                           const OpenntcAdapterOutput* outputs,
                                                           uint32_t count, void* const* texels);

/* Which texels a lookup reads, by StochasticFiltering.h as the engine has compiled it. `taps` has room for
 * OPENNTC_ADAPTER_MOST_TAPS; `count` receives how many were written. Every bit is compared, weights of Gaussians within
 * 1e-5. No set need be there. Only called with OPENNTC_ADAPTER_CAN_FILTER. */
OPENNTC_ADAPTER_EXPORT int openntc_adapter_filter(const OpenntcAdapterSampler* sampler, int way,
                                                  const OpenntcAdapterLookup* lookup, OpenntcAdapterTap* taps,
                                                  uint32_t* count);

#ifdef __cplusplus
}
#endif

#endif
