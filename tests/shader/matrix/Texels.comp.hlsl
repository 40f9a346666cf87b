// SPDX-License-Identifier: MIT
// The HLSL twin of Texels.comp.
#include "openntc/Inference.h"

[[vk::binding(0, 0)]] cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
[[vk::binding(1, 0)]] ByteAddressBuffer gLatents : register(t1);
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);
[[vk::binding(3, 0)]] RWByteAddressBuffer gResults : register(u3);

#define T NTC_TEXELS_PER_INVOCATION

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    bool isLinear = (id.z & 1u) != 0u;
    uint first = id.x * uint(T);
    float outputs[16 * T];
    NTC_LOOP for (uint i = 0u; i < 16u * uint(T); i++)
        outputs[i] = 0.0f;
#if T > 1
    int2 texels[T];
    NTC_LOOP for (uint t = 0u; t < uint(T); t++)
        texels[t] = int2(int(first + t), int(id.y));
    NtcSampleTextureSetTexels(desc, gLatents, 0u, gWeights, 0u, texels, int(id.z >> 1), isLinear, outputs);
#else
    NtcSampleTextureSet(desc, gLatents, 0u, gWeights, 0u, int2(int(first), int(id.y)), int(id.z >> 1), isLinear, outputs);
#endif
    NTC_LOOP for (uint n = 0u; n < 16u * uint(T); n++)
        gResults.Store(4u * (16u * first + n), asuint(outputs[n]));
}
