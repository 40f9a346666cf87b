// SPDX-License-Identifier: MIT
// Feedback without hardware: which mips of which parts of a texture are wanted, recorded by the shaders that
// sample it, whatever is resident.
//
// A region is a rectangle of texels of mip 0 (the tile size, TiledTexture.h), and has one word, in which bit
// m says that mip m was read in it: combined by OR, which needs no order and no other start than 0. Recorded
// are, for each mip that a filter reads, all regions that its footprint in that mip meets. Of texels in the
// tail, which is always wanted, only the region at the centre if there are more than four.
//
//   NtcRecordFeedback(context, id, uv, ddx, ddy);   // what NtcDemandGrad, or a hardware sampler, would read
//   NtcRecordLod(context, id, uv, lod);             // likewise, where the level of detail is known
//   NtcRecordTexel(context, id, texel, mip);        // one texel, for what is decoded texel by texel
//
// In a fragment shader take derivatives before any branch, and record behind `discard`. A rate below 1
// (NtcStreamingConstants::feedbackRate) records for some seeds only: whole quads with NtcGetQuadSeed.
//
// The buffer: GLSL and HLSL declare it at NTC_FEEDBACK_BINDING (2) of NTC_STREAMING_SET, register
// NTC_FEEDBACK_REGISTER (u17), unless NtcFeedbackLoad(context, word) and NtcFeedbackOr(context, word, bits)
// are defined. NTC_FEEDBACK_SUBGROUP 1 (GLSL): lanes of a subgroup with the same region make one atomic; in
// fragment shaders record under `if (!gl_HelperInvocation)` then, or a helper lane is elected and writes
// nothing.
#ifndef OPENNTC_STREAMING_FEEDBACK_H
#define OPENNTC_STREAMING_FEEDBACK_H

#include "StreamingBuffers.h"
#include "TileMaths.h"
#include "openntc/Portability.h"

#ifndef NTC_FEEDBACK_BINDING
#define NTC_FEEDBACK_BINDING 2
#endif
#ifndef NTC_FEEDBACK_REGISTER
#define NTC_FEEDBACK_REGISTER u17
#endif
#ifndef NTC_FEEDBACK_SUBGROUP
#define NTC_FEEDBACK_SUBGROUP 0
#endif
#if NTC_FEEDBACK_SUBGROUP && (defined(__cplusplus) || defined(NTC_HLSL))
#error NTC_FEEDBACK_SUBGROUP must be 0 in C++ and HLSL
#endif
#if NTC_FEEDBACK_SUBGROUP && NTC_TILE_FEEDBACK
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#endif

#if NTC_TILE_FEEDBACK

NTC_NAMESPACE_BEGIN

#if !defined(NtcFeedbackLoad)
#if defined(__cplusplus)
#define NtcFeedbackLoad(context, word) NtcLoadStreamingWord((context).memory->feedback, word)
#define NtcFeedbackOr(context, word, bits) NtcOrStreamingWord((context).memory->feedback, word, bits)
#elif defined(NTC_HLSL)
[[vk::binding(NTC_FEEDBACK_BINDING, NTC_STREAMING_SET)]] RWByteAddressBuffer ntcFeedback
    : register(NTC_FEEDBACK_REGISTER);
uint NtcOrFeedback(uint word, uint bits) {
    uint before;
    ntcFeedback.InterlockedOr(4u * word, bits, before);
    return before;
}
#define NtcFeedbackLoad(context, word) ntcFeedback.Load(4u * (word))
#define NtcFeedbackOr(context, word, bits) NtcOrFeedback(word, bits)
#else
layout(set = NTC_STREAMING_SET, binding = NTC_FEEDBACK_BINDING, std430) buffer NtcFeedbackBlock {
    uint words[];
}
ntcFeedback;
#define NtcFeedbackLoad(context, word) ntcFeedback.words[word]
#define NtcFeedbackOr(context, word, bits) atomicOr(ntcFeedback.words[word], bits)
#endif
#endif

/// Sets bits of a region's word. The read before may be stale, which only costs an atomic.
NTC_FUNCTION void NtcRecordRegion(NtcStreamingContext context, uint word, uint bits) {
#if NTC_FEEDBACK_SUBGROUP
    bool waits = true;
    while (waits) {
        uint first = subgroupBroadcastFirst(word);
        if (word == first) {
            uint all = subgroupOr(bits);
            if (subgroupElect() && (NtcFeedbackLoad(context, word) & all) != all)
                NtcFeedbackOr(context, word, all);
            waits = false;
        }
    }
#else
    if ((NtcFeedbackLoad(context, word) & bits) != bits)
        NtcFeedbackOr(context, word, bits);
#endif
}

/// The regions of a texture.
struct NtcRegions {
    uint firstWord;
    uint across;
    uint width; // texels of mip 0
    uint height;
};

NTC_FUNCTION NtcRegions NtcLoadRegions(NtcStreamingContext context, NtcTextureHeader header) {
    NtcRegions regions;
    regions.across = NtcPageTableLoad(context, header.word + NTC_HEADER_REGIONS_XY) & 0xFFFFu;
    regions.firstWord =
        context.launch.feedbackWord + NtcPageTableLoad(context, header.word + NTC_HEADER_FIRST_REGION);
    regions.width = NtcPageTableLoad(context, header.word + NTC_HEADER_REGION_WIDTH);
    regions.height = NtcPageTableLoad(context, header.word + NTC_HEADER_REGION_HEIGHT);
    return regions;
}

/// Records texels left ... right x top ... bottom of a mip, all inside it.
NTC_FUNCTION void NtcRecordTexels(NtcStreamingContext context, NtcTextureHeader header, NtcRegions regions,
                                  int2 leftTop, int2 rightBottom, int mip) {
    uint width = NtcGetTiledMipSize(header.width, mip);
    uint height = NtcGetTiledMipSize(header.height, mip);
    uint left = NtcGetFirstRegion(leftTop.x, width, header.width, regions.width);
    uint top = NtcGetFirstRegion(leftTop.y, height, header.height, regions.height);
    uint right = NtcGetLastRegion(rightBottom.x, width, header.width, regions.width);
    uint bottom = NtcGetLastRegion(rightBottom.y, height, header.height, regions.height);
    if (mip >= header.firstTailMip && (right - left + 1u) * (bottom - top + 1u) > 4u) {
        left = (left + right) / 2u;
        top = (top + bottom) / 2u;
        right = left;
        bottom = top;
    }
    NTC_LOOP for (uint y = top; y <= bottom; y++) {
        NTC_LOOP for (uint x = left; x <= right; x++)
            NtcRecordRegion(context, regions.firstWord + y * regions.across + x, 1u << uint(mip));
    }
}

/// Indices of texels of an axis that bilinear taps within `reach` texels of a coordinate read with a weight
/// above 0; both ends included, before addressing.
struct NtcTexelSpan {
    int first;
    int last;
};

NTC_FUNCTION NtcTexelSpan NtcGetTexelSpan(float u, uint size, uint wrap, bool isPoint, float reach) {
    NtcTexelCoord coord = NtcGetTexelCoord(u, size, wrap);
    NtcTexelSpan span;
    if (isPoint) {
        span.first = coord.texel;
        span.last = coord.texel;
        return span;
    }
    NtcTexelCoord bilinear = NtcGetBilinearCoord(coord);
    uint distance = 0u; // 16 bits of fraction, rounded up
    if (reach > 0.0f)
        distance = uint(NtcMultiply(reach > 32767.0f ? 32767.0f : reach, 65536.0f)) + 1u;
    uint part = distance & 0xFFFFu;
    int whole = int(distance >> 16);
    uint ahead = bilinear.fraction + part;
    span.first = bilinear.texel - whole - (bilinear.fraction < part ? 1 : 0);
    span.last = bilinear.texel + whole + int(ahead >> 16) + ((ahead & 0xFFFFu) != 0u ? 1 : 0);
    return span;
}

/// Records what a filter reads of one mip round (u, v), and as far as half the gradients.
NTC_FUNCTION void NtcRecordFootprint(NtcStreamingContext context, NtcTextureHeader header, NtcRegions regions,
                                     float2 uv, float2 gradients, int mip) {
    uint width = NtcGetTiledMipSize(header.width, mip);
    uint height = NtcGetTiledMipSize(header.height, mip);
    uint wrapU = (header.sampling >> 4) & 15u;
    uint wrapV = (header.sampling >> 8) & 15u;
    bool isPoint = (header.sampling & 15u) == uint(NTC_FILTER_POINT);
    NtcTexelSpan spanX =
        NtcGetTexelSpan(uv.x, width, wrapU, isPoint, NtcMultiply(gradients.x, float(width)) * 0.5f);
    NtcTexelSpan spanY =
        NtcGetTexelSpan(uv.y, height, wrapV, isPoint, NtcMultiply(gradients.y, float(height)) * 0.5f);
    NtcTexelRanges rangesX = NtcAddressRange(spanX.first, spanX.last, int(width), wrapU);
    NtcTexelRanges rangesY = NtcAddressRange(spanY.first, spanY.last, int(height), wrapV);
    NTC_LOOP for (uint part = 0u; part < 4u; part++) {
        int left = (part & 1u) == 0u ? rangesX.first0 : rangesX.first1;
        int right = (part & 1u) == 0u ? rangesX.last0 : rangesX.last1;
        int top = (part & 2u) == 0u ? rangesY.first0 : rangesY.first1;
        int bottom = (part & 2u) == 0u ? rangesY.last0 : rangesY.last1;
        if (right >= left && bottom >= top)
            NtcRecordTexels(context, header, regions, int2(left, top), int2(right, bottom), mip);
    }
}

NTC_FUNCTION void NtcRecordShape(NtcStreamingContext context, NtcTextureHeader header, float2 uv, float lod,
                                 float2 gradients) {
    NtcRegions regions = NtcLoadRegions(context, header);
    if (regions.across == 0u)
        return;
    float inside = NtcClampLod(lod, header.mips);
    if ((header.sampling & 15u) == uint(NTC_FILTER_TRILINEAR)) {
        int fine = int(floor(inside));
        NTC_LOOP for (int mip = fine; mip < header.mips && float(mip) < inside + 1.0f; mip++)
            NtcRecordFootprint(context, header, regions, uv, gradients, mip);
    } else {
        NtcRecordFootprint(context, header, regions, uv, gradients,
                           min(int(floor(inside + 0.5f)), header.mips - 1));
    }
}

/// Records what the texture's filter reads for these gradients, the texture's bias included.
NTC_FUNCTION void NtcRecordFeedback(NtcStreamingContext context, uint textureId, float2 uv, float2 ddx,
                                    float2 ddy) {
    if (!NtcPasses(context, context.launch.feedbackRate, 1u))
        return;
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    if (header.mips == 0)
        return;
    NtcSampleShape shape =
        NtcGetSampleShape(header.width, header.height, header.sampling, header.mipBias, ddx, ddy);
    NtcRecordShape(context, header, uv, shape.lod, shape.gradients);
}

/// The same for a level of detail, bias included. NaN is the coarsest.
NTC_FUNCTION void NtcRecordLod(NtcStreamingContext context, uint textureId, float2 uv, float lod) {
    if (!NtcPasses(context, context.launch.feedbackRate, 1u))
        return;
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    if (header.mips == 0)
        return;
    NtcRecordShape(context, header, uv, NtcIsNan(lod) ? NTC_COARSEST_LOD : lod, float2(0.0f, 0.0f));
}

/// Records one texel of a mip; texels outside are clamped, mips that do not exist ignored.
NTC_FUNCTION void NtcRecordTexel(NtcStreamingContext context, uint textureId, int2 texel, int mip) {
    if (!NtcPasses(context, context.launch.feedbackRate, 1u))
        return;
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    if (mip < 0 || mip >= header.mips)
        return;
    NtcRegions regions = NtcLoadRegions(context, header);
    if (regions.across == 0u)
        return;
    int x = min(max(texel.x, 0), int(NtcGetTiledMipSize(header.width, mip)) - 1);
    int y = min(max(texel.y, 0), int(NtcGetTiledMipSize(header.height, mip)) - 1);
    NtcRecordTexels(context, header, regions, int2(x, y), int2(x, y), mip);
}

NTC_NAMESPACE_END

#else
#define NtcRecordFeedback(context, textureId, uv, ddx, ddy)
#define NtcRecordLod(context, textureId, uv, lod)
#define NtcRecordTexel(context, textureId, texel, mip)
#endif

#endif
