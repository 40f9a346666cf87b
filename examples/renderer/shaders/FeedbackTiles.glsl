// SPDX-License-Identifier: MIT
// Texels of textures that are decoded on demand, in tiles: what a tap reads is recorded as feedback, and read where its
// tile lies in an atlas; where it is not there yet, the finest coarser mip that is, between its texels.
#ifndef OPENNTC_RENDERER_FEEDBACK_TILES_GLSL
#define OPENNTC_RENDERER_FEEDBACK_TILES_GLSL

#define NTC_STREAMING_SET 2
#define NTC_TILE_REQUESTS 0
#define NTC_TILE_STAMPS 0
#define NTC_TILE_RATES 0
#include "openntc/streaming/PageTable.h"
#include "openntc/streaming/Feedback.h"
#include "FeedbackTail.h"

layout(set = NTC_STREAMING_SET, binding = 3, std140) uniform Streaming {
    NtcStreamingConstants gStreaming;
};

/// Where a tap's texel is in the atlases of its texture's set. What is not whole lies between two columns and rows.
struct NtcrTile {
    uint slot;
    uint size;      // texels of a tile's side
    ivec2 texel;    // in the tile
    ivec2 next;     // the one to the right and below, or itself
    vec2 fraction;  // of the way to it
    bool isWhole;   // the mip that was asked for
};

/// A place of one axis in a coarser mip. range: of texels in the tile; all in texels of the mip.
void NtcrPlaceCoarse(uint texel, uint fromSize, uint toSize, ivec2 range, out int first, out int next, out float fraction) {
    float at = (float(texel) + 0.5) * float(toSize) / float(fromSize) - 0.5;
    fraction = at - floor(at);
    first = clamp(int(floor(at)), range.x, range.y);
    next = clamp(int(floor(at)) + 1, range.x, range.y);
}

NtcrTile NtcrFindTile(uint id, NtcStfTap tap) {
    NtcStreamingContext context = NtcMakeStreamingContext(gStreaming, 0u);
    NtcRecordTexel(context, id, tap.texel, tap.mip);
    NtcTextureHeader header = NtcLoadTextureHeader(context, id);
    NtcrTile tile;
    tile.size = header.tileWidth;
    int mip;
    NtcFindResidentMip(context, id, tap.texel, tap.mip, tile.isWhole, mip);
    mip = max(mip, 0); // the coarsest tiles are always there
    ivec2 texel = NtcMoveTexel(header, tap.texel, tap.mip, mip);
    ivec2 mipSize = ivec2(NtcGetTiledMipSize(header.width, mip), NtcGetTiledMipSize(header.height, mip));
    ivec2 corner = ivec2(0); // of the tile in the mip, and of the mip in the tile
    ivec2 place = ivec2(0);
    ivec2 end = mipSize;
    uint number = header.firstTailTile;
    if (mip < header.firstTailMip) {
        number = NtcGetTile(header, NtcLoadLevel(context, header, mip), texel, mip);
        corner = texel / int(tile.size) * int(tile.size);
        end = min(corner + int(tile.size), mipSize);
    } else {
        place = NtcrGetTailPlace(int(tile.size), mip - header.firstTailMip);
    }
    tile.slot = NtcGetTileSlot(context, header, number);
    tile.next = texel;
    tile.fraction = vec2(0.0);
    if (!tile.isWhole) {
        ivec2 fineSize = ivec2(NtcGetTiledMipSize(header.width, tap.mip), NtcGetTiledMipSize(header.height, tap.mip));
        NtcrPlaceCoarse(uint(tap.texel.x), uint(fineSize.x), uint(mipSize.x), ivec2(corner.x, end.x - 1), texel.x,
                        tile.next.x, tile.fraction.x);
        NtcrPlaceCoarse(uint(tap.texel.y), uint(fineSize.y), uint(mipSize.y), ivec2(corner.y, end.y - 1), texel.y,
                        tile.next.y, tile.fraction.y);
    }
    tile.texel = texel - corner + place;
    tile.next = tile.next - corner + place;
    return tile;
}

/// A texel of a tile in an atlas, whose layers are squares of tiles.
vec4 NtcrReadAtlas(texture2DArray atlas, NtcrTile tile, ivec2 texel) {
    uint across = uint(textureSize(atlas, 0).x) / tile.size;
    uint inLayer = tile.slot % (across * across);
    ivec2 corner = ivec2(inLayer % across, inLayer / across) * int(tile.size);
    return texelFetch(atlas, ivec3(corner + texel, tile.slot / (across * across)), 0);
}

vec4 NtcrReadTile(texture2DArray atlas, NtcrTile tile) {
    vec4 first = NtcrReadAtlas(atlas, tile, tile.texel);
    if (tile.isWhole)
        return first;
    vec4 right = NtcrReadAtlas(atlas, tile, ivec2(tile.next.x, tile.texel.y));
    vec4 below = NtcrReadAtlas(atlas, tile, ivec2(tile.texel.x, tile.next.y));
    vec4 last = NtcrReadAtlas(atlas, tile, tile.next);
    return mix(mix(first, right, tile.fraction.x), mix(below, last, tile.fraction.x), tile.fraction.y);
}

#endif
