// SPDX-License-Identifier: MIT
// Compute pass: decodes a rectangle of mip 0 on cooperative matrices to a storage buffer, 16 channels a
// texel, texels row by row. A subgroup decodes blocks of 8 x 4 texels, up to eight below one another.
//
// Set 0: 0 NtcTextureSetConstants (uniform), 1 latents, 2 weights (inference/CooperativeMatrices.h), 3
// results: binary16 numbers, 32 bytes a texel, or with NTC_RESULT_BITS=32 binary32 numbers, 64 bytes. Push
// constants: NtcDecodeBlocksConstants. Any number of workgroups along x; one or two a multiprocessor are
// good. Switches: NetworkCoopMat.h; NETWORK_VERSION, NTC_MATH (INT8 or INT8_HALF) as everywhere. Needs Vulkan
// 1.3, subgroups of 32 lanes and full ones, and subgroup shuffles.
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
#include "PassConstants.h"

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
#if NTC_RESULT_BITS == 16
#define QUAD uvec2
#else
#define QUAD uvec4
#endif
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    QUAD quads[]; // four outputs each
} gResults;
layout(push_constant) uniform DecodeBlocksPush {
    NtcDecodeBlocksConstants gPush;
};

uvec2 gBlock; // the subgroup's block: its first texel in the rectangle

// A lane writes what it has of any texel of the block: four lanes a texel, 32 bytes in one row.
void writeQuad(uint texel, uint first, vec4 four) {
    uvec2 place = gBlock + uvec2(texel & 7u, texel >> 3);
    if (place.x < gPush.width && place.y < gPush.height) {
        uint at = (place.y * gPush.width + place.x) * 4u + (first >> 2);
#if NTC_RESULT_BITS == 16
        gResults.quads[at] = uvec2(packHalf2x16(four.xy), packHalf2x16(four.zw));
#elif NTC_MATH == NTC_MATH_INT8_HALF
        gResults.quads[at] = floatBitsToUint(vec4(NtcRoundToHalf(four.x), NtcRoundToHalf(four.y),
                                                  NtcRoundToHalf(four.z), NtcRoundToHalf(four.w)));
#else
        gResults.quads[at] = floatBitsToUint(four);
#endif
    }
}
#define NTC_COOPMAT_WRITE writeQuad
#include "openntc/NetworkCoopMat.h"

layout(local_size_x = 32 * NTC_COOPMAT_SUBGROUPS) in;

NtcAxisTaps makeTaps(uint pixels, uint fraction) {
    NtcAxisTaps taps;
    taps.first = int(pixels & 0xFFFFu);
    taps.second = int(pixels >> 16);
    taps.fraction = uintBitsToFloat(fraction);
    return taps;
}
uint packTaps(NtcAxisTaps taps) {
    return uint(taps.first) | (uint(taps.second) << 16); // both are below 2^16
}

/// The axis inputs that another lane has made.
NtcAxisInputs readAxisInputs(NtcAxisInputs own, uint lane) {
    NtcAxisInputs inputs;
    inputs.highRes = makeTaps(NtcReadLane(packTaps(own.highRes), lane),
                              NtcReadLane(floatBitsToUint(own.highRes.fraction), lane));
    inputs.lowRes = makeTaps(NtcReadLane(packTaps(own.lowRes), lane),
                             NtcReadLane(floatBitsToUint(own.lowRes.fraction), lane));
    uint both = NtcReadLane(own.waves[0] | (own.waves[1] << 8), lane);
    inputs.waves[0] = both & 0x00FF00FFu;
    inputs.waves[1] = (both >> 8) & 0x00FF00FFu;
    inputs.waves[2] = NtcReadLane(own.waves[2], lane);
    return inputs;
}

void main() {
    NtcLoadCoopMatWeights();
    NtcMip mip = NtcGetMip(desc, 0);
    if (!NtcHasInputs(mip)) // alike for all
        return;
    uint across = (gPush.width + 7u) / 8u;
    uint down = (gPush.height + 3u) / 4u;
    uint subgroups = gl_NumWorkGroups.x * uint(NTC_COOPMAT_SUBGROUPS);
    // A subgroup takes up to eight blocks, one below the other: they share their columns, and a lane has made
    // one of their rows. Fewer where there would be nothing for some subgroups.
    uint turns = clamp(across * down / subgroups, 1u, 8u);
    uint strips = across * ((down + turns - 1u) / turns);
    uint lane = NtcGetLane();
    // All lanes of a subgroup take each turn; beyond the rectangle they decode its last column or row.
    for (uint strip = gl_WorkGroupID.x * uint(NTC_COOPMAT_SUBGROUPS) + NtcGetSubgroup(); strip < strips;
         strip += subgroups) {
        gBlock = uvec2(8u * (strip % across), 4u * turns * (strip / across));
        uint x = min(gBlock.x + (lane & 7u), gPush.width - 1u);
        uint y = min(gBlock.y + lane, gPush.height - 1u);
        NtcAxisInputs column = NtcMakeAxisInputs(mip, gPush.left + int(x), 0u);
        NtcAxisInputs ownRow = NtcMakeAxisInputs(mip, gPush.top + int(y), 1u);
        for (uint turn = 0u; turn < turns && gBlock.y < gPush.height; turn++) {
            NtcAxisInputs row = readAxisInputs(ownRow, 4u * turn + (lane >> 3));
            uint inputs[NTC_MAX_INPUT_WORDS];
            [[unroll]] for (uint i = 0u; i < uint(NTC_MAX_INPUT_WORDS); i++) inputs[i] = 0u;
            NtcCombineAxisInputs(NETWORK_VERSION, mip, 0u, 0u, column, row, inputs);
            NtcWriteNetworkCoopMat(inputs);
            gBlock.y += 4u;
        }
    }
}
