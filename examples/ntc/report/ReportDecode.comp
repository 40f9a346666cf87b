// SPDX-License-Identifier: MIT
// The pass that `ntc report` times: 8x8 invocations decode (8 * NTC_TEXELS_PER_INVOCATION) x 8 texels of mip 0, which
// repeats over the width and height, to a buffer of 16 numbers per texel: binary16 when timed, binary32 when compared.
// REPORT_LINEAR: true decodes to linear light. REPORT_BY_INDEX: neighbouring invocations decode different sets, the first
// `sets` of those that are bound.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifndef REPORT_LINEAR
#define REPORT_LINEAR false
#endif
#ifndef REPORT_BY_INDEX
#define REPORT_BY_INDEX 0
#endif
#include "openntc/Inference.h"

layout(local_size_x = 8, local_size_y = 8) in;

#define REPORT_MAX_SETS 8
layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc[REPORT_MAX_SETS];
    uvec4 offsets[REPORT_MAX_SETS]; // bytes: latents, weights
    uvec4 extent;                   // texels, powers of two; sets
}
gSets;
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    uvec4 results[];
}
gResults;
layout(push_constant) uniform ReportPush {
    uint widthAndForm; // width in texels; bit 31: binary32
}
gPush;

#define T NTC_TEXELS_PER_INVOCATION

void main() {
    uvec2 first =
        uvec2(gl_WorkGroupID.x * (8u * uint(T)) + gl_LocalInvocationID.x, gl_GlobalInvocationID.y);
    uint width = gPush.widthAndForm & 0x7FFFFFFFu;
    float outputs[16 * T];
    NTC_UNROLL for (uint n = 0u; n < 16u * uint(T); n++) outputs[n] = 0.0;
#if REPORT_BY_INDEX
    uint index = gl_LocalInvocationIndex & (gSets.extent.z - 1u);
#else
    const uint index = 0u;
#endif
#if T > 1
    int2 texels[T];
    NTC_UNROLL for (uint t = 0u; t < uint(T); t++) texels[t] =
        int2((first + uvec2(8u * t, 0u)) & (gSets.extent.xy - 1u));
    NtcSampleTextureSetTexels(gSets.desc[index], NTC_LATENTS, gSets.offsets[index].x, NTC_WEIGHTS,
                              gSets.offsets[index].y, texels, 0, REPORT_LINEAR, outputs);
#else
    int2 texel = int2(first & (gSets.extent.xy - 1u));
    NtcSampleTextureSet(gSets.desc[index], NTC_LATENTS, gSets.offsets[index].x, NTC_WEIGHTS,
                        gSets.offsets[index].y, texel, 0, REPORT_LINEAR, outputs);
#endif
    NTC_UNROLL for (uint t = 0u; t < uint(T); t++) {
        uint texelIndex = first.y * width + first.x + 8u * t;
        if ((gPush.widthAndForm & 0x80000000u) != 0u) {
            NTC_UNROLL for (uint v = 0u; v < 4u; v++) gResults.results[4u * texelIndex + v] =
                uvec4(floatBitsToUint(outputs[16u * t + 4u * v]), floatBitsToUint(outputs[16u * t + 4u * v + 1u]),
                      floatBitsToUint(outputs[16u * t + 4u * v + 2u]),
                      floatBitsToUint(outputs[16u * t + 4u * v + 3u]));
        } else {
            NTC_UNROLL for (uint v = 0u; v < 2u; v++) {
                uvec4 packed;
                NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
                    uint c = 16u * t + 8u * v + 2u * k;
                    packed[k] = packHalf2x16(vec2(outputs[c], outputs[c + 1u]));
                }
                gResults.results[2u * texelIndex + v] = packed;
            }
        }
    }
}
