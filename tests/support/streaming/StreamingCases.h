// SPDX-License-Identifier: MIT
// One call of a streaming function per item, in the common subset: shaders run it on a device, tests run the
// C++ build of the same source. Results are words.
#ifndef OPENNTC_TESTS_STREAMING_CASES_H
#define OPENNTC_TESTS_STREAMING_CASES_H

#include "openntc/streaming/Demand.h"
#include "openntc/streaming/Feedback.h"

#define CASE_DEMAND 0u
#define CASE_RECORD 1u
#define CASE_RECORD_LOD 2u
#define CASE_RECORD_TEXEL 3u
#define CASE_SET_TEXEL 4u
#define CASE_RESIDENCY 5u
#define CASE_MATHS 6u
#define CASE_PAGE 7u
#define CASE_WORDS 8

#if defined(__cplusplus)
namespace openntc {
#define CASE_FIELD_UINT std::uint32_t
#define CASE_FIELD_INT std::int32_t
#else
#define CASE_FIELD_UINT uint
#define CASE_FIELD_INT int
#endif

struct StreamingItem { // 48 bytes
    CASE_FIELD_UINT kind;
    CASE_FIELD_UINT textureId;
    float u;
    float v;
    float dudx;
    float dvdx;
    float dudy;
    float dvdy;
    CASE_FIELD_INT a;
    CASE_FIELD_INT b;
    CASE_FIELD_INT c;
    CASE_FIELD_UINT seed;
};

#if defined(__cplusplus)
}
#endif

NTC_NAMESPACE_BEGIN

#if defined(__cplusplus)
inline bool SampleSetTexel(const NtcStreamingContext& context, uint textureId, int2 texel, int mip,
                           NTC_INOUT_ARRAY(float, outputs, NTC_MAX_CHANNELS), bool& resident,
                           int& sampledMip) {
    const auto* sets = static_cast<const NtcDemandSets*>(context.memory->textureSets);
    return NtcSampleTextureSetTiled(sets->networkVersion, sets->math, context, textureId,
                                    {sets->sets, sets->latents, 0u, sets->weights, 0u}, texel, mip, false,
                                    outputs, resident, sampledMip);
}
#elif defined(NETWORK_VERSION)
bool SampleSetTexel(NtcStreamingContext context, uint textureId, int2 texel, int mip,
                    inout float outputs[NTC_MAX_CHANNELS], out bool resident, out int sampledMip) {
    return NtcSampleTextureSetTiled(context, textureId, NtcDemandSet(0), NTC_DEMAND_LATENTS, 0u,
                                    NTC_DEMAND_WEIGHTS, 0u, texel, mip, false, outputs, resident, sampledMip);
}
#endif

NTC_FUNCTION void RunStreamingItem(NtcStreamingContext context, StreamingItem item,
                                   NTC_OUT_ARRAY(uint, r, CASE_WORDS)) {
    for (int i = 0; i < CASE_WORDS; i++)
        r[i] = 0u;
    float2 uv = float2(item.u, item.v);
    float2 ddx = float2(item.dudx, item.dvdx);
    float2 ddy = float2(item.dudy, item.dvdy);
    bool resident = false;
    int sampledMip = -1;
    if (item.kind == CASE_DEMAND) {
        float4 color = NtcDemandGradMip(context, item.textureId, uv, ddx, ddy, resident, sampledMip);
        r[0] = asuint(color.x);
        r[1] = asuint(color.y);
        r[2] = asuint(color.z);
        r[3] = asuint(color.w);
    } else if (item.kind == CASE_RECORD) {
        NtcRecordFeedback(context, item.textureId, uv, ddx, ddy);
    } else if (item.kind == CASE_RECORD_LOD) {
        NtcRecordLod(context, item.textureId, uv, item.dudx);
    } else if (item.kind == CASE_RECORD_TEXEL) {
        NtcRecordTexel(context, item.textureId, int2(item.a, item.b), item.c);
#if defined(NETWORK_VERSION) || defined(__cplusplus)
    } else if (item.kind == CASE_SET_TEXEL) {
        float outputs[NTC_MAX_CHANNELS];
        for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            outputs[c] = -2.0f;
        r[6] = SampleSetTexel(context, item.textureId, int2(item.a, item.b), item.c, outputs, resident,
                              sampledMip)
                   ? 1u
                   : 0u;
        r[0] = asuint(outputs[0]);
        r[1] = asuint(outputs[1]);
        r[2] = asuint(outputs[2]);
        r[3] = asuint(outputs[3]);
        r[7] = asuint(outputs[7]);
#endif
    } else if (item.kind == CASE_RESIDENCY) {
        r[0] = NtcResidencyClamp(context, item.textureId, uv);
    } else if (item.kind == CASE_PAGE) {
        r[0] = NtcDemandPage(context, item.textureId, uint(item.a), resident);
    } else {
        uint size = uint(item.a);
        uint wrap = uint(item.b);
        NtcTexelCoord coord = NtcGetTexelCoord(item.u, size, wrap);
        NtcTexelCoord bilinear = NtcGetBilinearCoord(coord);
        NtcSampleShape shape = NtcGetSampleShape(size, size, 0x80000u, 0.25f, ddx, ddy);
        r[0] = uint(coord.texel);
        r[1] = coord.fraction;
        r[2] = uint(bilinear.texel);
        r[3] = bilinear.fraction;
        r[4] = uint(NtcAddressTexel(item.c, int(size), wrap));
        r[5] = asuint(shape.lod);
        r[6] = shape.taps;
        r[7] = asuint(NtcLog2(asfloat((asuint(item.v) & 0x7FFFFFFFu) | 0x00800000u)));
        return;
    }
    r[4] = resident ? 1u : 0u;
    r[5] = uint(sampledMip);
}

NTC_NAMESPACE_END

#endif
