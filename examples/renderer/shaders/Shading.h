// SPDX-License-Identifier: MIT
// How surfaces reflect light: glTF 2.0's metallic-roughness model (Appendix B, with the height-correlated
// Smith term) and KHR_materials_pbrSpecularGlossiness, normal maps and texture coordinates. Linear Rec. 709.
// Declares no resource. A shader calls what its material has: there is nothing to switch off.
//
// Directions are unit vectors that point away from the surface: n (normal), v (to the eye), l (to the light).
#ifndef OPENNTC_RENDERER_SHADING_H
#define OPENNTC_RENDERER_SHADING_H

#include "Vectors.h"

NTC_NAMESPACE_BEGIN

/// What both models come to. Make it with NtcrMakeMetallicRoughness or NtcrMakeSpecularGlossiness.
struct NtcrSurface {
    float3 diffuse;  // albedo of the diffuse part
    float3 f0;       // reflectance at normal incidence
    float coupling;  // the diffuse part gets 1 - Fresnel(coupling) of the light
    float roughness; // perceptual, 0 ... 1
    float alpha;     // of the distribution of microfacets
};

/// Light that comes back, by the two parts of the model.
struct NtcrReflection {
    float3 diffuse;
    float3 specular;
};

NTC_FUNCTION float NtcrGetAlpha(float roughness) {
    return max(roughness * roughness, 1e-3f);
}

/// roughness and metallic 0 ... 1.
NTC_FUNCTION NtcrSurface NtcrMakeMetallicRoughness(float3 baseColor, float metallic, float roughness) {
    NtcrSurface surface;
    surface.diffuse = baseColor * (1.0f - metallic);
    surface.f0 = NtcrMix(NtcrGray(0.04f), baseColor, metallic);
    surface.coupling = 0.04f;
    surface.roughness = roughness;
    surface.alpha = NtcrGetAlpha(roughness);
    return surface;
}

/// `diffuse` before it gives up what is reflected: the extension's c = diffuse * (1 - max(specular)).
NTC_FUNCTION NtcrSurface NtcrMakeSpecularGlossiness(float3 diffuse, float3 specular, float glossiness) {
    NtcrSurface surface;
    surface.coupling = NtcrGetLargest(specular);
    surface.diffuse = diffuse * (1.0f - surface.coupling);
    surface.f0 = specular;
    surface.roughness = 1.0f - glossiness;
    surface.alpha = NtcrGetAlpha(surface.roughness);
    return surface;
}

/// Trowbridge and Reitz's distribution of microfacets (GGX). The sine is that of the angle between n and h:
/// as 1 - cosine², narrow highlights would lose most of their digits.
NTC_FUNCTION float NtcrGetDistribution(float alpha, float3 n, float3 h) {
    float cosine = dot(n, h);
    if (cosine <= 0.0f)
        return 0.0f;
    float3 sine = cross(n, h);
    float d = dot(sine, sine) + alpha * alpha * cosine * cosine;
    return alpha * alpha / (NTCR_PI * d * d);
}

/// Smith's visibility term, height-correlated, with the 4 (n·l) (n·v) of the denominator in it. Cosines >= 0.
NTC_FUNCTION float NtcrGetVisibility(float alpha, float nDotL, float nDotV) {
    float a = alpha * alpha;
    float light = nDotV * sqrt(a + (1.0f - a) * nDotL * nDotL);
    float view = nDotL * sqrt(a + (1.0f - a) * nDotV * nDotV);
    return 0.5f / max(light + view, 1e-12f);
}

/// Schlick's weight of the reflectance at grazing angles.
NTC_FUNCTION float NtcrGetFresnelWeight(float vDotH) {
    float x = 1.0f - min(abs(vDotH), 1.0f);
    return NtcrSquare(x * x) * x;
}

/// The BRDF, without the cosine of the light; nothing for light from behind.
NTC_FUNCTION NtcrReflection NtcrEvaluateBrdf(NtcrSurface surface, float3 n, float3 v, float3 l) {
    NtcrReflection reflection;
    reflection.diffuse = NtcrGray(0.0f);
    reflection.specular = NtcrGray(0.0f);
    float nDotL = dot(n, l);
    if (nDotL <= 0.0f)
        return reflection;
    float3 h = normalize(v + l);
    float fresnel = NtcrGetFresnelWeight(dot(v, h));
    float specular =
        NtcrGetDistribution(surface.alpha, n, h) * NtcrGetVisibility(surface.alpha, nDotL, abs(dot(n, v)));
    reflection.specular = NtcrMix(surface.f0, NtcrGray(1.0f), fresnel) * specular;
    reflection.diffuse = surface.diffuse * ((1.0f - surface.coupling) * (1.0f - fresnel) / NTCR_PI);
    return reflection;
}

/// What occlusion leaves of indirect light. `texel`: red of the texture.
NTC_FUNCTION float NtcrGetOcclusion(float texel, float strength) {
    return 1.0f + strength * (texel - 1.0f);
}

/// A texel of a normal map, 0 ... 1, as a unit vector in the frame of the texture.
NTC_FUNCTION float3 NtcrUnpackNormal(float3 texel, float scale) {
    float3 n = texel * 2.0f - NtcrGray(1.0f);
    n = float3(n.x * scale, n.y * scale, n.z);
    return n * (1.0f / sqrt(max(dot(n, n), 1e-20f)));
}

/// `bent` (NtcrUnpackNormal) in the frame of vertex tangents. normal and tangent as interpolated, not made
/// unit vectors again: so are maps baked (MikkTSpace). tangent.w: -1 or 1.
NTC_FUNCTION float3 NtcrBendByTangents(float3 bent, float3 normal, float4 tangent) {
    float3 t = float3(tangent.x, tangent.y, tangent.z);
    return normalize(t * bent.x + cross(normal, t) * (tangent.w * bent.y) + normal * bent.z);
}

/// Differences of position and texture coordinates from pixel to pixel, along x and y of the screen.
struct NtcrDerivatives {
    float3 positionX;
    float3 positionY;
    float2 uvX;
    float2 uvY;
};

/// `bent` in the frame of the gradients of the texture coordinates (Mikkelsen 2010), which needs no tangents.
/// `normal`: unit vector. Green of glTF's normal maps is up in the image, to where v falls; tangents in its
/// files say the same.
NTC_FUNCTION float3 NtcrBendByDerivatives(float3 bent, float3 normal, NtcrDerivatives d) {
    float3 a = cross(d.positionY, normal);
    float3 b = cross(normal, d.positionX);
    float3 t = a * d.uvX.x + b * d.uvY.x;
    float3 s = a * d.uvX.y + b * d.uvY.y;
    // The sign of the triangle on the screen: seen from behind or with y pointing down, a and b turn round.
    float side = dot(cross(d.positionX, d.positionY), normal) < 0.0f ? -1.0f : 1.0f;
    float scale = side / sqrt(max(max(dot(t, t), dot(s, s)), 1e-30f));
    return normalize(t * (scale * bent.x) - s * (scale * bent.y) + normal * bent.z);
}

/// KHR_texture_transform as two rows (UvTransform of Scene.h).
NTC_FUNCTION float2 NtcrTransformUv(float2 uv, float3 row0, float3 row1) {
    float3 p = float3(uv.x, uv.y, 1.0f);
    return float2(dot(row0, p), dot(row1, p));
}

NTC_NAMESPACE_END

#endif
