// SPDX-License-Identifier: MIT
// Whether a masked surface is there: MaterialTexels.glsl with the definitions for the one texture that has the mask.
#ifndef OPENNTC_RENDERER_MASK_GLSL
#define OPENNTC_RENDERER_MASK_GLSL

#include "MaterialTexels.glsl"

bool NtcrIsThere(uint instance, uint triangle, ivec2 pixel) {
    NtcrPlace place = NtcrGetPlace(instance, triangle, pixel);
    NtcrTexel texel = NtcrGetTexel(place, pixel, true);
    float alpha = clamp(texel.color.w, 0.0, 1.0) * gMaterial.baseColor.w * NtcrGetColor(place).w;
    return alpha >= gMaterial.alphaCutoff;
}

#endif
