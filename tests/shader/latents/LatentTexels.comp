// SPDX-License-Identifier: MIT
// What texels of a rectangle of a mip read of a texture of latents, and what becomes of it: 64 words a texel, 48 inputs (of
// byte modes 12 words) and 16 outputs.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"

layout(local_size_x = 32) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    uint words[];
}
gResults;
layout(push_constant) uniform Push {
    int left;
    int top;
    int width;
    int height;
    int mip;
}
gPush;

void main() {
    int index = int(gl_GlobalInvocationID.x);
    if (index >= gPush.width * gPush.height)
        return;
    int2 texel = int2(gPush.left + index % gPush.width, gPush.top + index / gPush.width);
    uint first = 64u * uint(index);
#if NTC_WITH_REAL_INPUTS
    float inputs[NTC_MAX_INPUTS];
    if (!NtcPrepareRealInputsFrom(NETWORK_VERSION, NTC_MATH, NtcGetMip(desc, gPush.mip), NTC_LATENTS, 0u, texel, inputs))
        return;
    for (uint i = 0u; i < 48u; i++)
        gResults.words[first + i] = asuint(inputs[i]);
#else
    uint inputs[NTC_MAX_INPUT_WORDS];
    if (!NtcPrepareNetworkInputs(desc, NTC_LATENTS, 0u, texel, gPush.mip, inputs))
        return;
    for (uint i = 0u; i < 12u; i++)
        gResults.words[first + i] = inputs[i];
#endif
    float outputs[NTC_MAX_CHANNELS];
#if NTC_MATH == NTC_MATH_FP16
    // NtcSampleTextureSet samples again, and what lies close to the middle of two halves may then become the other one (an
    // H200: 3 of 1500 texels), so that outputs would not be those of the inputs above.
    NtcEvaluateHalfNetwork(NETWORK_VERSION, NTC_WEIGHTS, 0u, NtcGetLayerOffsets(desc), inputs, outputs);
#else
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, gPush.mip, false, outputs);
#endif
    for (uint c = 0u; c < 16u; c++)
        gResults.words[first + 48u + c] = asuint(outputs[c]);
}
