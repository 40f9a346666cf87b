// SPDX-License-Identifier: MIT
// Decodes a rectangle like DecodeTexels.comp, from any place in its buffers, and reports what sampling returned and which
// effects the shader was compiled with.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    uint words[]; // NTC_EFFECT_COUNT effects, then 17 per texel: what was returned, and the outputs
} gResults;
layout(push_constant) uniform Push {
    int left;
    int top;
    int width;
    int height;
    int mipLevel;
    uint convertToLinear; // 0 or 1
    uint latentsOffset;
    uint weightsOffset;
} gPush;

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index < uint(NTC_EFFECT_COUNT))
        gResults.words[index] = NtcGetEffect(index);
    if (index >= uint(gPush.width) * uint(gPush.height))
        return;
    int2 texel = int2(gPush.left + int(index % uint(gPush.width)), gPush.top + int(index / uint(gPush.width)));
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 77.0f;
    bool isDecoded = NtcSampleTextureSet(desc, NTC_LATENTS, gPush.latentsOffset, NTC_WEIGHTS, gPush.weightsOffset,
                                         texel, gPush.mipLevel, gPush.convertToLinear != 0u, outputs);
    uint first = uint(NTC_EFFECT_COUNT) + 17u * index;
    gResults.words[first] = isDecoded ? 1u : 0u;
    NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++)
        gResults.words[first + 1u + c] = asuint(outputs[c]);
}
