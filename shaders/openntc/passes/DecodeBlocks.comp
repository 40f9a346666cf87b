// SPDX-License-Identifier: MIT
// Compute pass: decodes a rectangle of one mip on cooperative matrices to a storage buffer, 16 channels a
// texel, texels row by row. A subgroup decodes blocks of 8 x 4 texels, up to eight below one another.
//
// Set 0: 0 NtcTextureSetConstants (uniform), 1 latents (a buffer, or a texture: openntc/LatentFetch.h), 2
// weights (inference/CooperativeMatrices.h), 3 results: binary16 numbers, 32 bytes a texel, or with
// NTC_RESULT_BITS=32 binary32 numbers, 64 bytes. Push constants: NtcDecodeBlocksConstants. Any number of
// workgroups along x; one or two a multiprocessor are good. NETWORK_VERSION; NTC_MATH: NTC_MATH_COOPMAT_INT8
// or NTC_MATH_COOPMAT_INT8_HALF; switches: NetworkCoopMat.h. Needs Vulkan 1.3, subgroups of 32 lanes and full
// ones, and subgroup shuffles. Nothing is written where the mip's latents are not present.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifndef NTC_RESULT_BITS
#define NTC_RESULT_BITS 16
#endif
#include "MatrixBuffers.h"
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

void writeQuad(uint texel, uint first, vec4 four);
#define NTC_COOPMAT_WRITE writeQuad
#include "openntc/NetworkCoopMat.h"
#define NTC_DECODE_BLOCK NtcWriteNetworkCoopMat
#include "DecodeStrips.h"

layout(local_size_x = 32 * NTC_COOPMAT_SUBGROUPS) in;

// A lane writes what it has of any texel of the block: four lanes a texel, 32 bytes in one row.
void writeQuad(uint texel, uint first, vec4 four) {
    uvec2 place = NtcGetBlockTexel(texel);
    if (place.x < gPush.width && place.y < gPush.height) {
        uint at = (place.y * gPush.width + place.x) * 4u + (first >> 2);
#if NTC_RESULT_BITS == 16
        gResults.quads[at] = uvec2(packHalf2x16(four.xy), packHalf2x16(four.zw));
#elif NTC_COOPMAT_HALF
        gResults.quads[at] = floatBitsToUint(vec4(NtcRoundToHalf(four.x), NtcRoundToHalf(four.y),
                                                  NtcRoundToHalf(four.z), NtcRoundToHalf(four.w)));
#else
        gResults.quads[at] = floatBitsToUint(four);
#endif
    }
}

void main() {
    NtcLoadCoopMatWeights();
    NtcDecodeStrips(NtcGetMip(desc, gPush.mipLevel), gPush.left, gPush.top, gPush.width, gPush.height);
}
