// SPDX-License-Identifier: MIT
// Runs FunctionCases.h: buffer 3 holds groups of { number, a, b, c, d }, buffer 4 gets four words for each.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"
layout(set = 0, binding = 0, std140) uniform Constants { NtcTextureSetConstants desc; };
#include "FunctionCases.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 3, std430) readonly buffer Cases { uint words[]; } gCases;
layout(set = 0, binding = 4, std430) writeonly buffer Results { uint words[]; } gResults;
layout(push_constant) uniform Push { uint count; } gPush;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= gPush.count)
        return;
    uint r[4];
    RunCase(gCases.words[5u * i], gCases.words[5u * i + 1u], gCases.words[5u * i + 2u], gCases.words[5u * i + 3u],
            gCases.words[5u * i + 4u], r);
    gResults.words[4u * i] = r[0];
    gResults.words[4u * i + 1u] = r[1];
    gResults.words[4u * i + 2u] = r[2];
    gResults.words[4u * i + 3u] = r[3];
}
