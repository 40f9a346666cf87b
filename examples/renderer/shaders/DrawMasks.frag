// SPDX-License-Identifier: MIT
// The visibility buffer, and depth, of masked surfaces where they are there.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Scene.glsl"
#include "Candidates.glsl"

layout(location = 0) flat in uvec2 gTriangle;
layout(location = 0) out uvec2 gVisible;

void main() {
    uint there = gLists[NtcrGetListIndex(ivec2(gl_FragCoord.xy)) + 1u];
    if (there == 0u || gCandidates[there - 1u].xy != gTriangle)
        discard;
    gVisible = uvec2(gTriangle.x + 1u, gTriangle.y);
}
