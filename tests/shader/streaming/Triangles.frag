// SPDX-License-Identifier: MIT
// StreamingCases.h in a fragment shader: derivatives first, a sample, and feedback behind `discard`. What was sampled is
// written beside the results, so that the C++ build can sample the same.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(set = 0, binding = 5, std430) readonly buffer Residency { uint words[]; } gResidency;
#define NtcResidencyLoad(context, word) gResidency.words[word]
#include "support/streaming/StreamingCases.h"

layout(location = 0) in vec2 uv;
layout(set = 0, binding = 0, std140) uniform Launch { NtcStreamingConstants launch; } gLaunch;
layout(set = 0, binding = 4, std430) writeonly buffer Results { uint words[]; } gResults;
layout(push_constant) uniform Push { uint kind; uint textureId; uint width; float scale; } gPush;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float2 ddx = dFdx(uv);
    float2 ddy = dFdy(uv);
    StreamingItem item;
    item.kind = gPush.kind;
    item.textureId = gPush.textureId;
    item.u = uv.x;
    item.v = uv.y;
    item.dudx = ddx.x;
    item.dvdx = ddx.y;
    item.dudy = ddy.x;
    item.dvdy = ddy.y;
    item.a = int(floor(uv.x * 187.0));
    item.b = int(floor(uv.y * 130.0));
    item.c = 0;
    item.seed = NtcGetQuadSeed(pixel);
    NtcStreamingContext context = NtcMakeStreamingContext(gLaunch.launch, item.seed);
    uint r[CASE_WORDS];
    RunStreamingItem(context, item, r);

    uint place = uint(FRAGMENT_WORDS) * (uint(pixel.y) * gPush.width + uint(pixel.x));
    for (uint k = 0u; k < uint(CASE_WORDS); k++)
        gResults.words[place + k] = r[k];
    uint inputs[8] = uint[8](asuint(item.u), asuint(item.v), asuint(item.dudx), asuint(item.dvdx), asuint(item.dudy),
                             asuint(item.dvdy), uint(item.a), uint(item.b));
    for (uint k = 0u; k < 8u; k++)
        gResults.words[place + uint(CASE_WORDS) + k] = inputs[k];
    bool isDiscarded = (pixel.x * 5 + pixel.y * 3) % 7 == 0;
    gResults.words[place + uint(FRAGMENT_WORDS) - 1u] = isDiscarded ? 1u : 2u;
    if (isDiscarded)
        discard;
#if NTC_FEEDBACK_SUBGROUP
    if (!gl_HelperInvocation)
#endif
        NtcRecordFeedback(context, item.textureId, uv, ddx, ddy);
}
