// SPDX-License-Identifier: MIT
// Light without assets: a sun, and a sky whose radiance is quadratic in height, L(d) = a + b y + c y². That
// is a spherical harmonic of order 2, so its irradiance and its reflections in rough surfaces have closed
// forms (Ramamoorthi and Hanrahan 2001) and need no textures. Declares no resource.
//
// Reflections of the sky use the split sum (Karis 2013): the sky prefiltered by the distribution of
// microfacets, times f0 * A + B. A and B are a table of 32 x 32 cells that the host computes
// (scene/EnvironmentTable.h); who has it reads the four cells of NtcrGetEnvironmentTaps.
#ifndef OPENNTC_RENDERER_LIGHTING_H
#define OPENNTC_RENDERER_LIGHTING_H

#include "Shading.h"

#define NTCR_ENVIRONMENT_SIZE 32

NTC_NAMESPACE_BEGIN

/// 80 bytes, the same in every language: may be a member of a constant buffer. Fourth components are unused.
struct NtcrLights {
    float4 sunDirection;  // to the sun, unit vector
    float4 sunIrradiance; // on a surface that faces it
    float4 skyA;          // radiance of the horizon
    float4 skyB;          // (zenith - ground) / 2
    float4 skyC;          // (zenith + ground) / 2 - horizon
};

NTC_FUNCTION float3 NtcrGetXyz(float4 v) {
    return float3(v.x, v.y, v.z);
}

/// Radiance from direction d, +Y up.
NTC_FUNCTION float3 NtcrGetSky(NtcrLights lights, float3 d) {
    return NtcrGetXyz(lights.skyA) + (NtcrGetXyz(lights.skyB) + NtcrGetXyz(lights.skyC) * d.y) * d.y;
}

/// Irradiance over pi: what a white diffuse surface sends out.
NTC_FUNCTION float3 NtcrGetSkyIrradiance(NtcrLights lights, float3 n) {
    return NtcrGetXyz(lights.skyA) + NtcrGetXyz(lights.skyB) * (n.y * 2.0f / 3.0f) +
           NtcrGetXyz(lights.skyC) * (0.25f + 0.25f * n.y * n.y);
}

/// What is left of the sky's linear and quadratic part in reflections, by perceptual roughness: means over
/// the distribution of microfacets (n = v = r), linear between tenths.
NTC_FUNCTION float2 NtcrGetPrefilter(float roughness) {
    const float first[11] = {1.0f,    0.9987f, 0.9876f, 0.9603f, 0.9182f, 0.8674f,
                             0.8151f, 0.7667f, 0.7255f, 0.6923f, 0.6667f};
    const float second[11] = {1.0f,    0.9962f, 0.9653f, 0.8917f, 0.7842f, 0.6624f,
                              0.5447f, 0.4425f, 0.3601f, 0.2969f, 0.25f};
    float place = clamp(roughness, 0.0f, 1.0f) * 10.0f;
    int i = min(int(place), 9);
    float t = place - float(i);
    return float2(first[i] + (first[i + 1] - first[i]) * t, second[i] + (second[i + 1] - second[i]) * t);
}

/// The sky as a surface of this roughness reflects it along r.
NTC_FUNCTION float3 NtcrGetPrefilteredSky(NtcrLights lights, float3 r, float roughness) {
    float2 p = NtcrGetPrefilter(roughness);
    return NtcrGetXyz(lights.skyA) + NtcrGetXyz(lights.skyB) * (p.x * r.y) +
           NtcrGetXyz(lights.skyC) * (1.0f / 3.0f + p.y * (r.y * r.y - 1.0f / 3.0f));
}

/// Where A and B lie in the table: (1 - x) (1 - y) of cell `first`, x (1 - y) of `first + 1`, (1 - x) y of
/// `first + NTCR_ENVIRONMENT_SIZE`, x y of the one after that.
struct NtcrEnvironmentTaps {
    uint first;
    float x;
    float y;
};

/// Rows are the square root of roughness, columns that of |n·v|, both 0 to 1 at the outermost cells: near
/// 0 A and B change most. They are then within 0.005 of the integral.
NTC_FUNCTION NtcrEnvironmentTaps NtcrGetEnvironmentTaps(float roughness, float nDotV) {
    float last = float(NTCR_ENVIRONMENT_SIZE - 1);
    float column = sqrt(min(abs(nDotV), 1.0f)) * last;
    float row = sqrt(clamp(roughness, 0.0f, 1.0f)) * last;
    int x = min(int(column), NTCR_ENVIRONMENT_SIZE - 2);
    int y = min(int(row), NTCR_ENVIRONMENT_SIZE - 2);
    NtcrEnvironmentTaps taps;
    taps.first = uint(y * NTCR_ENVIRONMENT_SIZE + x);
    taps.x = column - float(x);
    taps.y = row - float(y);
    return taps;
}

/// A and B out of the four cells, in the order of NtcrEnvironmentTaps.
NTC_FUNCTION float2 NtcrMixEnvironment(NtcrEnvironmentTaps taps, float2 c0, float2 c1, float2 c2, float2 c3) {
    float2 low = c0 + (c1 - c0) * taps.x;
    float2 high = c2 + (c3 - c2) * taps.x;
    return low + (high - low) * taps.y;
}

/// One light of an exact direction. `visible`: 0 in its shadow, 1 in its light.
NTC_FUNCTION NtcrReflection NtcrReflectSun(NtcrLights lights, NtcrSurface surface, float3 n, float3 v,
                                           float visible) {
    float3 l = NtcrGetXyz(lights.sunDirection);
    float3 irradiance = NtcrGetXyz(lights.sunIrradiance) * (max(dot(n, l), 0.0f) * visible);
    NtcrReflection reflection = NtcrEvaluateBrdf(surface, n, v, l);
    reflection.diffuse = reflection.diffuse * irradiance;
    reflection.specular = reflection.specular * irradiance;
    return reflection;
}

/// The sky, before occlusion. `environment`: A and B.
NTC_FUNCTION NtcrReflection NtcrReflectSky(NtcrLights lights, NtcrSurface surface, float3 n, float3 v,
                                           float2 environment) {
    float3 fresnel = surface.f0 * environment.x + NtcrGray(environment.y);
    float3 r = n * (2.0f * dot(n, v)) - v;
    NtcrReflection reflection;
    reflection.specular = NtcrGetPrefilteredSky(lights, r, surface.roughness) * fresnel;
    reflection.diffuse = NtcrGetSkyIrradiance(lights, n) * surface.diffuse * (NtcrGray(1.0f) - fresnel);
    return reflection;
}

/// Both lights on a surface. `occlusion` (NtcrGetOcclusion; 1 without a texture) dims the sky alone.
NTC_FUNCTION NtcrReflection NtcrReflectLights(NtcrLights lights, NtcrSurface surface, float3 n, float3 v,
                                              float2 environment, float occlusion, float visible) {
    NtcrReflection sun = NtcrReflectSun(lights, surface, n, v, visible);
    NtcrReflection sky = NtcrReflectSky(lights, surface, n, v, environment);
    NtcrReflection sum;
    sum.diffuse = sun.diffuse + sky.diffuse * occlusion;
    sum.specular = sun.specular + sky.specular * occlusion;
    return sum;
}

NTC_FUNCTION float3 NtcrGetRadiance(NtcrReflection reflection) {
    return reflection.diffuse + reflection.specular;
}

/// KHR_materials_transmission of a thin surface, without what is behind it: in the share `transmission`, the
/// sky along the view ray takes the place of the diffuse part, as blurred as a reflection would be.
NTC_FUNCTION float3 NtcrGetTransmittedRadiance(NtcrLights lights, NtcrSurface surface,
                                               NtcrReflection reflection, float3 v, float2 environment,
                                               float transmission) {
    float3 fresnel = surface.f0 * environment.x + NtcrGray(environment.y);
    float3 behind = NtcrGetPrefilteredSky(lights, -v, surface.roughness);
    float3 passed = surface.diffuse * (NtcrGray(1.0f) - fresnel) * behind;
    return reflection.specular + NtcrMix(reflection.diffuse, passed, transmission);
}

NTC_NAMESPACE_END

#endif
