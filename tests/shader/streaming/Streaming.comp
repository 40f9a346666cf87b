// SPDX-License-Identifier: MIT
// Runs StreamingCases.h: an item per invocation.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(set = 0, binding = 5, std430) readonly buffer Residency { uint words[]; } gResidency;
#define NtcResidencyLoad(context, word) gResidency.words[word]
#include "support/streaming/StreamingCases.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std140) uniform Launch { NtcStreamingConstants launch; } gLaunch;
layout(set = 0, binding = 3, std430) readonly buffer Items { StreamingItem items[]; } gItems;
layout(set = 0, binding = 4, std430) writeonly buffer Results { uint words[]; } gResults;
layout(push_constant) uniform Push { uint count; } gPush;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= gPush.count)
        return;
    StreamingItem item = gItems.items[i];
    uint r[CASE_WORDS];
    RunStreamingItem(NtcMakeStreamingContext(gLaunch.launch, item.seed), item, r);
    for (uint k = 0u; k < uint(CASE_WORDS); k++)
        gResults.words[uint(CASE_WORDS) * i + k] = r[k];
}
