// SPDX-License-Identifier: MIT
// A screen of samples of resident images, in cells of one texture each; BENCH_FEEDBACK 1 records feedback
// too.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/streaming/Demand.h"
#include "openntc/streaming/Feedback.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, std430) writeonly buffer Results { uint colors[]; } gResults;
layout(push_constant) uniform Push {
    NtcStreamingConstants launch;
    uint size;   // pixels a side
    uint cell;   // pixels a side of what shows one texture
    float texel; // of mip 0, in texture coordinates
} gPush;

void main() {
    int2 pixel = int2(gl_GlobalInvocationID.xy);
    uint id = (uint(pixel.y) / gPush.cell) * (gPush.size / gPush.cell) + uint(pixel.x) / gPush.cell;
    // 1.5 texels of mip 0 a pixel: mips 0 and 1.
    float2 ddx = float2(1.5 * gPush.texel, 0.0);
    float2 ddy = float2(0.0, 1.5 * gPush.texel);
    float2 uv = float2(pixel) * (1.5 * gPush.texel);
    NtcStreamingContext context = NtcMakeStreamingContext(gPush.launch, NtcGetQuadSeed(pixel));
    bool resident;
    float4 color = NtcDemandGrad(context, id, uv, ddx, ddy, resident);
#if BENCH_FEEDBACK
    NtcRecordFeedback(context, id, uv, ddx, ddy);
#endif
    gResults.colors[uint(pixel.y) * gPush.size + uint(pixel.x)] = packUnorm4x8(resident ? color : float4(1.0, 0.0, 1.0, 1.0));
}
