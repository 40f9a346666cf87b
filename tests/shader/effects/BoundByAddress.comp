// SPDX-License-Identifier: MIT
// Compile test: constants, latents and weights by buffer device address, handed over in push constants.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_buffer_reference : require

layout(buffer_reference, std430, buffer_reference_align = 4) readonly buffer WordsAt {
    uint words[];
};
#define NtcBuffer WordsAt
#define NtcBufferLoad(buffer_, byteOffset) (buffer_).words[(byteOffset) >> 2]
#include "openntc/Inference.h"

layout(local_size_x = 64) in;
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer ConstantsAt {
    NtcTextureSetConstants desc;
};
layout(buffer_reference, std430, buffer_reference_align = 4) writeonly buffer ResultsAt {
    float outputs[];
};
layout(push_constant) uniform Push {
    ConstantsAt constants;
    WordsAt latents;
    WordsAt weights;
    ResultsAt results;
} gPush;

void main() {
    float outputs[NTC_MAX_CHANNELS];
    int2 texel = int2(gl_GlobalInvocationID.xy);
    if (NtcSampleTextureSet(gPush.constants.desc, gPush.latents, 0u, gPush.weights, 0u, texel, 0, false, outputs))
        gPush.results.outputs[gl_GlobalInvocationID.x] = outputs[0];
}
