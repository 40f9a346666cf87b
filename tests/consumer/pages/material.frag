// SPDX-License-Identifier: MIT
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/Inference.h"
layout(std140, binding = 0) uniform Constants { NtcTextureSetConstants desc; };
layout(location = 0) out vec4 color;

void main() {
    float channels[NTC_MAX_CHANNELS];
    bool known = NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, ivec2(gl_FragCoord.xy), 0, false, channels);
    color = known ? vec4(channels[0], channels[1], channels[2], 1.0) : vec4(0.0);
}
