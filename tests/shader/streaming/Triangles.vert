// SPDX-License-Identifier: MIT
// Triangles with slanted edges, so that many quads are only half covered. uv is linear in the pixel, and turned.
#version 460
layout(location = 0) out vec2 uv;
layout(push_constant) uniform Push { uint kind; uint textureId; uint width; float scale; } gPush;

void main() {
    // Four fans round the centre of the picture, with gaps between them.
    const vec2 corners[12] = vec2[12](vec2(-0.97, -0.91), vec2(0.13, -0.83), vec2(-0.21, 0.04),
                                      vec2(0.31, -0.95), vec2(0.93, -0.11), vec2(0.08, -0.07),
                                      vec2(-0.9, 0.17), vec2(-0.12, 0.11), vec2(-0.55, 0.96),
                                      vec2(0.02, 0.21), vec2(0.96, 0.07), vec2(0.41, 0.99));
    vec2 corner = corners[gl_VertexIndex];
    gl_Position = vec4(corner, 0.0, 1.0);
    uv = gPush.scale * vec2(corner.x * 0.61 - corner.y * 0.35, corner.x * 0.29 + corner.y * 0.53) + 0.37;
}
