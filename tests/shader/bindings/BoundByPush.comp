// SPDX-License-Identifier: MIT
// The 160 bytes of constants that a set with one mip needs, in push constants (UNIFORM_CONSTANTS=0) or, for devices with
// fewer of them, in a small uniform buffer (1); latents and weights at the default bindings.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NTC_SINGLE_MIP 1
#include "openntc/Inference.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    float outputs[];
} gResults;
#if UNIFORM_CONSTANTS
layout(set = 0, binding = 0, std140) uniform Constants {
    NtcSingleMipConstants desc;
};
#define DESC desc
#else
#define DESC gPush.desc
#endif
layout(push_constant) uniform Push {
    int width;
    int height;
    int padding0;
    int padding1;
#if !UNIFORM_CONSTANTS
    NtcSingleMipConstants desc;
#endif
} gPush;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= gPush.width * gPush.height)
        return;
    float outputs[NTC_MAX_CHANNELS];
    int2 texel = int2(index % gPush.width, index / gPush.width);
    if (NtcSampleTextureSet(DESC, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, 0, false, outputs)) {
        NTC_LOOP for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            gResults.outputs[NTC_MAX_CHANNELS * index + c] = outputs[c];
    }
}
