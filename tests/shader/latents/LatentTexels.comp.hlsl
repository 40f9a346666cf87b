// SPDX-License-Identifier: MIT
// The HLSL twin of LatentTexels.comp: what NtcSampleLatents looks like there.
[[vk::binding(1, 0)]] Texture2DArray<float4> gLatentTexture : register(t1); // one combined descriptor in SPIR-V
[[vk::binding(1, 0)]] SamplerState gLatentSampler : register(s1);
#define NtcSampleLatents(latents, latentsOffset, uv, layer, level)                                                     \
    gLatentTexture.SampleLevel(gLatentSampler, float3(uv, float(layer)), float(level))
#include "openntc/Inference.h"

[[vk::binding(0, 0)]] cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);
[[vk::binding(3, 0)]] RWByteAddressBuffer gResults : register(u3);

struct Push {
    int left;
    int top;
    int width;
    int height;
    int mip;
};
[[vk::push_constant]] ConstantBuffer<Push> gPush;

[numthreads(32, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    int index = int(id.x);
    if (index >= gPush.width * gPush.height)
        return;
    int2 texel = int2(gPush.left + index % gPush.width, gPush.top + index / gPush.width);
    uint first = 64u * uint(index);
#if NTC_WITH_REAL_INPUTS
    float inputs[NTC_MAX_INPUTS];
    if (!NtcPrepareRealInputsFrom(NETWORK_VERSION, NTC_MATH, NtcGetMip(desc, gPush.mip), gWeights, 0u, texel, inputs))
        return;
    for (uint i = 0u; i < 48u; i++)
        gResults.Store(4u * (first + i), asuint(inputs[i]));
#else
    uint inputs[NTC_MAX_INPUT_WORDS];
    if (!NtcPrepareNetworkInputs(desc, gWeights, 0u, texel, gPush.mip, inputs))
        return;
    for (uint i = 0u; i < 12u; i++)
        gResults.Store(4u * (first + i), inputs[i]);
#endif
    float outputs[NTC_MAX_CHANNELS];
#if NTC_MATH == NTC_MATH_FP16
    NtcEvaluateHalfNetwork(NETWORK_VERSION, gWeights, 0u, NtcGetLayerOffsets(desc), inputs, outputs); // as in the GLSL
#else
    NtcSampleTextureSet(desc, gWeights, 0u, gWeights, 0u, texel, gPush.mip, false, outputs);
#endif
    for (uint c = 0u; c < 16u; c++)
        gResults.Store(4u * (first + 48u + c), asuint(outputs[c]));
}
