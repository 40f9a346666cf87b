// SPDX-License-Identifier: MIT
// Bindless: an index per texture set into arrays of buffers; a set's buffer holds its latents and its weights.
// NON_UNIFORM_SETS: every other lane decodes the next set.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require

#define SET_COUNT 3
layout(set = 1, binding = 0, std430) readonly buffer Words {
    uint words[];
} gBuffers[SET_COUNT];
#define NtcBuffer uint
#if NON_UNIFORM_SETS
#define NtcBufferLoad(buffer_, byteOffset) gBuffers[nonuniformEXT(buffer_)].words[(byteOffset) >> 2]
#else
#define NtcBufferLoad(buffer_, byteOffset) gBuffers[buffer_].words[(byteOffset) >> 2]
#endif
#include "openntc/Inference.h"

layout(local_size_x = 64) in;
layout(set = 1, binding = 1, std430) readonly buffer Constants {
    NtcTextureSetConstants desc;
} gConstants[SET_COUNT];
layout(set = 0, binding = 0, std430) writeonly buffer Results {
    float outputs[];
} gResults;
layout(push_constant) uniform Push {
    int width;
    int height;
    int mipLevel;
    uint textureSet;
    uint latentsOffset;
    uint weightsOffset;
} gPush;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= gPush.width * gPush.height)
        return;
    uint textureSet = gPush.textureSet;
#if NON_UNIFORM_SETS
    textureSet += uint(index & 1);
#define SET nonuniformEXT(textureSet)
#else
#define SET textureSet
#endif
    float outputs[NTC_MAX_CHANNELS];
    int2 texel = int2(index % gPush.width, index / gPush.width);
    if (NtcSampleTextureSet(gConstants[SET].desc, textureSet, gPush.latentsOffset, textureSet, gPush.weightsOffset,
                            texel, gPush.mipLevel, false, outputs)) {
        NTC_LOOP for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            gResults.outputs[NTC_MAX_CHANNELS * index + c] = outputs[c];
    }
}
