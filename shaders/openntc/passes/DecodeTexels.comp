// SPDX-License-Identifier: MIT
// Compute pass: decodes a rectangle of one mip to a storage buffer, 16 floats per texel, texels row by row.
//
// Bindings of set 0: 0 the 624 bytes of NtcTextureSetConstants (uniform), 1 latents, 2 weights, 3 results.
// Push constants: NtcDecodeTexelsConstants (PassConstants.h), 24 bytes. Dispatch ceil(width * height / 64)
// groups along x. Compile once per NETWORK_VERSION and NTC_MATH; with -DNTC_DOT4_SPIRV on devices that have
// shaderIntegerDotProduct. Texels of a mip whose latents are not present become 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"
#include "PassConstants.h"

layout(local_size_x = NTC_DECODE_TEXELS_GROUP) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    float outputs[];
} gResults;
layout(push_constant) uniform DecodeTexelsPush {
    NtcDecodeTexelsConstants gPush;
};

void main() {
    uint index = gl_GlobalInvocationID.x;
    if (index >= uint(gPush.width) * uint(gPush.height))
        return;
    int2 texel = int2(gPush.left + int(index % uint(gPush.width)), gPush.top + int(index / uint(gPush.width)));
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0f;
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, gPush.mipLevel, gPush.convertToLinear != 0u,
                        outputs);
    NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++)
        gResults.outputs[index * uint(NTC_MAX_CHANNELS) + c] = outputs[c];
}
