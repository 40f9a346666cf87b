// SPDX-License-Identifier: MIT
// DecodeTexels.comp as a language without `precise` has it: a uniform zero keeps the roundings.
#version 460
#extension GL_GOOGLE_include_directive : require

layout(set = 0, binding = 4, std140) uniform Opaque {
    uint zero;
} gOpaque;
#define NTC_NO_PRECISE 1
#define NTC_NO_LOOP_ATTRIBUTES 1
#define NTC_OPAQUE_ZERO gOpaque.zero
#include "openntc/Inference.h"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    float outputs[];
} gResults;
layout(push_constant) uniform Push {
    uint width;
    uint height;
    int mipLevel;
} gPush;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= gPush.width * gPush.height)
        return;
    int2 texel = int2(int(index % gPush.width), int(index / gPush.width));
    float outputs[NTC_MAX_CHANNELS];
    for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0;
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, gPush.mipLevel, false, outputs);
    for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++)
        gResults.outputs[index * uint(NTC_MAX_CHANNELS) + c] = outputs[c];
}
