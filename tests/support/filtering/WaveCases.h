// SPDX-License-Identifier: MIT
// Pixels of a picture that is filtered by waves, in the common subset: shaders run them on a device, tests
// on emulated waves. Includes what waves need; in C++ their emulation comes before.
#ifndef OPENNTC_TESTS_WAVE_CASES_H
#define OPENNTC_TESTS_WAVE_CASES_H

#include "openntc/StochasticFiltering.h"
#include "openntc/filtering/StfShare.h"

// WaveScene::flags
#define WAVE_DISCARD 1u // a pattern of pixels takes no part
#define WAVE_KEYS 2u    // two textures
#define WAVE_ISLANDS 4u // pixels of a wave lie in two places of the texture
#define WAVE_MIPS 8u    // levels of detail differ from pixel to pixel
#define WAVE_SHARE 16u  // sharing; else collaboration
#define WAVE_ROTATE 32u // shared lanes use one number, rotated by lane
#define WAVE_WORDS 16

#if defined(__cplusplus)
#include <cmath>
namespace openntc {
#define WAVE_FIELD_UINT std::uint32_t
#define WAVE_FIELD_INT std::int32_t
#else
#define WAVE_FIELD_UINT uint
#define WAVE_FIELD_INT int
#endif

struct WaveScene { // 64 bytes
    WAVE_FIELD_UINT kernel;
    WAVE_FIELD_UINT wrap;
    WAVE_FIELD_UINT flags;
    WAVE_FIELD_UINT maxRounds;
    WAVE_FIELD_UINT span;
    WAVE_FIELD_UINT frame;
    WAVE_FIELD_UINT frames; // summed up, from `frame` on
    WAVE_FIELD_INT size;    // of the texture; mips down to 1
    float u;                // of pixel 0
    float v;
    float dudx; // and minus those for v of y: a rotation
    float dvdx;
    WAVE_FIELD_INT lod; // of all pixels, unless WAVE_MIPS
    WAVE_FIELD_UINT mips;
    WAVE_FIELD_UINT width; // of the picture
    WAVE_FIELD_UINT taps;  // anisotropic
};

#if defined(__cplusplus)
/// `magnification` pixels a texel of 256 x 256, aligned or turned by 45 degrees; one frame.
inline WaveScene MakeWaveScene(std::uint32_t kernel, double magnification, bool isTurned) {
    WaveScene scene{};
    scene.kernel = kernel;
    scene.wrap = NTC_WRAP_REPEAT;
    scene.maxRounds = 8;
    scene.span = 4;
    scene.frames = 1;
    scene.size = 256;
    const double step = 1 / magnification / 256;
    scene.dudx = static_cast<float>(isTurned ? step * std::sqrt(0.5) : step);
    scene.dvdx = isTurned ? scene.dudx : 0.0f;
    scene.mips = NTC_MIPS_NEAREST;
    scene.taps = 1;
    return scene;
}
} // namespace openntc
#endif

NTC_NAMESPACE_BEGIN

// How many texels this lane has decoded.
#if defined(__cplusplus)
inline thread_local uint waveDecodes = 0;
#elif defined(NTC_HLSL)
static uint waveDecodes;
#else
uint waveDecodes;
#endif

struct WaveContext {
    uint key;
};

NTC_FUNCTION float4 WaveFetch(WaveContext context, NtcStfTap tap) {
    if (tap.isBorder)
        return float4(0.25f, 0.5f, 0.125f, 1.0f);
    waveDecodes += 1u;
    uint4 words = NtcStfPcg4d(uint(tap.texel.x), uint(tap.texel.y), uint(tap.mip), context.key);
    return float4(float(words.x >> 8) * 5.9604645e-8f, float(words.y >> 8) * 5.9604645e-8f,
                  float(words.z >> 8) * 5.9604645e-8f, float(words.w >> 8) * 5.9604645e-8f);
}

NTC_STF_DEFINE_FILTER(WaveExact, float4, WaveContext, WaveFetch)
NTC_STF_DEFINE_COLLABORATION(WaveCollaborate, float4, WaveContext, WaveFetch)
NTC_STF_DEFINE_SHARING(WaveShare, float4, WaveContext, WaveFetch)

NTC_FUNCTION int GetWaveLevels(int size) {
    int levels = 1;
    for (int rest = size; rest > 1; rest >>= 1)
        levels += 1;
    return levels;
}

/// Arrangements of a wave's lanes: quads side by side, then rows of them: 8 lanes are 4 x 2, 32 lanes 8 x 4.
NTC_FUNCTION int2 GetWavePixel(uint lane) {
    return int2(int((lane & 1u) | ((lane >> 1) & 2u) | ((lane >> 2) & 4u)),
                int(((lane >> 1) & 1u) | ((lane >> 2) & 2u) | ((lane >> 3) & 4u)));
}

NTC_FUNCTION bool IsWaveDiscarded(WaveScene scene, int2 pixel) {
    return (scene.flags & WAVE_DISCARD) != 0u && (pixel.x * 5 + pixel.y * 3) % 7 < 3;
}

/// What a pixel looks up.
struct WaveLookup {
    NtcStfSampler settings;
    NtcStfExtent extent;
    NtcStfFootprint footprint;
    WaveContext context;
    float2 uv;
};

NTC_FUNCTION WaveLookup MakeWaveLookup(WaveScene scene, int2 pixel) {
    WaveLookup lookup;
    lookup.settings = NtcStfMakeSampler(scene.kernel, scene.wrap);
    lookup.settings.mips = scene.mips;
    lookup.extent = NtcStfMakeExtent(scene.size, scene.size, GetWaveLevels(scene.size));
    lookup.context.key = (scene.flags & WAVE_KEYS) != 0u ? uint((pixel.x + 3 * pixel.y) % 5) & 1u : 0u;
    int lod = scene.lod;
    if ((scene.flags & WAVE_MIPS) != 0u)
        lod += ((pixel.x * 7 + pixel.y * 13) % 5) * 40000;
    lookup.footprint = NtcStfMakeFootprint(lookup.settings, lookup.extent, lod);
    lookup.footprint.taps = scene.taps;
    lookup.footprint.axis = float2(NtcMultiply(scene.dudx, 3.0f), NtcMultiply(scene.dvdx, 3.0f));
    float x = float(pixel.x) + 0.5f;
    float y = float(pixel.y) + 0.5f;
    NTC_PRECISE float turnedX = NtcMultiply(x, scene.dudx) - NtcMultiply(y, scene.dvdx);
    NTC_PRECISE float turnedY = NtcMultiply(x, scene.dvdx) + NtcMultiply(y, scene.dudx);
    NTC_PRECISE float u = scene.u + NtcKeep(turnedX);
    NTC_PRECISE float v = scene.v + NtcKeep(turnedY);
    lookup.uv = float2(NtcKeep(u), NtcKeep(v));
    if ((scene.flags & WAVE_ISLANDS) != 0u && (pixel.x + pixel.y) % 3 == 0)
        lookup.uv.x = NtcMultiply(lookup.uv.x, 0.5f);
    return lookup;
}

/// Words 0 ... 3: by the wave, summed over frames; 4 ... 7: the exact filter; 8: texels decoded by the wave;
/// 9: the texels that the exact filter decodes; 10: 1 if the pixel took part; 11 ... 14: squared errors of
/// frames, summed.
NTC_FUNCTION void RunWavePixel(WaveScene scene, int2 pixel, uint lane, bool isLive,
                               NTC_OUT_ARRAY(uint, r, WAVE_WORDS)) {
    for (int i = 0; i < WAVE_WORDS; i++)
        r[i] = 0u;
    WaveLookup lookup = MakeWaveLookup(scene, pixel);
    float4 exact = WaveExact(lookup.context, lookup.settings, lookup.extent, lookup.uv, lookup.footprint);
    r[9] = waveDecodes;
    waveDecodes = 0u;
    NtcStfWaveLane waveLane = NtcStfMakeWaveLane(lookup.context.key, isLive);
    waveLane.maxRounds = scene.maxRounds;
    float4 sum = float4(0.0f, 0.0f, 0.0f, 0.0f);
    float4 squares = sum;
    NTC_LOOP for (uint frame = 0u; frame < scene.frames; frame++) {
        uint4 random = NtcStfRandomHashed(pixel, scene.frame + frame, 0u, 0u);
        if ((scene.flags & WAVE_ROTATE) != 0u)
            random = NtcStfRotateLane(NtcStfRandomHashed(int2(0, 0), scene.frame + frame, 0u, 0u), lane);
        float4 value;
        if ((scene.flags & WAVE_SHARE) != 0u)
            value = WaveShare(lookup.context, waveLane, scene.span, lookup.settings, lookup.extent, lookup.uv,
                              lookup.footprint, random);
        else
            value = WaveCollaborate(lookup.context, waveLane, lookup.settings, lookup.extent, lookup.uv,
                                    lookup.footprint, random);
        NtcStfAdd(sum, value, 1.0f);
        float4 error = value - exact;
        NtcStfAdd(squares, error * error, 1.0f);
    }
    r[0] = asuint(sum.x);
    r[1] = asuint(sum.y);
    r[2] = asuint(sum.z);
    r[3] = asuint(sum.w);
    r[4] = asuint(exact.x);
    r[5] = asuint(exact.y);
    r[6] = asuint(exact.z);
    r[7] = asuint(exact.w);
    r[8] = waveDecodes;
    r[10] = isLive ? 1u : 0u;
    r[11] = asuint(squares.x);
    r[12] = asuint(squares.y);
    r[13] = asuint(squares.z);
    r[14] = asuint(squares.w);
}

NTC_NAMESPACE_END

#endif
