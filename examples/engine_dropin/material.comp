// SPDX-License-Identifier: MIT
// The engine's shader: each thread decodes the texel of mip 0 under its id.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h" // declares the latents at binding 1 and the weights at binding 2

layout(local_size_x = 8, local_size_y = 8) in;
layout(std140, binding = 0) uniform Constants { NtcTextureSetConstants desc; };
layout(std430, binding = 3) writeonly buffer Texels { float values[]; } gTexels;

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = NtcGetTextureDimensions(desc, 0);
    if (texel.x >= size.x || texel.y >= size.y)
        return;
    float channels[NTC_MAX_CHANNELS];
    bool known = NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, 0, false, channels);
    for (int c = 0; c < NTC_MAX_CHANNELS; c++)
        gTexels.values[(texel.y * size.x + texel.x) * NTC_MAX_CHANNELS + c] = known ? channels[c] : 0.0;
}
