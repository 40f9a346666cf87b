// SPDX-License-Identifier: MIT
// A rectangle of a mip to a buffer: [y][x][16] numbers, all outputs of the network. What build.mjs hands to naga, for each network.
#version 450
#extension GL_GOOGLE_include_directive : require
#define NTC_NO_LOOP_ATTRIBUTES
#define NTC_NO_PRECISE
#define NTC_OPAQUE_ZERO gPart.zero

layout(set = 0, binding = 4, std140) uniform Part {
    ivec2 origin;
    uvec2 size;
    int mip;
    uint zero; // which keeps roundings apart: WGSL has no `precise`
} gPart;
#include "openntc/Inference.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) buffer Texels {
    uint channels[];
} gTexels;

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= gPart.size.x || at.y >= gPart.size.y)
        return;
    float channels[NTC_MAX_CHANNELS];
    for (int i = 0; i < NTC_MAX_CHANNELS; i++)
        channels[i] = 0.0f;
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, gPart.origin + ivec2(at), gPart.mip, false, channels);
    uint first = (at.y * gPart.size.x + at.x) * uint(NTC_MAX_CHANNELS);
    for (int c = 0; c < NTC_MAX_CHANNELS; c++)
        gTexels.channels[first + uint(c)] = asuint(channels[c]);
}
