// SPDX-License-Identifier: MIT
// Decodes a rectangle of a mip from a slice. The buffer of latents begins with rows of NtcSliceConstants; the push
// constants say which row counts. Texels without latents keep what the buffer of results held.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/streaming/Slices.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    float outputs[];
} gResults;
layout(push_constant) uniform Push {
    int left;
    int top;
    int width;
    int height;
    int mip;
    uint row;
} gPush;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= gPush.width * gPush.height)
        return;
    int2 texel = int2(gPush.left + index % gPush.width, gPush.top + index / gPush.width);
    NtcSliceConstants row = NtcLoadSliceConstants(NTC_LATENTS, 32u * gPush.row);
    float outputs[NTC_MAX_CHANNELS];
    if (NtcSampleSlice(desc, row, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, gPush.mip, false, outputs)) {
        NTC_LOOP for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            gResults.outputs[NTC_MAX_CHANNELS * index + c] = outputs[c];
    }
}
