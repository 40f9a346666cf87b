// SPDX-License-Identifier: MIT
// Compute pass: GDeflate tiles, one a group of 32 threads, on any device.
//
// Set 0: 0 tiles (NtcGDeflateTile), 1 compressed words, 2 output, 3 one word, to which the number of tiles
// that are corrupt is added. Bindings 1 and 2 may be one buffer, of different words. Push constants:
// NtcGDeflateConstants. Dispatch the groups of MakeGDeflatePass (passes/GDeflatePass.h).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "GDeflateConstants.h"

layout(local_size_x = 32) in;

layout(set = 0, binding = 0, std430) readonly buffer Tiles {
    NtcGDeflateTile entries[];
}
gTiles;
layout(set = 0, binding = 1, std430) readonly buffer Compressed {
    uint words[];
}
gCompressed;
layout(set = 0, binding = 2, std430) coherent buffer Output {
    uint words[];
}
gOutput;
layout(set = 0, binding = 3, std430) buffer Corrupt {
    uint tiles;
}
gCorrupt;
layout(push_constant) uniform GDeflatePush {
    NtcGDeflateConstants gPush;
};

#define NTC_GROUP_SHARED shared
#define NTC_GROUP_BARRIER() barrier()
#define NTC_DEVICE_BARRIER()                                                                                 \
    memoryBarrierBuffer();                                                                                   \
    barrier()
#define NtcLoadTileWord(i) gCompressed.words[i]
#define NtcLoadOutputWord(i) gOutput.words[i]
#define NtcClearOutputWord(i) gOutput.words[i] = 0u
#define NtcOrOutputWord(i, bits) atomicOr(gOutput.words[i], bits)
#define NtcLowerShared(place, value) atomicMin(place, value)
#define NtcOrShared(place, bits) atomicOr(place, bits)
#define NtcLowestBit(x) uint(findLSB(x))
#include "GDeflateGroup.h"

void main() {
    uint tile = gl_WorkGroupID.x + gl_WorkGroupID.y * uint(NTC_GDEFLATE_GROUPS);
    if (tile >= gPush.tiles)
        return;
    bool isRight = NtcDecompressTile(gTiles.entries[gPush.firstTile + tile], gl_LocalInvocationIndex);
    if (!isRight && gl_LocalInvocationIndex == 0u)
        atomicAdd(gCorrupt.tiles, 1u);
}
