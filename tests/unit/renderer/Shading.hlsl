// SPDX-License-Identifier: MIT
// The renderer's maths as HLSL: compiled, not run.
#include "renderer/shaders/Lighting.h"
#include "renderer/shaders/ToneMap.h"

struct Data {
    NtcrLights lights;
    NtcrDerivatives d;
    float3 n;
    float3 v;
};
StructuredBuffer<Data> gData : register(t0);
RWStructuredBuffer<uint> gPixels : register(u1);

[numthreads(1, 1, 1)] void main() {
    Data data = gData[0];
    NtcrSurface a = NtcrMakeMetallicRoughness(data.n, data.v.x, data.v.y);
    NtcrSurface b = NtcrMakeSpecularGlossiness(data.n, data.v, data.v.y);
    float3 n = NtcrBendByDerivatives(NtcrUnpackNormal(data.v, 1.0f), data.n, data.d);
    n = NtcrBendByTangents(n, data.n, float4(data.v, 1.0f));
    NtcrEnvironmentTaps taps = NtcrGetEnvironmentTaps(a.roughness, dot(n, data.v));
    float2 environment =
        NtcrMixEnvironment(taps, data.n.xy, data.n.yz, data.v.xy, data.v.yz);
    NtcrReflection r =
        NtcrReflectLights(data.lights, a, n, data.v, environment, NtcrGetOcclusion(0.5f, 1.0f), 1.0f);
    float3 color = NtcrGetTransmittedRadiance(data.lights, b, r, data.v, environment, 0.5f);
    color += NtcrGetRadiance(r);
    float2 uv = NtcrTransformUv(data.v.xy, data.n, data.v);
    gPixels[0] = NtcrMakePixel(color * uv.x, uv.y, NTCR_TONE_NEUTRAL);
}
