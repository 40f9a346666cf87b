// SPDX-License-Identifier: MIT
// The HLSL twin of Texels.frag.
#include "openntc/Inference.h"

[[vk::binding(0, 0)]] cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
[[vk::binding(1, 0)]] ByteAddressBuffer gLatents : register(t1);
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);

struct Targets {
    float4 first : SV_Target0;
    float4 second : SV_Target1;
    float4 third : SV_Target2;
    float4 fourth : SV_Target3;
};

#define T NTC_TEXELS_PER_INVOCATION

Targets main(float4 position : SV_Position, nointerpolation int mipLevel : MIP, nointerpolation uint isLinear : LINEAR) {
    int2 texel = int2(int(position.x), int(position.y));
    float outputs[16 * T];
    NTC_LOOP for (uint i = 0u; i < 16u * uint(T); i++)
        outputs[i] = 0.0f;
#if T > 1
    int2 texels[T];
    NTC_LOOP for (uint t = 0u; t < uint(T); t++)
        texels[t] = int2(texel.x + int(t), texel.y);
    NtcSampleTextureSetTexels(desc, gLatents, 0u, gWeights, 0u, texels, mipLevel, isLinear != 0u, outputs);
#else
    NtcSampleTextureSet(desc, gLatents, 0u, gWeights, 0u, texel, mipLevel, isLinear != 0u, outputs);
#endif
    Targets targets;
    targets.first = float4(outputs[0], outputs[1], outputs[2], outputs[3]);
    targets.second = float4(outputs[4], outputs[5], outputs[6], outputs[7]);
    targets.third = float4(outputs[8], outputs[9], outputs[10], outputs[11]);
    targets.fourth = float4(outputs[12], outputs[13], outputs[14], outputs[15]);
    return targets;
}
