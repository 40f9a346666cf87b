// SPDX-License-Identifier: MIT
// Compute pass: decodes a rectangle of mip 0 on cooperative matrices to a storage buffer, 16 channels a
// texel, texels row by row. A subgroup decodes blocks of 8 x 4 texels, one after the other.
//
// Set 0: 0 NtcTextureSetConstants (uniform), 1 latents, 2 weights (inference/CooperativeMatrices.h), 3
// results: binary16 numbers, 32 bytes a texel, or with NTC_RESULT_BITS=32 binary32 numbers, 64 bytes. Push
// constants: NtcDecodeBlocksConstants. Any number of workgroups along x; one or two a multiprocessor are
// good. Switches: NetworkCoopMat.h; NETWORK_VERSION, NTC_MATH (INT8 or INT8_HALF) as everywhere. Needs Vulkan
// 1.3, subgroups of 32 lanes and full ones.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifndef NTC_RESULT_BITS
#define NTC_RESULT_BITS 16
#endif
#define NTC_COOPMAT_WEIGHTS gWeights.vectors
#define NtcBuffer uint
#define NtcBufferLoad(buffer, byteOffset) gLatents.words[(byteOffset) >> 2]
layout(set = 0, binding = 1, std430) readonly buffer Latents {
    uint words[];
} gLatents;
layout(set = 0, binding = 2, std430) readonly buffer Weights {
    uvec4 vectors[];
} gWeights;
#include "openntc/Inference.h"
#include "openntc/NetworkCoopMat.h"
#include "PassConstants.h"

layout(local_size_x = 32 * NTC_COOPMAT_SUBGROUPS) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
#define VECTORS uint(NTC_RESULT_BITS / 8)
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    uvec4 vectors[];
} gResults;
layout(push_constant) uniform DecodeBlocksPush {
    NtcDecodeBlocksConstants gPush;
};

void writeTexel(uint at, float outputs[NTC_MAX_CHANNELS]) {
    [[unroll]] for (uint v = 0u; v < VECTORS; v++) {
        uvec4 packedWords;
        [[unroll]] for (uint k = 0u; k < 4u; k++) {
#if NTC_RESULT_BITS == 16
            packedWords[k] = packHalf2x16(vec2(outputs[8u * v + 2u * k], outputs[8u * v + 2u * k + 1u]));
#else
            packedWords[k] = floatBitsToUint(outputs[4u * v + k]);
#endif
        }
        gResults.vectors[at + v] = packedWords;
    }
}

void main() {
    NtcLoadCoopMatWeights();
    uint across = (gPush.width + 7u) / 8u;
    uint blocks = across * ((gPush.height + 3u) / 4u);
    uint lane = NtcGetLane();
    // All lanes of a subgroup take each turn; beyond the rectangle they decode its last column or row.
    for (uint block = gl_WorkGroupID.x * uint(NTC_COOPMAT_SUBGROUPS) + NtcGetSubgroup(); block < blocks;
         block += gl_NumWorkGroups.x * uint(NTC_COOPMAT_SUBGROUPS)) {
        uvec2 place = uvec2(8u * (block % across) + (lane & 7u), 4u * (block / across) + (lane >> 3));
        uvec2 inside = min(place, uvec2(gPush.width - 1u, gPush.height - 1u));
        uint inputs[NTC_MAX_INPUT_WORDS];
        [[unroll]] for (uint i = 0u; i < uint(NTC_MAX_INPUT_WORDS); i++) inputs[i] = 0u;
        bool isPresent = NtcPrepareNetworkInputs(desc, 0u, 0u, ivec2(gPush.left, gPush.top) + ivec2(inside),
                                                 0, inputs);
        float outputs[NTC_MAX_CHANNELS];
        NtcEvaluateNetworkCoopMat(inputs, outputs);
        if (isPresent && place == inside)
            writeTexel((place.y * gPush.width + place.x) * VECTORS, outputs);
    }
}
