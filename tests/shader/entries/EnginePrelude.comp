// SPDX-License-Identifier: MIT
// An engine whose own prelude gives GLSL the names of HLSL, before our headers do.
#version 460
#extension GL_GOOGLE_include_directive : require
#define int2 ivec2
#define uint4 uvec4
#define float2 vec2
#define float4 vec4
#define asuint(x) floatBitsToUint(x)
#define asfloat(x) uintBitsToFloat(x)
#include "openntc/Inference.h"

layout(local_size_x = 1) in;
layout(set = 0, binding = 0, std140) uniform Constants { NtcTextureSetConstants desc; };
layout(set = 0, binding = 3, std430) writeonly buffer Results { float gResults[]; };

void main() {
    float outputs[NTC_MAX_CHANNELS];
    if (NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, int2(0, 0), 0, true, outputs))
        gResults[0] = asfloat(asuint(outputs[0]) ^ 1u);
}
