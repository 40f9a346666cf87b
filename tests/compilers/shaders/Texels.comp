// SPDX-License-Identifier: MIT
// The GLSL twin of Texels.hlsl. TEXELS_OPAQUE as there.
#version 450
#extension GL_GOOGLE_include_directive : require

layout(set = 0, binding = 4, std140) uniform Texels {
    uint width;
    uint height;
    int mip;
    uint zero;
} gTexels;
#if defined(TEXELS_OPAQUE)
#define NTC_OPAQUE_ZERO gTexels.zero
#endif
#include "openntc/Inference.h"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) buffer Results {
    uint outputs[];
} gResults;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= gTexels.width * gTexels.height)
        return;
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0f;
    int2 texel = int2(int(index % gTexels.width), int(index / gTexels.width));
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, gTexels.mip, false, outputs);
    NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++)
        gResults.outputs[index * uint(NTC_MAX_CHANNELS) + c] = asuint(outputs[c]);
}
