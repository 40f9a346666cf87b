// SPDX-License-Identifier: MIT
// For the tests of the harness itself: result[i] = input[i] * FACTOR + OFFSET + push + uniform.
#version 460
layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) readonly buffer Input { uint words[]; } gInput;
layout(set = 0, binding = 1, std430) writeonly buffer Result { uint words[]; } gResult;
layout(set = 0, binding = 2, std140) uniform Constants { uvec4 value; } gConstants;
layout(push_constant) uniform Push { uint count; uint addend; } gPush;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < gPush.count)
        gResult.words[i] = gInput.words[i] * FACTOR + OFFSET + gPush.addend + gConstants.value.y;
}
