// SPDX-License-Identifier: MIT
// The encoder of NTC_BC_FORMAT at NTC_BC_QUALITY under one name, for GLSL and HLSL.
#ifndef OPENNTC_BC_ENCODE_BLOCK_H
#define OPENNTC_BC_ENCODE_BLOCK_H

#include "openntc/bc/BlockFormats.h"
#include "openntc/bc/Quality.h"

#if !defined(NTC_BC_FORMAT)
#error NTC_BC_FORMAT is not defined: a number of bc/BlockFormats.h
#endif
#ifndef NTC_BC_QUALITY
#define NTC_BC_QUALITY NTC_BC_QUALITY_NORMAL
#endif
#if NTC_BC_QUALITY < 0 || NTC_BC_QUALITY > 2
#error NTC_BC_QUALITY must be 0 ... 2 (bc/Quality.h)
#endif

/// 32-bit words of a block.
#if NTC_BC_FORMAT == NTC_BC_BC1 || NTC_BC_FORMAT == NTC_BC_BC4_UNSIGNED || NTC_BC_FORMAT == NTC_BC_BC4_SIGNED
#define NTC_BC_WORDS 2
#else
#define NTC_BC_WORDS 4
#endif

#if NTC_BC_FORMAT <= NTC_BC_BC3
#include "openntc/bc/Bc1.h"
#include "openntc/bc/Bc4.h"
#elif NTC_BC_FORMAT <= NTC_BC_BC5_SIGNED
#include "openntc/bc/Bc4.h"
#elif NTC_BC_FORMAT == NTC_BC_BC6_UNSIGNED || NTC_BC_FORMAT == NTC_BC_BC6_SIGNED
#include "openntc/bc/Bc6.h"
#elif NTC_BC_FORMAT == NTC_BC_BC7
#include "openntc/bc/Bc7Pack.h"
#else
#error NTC_BC_FORMAT has no encoder
#endif

/// A block's texels, row by row, as encoders take them: 0 ... 255, -127 ... 127 for signed formats, for BC6H
/// the bits of halves, sign-extended.
struct NtcBlockTexels {
    int red[16];
    int green[16];
    int blue[16];
    int alpha[16];
};

/// The words of a block; formats of 8 bytes use x and y. alphaThreshold: BC1, -1 ... 255; allowedModes and
/// hint: BC7.
uint4 NtcEncodeBlock(NtcBlockTexels texels, int alphaThreshold, int allowedModes, int hint) {
    uint4 words = uint4(0u, 0u, 0u, 0u);
#if NTC_BC_FORMAT <= NTC_BC_BC3
    NtcBc1Block colors = NtcEncodeBc1(texels.red, texels.green, texels.blue, texels.alpha, alphaThreshold,
                                      NTC_BC_FORMAT == NTC_BC_BC1, NTC_BC_QUALITY);
#if NTC_BC_FORMAT == NTC_BC_BC1
    words.x = uint(colors.words[0]);
    words.y = uint(colors.words[1]);
#else
#if NTC_BC_FORMAT == NTC_BC_BC2
    NtcBc2Alpha alpha = NtcEncodeBc2Alpha(texels.alpha);
#else
    NtcBc4Block alpha = NtcEncodeBc4(texels.alpha, 255, 0, true, NTC_BC_QUALITY);
#endif
    words.x = uint(alpha.words[0]);
    words.y = uint(alpha.words[1]);
    words.z = uint(colors.words[0]);
    words.w = uint(colors.words[1]);
#endif
#elif NTC_BC_FORMAT <= NTC_BC_BC5_SIGNED
#if NTC_BC_FORMAT == NTC_BC_BC4_SIGNED || NTC_BC_FORMAT == NTC_BC_BC5_SIGNED
    NtcBc4Block block = NtcEncodeBc4(texels.red, 254, 127, false, NTC_BC_QUALITY);
#else
    NtcBc4Block block = NtcEncodeBc4(texels.red, 255, 0, false, NTC_BC_QUALITY);
#endif
    words.x = uint(block.words[0]);
    words.y = uint(block.words[1]);
#if NTC_BC_FORMAT == NTC_BC_BC5_UNSIGNED
    block = NtcEncodeBc4(texels.green, 255, 0, false, NTC_BC_QUALITY);
#elif NTC_BC_FORMAT == NTC_BC_BC5_SIGNED
    block = NtcEncodeBc4(texels.green, 254, 127, false, NTC_BC_QUALITY);
#endif
#if NTC_BC_WORDS == 4
    words.z = uint(block.words[0]);
    words.w = uint(block.words[1]);
#endif
#elif NTC_BC_FORMAT == NTC_BC_BC6_UNSIGNED || NTC_BC_FORMAT == NTC_BC_BC6_SIGNED
    bool isSigned = NTC_BC_FORMAT == NTC_BC_BC6_SIGNED;
    int halves[48];
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        halves[3 * t] = NtcBc6Input(texels.red[t], isSigned);
        halves[3 * t + 1] = NtcBc6Input(texels.green[t], isSigned);
        halves[3 * t + 2] = NtcBc6Input(texels.blue[t], isSigned);
    }
    NtcBc6Block block = NtcEncodeBc6(halves, NTC_BC_QUALITY, isSigned);
    words = uint4(uint(block.words[0]), uint(block.words[1]), uint(block.words[2]), uint(block.words[3]));
#elif NTC_BC_FORMAT == NTC_BC_BC7
    NTC_BC7_DECLARE_TEXELS(x);
    NTC_UNROLL for (int t = 0; t < 16; t++)
        NTC_BC7_SET_TEXEL(x, t, texels.red[t], texels.green[t], texels.blue[t], texels.alpha[t]);
    NtcBc7Block block = NtcEncodeBc7(x, NTC_BC_QUALITY, allowedModes, hint);
    words = uint4(block.words[0], block.words[1], block.words[2], block.words[3]);
#endif
    return words;
}

#endif
