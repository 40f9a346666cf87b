// SPDX-License-Identifier: MIT
// The pass that bench_gpu times: 8x8 invocations decode (8 * NTC_TEXELS_PER_INVOCATION) x 8 texels of mip 0 to a buffer,
// 16 binary16 numbers per texel (BENCH_RESULT_BITS=16) or 16 binary32 numbers (32, for comparison).
// BENCH_LINEAR: true decodes to linear light. BENCH_STAGE: 0 all; 1 the network's inputs
// alone, 2 the network alone (inputs made up from the position), 3 all, but not compared (bench_gpu), 4 all, for the table
// of pipelines only (bench_gpu).
#version 460
#extension GL_GOOGLE_include_directive : require
#ifndef BENCH_STAGE
#define BENCH_STAGE 0
#endif
#ifndef BENCH_LINEAR
#define BENCH_LINEAR false
#endif
#include "openntc/Inference.h"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
#if BENCH_RESULT_BITS == 16
#define BENCH_VECTORS 2u
#else
#define BENCH_VECTORS 4u
#endif
layout(set = 0, binding = 3, std430) writeonly buffer Results {
    uvec4 results[];
} gResults;
layout(push_constant) uniform BenchPush {
    uint width; // texels, a multiple of 8 NTC_TEXELS_PER_INVOCATION
} gPush;

#define T NTC_TEXELS_PER_INVOCATION

void main() {
    uvec2 first = uvec2(gl_WorkGroupID.x * (8u * uint(T)) + gl_LocalInvocationID.x, gl_GlobalInvocationID.y);
    float outputs[16 * T];
    NTC_UNROLL for (uint n = 0u; n < 16u * uint(T); n++) outputs[n] = 0.0;
#if BENCH_STAGE == 1
    uint inputs[NTC_MAX_INPUT_WORDS];
    NTC_UNROLL for (uint n = 0u; n < uint(NTC_MAX_INPUT_WORDS); n++) inputs[n] = 0u;
    NtcPrepareNetworkInputs(desc, NTC_LATENTS, 0u, int2(first), 0, inputs);
    NTC_UNROLL for (uint n = 0u; n < uint(NTC_MAX_INPUT_WORDS); n++) outputs[n & 15u] += float(inputs[n]);
#elif BENCH_STAGE == 2 && NTC_MATH == NTC_MATH_COOPVEC_INT8
    uint inputs[NTC_MAX_INPUT_WORDS];
    NTC_UNROLL for (uint n = 0u; n < uint(NTC_MAX_INPUT_WORDS); n++) inputs[n] = first.x * 0x9E3779B9u + first.y * n;
    NtcEvaluateInt8CoopVec(0u, NtcMakeLayerOffsets(desc.networkWeightOffset0, desc.networkWeightOffset1,
                                                   desc.networkWeightOffset2, desc.networkWeightOffset3,
                                                   desc.networkScaleBiasOffset), inputs, outputs);
#elif T > 1
    int2 texels[T];
    NTC_UNROLL for (uint t = 0u; t < uint(T); t++) texels[t] = int2(first) + int2(8u * t, 0);
    NtcSampleTextureSetTexels(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texels, 0, BENCH_LINEAR, outputs);
#else
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, int2(first), 0, BENCH_LINEAR, outputs);
#endif
    NTC_UNROLL for (uint t = 0u; t < uint(T); t++) {
        uint at = (first.y * gPush.width + first.x + 8u * t) * BENCH_VECTORS;
        NTC_UNROLL for (uint v = 0u; v < BENCH_VECTORS; v++) {
            uvec4 packed;
            NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
#if BENCH_RESULT_BITS == 16
                uint c = 16u * t + 8u * v + 2u * k;
                packed[k] = packHalf2x16(vec2(outputs[c], outputs[c + 1u]));
#else
                packed[k] = floatBitsToUint(outputs[16u * t + 4u * v + k]);
#endif
            }
            gResults.results[at + v] = packed;
        }
    }
}
