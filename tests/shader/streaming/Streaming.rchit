// SPDX-License-Identifier: MIT
// Streaming in a closest-hit shader: a texel of a texture set, and its feedback.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_tracing : require
#include "openntc/streaming/PageTable.h"
#include "openntc/streaming/Feedback.h"

layout(location = 0) rayPayloadInEXT vec4 payload;
hitAttributeEXT vec2 barycentrics;
layout(set = 0, binding = 0, std140) uniform Launch { NtcStreamingConstants launch; } gLaunch;
layout(set = 0, binding = 3, std430) readonly buffer Sets { NtcTextureSetConstants sets[]; } gSets;

void main() {
    NtcStreamingContext context = NtcMakeStreamingContext(gLaunch.launch, NtcGetThreadSeed(gl_LaunchIDEXT.x));
    int2 texel = int2(barycentrics * 256.0);
    float outputs[NTC_MAX_CHANNELS];
    bool resident;
    int sampledMip;
    payload = vec4(0.0);
    if (NtcSampleTextureSetTiled(context, uint(gl_InstanceCustomIndexEXT), gSets.sets[gl_InstanceID], NTC_LATENTS, 0u,
                                 NTC_WEIGHTS, 0u, texel, 0, true, outputs, resident, sampledMip))
        payload = vec4(outputs[0], outputs[1], outputs[2], float(sampledMip));
    NtcRecordTexel(context, uint(gl_InstanceCustomIndexEXT), texel, 0);
}
