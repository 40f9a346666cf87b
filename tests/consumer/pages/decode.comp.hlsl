// SPDX-License-Identifier: MIT
#include "openntc/Inference.h"
ConstantBuffer<NtcTextureSetConstants> desc : register(b0);
RWTexture2D<float4> image : register(u3);

[numthreads(8, 8, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    float channels[NTC_MAX_CHANNELS];
    if (NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, int2(id.xy), 0, false, channels))
        image[id.xy] = float4(channels[0], channels[1], channels[2], 1.0);
}
