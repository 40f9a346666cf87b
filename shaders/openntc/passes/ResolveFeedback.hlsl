// SPDX-License-Identifier: MIT
// Compute pass: the HLSL twin of ResolveFeedback.comp, same resources and results. Entry point main.
// Registers: u0 feedback, u1 last bytes, u2 changes; in SPIR-V bindings 0 to 2 of set 0.
#include "openntc/streaming/StreamingConstants.h"
#include "openntc/streaming/TileMaths.h"

[[vk::binding(0, 0)]] RWByteAddressBuffer gFeedback : register(u0);
[[vk::binding(1, 0)]] RWByteAddressBuffer gLast : register(u1);
[[vk::binding(2, 0)]] RWByteAddressBuffer gChanges : register(u2);

[[vk::push_constant]] ConstantBuffer<NtcResolveFeedbackConstants> gPush;

[numthreads(NTC_RESOLVE_FEEDBACK_GROUP, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    uint first = 4u * id.x;
    if (first >= gPush.regionCount)
        return;
    uint place = (gPush.firstRegion + first) >> 2;
    uint before = gLast.Load(4u * place);
    uint after = before;
    NTC_LOOP for (uint k = 0u; k < 4u && first + k < gPush.regionCount; k++) {
        uint region = gPush.firstRegion + first + k;
        uint address = 4u * (gPush.feedbackWord + region);
        uint bits = gFeedback.Load(address);
        if (bits != 0u)
            gFeedback.Store(address, 0u);
        uint mip = NtcGetFinestMip(bits);
        uint shift = 8u * k;
        if (mip != ((before >> shift) & 255u)) {
            uint entry;
            gChanges.InterlockedAdd(0u, 1u, entry);
            if (entry < gChanges.Load(8u)) {
                gChanges.Store(16u + 8u * entry, region);
                gChanges.Store(20u + 8u * entry, mip);
                after = (after & ~(255u << shift)) | (mip << shift);
            } else {
                uint dropped;
                gChanges.InterlockedAdd(4u, 1u, dropped);
            }
        }
    }
    if (after != before)
        gLast.Store(4u * place, after);
}
