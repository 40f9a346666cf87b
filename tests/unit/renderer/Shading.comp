// SPDX-License-Identifier: MIT
// The renderer's maths as GLSL: compiled, not run.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "renderer/shaders/Lighting.h"
#include "renderer/shaders/ToneMap.h"

layout(local_size_x = 1) in;
layout(set = 0, binding = 0, std430) buffer Data {
    NtcrLights lights;
    NtcrDerivatives d;
    vec3 n;
    vec3 v;
    uint pixel;
}
gData;

void main() {
    NtcrSurface a = NtcrMakeMetallicRoughness(gData.n, gData.v.x, gData.v.y);
    NtcrSurface b = NtcrMakeSpecularGlossiness(gData.n, gData.v, gData.v.y);
    vec3 n = NtcrBendByDerivatives(NtcrUnpackNormal(gData.v, 1.0), gData.n, gData.d);
    n = NtcrBendByTangents(n, gData.n, vec4(gData.v, 1.0));
    NtcrEnvironmentTaps taps = NtcrGetEnvironmentTaps(a.roughness, dot(n, gData.v));
    vec2 environment = NtcrMixEnvironment(taps, vec2(0.1), vec2(0.2), vec2(0.3), vec2(0.4));
    NtcrReflection r =
        NtcrReflectLights(gData.lights, a, n, gData.v, environment, NtcrGetOcclusion(0.5, 1.0), 1.0);
    vec3 color = NtcrGetTransmittedRadiance(gData.lights, b, r, gData.v, environment, 0.5);
    color += NtcrGetRadiance(r);
    vec2 uv = NtcrTransformUv(gData.v.xy, gData.n, gData.v);
    gData.pixel = NtcrMakePixel(color * uv.x, uv.y, NTCR_TONE_NEUTRAL);
}
