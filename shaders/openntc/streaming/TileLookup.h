// SPDX-License-Identifier: MIT
// Tiles of texels, requests and stamps; included by PageTable.h.
//
// An engine with a table of its own defines NtcGetTileSlot(context, header, tile): the slot of a tile, or
// NTC_TILE_MISSING; or the accessors of StreamingBuffers.h, if only the memory is its own.
#ifndef OPENNTC_TILE_LOOKUP_H
#define OPENNTC_TILE_LOOKUP_H

#include "StreamingBuffers.h"
#include "TileAddress.h"
#include "TileMaths.h"
#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

#if !defined(NtcGetTileSlot)
#define NtcGetTileSlot(context, header, tile)                                                                \
    NtcPageTableLoad(context, (context).launch.entriesWord + (header).firstEntry + (tile))
#endif

/// A level of tiles, unpacked.
struct NtcLevel {
    uint width; // texels of lastMip
    uint height;
    int firstMip;
    int lastMip;
    uint tilesX;
    uint tilesY;
    uint firstTile;
};

NTC_FUNCTION NtcLevel NtcLoadLevel(NtcStreamingContext context, NtcTextureHeader header, int level) {
    uint word = header.word + NTC_HEADER_LEVELS + 4u * uint(min(max(level, 0), NTC_MAX_LEVELS - 1));
    uint widthFirstMip = NtcPageTableLoad(context, word);
    uint heightLastMip = NtcPageTableLoad(context, word + 1u);
    uint tilesXY = NtcPageTableLoad(context, word + 2u);
    NtcLevel result;
    result.width = widthFirstMip & 0xFFFFFu;
    result.height = heightLastMip & 0xFFFFFu;
    result.firstMip = int(widthFirstMip >> 24);
    result.lastMip = int(heightLastMip >> 24);
    result.tilesX = tilesXY & 0xFFFFu;
    result.tilesY = tilesXY >> 16;
    result.firstTile = NtcPageTableLoad(context, word + 3u);
    return result;
}

/// The level that serves a mip in front of the tail.
NTC_FUNCTION int NtcGetLevelOfMip(NtcStreamingContext context, NtcTextureHeader header, int mip) {
    uint word = NtcPageTableLoad(context, header.word + NTC_HEADER_MIP_LEVELS + ((uint(mip) >> 3) & 1u));
    return int((word >> (4u * (uint(mip) & 7u))) & 15u);
}

/// Number of the tile that holds a texel of a mip of the level; the texel is inside the mip.
NTC_FUNCTION uint NtcGetTile(NtcTextureHeader header, NtcLevel level, int2 texel, int mip) {
    int shift = level.lastMip - mip;
    int x = NtcTileOfTexel(texel.x, int(NtcGetTiledMipSize(header.width, mip)), shift, int(header.tileWidth));
    int y =
        NtcTileOfTexel(texel.y, int(NtcGetTiledMipSize(header.height, mip)), shift, int(header.tileHeight));
    return level.firstTile + uint(y) * level.tilesX + uint(x);
}

#if NTC_TILE_REQUESTS
/// Appends a tile to the queue, unless that was done since the host last cleared its bit, or the rate says
/// no. A full queue counts what it drops.
NTC_FUNCTION void NtcRequestTile(NtcStreamingContext context, uint textureId, NtcTextureHeader header,
                                 uint tile) {
    if (!NtcPasses(context, context.launch.requestRate, 0u))
        return;
    uint entry = header.firstEntry + tile;
    uint word = context.launch.bitsWord + (entry >> 5);
    uint bit = 1u << (entry & 31u);
    if ((NtcLaunchStateLoad(context, word) & bit) != 0u)
        return;
    if ((NtcLaunchStateOr(context, word, bit) & bit) != 0u)
        return;
    uint queue = context.launch.queueWord;
    uint place = NtcLaunchStateAdd(context, queue, 1u);
    if (place < NtcLaunchStateLoad(context, queue + 2u)) {
        NtcLaunchStateStore(context, queue + 4u + 2u * place, textureId);
        NtcLaunchStateStore(context, queue + 5u + 2u * place, tile);
    } else {
        NtcLaunchStateAdd(context, queue + 1u, 1u);
    }
}
#else
#define NtcRequestTile(context, textureId, header, tile)
#endif

#if NTC_TILE_STAMPS
/// Says that this round has read the slot. All threads store the same word, so the race is harmless.
NTC_FUNCTION void NtcStampSlot(NtcStreamingContext context, NtcTextureHeader header, uint slot) {
    uint word = context.launch.stampsWord + header.firstSlot + slot;
    if (NtcLaunchStateLoad(context, word) != context.launch.round)
        NtcLaunchStateStore(context, word, context.launch.round);
}
#else
#define NtcStampSlot(context, header, slot)
#endif

/// True if the whole tail is there; stamps it. Otherwise requests what is missing of it if `requests`.
NTC_FUNCTION bool NtcUseTail(NtcStreamingContext context, uint textureId, NtcTextureHeader header,
                             bool requests) {
    bool complete = header.tileCount > header.firstTailTile;
    NTC_LOOP for (uint tile = header.firstTailTile; tile < header.tileCount; tile++) {
        uint slot = NtcGetTileSlot(context, header, tile);
        if (slot == NTC_TILE_MISSING) {
            complete = false;
            if (requests) {
                NtcRequestTile(context, textureId, header, tile);
            }
        } else {
            NtcStampSlot(context, header, slot);
        }
    }
    return complete;
}

/// True if the tile of a texel is there; stamps it. Otherwise requests it if `requests`. The tail counts as
/// one tile.
NTC_FUNCTION bool NtcUseTexel(NtcStreamingContext context, uint textureId, NtcTextureHeader header,
                              int2 texel, int mip, bool requests) {
    if (mip >= header.firstTailMip)
        return NtcUseTail(context, textureId, header, requests);
    NtcLevel level = NtcLoadLevel(context, header, NtcGetLevelOfMip(context, header, mip));
    uint tile = NtcGetTile(header, level, texel, mip);
    uint slot = NtcGetTileSlot(context, header, tile);
    if (slot != NTC_TILE_MISSING) {
        NtcStampSlot(context, header, slot);
        return true;
    }
    if (requests) {
        NtcRequestTile(context, textureId, header, tile);
    }
    return false;
}

/// A page of a resource (PageTable::AddPages): its value, and whether there is one; requests it otherwise.
/// Pages carry no stamps. 0 where there is no such page or resource.
NTC_FUNCTION uint NtcDemandPage(NtcStreamingContext context, uint pagesId, uint page,
                                NTC_OUT(bool, resident)) {
    NtcTextureHeader header = NtcLoadTextureHeader(context, pagesId);
    resident = false;
    if (header.format != uint(NTC_TILES_PAGES) || page >= header.tileCount)
        return 0u;
    uint value = NtcGetTileSlot(context, header, page);
    resident = value != NTC_TILE_MISSING;
    if (!resident) {
        NtcRequestTile(context, pagesId, header, page);
    }
    return resident ? value : 0u;
}

/// The first mip of the next coarser level; that of the tail, or `mips` where there is none.
NTC_FUNCTION int NtcGetNextMip(NtcStreamingContext context, NtcTextureHeader header, int mip) {
    if (mip >= header.firstTailMip)
        return header.mips;
    return NtcLoadLevel(context, header, NtcGetLevelOfMip(context, header, mip)).lastMip + 1;
}

/// The texel of a coarser (or the same) mip at the centre of a texel of `mip`, both clamped to their mips.
NTC_FUNCTION int2 NtcMoveTexel(NtcTextureHeader header, int2 texel, int mip, int toMip) {
    uint width = NtcGetTiledMipSize(header.width, mip);
    uint height = NtcGetTiledMipSize(header.height, mip);
    uint x = uint(min(max(texel.x, 0), int(width) - 1));
    uint y = uint(min(max(texel.y, 0), int(height) - 1));
    x = NtcScaleTexel(x, width, NtcGetTiledMipSize(header.width, toMip));
    y = NtcScaleTexel(y, height, NtcGetTiledMipSize(header.height, toMip));
    return int2(int(x), int(y));
}

/// Looks for a texel: sampledMip is `mip` if its tile is there (`resident`), else the first mip of the finest
/// coarser level whose tile is, and the tile of `mip` has been requested. False, sampledMip -1: nothing is
/// there, or no such mip or texture exists (then nothing is requested). Texels outside are clamped.
NTC_FUNCTION bool NtcFindResidentMip(NtcStreamingContext context, uint textureId, int2 texel, int mip,
                                     NTC_OUT(bool, resident), NTC_OUT(int, sampledMip)) {
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    resident = false;
    sampledMip = -1;
    if (mip < 0 || mip >= header.mips)
        return false;
#if NTC_TILE_FALLBACK
    int candidate = mip;
    NTC_LOOP while (candidate < header.mips) {
        if (NtcUseTexel(context, textureId, header, NtcMoveTexel(header, texel, mip, candidate), candidate,
                        candidate == mip)) {
            resident = candidate == mip;
            sampledMip = candidate;
            return true;
        }
        candidate = NtcGetNextMip(context, header, candidate);
    }
#else
    if (NtcUseTexel(context, textureId, header, NtcMoveTexel(header, texel, mip, mip), mip, true)) {
        resident = true;
        sampledMip = mip;
        return true;
    }
#endif
    return false;
}

NTC_NAMESPACE_END

#endif
