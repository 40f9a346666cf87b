// SPDX-License-Identifier: MIT
// Decides which candidate of one material is there: the nearest whose mask lets it be, if it hides what is there already.
// Drawing in order with a depth test comes to the same: of equally near ones the first instance's, its first triangle.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Mask.glsl"
#include "Count.glsl"
#include "Candidates.glsl"
#include "Tiles.glsl"

layout(set = 0, binding = 6) uniform utexture2D gVisible;
layout(set = 0, binding = 12) uniform texture2D gDepth;

/// Depth grows towards the eye, and is not negative: its bits are ordered as it is.
bool hides(uvec4 a, uvec4 b) {
    if (a.z != b.z)
        return a.z > b.z;
    return a.x != b.x ? a.x < b.x : a.y < b.y;
}

uvec4 findThere(uint list, ivec2 pixel) {
    uint there = gLists[list + 1u];
    if (there != 0u)
        return gCandidates[there - 1u];
    uvec2 visible = texelFetch(gVisible, pixel, 0).xy;
    if (visible.x == 0u)
        return uvec4(0u); // hidden by whatever is not as far as that
    return uvec4(visible.x - 1u, visible.y, floatBitsToUint(texelFetch(gDepth, pixel, 0).x), 0u);
}

/// The nearest candidate of this material between two, `front` and `back`, + 1; 0: none.
uint findNext(uint list, uvec4 front, bool hasFront, uvec4 back) {
    uint found = 0u;
    uvec4 nearest = back;
    for (uint i = gLists[list]; i != 0u;) {
        uvec4 candidate = gCandidates[i - 1u];
        if (hides(candidate, nearest) && (!hasFront || hides(front, candidate)) &&
            gInstances[candidate.x].material == gMaterial.index) {
            nearest = candidate;
            found = i;
        }
        i = candidate.w;
    }
    return found;
}

void main() {
    ivec2 pixel = NtcrGetTilePixel();
    if (pixel.x >= gFrame.width || pixel.y >= gFrame.height)
        return;
    uint list = NtcrGetListIndex(pixel);
    if (gLists[list] == 0u)
        return;
    uvec4 back = findThere(list, pixel), front = back;
    bool hasFront = false;
    while (true) {
        uint next = findNext(list, front, hasFront, back);
        if (next == 0u)
            break;
        front = gCandidates[next - 1u];
        hasFront = true;
        if (NtcrIsThere(front.x, front.y, pixel)) {
            gLists[list + 1u] = next;
            break;
        }
    }
    NtcrCountTexels();
}
