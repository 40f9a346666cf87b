// SPDX-License-Identifier: MIT
// Runs FilterCases.h: an item per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "support/filtering/FilterCases.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Items { FilterItem items[]; } gItems;
layout(set = 0, binding = 1, std430) writeonly buffer Results { uint words[]; } gResults;
layout(push_constant) uniform Push { uint count; } gPush;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= gPush.count)
        return;
    uint r[FILTER_WORDS];
    RunFilterItem(gItems.items[i], r);
    for (uint k = 0u; k < uint(FILTER_WORDS); k++)
        gResults.words[uint(FILTER_WORDS) * i + k] = r[k];
}
