// SPDX-License-Identifier: MIT
// Shades the pixels of one material that the visibility buffer shows, in tiles of 8 x 4. Lanes lie in 2 x 2 pixels, waves
// of 8 in 4 x 2, waves of 32 in a tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_vote : require
#include "Shade.glsl"
#include "Count.glsl"

layout(local_size_x = 32) in;

layout(set = 0, binding = 6) uniform utexture2D gVisible;
layout(set = 0, binding = 7, rgba32f) writeonly uniform image2D gPicture;

layout(push_constant) uniform Push {
    uint firstTileX;
    uint firstTileY;
} gPush;

ivec2 getPixel() {
    uint lane = gl_LocalInvocationIndex;
    uvec2 inTile = uvec2((lane & 1u) | ((lane >> 1) & 2u) | ((lane >> 2) & 4u), ((lane >> 1) & 1u) | ((lane >> 2) & 2u));
    return ivec2((gl_WorkGroupID.xy + uvec2(gPush.firstTileX, gPush.firstTileY)) * uvec2(8u, 4u) + inTile);
}

void main() {
    ivec2 pixel = getPixel();
    bool isInside = pixel.x < gFrame.width && pixel.y < gFrame.height;
    uvec2 visible = isInside ? texelFetch(gVisible, pixel, 0).xy : uvec2(0u);
    bool isLive = visible.x != 0u && gInstances[max(visible.x, 1u) - 1u].material == gMaterial.index;
    if (!subgroupAny(isLive))
        return;
#if NTCR_FILTER < 2
    if (!isLive)
        return;
#endif
    vec4 color = NtcrShade(isLive ? visible.x - 1u : 0u, isLive ? visible.y : 0u, pixel, isLive);
    if (isLive) {
        imageStore(gPicture, pixel, vec4(color.xyz, 1.0));
        NtcrCountTexels();
    }
}
