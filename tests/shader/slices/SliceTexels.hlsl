// SPDX-License-Identifier: MIT
// The HLSL twin of SliceTexels.comp.
#include "openntc/streaming/Slices.h"

[[vk::binding(0, 0)]] cbuffer Constants : register(b0) {
    NtcTextureSetConstants desc;
};
[[vk::binding(1, 0)]] ByteAddressBuffer gLatents : register(t1);
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);
[[vk::binding(3, 0)]] RWByteAddressBuffer gResults : register(u3);

struct Push {
    int left;
    int top;
    int width;
    int height;
    int mip;
    uint row;
};
[[vk::push_constant]] ConstantBuffer<Push> gPush;

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    int index = int(id.x);
    if (index >= gPush.width * gPush.height)
        return;
    int2 texel = int2(gPush.left + index % gPush.width, gPush.top + index / gPush.width);
    NtcSliceConstants row = NtcLoadSliceConstants(gLatents, 32u * gPush.row);
    float outputs[NTC_MAX_CHANNELS];
    NTC_LOOP for (uint i = 0u; i < uint(NTC_MAX_CHANNELS); i++)
        outputs[i] = 0.0f;
    if (NtcSampleSlice(desc, row, gLatents, 0u, gWeights, 0u, texel, gPush.mip, false, outputs)) {
        NTC_LOOP for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++)
            gResults.Store(4u * (uint(index) * uint(NTC_MAX_CHANNELS) + c), asuint(outputs[c]));
    }
}
