// SPDX-License-Identifier: MIT
// The sky, behind everything.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Scene.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 7, rgba32f) writeonly uniform image2D gPicture;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = ivec2(gFrame.width, gFrame.height);
    if (any(greaterThanEqual(pixel, size)))
        return;
    vec2 at = (vec2(pixel) + 0.5) * 2.0 / vec2(size) - 1.0;
    vec3 direction = gFrame.rayCenter.xyz + gFrame.rayX.xyz * at.x + gFrame.rayY.xyz * at.y;
    imageStore(gPicture, pixel, vec4(NtcrGetSky(gFrame.lights, normalize(direction)), 1.0));
}
