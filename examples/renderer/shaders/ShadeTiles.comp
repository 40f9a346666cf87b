// SPDX-License-Identifier: MIT
// Shades the pixels of one material that the visibility buffer shows, in tiles.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_KHR_shader_subgroup_vote : require
#include "Shade.glsl"
#include "Count.glsl"
#include "Tiles.glsl"

layout(set = 0, binding = 6) uniform utexture2D gVisible;
layout(set = 0, binding = 7, rgba32f) writeonly uniform image2D gPicture;

void main() {
    ivec2 pixel = NtcrGetTilePixel();
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
