// SPDX-License-Identifier: MIT
// Latents in a texture, in HLSL: what NtcSampleLatents looks like there. Compiled and validated, not run.
Texture2DArray<float4> latentTexture : register(t3);
SamplerState latentSampler : register(s4);
#define NtcSampleLatents(latents, latentsOffset, uv, layer, level)                                                     \
    latentTexture.SampleLevel(latentSampler, float3(uv, float(layer)), float(level))
#include "openntc/Inference.h"

cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
ByteAddressBuffer weights : register(t2);
RWByteAddressBuffer results : register(u5);

[numthreads(32, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    float outputs[NTC_MAX_CHANNELS];
    if (NtcSampleTextureSet(desc, weights, 0u, weights, 0u, int2(id.xy), 0, false, outputs))
        results.Store4(16u * id.x, asuint(float4(outputs[0], outputs[1], outputs[2], outputs[3])));
}
