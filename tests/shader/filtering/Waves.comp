// SPDX-License-Identifier: MIT
// Runs WaveCases.h: a wave of the device is a block of pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
#define NTC_STF_MAX_ROUNDS 8
#include "support/filtering/WaveCases.h"

layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std140) uniform Scene { WaveScene scene; } gScene;
layout(set = 0, binding = 1, std430) writeonly buffer Results { uint words[]; } gResults;

void main() {
    uint waveWidth = gl_SubgroupSize >= 32u ? 8u : 4u;
    uint waveHeight = gl_SubgroupSize / waveWidth;
    uint wave = gl_GlobalInvocationID.x / gl_SubgroupSize;
    uint wavesAcross = gScene.scene.width / waveWidth;
    int2 pixel = int2(wave % wavesAcross * waveWidth, wave / wavesAcross * waveHeight) +
                 GetWavePixel(gl_SubgroupInvocationID);
    if (IsWaveDiscarded(gScene.scene, pixel))
        return;
    uint r[WAVE_WORDS];
    waveDecodes = 0u;
    RunWavePixel(gScene.scene, pixel, gl_SubgroupInvocationID, true, r);
    uint place = uint(WAVE_WORDS) * (uint(pixel.y) * gScene.scene.width + uint(pixel.x));
    for (uint k = 0u; k < uint(WAVE_WORDS); k++)
        gResults.words[place + k] = r[k];
}
