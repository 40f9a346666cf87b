// SPDX-License-Identifier: MIT
// The running mean over frames, in their order, in binary32; and of it the picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Scene.glsl"
#include "ToneMap.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 7, rgba32f) readonly uniform image2D gPicture;
layout(set = 0, binding = 8, rgba32f) uniform image2D gMean;
layout(set = 0, binding = 9, std430) writeonly buffer Pixels {
    uint gPixels[];
};

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= gFrame.width || pixel.y >= gFrame.height)
        return;
    vec3 color = imageLoad(gPicture, pixel).xyz;
    if (gFrame.newWeight < 1.0) {
        vec3 mean = imageLoad(gMean, pixel).xyz;
        color = mean + (color - mean) * gFrame.newWeight;
    }
    imageStore(gMean, pixel, vec4(color, 1.0));
    // Kernels with negative weights may leave less than nothing; clamped after averaging.
    gPixels[pixel.y * gFrame.width + pixel.x] =
        NtcrMakePixel(max(color, vec3(0.0)), gFrame.exposure, gFrame.toneCurve);
}
