// SPDX-License-Identifier: MIT
// Remembers a fragment of a masked surface; whether it is there a compute shader decides (ResolveMasks.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Scene.glsl"
#include "Candidates.glsl"

layout(early_fragment_tests) in;
layout(location = 0) flat in uvec2 gTriangle;

void main() {
    uint candidate = atomicAdd(gCandidateCount, 1u);
    if (candidate >= uint(gCandidates.length()))
        return;
    uint next = atomicExchange(gLists[NtcrGetListIndex(ivec2(gl_FragCoord.xy))], candidate + 1u);
    gCandidates[candidate] = uvec4(gTriangle, floatBitsToUint(gl_FragCoord.z), next);
}
