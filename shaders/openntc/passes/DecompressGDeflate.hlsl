// SPDX-License-Identifier: MIT
// Compute pass: the HLSL twin of DecompressGDeflate.comp, same resources and results. Entry point main.
// Registers: t0 tiles, t1 compressed words, u2 output, u3 corrupt tiles; in SPIR-V bindings 0 to 3 of set 0.
#include "GDeflateConstants.h"

[[vk::binding(0, 0)]] StructuredBuffer<NtcGDeflateTile> gTiles : register(t0);
[[vk::binding(1, 0)]] ByteAddressBuffer gCompressed : register(t1);
[[vk::binding(2, 0)]] globallycoherent RWByteAddressBuffer gOutput : register(u2);
[[vk::binding(3, 0)]] RWByteAddressBuffer gCorrupt : register(u3);

[[vk::push_constant]] ConstantBuffer<NtcGDeflateConstants> gPush;

#define NTC_GROUP_SHARED groupshared
#define NTC_GROUP_BARRIER() GroupMemoryBarrierWithGroupSync()
#define NTC_DEVICE_BARRIER() AllMemoryBarrierWithGroupSync()
#define NtcLoadTileWord(i) gCompressed.Load(4u * (i))
#define NtcLoadOutputWord(i) gOutput.Load(4u * (i))
#define NtcClearOutputWord(i) gOutput.Store(4u * (i), 0u)
#define NtcOrOutputWord(i, bits) gOutput.InterlockedOr(4u * (i), bits)
#define NtcLowerShared(place, value) InterlockedMin(place, value)
#define NtcOrShared(place, bits) InterlockedOr(place, bits)
#define NtcLowestBit(x) firstbitlow(x)
#include "GDeflateGroup.h"

[numthreads(32, 1, 1)]
void main(uint3 group : SV_GroupID, uint lane : SV_GroupIndex) {
    uint tile = group.x + group.y * uint(NTC_GDEFLATE_GROUPS);
    if (tile >= gPush.tiles)
        return;
    bool isRight = NtcDecompressTile(gTiles[gPush.firstTile + tile], lane);
    if (!isRight && lane == 0u) {
        uint ignored;
        gCorrupt.InterlockedAdd(0u, 1u, ignored);
    }
}
