// SPDX-License-Identifier: MIT
// Compute pass: compresses a rectangle of texels to blocks, one an invocation. Texels beyond the rectangle
// repeat its edge; the source is read nowhere else.
//
// Compile once per NTC_BC_FORMAT (bc/BlockFormats.h), NTC_BC_QUALITY (bc/Quality.h), NTC_BC_SOURCE and
// NTC_BC_TARGET (NTC_BC_BUFFER 0, or NTC_BC_IMAGE 1), and for BC7 NTC_BC_HINTS (0 or 1), and with
// NTC_DOT4_SPIRV on devices that have shaderIntegerDotProduct: the same blocks, faster.
// Bindings of set 0: 0 source: a buffer of texels (R8G8B8A8, four signed bytes, or four halves for BC6H), or
// a sampled image of floats; 1 destination: a buffer of blocks, or a storage image of two words (rg32ui; BC1,
// BC4) or four (rgba32ui); 2 with NTC_BC_HINTS: a buffer of hints, a word a block.
// Push constants: NtcCompressBlocksConstants. Dispatch ceil(blocks / 8) groups of each side.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/bc/EncodeBlock.h"
#include "openntc/bc/TexelNumbers.h"
#include "PassConstants.h"

#ifndef NTC_BC_SOURCE
#define NTC_BC_SOURCE NTC_BC_BUFFER
#endif
#ifndef NTC_BC_TARGET
#define NTC_BC_TARGET NTC_BC_BUFFER
#endif
#ifndef NTC_BC_HINTS
#define NTC_BC_HINTS 0
#endif

layout(local_size_x = NTC_COMPRESS_BLOCKS_GROUP, local_size_y = NTC_COMPRESS_BLOCKS_GROUP) in;

#if NTC_BC_SOURCE == NTC_BC_IMAGE
#extension GL_EXT_samplerless_texture_functions : require
layout(set = 0, binding = 0) uniform texture2D gSource;
#else
layout(set = 0, binding = 0, std430) readonly buffer Source {
    uint words[];
} gSource;
#endif
#if NTC_BC_TARGET == NTC_BC_IMAGE
#if NTC_BC_WORDS == 2
layout(set = 0, binding = 1, rg32ui) uniform writeonly uimage2D gBlocks;
#else
layout(set = 0, binding = 1, rgba32ui) uniform writeonly uimage2D gBlocks;
#endif
#else
layout(set = 0, binding = 1, std430) writeonly buffer Blocks {
    uint words[];
} gBlocks;
#endif
#if NTC_BC_HINTS
layout(set = 0, binding = 2, std430) readonly buffer Hints {
    int words[];
} gHints;
#endif
layout(push_constant) uniform CompressBlocksPush {
    NtcCompressBlocksConstants gPush;
};

void main() {
    uvec2 block = gl_GlobalInvocationID.xy;
    if (block.x >= uint(gPush.width + 3) / 4u || block.y >= uint(gPush.height + 3) / 4u)
        return;
    NtcBlockTexels texels;
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        int x = gPush.left + min(int(block.x) * 4 + t % 4, gPush.width - 1);
        int y = gPush.top + min(int(block.y) * 4 + t / 4, gPush.height - 1);
#if NTC_BC_SOURCE == NTC_BC_IMAGE
        float4 texel = texelFetch(gSource, int2(x, y), gPush.sourceMip);
        texels.red[t] = NtcGetTexelNumber(texel.x);
        texels.green[t] = NtcGetTexelNumber(texel.y);
        texels.blue[t] = NtcGetTexelNumber(texel.z);
        texels.alpha[t] = NtcGetTexelNumber(texel.w);
#else
        uint word = gPush.sourceWord + uint(y) * gPush.sourceRowWords + uint(x * NTC_BC_TEXEL_WORDS);
        uint first = gSource.words[word];
#if NTC_BC_TEXEL_WORDS == 2
        uint second = gSource.words[word + 1u];
#else
        uint second = 0u;
#endif
        texels.red[t] = NtcGetTexelNumber(first, second, 0u);
        texels.green[t] = NtcGetTexelNumber(first, second, 1u);
        texels.blue[t] = NtcGetTexelNumber(first, second, 2u);
        texels.alpha[t] = NtcGetTexelNumber(first, second, 3u);
#endif
    }
    int hint = -1;
#if NTC_BC_HINTS
    hint = gHints.words[gPush.hintWord + block.y * gPush.hintRowWords + block.x];
#endif
    uint4 words = NtcEncodeBlock(texels, gPush.alphaThreshold, int(gPush.allowedModes), hint);
#if NTC_BC_TARGET == NTC_BC_IMAGE
    imageStore(gBlocks, int2(block) + int2(gPush.destinationLeft, gPush.destinationTop), words);
#else
    uint to = gPush.destinationWord + block.y * gPush.destinationRowWords + block.x * uint(NTC_BC_WORDS);
    gBlocks.words[to] = words.x;
    gBlocks.words[to + 1u] = words.y;
#if NTC_BC_WORDS == 4
    gBlocks.words[to + 2u] = words.z;
    gBlocks.words[to + 3u] = words.w;
#endif
#endif
}
