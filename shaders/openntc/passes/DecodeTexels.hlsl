// SPDX-License-Identifier: MIT
// Compute pass: the HLSL twin of DecodeTexels.comp, same resources and results. Entry point main.
//
// glslangValidator: -D -S comp -e main -DNTC_HLSL=1, for vulkan1.1. DXC: -T cs_6_4 -E main -spirv. Registers
// are those of D3D: b0 constants, t1 latents, t2 weights, u3 results; in SPIR-V they are bindings 0 to 3 of
// set 0.
#include "openntc/Inference.h"
#include "PassConstants.h"

[[vk::binding(0, 0)]] cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
[[vk::binding(1, 0)]] ByteAddressBuffer gLatents : register(t1);
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);
[[vk::binding(3, 0)]] RWByteAddressBuffer gResults : register(u3);

[[vk::push_constant]] ConstantBuffer<NtcDecodeTexelsConstants> gPush;

[numthreads(NTC_DECODE_TEXELS_GROUP, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    uint index = id.x;
    if (index >= uint(gPush.width) * uint(gPush.height))
        return;
    int2 texel = int2(gPush.left + int(index % uint(gPush.width)), gPush.top + int(index / uint(gPush.width)));
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0f;
    NtcSampleTextureSet(desc, gLatents, 0u, gWeights, 0u, texel, gPush.mipLevel, gPush.convertToLinear != 0u, outputs);
    NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++)
        gResults.Store(4u * (index * uint(NTC_MAX_CHANNELS) + c), asuint(outputs[c]));
}
