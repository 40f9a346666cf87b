// SPDX-License-Identifier: MIT
// Demand-loaded textures: a filtered sample of a tiled texture, ordinary images and texture sets alike, that
// requests what it misses and makes do with coarser mips meanwhile.
//
//   bool resident;
//   float4 color = NtcDemandGrad(context, id, uv, ddx, ddy, resident);
//
// Texture sets need NETWORK_VERSION (that of all of them), their constants as NtcDemandSet(index), and
// latents and weights as NTC_DEMAND_LATENTS and NTC_DEMAND_WEIGHTS, which are NTC_LATENTS and NTC_WEIGHTS of
// Buffers.h unless defined (in HLSL, or where NtcBufferLoad is the engine's, they must be:
// ByteAddressBuffers or NtcBuffers). NtcDemandSet is an array of
// NtcTextureSetConstants declared at NTC_TEXTURE_SETS_BINDING (4) of NTC_STREAMING_SET, register
// NTC_TEXTURE_SETS_REGISTER (t18), unless the macro is defined. Every tap of a filter is a decoded texel:
// 4 for bilinear, 8 for trilinear, times the anisotropic taps; NTC_FILTER_POINT is one.
// Without these only images are read, and a texture set is not resident.
#ifndef OPENNTC_STREAMING_DEMAND_H
#define OPENNTC_STREAMING_DEMAND_H

#include "PageTable.h"
#include "TileTexels.h"
#include "openntc/Portability.h"

#ifndef NTC_TEXTURE_SETS_BINDING
#define NTC_TEXTURE_SETS_BINDING 4
#endif
#ifndef NTC_TEXTURE_SETS_REGISTER
#define NTC_TEXTURE_SETS_REGISTER t18
#endif

#if defined(__cplusplus)
#define NTC_WITH_DEMAND_SETS 1
#elif !defined(NETWORK_VERSION)
#define NTC_WITH_DEMAND_SETS 0
#elif (defined(NTC_HLSL) || defined(NTC_OWN_BUFFER_LOAD)) && !defined(NTC_DEMAND_LATENTS)
#define NTC_WITH_DEMAND_SETS 0
#else
#define NTC_WITH_DEMAND_SETS 1
#endif

#if defined(__cplusplus)
namespace openntc::shader {

/// What NtcStreamingMemory::textureSets points to.
struct NtcDemandSets {
    int networkVersion;
    int math;
    const NtcTextureSetConstants* sets;
    NtcBuffer latents;
    NtcBuffer weights;
};

inline bool NtcFetchSetOutputs(const NtcStreamingContext& context, const NtcTextureHeader& header, uint index,
                               uint weightsOffset, bool convertToLinear, int2 texel, int mip,
                               NTC_INOUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    const NtcDemandSets* const sets = static_cast<const NtcDemandSets*>(context.memory->textureSets);
    if (sets == nullptr)
        return false;
    const NtcTextureSetConstants& desc = sets->sets[index];
    const NtcMip patched = NtcPatchMip(NtcGetMip(desc, mip), NtcLoadSlice(context, header, texel, mip));
    return NtcSampleMip(sets->networkVersion, sets->math, patched, sets->latents, 0u, sets->weights,
                        weightsOffset, NtcGetLayerOffsets(desc), desc.channelColorSpaces, texel,
                        convertToLinear, outputs);
}

} // namespace openntc::shader
#elif NTC_WITH_DEMAND_SETS
#if !defined(NtcDemandSet)
#if defined(NTC_HLSL)
[[vk::binding(NTC_TEXTURE_SETS_BINDING, NTC_STREAMING_SET)]] StructuredBuffer<NtcTextureSetConstants>
    ntcTextureSets : register(NTC_TEXTURE_SETS_REGISTER);
#define NtcDemandSet(index) ntcTextureSets[index]
#else
layout(set = NTC_STREAMING_SET, binding = NTC_TEXTURE_SETS_BINDING,
       std430) readonly buffer NtcTextureSetsBlock {
    NtcTextureSetConstants sets[];
}
ntcTextureSets;
#define NtcDemandSet(index) ntcTextureSets.sets[index]
#endif
#endif
#if !defined(NTC_DEMAND_LATENTS)
#define NTC_DEMAND_LATENTS NTC_LATENTS
#define NTC_DEMAND_WEIGHTS NTC_WEIGHTS
#endif

bool NtcFetchSetOutputs(NtcStreamingContext context, NtcTextureHeader header, uint index, uint weightsOffset,
                        bool convertToLinear, int2 texel, int mip,
                        NTC_INOUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    return NtcSampleMip(
        NETWORK_VERSION, NTC_MATH,
        NtcPatchMip(NtcGetMip(NtcDemandSet(index), mip), NtcLoadSlice(context, header, texel, mip)),
        NTC_DEMAND_LATENTS, 0u, NTC_DEMAND_WEIGHTS, weightsOffset, NtcGetLayerOffsets(NtcDemandSet(index)),
        NtcDemandSet(index).channelColorSpaces, texel, convertToLinear, outputs);
}
#endif

NTC_NAMESPACE_BEGIN

/// A texel of a mip, inside it, whose tile is there.
NTC_FUNCTION float4 NtcFetchTiledTexel(NtcStreamingContext context, NtcTextureHeader header, int2 texel,
                                       int mip) {
#if NTC_WITH_DEMAND_SETS
    if (header.format == uint(NTC_TILES_TEXTURE_SET)) {
        float outputs[NTC_MAX_CHANNELS];
        NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) outputs[c] = 0.0f;
        uint channels = NtcPageTableLoad(context, header.word + NTC_HEADER_CHANNELS);
        NtcFetchSetOutputs(context, header, NtcPageTableLoad(context, header.word + NTC_HEADER_TEXTURE_SET),
                           NtcPageTableLoad(context, header.word + NTC_HEADER_WEIGHTS_OFFSET),
                           (channels & 256u) != 0u, texel, mip, outputs);
        uint first = uint(min(int(channels & 255u), NTC_MAX_CHANNELS - 4));
        return float4(outputs[first], outputs[first + 1u], outputs[first + 2u], outputs[first + 3u]);
    }
#endif
    return NtcFetchImageTexel(context, header, texel, mip);
}

/// Four taps of one mip: texels left ... right x top ... bottom, addressed, and how far between them the
/// sample lies, 0 ... 65535. Taps without weight are not read.
struct NtcTaps {
    int2 leftTop;
    int2 rightBottom;
    uint fractionX;
    uint fractionY;
};

NTC_FUNCTION NtcTaps NtcGetTaps(NtcTextureHeader header, float2 uv, int mip) {
    int width = int(NtcGetTiledMipSize(header.width, mip));
    int height = int(NtcGetTiledMipSize(header.height, mip));
    uint wrapU = (header.sampling >> 4) & 15u;
    uint wrapV = (header.sampling >> 8) & 15u;
    NtcTexelCoord x = NtcGetTexelCoord(uv.x, uint(width), wrapU);
    NtcTexelCoord y = NtcGetTexelCoord(uv.y, uint(height), wrapV);
    if ((header.sampling & 15u) == uint(NTC_FILTER_POINT)) {
        x.fraction = 0u;
        y.fraction = 0u;
    } else {
        x = NtcGetBilinearCoord(x);
        y = NtcGetBilinearCoord(y);
    }
    NtcTaps taps;
    taps.leftTop = int2(NtcAddressTexel(x.texel, width, wrapU), NtcAddressTexel(y.texel, height, wrapV));
    taps.rightBottom =
        int2(NtcAddressTexel(x.texel + 1, width, wrapU), NtcAddressTexel(y.texel + 1, height, wrapV));
    taps.fractionX = x.fraction;
    taps.fractionY = y.fraction;
    return taps;
}

/// Texel of tap 0 ... 3.
NTC_FUNCTION int2 NtcGetTapTexel(NtcTaps taps, uint tap) {
    return int2((tap & 1u) != 0u ? taps.rightBottom.x : taps.leftTop.x,
                (tap & 2u) != 0u ? taps.rightBottom.y : taps.leftTop.y);
}

/// Its weight; products of two exact 16-bit fractions, rounded once.
NTC_FUNCTION float NtcGetTapWeight(NtcTaps taps, uint tap) {
    uint x = (tap & 1u) != 0u ? taps.fractionX : 65536u - taps.fractionX;
    uint y = (tap & 2u) != 0u ? taps.fractionY : 65536u - taps.fractionY;
    return NtcMultiply(float(x) * 1.52587890625e-5f, float(y) * 1.52587890625e-5f);
}

/// a b + c, rounded twice.
NTC_FUNCTION float4 NtcAddScaled(float4 sum, float4 color, float weight) {
    NTC_PRECISE float x = sum.x + NtcMultiply(color.x, weight);
    NTC_PRECISE float y = sum.y + NtcMultiply(color.y, weight);
    NTC_PRECISE float z = sum.z + NtcMultiply(color.z, weight);
    NTC_PRECISE float w = sum.w + NtcMultiply(color.w, weight);
    return float4(x, y, z, w);
}

/// Point or bilinear, of a mip or the finest coarser one that is there in all its taps. sampledMip is that,
/// or -1. Requests every missing tile of `mip`.
NTC_FUNCTION float4 NtcDemandMip(NtcStreamingContext context, uint textureId, NtcTextureHeader header,
                                 float2 uv, int mip, NTC_OUT(int, sampledMip)) {
    sampledMip = -1;
    float4 color = float4(0.0f, 0.0f, 0.0f, 0.0f);
    int candidate = mip;
#if NTC_TILE_FALLBACK
    NTC_LOOP while (candidate < header.mips && sampledMip < 0)
#endif
    {
        NtcTaps taps = NtcGetTaps(header, uv, candidate);
        bool complete = true;
        NTC_LOOP for (uint tap = 0u; tap < 4u; tap++) {
            if (NtcGetTapWeight(taps, tap) > 0.0f) { // nested: && of HLSL evaluates both sides
                if (!NtcUseTexel(context, textureId, header, NtcGetTapTexel(taps, tap), candidate,
                                 candidate == mip))
                    complete = false;
            }
        }
        if (complete) {
            sampledMip = candidate;
            NTC_LOOP for (uint read = 0u; read < 4u; read++) {
                float weight = NtcGetTapWeight(taps, read);
                if (weight > 0.0f)
                    color = NtcAddScaled(
                        color, NtcFetchTiledTexel(context, header, NtcGetTapTexel(taps, read), candidate),
                        weight);
            }
        }
#if NTC_TILE_FALLBACK
        candidate = NtcGetNextMip(context, header, candidate);
#endif
    }
    return color;
}

/// Samples with the texture's filter, wrap modes, bias and anisotropy. resident: everything that the sample
/// reads was there. sampledMip: the coarsest mip that was read in its place, the wanted one (trilinear: the
/// coarser of the two) if nothing was missing; -1: somewhere nothing was there, which then counts as 0.
NTC_FUNCTION float4 NtcDemandGradMip(NtcStreamingContext context, uint textureId, float2 uv, float2 ddx,
                                     float2 ddy, NTC_OUT(bool, resident), NTC_OUT(int, sampledMip)) {
    float4 color = float4(0.0f, 0.0f, 0.0f, 0.0f);
    resident = false;
    sampledMip = -1;
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    if (header.mips == 0)
        return color;
#if !NTC_WITH_DEMAND_SETS
    if (header.format == uint(NTC_TILES_TEXTURE_SET))
        return color;
#endif
    NtcSampleShape shape =
        NtcGetSampleShape(header.width, header.height, header.sampling, header.mipBias, ddx, ddy);
    float lod = NtcClampLod(shape.lod, header.mips);
    int fine = min(int(floor(lod + 0.5f)), header.mips - 1);
    float between = 0.0f;
    if ((header.sampling & 15u) == uint(NTC_FILTER_TRILINEAR)) {
        fine = int(floor(lod));
        between = lod - float(fine); // exact
    }
    int coarse = between > 0.0f ? fine + 1 : fine;
    resident = true;
    int lowest = 0;
    bool isEmpty = false;
    NTC_LOOP for (int mip = fine; mip <= coarse; mip++) {
        float weight = mip == fine ? 1.0f - between : between;
        weight = NtcMultiply(NtcKeep(weight), NtcGetReciprocal(shape.taps));
        NTC_LOOP for (uint tap = 0u; tap < shape.taps; tap++) {
            float place = NtcGetTapPlace(tap, shape.taps);
            NTC_PRECISE float u = uv.x + NtcMultiply(shape.axis.x, place);
            NTC_PRECISE float v = uv.y + NtcMultiply(shape.axis.y, place);
            int used = -1;
            float4 part = NtcDemandMip(context, textureId, header, float2(u, v), mip, used);
            color = NtcAddScaled(color, part, weight);
            resident = resident && used == mip;
            isEmpty = isEmpty || used < 0;
            lowest = max(lowest, used);
        }
    }
    sampledMip = isEmpty ? -1 : lowest;
    return color;
}

/// NtcDemandGradMip without the mip.
NTC_FUNCTION float4 NtcDemandGrad(NtcStreamingContext context, uint textureId, float2 uv, float2 ddx,
                                  float2 ddy, NTC_OUT(bool, resident)) {
    int sampledMip = -1;
    return NtcDemandGradMip(context, textureId, uv, ddx, ddy, resident, sampledMip);
}

NTC_NAMESPACE_END

#endif
