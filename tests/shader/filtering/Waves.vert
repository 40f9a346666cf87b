// SPDX-License-Identifier: MIT
// A triangle that covers the picture, or, from vertex 3 on, triangles with slanted edges and some of a pixel.
#version 460
layout(push_constant) uniform Push { uint first; } gPush;

void main() {
    int index = gl_VertexIndex + int(gPush.first);
    const vec2 screen[3] = vec2[3](vec2(-1.0, -1.0), vec2(3.0, -1.0), vec2(-1.0, 3.0));
    const vec2 corners[12] = vec2[12](vec2(-0.97, -0.91), vec2(0.13, -0.83), vec2(-0.21, 0.04),
                                      vec2(0.31, -0.95), vec2(0.93, -0.11), vec2(0.08, -0.07),
                                      vec2(-0.9, 0.17), vec2(-0.12, 0.11), vec2(-0.55, 0.96),
                                      vec2(0.512, 0.512), vec2(0.55, 0.512), vec2(0.512, 0.55));
    gl_Position = vec4(index < 3 ? screen[index] : corners[index - 3], 0.0, 1.0);
}
