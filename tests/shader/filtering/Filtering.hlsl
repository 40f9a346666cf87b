// SPDX-License-Identifier: MIT
// The HLSL twin of Filtering.comp.
#include "support/filtering/FilterCases.h"

[[vk::binding(0, 0)]] StructuredBuffer<FilterItem> gItems : register(t0);
[[vk::binding(1, 0)]] RWByteAddressBuffer gResults : register(u1);
struct Push {
    uint count;
};
[[vk::push_constant]] ConstantBuffer<Push> gPush;

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    if (id.x >= gPush.count)
        return;
    uint r[FILTER_WORDS];
    RunFilterItem(gItems[id.x], r);
    for (uint k = 0u; k < uint(FILTER_WORDS); k++)
        gResults.Store(4u * (uint(FILTER_WORDS) * id.x + k), r[k]);
}
