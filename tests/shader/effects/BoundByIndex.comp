// SPDX-License-Identifier: MIT
// Compile test: bindless, an index per texture set into arrays of buffers. NON_UNIFORM_SETS: lanes differ in it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_nonuniform_qualifier : require

layout(set = 1, binding = 0, std430) readonly buffer Words {
    uint words[];
} gBuffers[];
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
} gConstants[];
layout(set = 0, binding = 0, std430) buffer Results {
    float outputs[];
} gResults;
layout(push_constant) uniform Push {
    uint textureSet;
    uint latentsOffset;
    uint weightsOffset;
} gPush;

void main() {
    uint index = gPush.textureSet;
#if NON_UNIFORM_SETS
    index += gl_GlobalInvocationID.x & 1u;
#define SET nonuniformEXT(index)
#else
#define SET index
#endif
    float outputs[NTC_MAX_CHANNELS];
    int2 texel = int2(gl_GlobalInvocationID.xy);
    if (NtcSampleTextureSet(gConstants[SET].desc, index, gPush.latentsOffset, index, gPush.weightsOffset, texel, 0,
                            false, outputs))
        gResults.outputs[gl_GlobalInvocationID.x] = outputs[0];
}
