// SPDX-License-Identifier: MIT
// The HLSL twin of Streaming.comp.
[[vk::binding(1, 0)]] ByteAddressBuffer gLatents : register(t1);
[[vk::binding(2, 0)]] ByteAddressBuffer gWeights : register(t2);
[[vk::binding(5, 0)]] ByteAddressBuffer gResidency : register(t5);
#define NtcResidencyLoad(context, word) gResidency.Load(4u * (word))
#define NTC_DEMAND_LATENTS gLatents
#define NTC_DEMAND_WEIGHTS gWeights
#include "support/streaming/StreamingCases.h"

[[vk::binding(0, 0)]] cbuffer Launch : register(b0) {
    NtcStreamingConstants gLaunch;
};
[[vk::binding(3, 0)]] StructuredBuffer<StreamingItem> gItems : register(t3);
[[vk::binding(4, 0)]] RWByteAddressBuffer gResults : register(u4);
struct Push {
    uint count;
};
[[vk::push_constant]] ConstantBuffer<Push> gPush;

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    if (id.x >= gPush.count)
        return;
    StreamingItem item = gItems[id.x];
    uint r[CASE_WORDS];
    RunStreamingItem(NtcMakeStreamingContext(gLaunch, item.seed), item, r);
    for (uint k = 0u; k < uint(CASE_WORDS); k++)
        gResults.Store(4u * (uint(CASE_WORDS) * id.x + k), r[k]);
}
