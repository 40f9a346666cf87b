// SPDX-License-Identifier: MIT
// WaveCases.h in a fragment shader: partial waves, and waves after `discard`. gl_HelperInvocation wants SPIR-V
// below 1.6: the lavapipe of Mesa 22.3 ends at the built-in of later versions.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NTC_STF_MAX_ROUNDS 8
#include "support/filtering/WaveCases.h"

layout(set = 0, binding = 0, std140) uniform Scene { WaveScene scene; } gScene;
layout(set = 0, binding = 1, std430) writeonly buffer Results { uint words[]; } gResults;

void main() {
    int2 pixel = int2(gl_FragCoord.xy);
    if (IsWaveDiscarded(gScene.scene, pixel))
        discard;
    uint r[WAVE_WORDS];
    waveDecodes = 0u;
    RunWavePixel(gScene.scene, pixel, gl_SubgroupInvocationID, !gl_HelperInvocation, r);
    uint place = uint(WAVE_WORDS) * (uint(pixel.y) * gScene.scene.width + uint(pixel.x));
    for (uint k = 0u; k < uint(WAVE_WORDS); k++)
        gResults.words[place + k] = r[k];
}
