// SPDX-License-Identifier: MIT
// The light that a pixel of a triangle sends to the eye. Beside the material's textures (MaterialTexels.glsl):
//   NTCR_SPEC_GLOSS     specular-glossiness in the place of metallic-roughness
//   NTCR_EMISSION, NTCR_TRANSMITS   the material emits, or lets light through
#ifndef OPENNTC_RENDERER_SHADE_GLSL
#define OPENNTC_RENDERER_SHADE_GLSL

#include "MaterialTexels.glsl"
#include "Shading.h"

layout(set = 0, binding = 4, std430) readonly buffer EnvironmentTable {
    vec2 gEnvironment[];
};

NtcrSurface NtcrGetSurface(NtcrTexel texel, vec3 color) {
#if NTCR_SPEC_GLOSS
    vec4 gloss = gMaterial.specularGlossiness;
#if NTCR_SPECULAR_GLOSSINESS_SOURCE
    gloss *= clamp(texel.gloss, 0.0, 1.0);
#endif
    return NtcrMakeSpecularGlossiness(color, gloss.xyz, gloss.w);
#else
    float metallic = gMaterial.metallic, roughness = gMaterial.roughness;
#if NTCR_METALLIC_ROUGHNESS_SOURCE
    roughness *= clamp(texel.gloss.x, 0.0, 1.0);
    metallic *= clamp(texel.gloss.y, 0.0, 1.0);
#endif
    return NtcrMakeMetallicRoughness(color, metallic, roughness);
#endif
}

vec3 NtcrGetNormal(NtcrTexel texel, NtcrGeometry geometry, NtcrPlace place) {
    vec3 normal = normalize(geometry.normal);
#if NTCR_NORMAL_SOURCE
    vec3 bent = NtcrUnpackNormal(texel.relief.xyz, gMaterial.normalScale);
    if (geometry.tangent.w != 0.0) {
        normal = NtcrBendByTangents(bent, geometry.normal, geometry.tangent);
    } else {
        NtcrLookup row = gMaterial.lookups[NTCR_NORMAL_LOOKUP];
        NtcrUv uv = NtcrGetUv(place, row.row0, row.row1);
        NtcrDerivatives d;
        d.positionX = geometry.alongX;
        d.positionY = geometry.alongY;
        d.uvX = uv.alongX;
        d.uvY = uv.alongY;
        normal = NtcrBendByDerivatives(bent, normal, d);
    }
#endif
    return place.isBack ? -normal : normal;
}

/// Radiance and alpha. With NTCR_FILTER 2 and 3 every lane of the wave calls this; of lanes that are not live the result
/// means nothing.
vec4 NtcrShade(uint instance, uint triangle, ivec2 pixel, bool isLive) {
    NtcrPlace place = NtcrGetPlace(instance, triangle, pixel);
    NtcrTexel texel = NtcrGetTexel(place, pixel, isLive);
    NtcrGeometry geometry = NtcrGetGeometry(instance, place);
    vec4 color = clamp(texel.color, 0.0, 1.0) * gMaterial.baseColor * NtcrGetColor(place);
    NtcrSurface surface = NtcrGetSurface(texel, color.xyz);
    vec3 n = NtcrGetNormal(texel, geometry, place);
    vec3 toEye = gFrame.eye.w != 0.0 ? gFrame.eye.xyz - geometry.position : -gFrame.rayCenter.xyz;
    vec3 v = normalize(toEye);
    float nDotV = abs(dot(n, v));
    NtcrEnvironmentTaps taps = NtcrGetEnvironmentTaps(surface.roughness, nDotV);
    vec2 environment =
        NtcrMixEnvironment(taps, gEnvironment[taps.first], gEnvironment[taps.first + 1u],
                           gEnvironment[taps.first + uint(NTCR_ENVIRONMENT_SIZE)],
                           gEnvironment[taps.first + uint(NTCR_ENVIRONMENT_SIZE) + 1u]);
    float occlusion = 1.0;
#if NTCR_OCCLUSION_SOURCE
    occlusion = NtcrGetOcclusion(clamp(texel.relief.w, 0.0, 1.0), gMaterial.occlusionStrength);
#endif
    NtcrReflection reflection =
        NtcrReflectLights(gFrame.lights, surface, n, v, environment, occlusion, 1.0);
#if NTCR_TRANSMITS
    float transmission = gMaterial.emissive.w;
#if NTCR_TRANSMISSION_SOURCE
    transmission *= clamp(texel.light.w, 0.0, 1.0);
#endif
    vec3 radiance =
        NtcrGetTransmittedRadiance(gFrame.lights, surface, reflection, v, environment, transmission);
#else
    vec3 radiance = NtcrGetRadiance(reflection);
#endif
#if NTCR_EMISSION
    vec3 emission = gMaterial.emissive.xyz;
#if NTCR_EMISSIVE_SOURCE
    emission *= max(texel.light.xyz, vec3(0.0));
#endif
    radiance += emission;
#endif
    return vec4(radiance, color.w);
}

#endif
