// SPDX-License-Identifier: MIT
// Streaming in a fragment shader: derivatives first, then samples; feedback behind `discard`.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/streaming/Demand.h"
#include "openntc/streaming/Feedback.h"

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;
layout(set = 0, binding = 0, std140) uniform Launch { NtcStreamingConstants launch; } gLaunch;

void main() {
    float2 ddx = dFdx(uv);
    float2 ddy = dFdy(uv);
    NtcStreamingContext context = NtcMakeStreamingContext(gLaunch.launch, NtcGetQuadSeed(int2(gl_FragCoord.xy)));
    bool resident;
    color = NtcDemandGrad(context, 0u, uv, ddx, ddy, resident);
    if (color.w < 0.5)
        discard;
    if (!gl_HelperInvocation)
        NtcRecordFeedback(context, 0u, uv, ddx, ddy);
}
