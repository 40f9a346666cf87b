// SPDX-License-Identifier: MIT
// Compute pass: the HLSL twin of CompressBlocks.comp, same permutations, resources and results. Entry point
// main. Registers: t0 source, u1 destination, t2 hints; in SPIR-V bindings 0 to 2 of set 0.
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

#if NTC_BC_SOURCE == NTC_BC_IMAGE
[[vk::binding(0, 0)]] Texture2D<float4> gSource : register(t0);
#else
[[vk::binding(0, 0)]] ByteAddressBuffer gSource : register(t0);
#endif
#if NTC_BC_TARGET == NTC_BC_IMAGE
#if NTC_BC_WORDS == 2
[[vk::binding(1, 0)]] RWTexture2D<uint2> gBlocks : register(u1);
#else
[[vk::binding(1, 0)]] RWTexture2D<uint4> gBlocks : register(u1);
#endif
#else
[[vk::binding(1, 0)]] RWByteAddressBuffer gBlocks : register(u1);
#endif
#if NTC_BC_HINTS
[[vk::binding(2, 0)]] ByteAddressBuffer gHints : register(t2);
#endif
[[vk::push_constant]] ConstantBuffer<NtcCompressBlocksConstants> gPush;

[numthreads(NTC_COMPRESS_BLOCKS_GROUP, NTC_COMPRESS_BLOCKS_GROUP, 1)] void main(uint3 id : SV_DispatchThreadID) {
    uint2 block = id.xy;
    if (block.x >= uint(gPush.width + 3) / 4u || block.y >= uint(gPush.height + 3) / 4u)
        return;
    NtcBlockTexels texels;
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        int x = gPush.left + min(int(block.x) * 4 + t % 4, gPush.width - 1);
        int y = gPush.top + min(int(block.y) * 4 + t / 4, gPush.height - 1);
#if NTC_BC_SOURCE == NTC_BC_IMAGE
        float4 texel = gSource.Load(int3(x, y, gPush.sourceMip));
        texels.red[t] = NtcGetTexelNumber(texel.x);
        texels.green[t] = NtcGetTexelNumber(texel.y);
        texels.blue[t] = NtcGetTexelNumber(texel.z);
        texels.alpha[t] = NtcGetTexelNumber(texel.w);
#else
        uint word = gPush.sourceWord + uint(y) * gPush.sourceRowWords + uint(x * NTC_BC_TEXEL_WORDS);
        uint first = gSource.Load(4u * word);
#if NTC_BC_TEXEL_WORDS == 2
        uint second = gSource.Load(4u * word + 4u);
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
    hint = int(gHints.Load(4u * (gPush.hintWord + block.y * gPush.hintRowWords + block.x)));
#endif
    uint4 words = NtcEncodeBlock(texels, gPush.alphaThreshold, int(gPush.allowedModes), hint);
#if NTC_BC_TARGET == NTC_BC_IMAGE
    uint2 to = block + uint2(gPush.destinationLeft, gPush.destinationTop);
#if NTC_BC_WORDS == 2
    gBlocks[to] = words.xy;
#else
    gBlocks[to] = words;
#endif
#else
    uint to = gPush.destinationWord + block.y * gPush.destinationRowWords + block.x * uint(NTC_BC_WORDS);
#if NTC_BC_WORDS == 2
    gBlocks.Store2(4u * to, words.xy);
#else
    gBlocks.Store4(4u * to, words);
#endif
#endif
}
