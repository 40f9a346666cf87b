// SPDX-License-Identifier: MIT
// The engine's own descriptor set and binding numbers for latents and weights, at offsets in buffers of
// many sets.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NTC_DESCRIPTOR_SET 2
#define NTC_LATENTS_BINDING 7
#define NTC_WEIGHTS_BINDING 9
#include "openntc/Inference.h"

layout(local_size_x = 64) in;
layout(set = 3, binding = 5, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 1, std430) writeonly buffer Results {
    float outputs[];
} gResults;
layout(push_constant) uniform Push {
    int width;
    int height;
    int mipLevel;
    uint latentsOffset;
    uint weightsOffset;
} gPush;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= gPush.width * gPush.height)
        return;
    float outputs[NTC_MAX_CHANNELS];
    int2 texel = int2(index % gPush.width, index / gPush.width);
    if (NtcSampleTextureSet(desc, NTC_LATENTS, gPush.latentsOffset, NTC_WEIGHTS, gPush.weightsOffset, texel,
                            gPush.mipLevel, false, outputs)) {
        NTC_LOOP for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            gResults.outputs[NTC_MAX_CHANNELS * index + c] = outputs[c];
    }
}
