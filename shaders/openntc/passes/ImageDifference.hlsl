// SPDX-License-Identifier: MIT
// Compute pass: the HLSL twin of ImageDifference.comp, same resources and results. Entry point main.
// Registers: t0, t1 images, u2 results; in SPIR-V bindings 0 to 2 of set 0.
#include "ImageDifferenceTexel.h"

[[vk::binding(0, 0)]] Texture2D<float4> gFirst : register(t0);
[[vk::binding(1, 0)]] Texture2D<float4> gSecond : register(t1);
[[vk::binding(2, 0)]] RWByteAddressBuffer gResults : register(u2);

[[vk::push_constant]] ConstantBuffer<NtcImageDifferenceConstants> gPush;

static const uint kLanes = uint(NTC_DIFFERENCE_GROUP * NTC_DIFFERENCE_GROUP);
groupshared uint2 gSums[NTC_DIFFERENCE_GROUP * NTC_DIFFERENCE_GROUP];

[numthreads(NTC_DIFFERENCE_GROUP, NTC_DIFFERENCE_GROUP, 1)]
void main(uint3 group : SV_GroupID, uint3 local : SV_GroupThreadID, uint lane : SV_GroupIndex) {
    NtcWideSum sums[NTC_DIFFERENCE_SUMS];
    NTC_UNROLL for (int c = 0; c < NTC_DIFFERENCE_SUMS; c++) {
        sums[c].low = 0u;
        sums[c].high = 0u;
    }
    // Texels of an invocation lie a group apart, so that neighbours read neighbours.
    int2 corner = int2(group.xy) * (NTC_DIFFERENCE_GROUP * NTC_DIFFERENCE_TEXELS);
    NTC_LOOP for (int i = 0; i < NTC_DIFFERENCE_TEXELS * NTC_DIFFERENCE_TEXELS; i++) {
        int2 place = corner + int2(local.xy) +
                     NTC_DIFFERENCE_GROUP * int2(i % NTC_DIFFERENCE_TEXELS, i / NTC_DIFFERENCE_TEXELS);
        if (place.x < gPush.width && place.y < gPush.height) {
            uint errors[NTC_DIFFERENCE_SUMS];
            NtcMeasureTexel(gFirst.Load(int3(int2(gPush.firstLeft, gPush.firstTop) + place, 0)),
                            gSecond.Load(int3(int2(gPush.secondLeft, gPush.secondTop) + place, 0)),
                            gPush.steps, gPush.alphaThreshold, gPush.flags, errors);
            NTC_UNROLL for (int e = 0; e < NTC_DIFFERENCE_SUMS; e++) sums[e] =
                NtcAddWide(sums[e], errors[e], 0u);
        }
    }
    NTC_UNROLL for (int s = 0; s < NTC_DIFFERENCE_SUMS; s++) {
        gSums[lane] = uint2(sums[s].low, sums[s].high);
        NTC_LOOP for (uint half_ = kLanes / 2u; half_ > 0u; half_ >>= 1u) {
            GroupMemoryBarrierWithGroupSync();
            if (lane < half_) {
                NtcWideSum own;
                own.low = gSums[lane].x;
                own.high = gSums[lane].y;
                NtcWideSum both = NtcAddWide(own, gSums[lane + half_].x, gSums[lane + half_].y);
                gSums[lane] = uint2(both.low, both.high);
            }
        }
        if (lane == 0u) {
            // Whoever makes the low word wrap round carries: whatever the order, the sum is right at the end.
            uint2 all = gSums[0];
            uint address = 4u * (gPush.word + 2u * uint(s));
            uint before;
            gResults.InterlockedAdd(address, all.x, before);
            uint ignored;
            gResults.InterlockedAdd(address + 4u, all.y + (before + all.x < before ? 1u : 0u), ignored);
        }
        GroupMemoryBarrierWithGroupSync();
    }
}
