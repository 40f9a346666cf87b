// SPDX-License-Identifier: MIT
// Decodes a mip with NTC_TEXELS_PER_INVOCATION texels per invocation; every lane takes part to the end. What sampling
// left alone stays 77, and is 78 where it also said so.
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
layout(push_constant) uniform Push {
    uint width;
    uint height;
    int mipLevel;
    uint convertToLinear; // 0 or 1
} gPush;

#define T NTC_TEXELS_PER_INVOCATION

void main() {
    uint first = gl_GlobalInvocationID.x * uint(T);
    float outputs[16 * T];
    for (uint i = 0u; i < 16u * uint(T); i++)
        outputs[i] = 77.0;
    bool isDecoded = false;
#if T > 1
    int2 texels[T];
    for (uint t = 0u; t < uint(T); t++)
        texels[t] = int2(int((first + t) % gPush.width), int((first + t) / gPush.width));
    isDecoded = NtcSampleTextureSetTexels(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texels, gPush.mipLevel,
                                          gPush.convertToLinear != 0u, outputs);
#else
    int2 texel = int2(int(first % gPush.width), int(first / gPush.width));
    isDecoded = NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, gPush.mipLevel,
                                    gPush.convertToLinear != 0u, outputs);
#endif
    for (uint n = 0u; n < 16u * uint(T); n++) {
        if (first + n / 16u < gPush.width * gPush.height)
            gResults.outputs[16u * first + n] = isDecoded ? outputs[n] : outputs[n] + 1.0;
    }
}
