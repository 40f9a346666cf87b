// SPDX-License-Identifier: MIT
// A material's fragment shader: 16 outputs to four targets. With NTC_TEXELS_PER_INVOCATION the texels beside are averaged.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"

layout(set = 0, binding = 0, std140) uniform Constants {
    NtcTextureSetConstants desc;
};
layout(location = 0) flat in int inMipLevel;
layout(location = 1) flat in uint inIsLinear;
layout(location = 0) out vec4 outTargets[4];

#define T NTC_TEXELS_PER_INVOCATION

void main() {
    int2 texel = int2(int(gl_FragCoord.x), int(gl_FragCoord.y));
    float outputs[16 * T];
    for (uint i = 0u; i < 16u * uint(T); i++)
        outputs[i] = 0.0;
#if T > 1
    int2 texels[T];
    for (uint t = 0u; t < uint(T); t++)
        texels[t] = int2(texel.x + int(t), texel.y);
    NtcSampleTextureSetTexels(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texels, inMipLevel, inIsLinear != 0u, outputs);
#else
    NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, inMipLevel, inIsLinear != 0u, outputs);
#endif
    for (uint target = 0u; target < 4u; target++) {
        vec4 sum = vec4(0.0);
        for (uint k = 0u; k < uint(T); k++) {
            uint at = 16u * k + 4u * target;
            sum += vec4(outputs[at], outputs[at + 1u], outputs[at + 2u], outputs[at + 3u]);
        }
        outTargets[target] = sum / float(T);
    }
}
