// SPDX-License-Identifier: MIT
// Empties the lists of candidates.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Scene.glsl"
#include "Candidates.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= gFrame.width || pixel.y >= gFrame.height)
        return;
    uint list = NtcrGetListIndex(pixel);
    gLists[list] = 0u;
    gLists[list + 1u] = 0u;
    if (list == 0u)
        gCandidateCount = 0u;
}
