// SPDX-License-Identifier: MIT
// A compute shader with every switch: NTC_TEXELS_PER_INVOCATION texels of mip 0 or 1 per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    float outputs[];
} gResults;

#define T NTC_TEXELS_PER_INVOCATION

void main() {
    bool isLinear = (gl_GlobalInvocationID.z & 1u) != 0u;
    uint first = gl_GlobalInvocationID.x * uint(T);
    float outputs[16 * T];
    for (uint i = 0u; i < 16u * uint(T); i++)
        outputs[i] = 0.0;
#if T > 1
    int2 texels[T];
    for (uint t = 0u; t < uint(T); t++)
        texels[t] = int2(int(first + t), int(gl_GlobalInvocationID.y));
    NtcSampleTextureSetTexels(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texels, int(gl_GlobalInvocationID.z >> 1), isLinear, outputs);
#else
    int2 texel = int2(int(first), int(gl_GlobalInvocationID.y));
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, int(gl_GlobalInvocationID.z >> 1), isLinear, outputs);
#endif
    for (uint n = 0u; n < 16u * uint(T); n++)
        gResults.outputs[16u * first + n] = outputs[n];
}
