// SPDX-License-Identifier: MIT
// Fragments of masked surfaces that nothing opaque hides: for each pixel a list, in no order, of what may be there.
#ifndef OPENNTC_RENDERER_CANDIDATES_GLSL
#define OPENNTC_RENDERER_CANDIDATES_GLSL

layout(set = 0, binding = 10, std430) buffer Candidates {
    uint gCandidateCount; // of all; those beyond the array's end are not in lists, and the host makes it larger
    uint gPadding[3];
    uvec4 gCandidates[]; // instance, triangle, bits of depth, next one + 1
};
layout(set = 0, binding = 11, std430) buffer Lists {
    uint gLists[]; // two of a pixel: its first candidate + 1, the one that is there + 1
};

uint NtcrGetListIndex(ivec2 pixel) {
    return 2u * uint(pixel.y * gFrame.width + pixel.x);
}

#endif
