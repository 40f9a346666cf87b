// SPDX-License-Identifier: MIT
// The residency map in shaders: how fine a filter may read at a place. Included by PageTable.h.
//
// NtcResidencyLoad(context, word) reads the map's buffer, four bytes a word, the lowest first. It must be
// defined before the first include where NtcResidencyClamp is wanted in a shader.
#ifndef OPENNTC_RESIDENCY_MAP_H
#define OPENNTC_RESIDENCY_MAP_H

#include "StreamingBuffers.h"
#include "TileLookup.h"
#include "TileMaths.h"
#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

#if !defined(NtcResidencyLoad) && defined(__cplusplus)
#define NtcResidencyLoad(context, word) NtcLoadStreamingWord((context).memory->residency, word)
#endif

#if defined(NtcResidencyLoad)
/// The finest mip that a filter at (u, v) may read without meeting a hole: the largest of the 2 x 2 entries
/// of the residency map around the place, whose bytes are the finest mip resident per tile of level 0 (the
/// tile manager's residency map), at the index that the tile has as an entry of the page table. 255: nothing
/// is there yet.
NTC_FUNCTION uint NtcResidencyClamp(NtcStreamingContext context, uint textureId, float2 uv) {
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    if (header.mips == 0)
        return 255u;
    uint width = header.width;
    uint height = header.height;
    uint tileWidth = header.width;
    uint tileHeight = header.height;
    uint tilesX = 1u;
    uint tilesY = 1u;
    if (header.levels > 0) {
        NtcLevel level = NtcLoadLevel(context, header, 0);
        width = level.width;
        height = level.height;
        tileWidth = header.tileWidth;
        tileHeight = header.tileHeight;
        tilesX = level.tilesX;
        tilesY = level.tilesY;
    }
    uint wrapU = (header.sampling >> 4) & 15u;
    uint wrapV = (header.sampling >> 8) & 15u;
    uint x = uint(NtcAddressTexel(NtcGetTexelCoord(uv.x, width, wrapU).texel, int(width), wrapU));
    uint y = uint(NtcAddressTexel(NtcGetTexelCoord(uv.y, height, wrapV).texel, int(height), wrapV));
    // The neighbour on the side of the nearer edge.
    int tileX = int(x / tileWidth);
    int tileY = int(y / tileHeight);
    int nextX = 2u * (x % tileWidth) < tileWidth ? tileX - 1 : tileX + 1;
    int nextY = 2u * (y % tileHeight) < tileHeight ? tileY - 1 : tileY + 1;
    nextX = NtcAddressTexel(nextX, int(tilesX), wrapU);
    nextY = NtcAddressTexel(nextY, int(tilesY), wrapV);
    uint largest = 0u;
    NTC_UNROLL for (uint i = 0u; i < 4u; i++) {
        uint entry = header.firstEntry + uint((i & 2u) != 0u ? nextY : tileY) * tilesX +
                     uint((i & 1u) != 0u ? nextX : tileX);
        uint value = (NtcResidencyLoad(context, entry >> 2) >> (8u * (entry & 3u))) & 255u;
        largest = value > largest ? value : largest;
    }
    return largest;
}
#endif

NTC_NAMESPACE_END

#endif
