// SPDX-License-Identifier: MIT
// The HLSL twin of Waves.comp.
#define NTC_STF_MAX_ROUNDS 8
#include "support/filtering/WaveCases.h"

[[vk::binding(0, 0)]] cbuffer Scene : register(b0) {
    WaveScene gScene;
};
[[vk::binding(1, 0)]] RWByteAddressBuffer gResults : register(u1);

[numthreads(64, 1, 1)] void main(uint3 id : SV_DispatchThreadID) {
    uint waveWidth = WaveGetLaneCount() >= 32u ? 8u : 4u;
    uint waveHeight = WaveGetLaneCount() / waveWidth;
    uint wave = id.x / WaveGetLaneCount();
    uint wavesAcross = gScene.width / waveWidth;
    int2 pixel = int2(wave % wavesAcross * waveWidth, wave / wavesAcross * waveHeight) +
                 GetWavePixel(WaveGetLaneIndex());
    if (IsWaveDiscarded(gScene, pixel))
        return;
    uint r[WAVE_WORDS];
    waveDecodes = 0u;
    RunWavePixel(gScene, pixel, WaveGetLaneIndex(), true, r);
    uint place = uint(WAVE_WORDS) * (uint(pixel.y) * gScene.width + uint(pixel.x));
    for (uint k = 0u; k < uint(WAVE_WORDS); k++)
        gResults.Store(4u * (place + k), r[k]);
}
