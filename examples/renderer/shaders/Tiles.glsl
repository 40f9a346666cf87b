// SPDX-License-Identifier: MIT
// Work groups of 32 lanes that are tiles of 8 x 4 pixels. Lanes lie in 2 x 2 pixels, waves of 8 in 4 x 2, waves of 32 in a
// tile.
#ifndef OPENNTC_RENDERER_TILES_GLSL
#define OPENNTC_RENDERER_TILES_GLSL

layout(local_size_x = 32) in;

layout(push_constant) uniform Push {
    uint firstTileX;
    uint firstTileY;
} gPush;

ivec2 NtcrGetTilePixel() {
    uint lane = gl_LocalInvocationIndex;
    uvec2 inTile = uvec2((lane & 1u) | ((lane >> 1) & 2u) | ((lane >> 2) & 4u), ((lane >> 1) & 1u) | ((lane >> 2) & 2u));
    return ivec2((gl_WorkGroupID.xy + uvec2(gPush.firstTileX, gPush.firstTileY)) * uvec2(8u, 4u) + inTile);
}

#endif
