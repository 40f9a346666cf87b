// SPDX-License-Identifier: MIT
// Constants, latents, weights and results by buffer device address, handed over in push constants; no descriptor at all.
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
    int width;
    int height;
    int mipLevel;
} gPush;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= gPush.width * gPush.height)
        return;
    float outputs[NTC_MAX_CHANNELS];
    int2 texel = int2(index % gPush.width, index / gPush.width);
    if (NtcSampleTextureSet(gPush.constants.desc, gPush.latents, 0u, gPush.weights, 0u, texel, gPush.mipLevel, false,
                            outputs)) {
        NTC_LOOP for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            gPush.results.outputs[NTC_MAX_CHANNELS * index + c] = outputs[c];
    }
}
