// SPDX-License-Identifier: MIT
// The engine's own registers and spaces, at offsets in buffers of many sets: the HLSL twin of BoundByNumber.comp. The
// functions take the buffers as arguments.
#include "openntc/Inference.h"

[[vk::binding(5, 3)]] cbuffer Constants : register(b5, space3) {
    NtcTextureSetConstants desc;
};
[[vk::binding(7, 2)]] ByteAddressBuffer gLatents : register(t7, space2);
[[vk::binding(9, 2)]] ByteAddressBuffer gWeights : register(t9, space2);
[[vk::binding(1, 0)]] RWByteAddressBuffer gResults : register(u1);

struct Push {
    int width;
    int height;
    int mipLevel;
    uint latentsOffset;
    uint weightsOffset;
};
[[vk::push_constant]] ConstantBuffer<Push> gPush;

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    int index = int(id.x);
    if (index >= gPush.width * gPush.height)
        return;
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (int i = 0; i < NTC_MAX_CHANNELS; i++)
        outputs[i] = 0.0f;
    int2 texel = int2(index % gPush.width, index / gPush.width);
    if (NtcSampleTextureSet(desc, gLatents, gPush.latentsOffset, gWeights, gPush.weightsOffset, texel, gPush.mipLevel,
                            false, outputs)) {
        NTC_LOOP for (int c = 0; c < NTC_MAX_CHANNELS; c++)
            gResults.Store(4u * uint(NTC_MAX_CHANNELS * index + c), asuint(outputs[c]));
    }
}
