// SPDX-License-Identifier: MIT
// A material's texels through the taps of StochasticFiltering.h, wherever they come from. Compiled for what the material
// has; slot X is one of BASE_COLOR, METALLIC_ROUGHNESS, SPECULAR_GLOSSINESS, NORMAL, OCCLUSION, EMISSIVE, TRANSMISSION:
//   NTCR_X_SOURCE    1: the source image; 2: a texture made from a texture set; 3: a texture set, decoded here
//   NTCR_X_LOOKUP    which of the material's lookups reads it
//   NTCR_X_CHANNEL   with source 3: its first channel
//   NTCR_X_LINEAR    with sources 1 and 2: colours are stored linear
//   NTCR_NORMAL_XY   the normal map has two channels
//   NTCR_LOOKUPS, NTCR_SET_LOOKUPS   how many; a bit for each that decodes
//   NTCR_TILED       textures of source 2 are tiles in atlases (FeedbackTiles.glsl)
//   NTCR_ALPHA       alpha counts
//   NTCR_KERNEL      NTC_KERNEL_*; not defined: that of the sampler
//   NTCR_MIPS        NTC_MIPS_*; likewise
//   NTCR_ISOTROPIC   samplers have no anisotropy
//   NTCR_FILTER      0: all texels; 1: one; 2: one, shared by 2 x 2 pixels; 3: all, divided among a wave
#ifndef OPENNTC_RENDERER_MATERIAL_TEXELS_GLSL
#define OPENNTC_RENDERER_MATERIAL_TEXELS_GLSL

#extension GL_EXT_samplerless_texture_functions : require

#if NTCR_SET_LOOKUPS
#include "openntc/Inference.h"
layout(set = 1, binding = 8, std140) uniform TextureSet {
    NtcTextureSetConstants gSet;
};
#endif

#include "openntc/StochasticFiltering.h"
#if NTCR_FILTER == 2
#include "openntc/filtering/StfShare.h"
#elif NTCR_FILTER == 3
#include "openntc/filtering/StfCollaborate.h"
#endif
#include "openntc/ColorSpaces.h"
#include "Scene.glsl"
#if NTCR_TILED
#include "FeedbackTiles.glsl"
#endif

layout(set = 1, binding = 0, std140) uniform Material {
    NtcrMaterial gMaterial;
};
layout(set = 0, binding = 5, std430) buffer Counters {
    uint gCounters[]; // low and high words: texels of lookups, texels decoded
};

uint gTexels = 0u, gDecoded = 0u; // of this invocation

#define NTCR_DECLARE_IMAGE(slot, number) layout(set = 1, binding = number) uniform texture2D slot
#if NTCR_TILED
#define NTCR_DECLARE_DECODED(slot, number) layout(set = 1, binding = number) uniform texture2DArray slot
#else
#define NTCR_DECLARE_DECODED(slot, number) NTCR_DECLARE_IMAGE(slot, number)
#endif
#if NTCR_BASE_COLOR_SOURCE == 1
NTCR_DECLARE_IMAGE(gBaseColor, 1);
#define NTCR_READ_BASE_COLOR NTCR_READ_IMAGE(gBaseColor)
#elif NTCR_BASE_COLOR_SOURCE == 2
NTCR_DECLARE_DECODED(gBaseColor, 1);
#define NTCR_READ_BASE_COLOR NTCR_READ_DECODED(gBaseColor)
#endif
#if NTCR_METALLIC_ROUGHNESS_SOURCE == 1
NTCR_DECLARE_IMAGE(gMetallicRoughness, 2);
#define NTCR_READ_METALLIC_ROUGHNESS NTCR_READ_IMAGE(gMetallicRoughness)
#elif NTCR_METALLIC_ROUGHNESS_SOURCE == 2
NTCR_DECLARE_DECODED(gMetallicRoughness, 2);
#define NTCR_READ_METALLIC_ROUGHNESS NTCR_READ_DECODED(gMetallicRoughness)
#endif
#if NTCR_SPECULAR_GLOSSINESS_SOURCE == 1
NTCR_DECLARE_IMAGE(gSpecularGlossiness, 3);
#define NTCR_READ_SPECULAR_GLOSSINESS NTCR_READ_IMAGE(gSpecularGlossiness)
#elif NTCR_SPECULAR_GLOSSINESS_SOURCE == 2
NTCR_DECLARE_DECODED(gSpecularGlossiness, 3);
#define NTCR_READ_SPECULAR_GLOSSINESS NTCR_READ_DECODED(gSpecularGlossiness)
#endif
#if NTCR_NORMAL_SOURCE == 1
NTCR_DECLARE_IMAGE(gNormal, 4);
#define NTCR_READ_NORMAL NTCR_READ_IMAGE(gNormal)
#elif NTCR_NORMAL_SOURCE == 2
NTCR_DECLARE_DECODED(gNormal, 4);
#define NTCR_READ_NORMAL NTCR_READ_DECODED(gNormal)
#endif
#if NTCR_OCCLUSION_SOURCE == 1
NTCR_DECLARE_IMAGE(gOcclusion, 5);
#define NTCR_READ_OCCLUSION NTCR_READ_IMAGE(gOcclusion)
#elif NTCR_OCCLUSION_SOURCE == 2
NTCR_DECLARE_DECODED(gOcclusion, 5);
#define NTCR_READ_OCCLUSION NTCR_READ_DECODED(gOcclusion)
#endif
#if NTCR_EMISSIVE_SOURCE == 1
NTCR_DECLARE_IMAGE(gEmissive, 6);
#define NTCR_READ_EMISSIVE NTCR_READ_IMAGE(gEmissive)
#elif NTCR_EMISSIVE_SOURCE == 2
NTCR_DECLARE_DECODED(gEmissive, 6);
#define NTCR_READ_EMISSIVE NTCR_READ_DECODED(gEmissive)
#endif
#if NTCR_TRANSMISSION_SOURCE == 1
NTCR_DECLARE_IMAGE(gTransmission, 7);
#define NTCR_READ_TRANSMISSION NTCR_READ_IMAGE(gTransmission)
#elif NTCR_TRANSMISSION_SOURCE == 2
NTCR_DECLARE_DECODED(gTransmission, 7);
#define NTCR_READ_TRANSMISSION NTCR_READ_DECODED(gTransmission)
#endif

/// Only what the material has. Linear light.
struct NtcrTexel {
    vec4 color; // base or diffuse colour, alpha
#if NTCR_NORMAL_SOURCE || NTCR_OCCLUSION_SOURCE
    vec4 relief; // normal map, occlusion
#endif
#if NTCR_METALLIC_ROUGHNESS_SOURCE || NTCR_SPECULAR_GLOSSINESS_SOURCE
    vec4 gloss; // roughness, metallic; or specular, glossiness
#endif
#if NTCR_EMISSIVE_SOURCE || NTCR_TRANSMISSION_SOURCE
    vec4 light; // emission, transmission
#endif
};

void NtcStfClear(out NtcrTexel texel) {
    texel.color = vec4(0.0);
#if NTCR_NORMAL_SOURCE || NTCR_OCCLUSION_SOURCE
    texel.relief = vec4(0.0);
#endif
#if NTCR_METALLIC_ROUGHNESS_SOURCE || NTCR_SPECULAR_GLOSSINESS_SOURCE
    texel.gloss = vec4(0.0);
#endif
#if NTCR_EMISSIVE_SOURCE || NTCR_TRANSMISSION_SOURCE
    texel.light = vec4(0.0);
#endif
}

void NtcStfAdd(inout NtcrTexel sum, NtcrTexel texel, float weight) {
#if NTCR_BASE_COLOR_SOURCE
    NtcStfAdd(sum.color, texel.color, weight);
#endif
#if NTCR_NORMAL_SOURCE || NTCR_OCCLUSION_SOURCE
    NtcStfAdd(sum.relief, texel.relief, weight);
#endif
#if NTCR_METALLIC_ROUGHNESS_SOURCE || NTCR_SPECULAR_GLOSSINESS_SOURCE
    NtcStfAdd(sum.gloss, texel.gloss, weight);
#endif
#if NTCR_EMISSIVE_SOURCE || NTCR_TRANSMISSION_SOURCE
    NtcStfAdd(sum.light, texel.light, weight);
#endif
}

#if NTCR_FILTER >= 2
NtcrTexel NtcStfReadLane(NtcrTexel texel, uint lane) {
    NtcrTexel other = texel;
#if NTCR_BASE_COLOR_SOURCE
    other.color = NtcStfReadLane(texel.color, lane);
#endif
#if NTCR_NORMAL_SOURCE || NTCR_OCCLUSION_SOURCE
    other.relief = NtcStfReadLane(texel.relief, lane);
#endif
#if NTCR_METALLIC_ROUGHNESS_SOURCE || NTCR_SPECULAR_GLOSSINESS_SOURCE
    other.gloss = NtcStfReadLane(texel.gloss, lane);
#endif
#if NTCR_EMISSIVE_SOURCE || NTCR_TRANSMISSION_SOURCE
    other.light = NtcStfReadLane(texel.light, lane);
#endif
    return other;
}
#endif

vec3 NtcrDecodeSrgb3(vec3 c) {
    return vec3(NtcDecodeSrgb(c.x), NtcDecodeSrgb(c.y), NtcDecodeSrgb(c.z));
}

#if NTCR_NORMAL_XY
/// As a texel of three channels has it.
float NtcrGetNormalZ(vec2 xy) {
    vec2 n = 2.0 * xy - 1.0;
    return 0.5 + 0.5 * sqrt(max(1.0 - dot(n, n), 0.0));
}
#endif

#define NTCR_READ_IMAGE(image) texelFetch(image, tap.texel, tap.mip)
#if NTCR_TILED
#define NTCR_READ_DECODED(image) NtcrReadTile(image, tile)
#else
#define NTCR_READ_DECODED(image) NTCR_READ_IMAGE(image)
#endif
#define NTCR_CHANNELS3(first) vec3(channels[first], channels[(first) + 1], channels[(first) + 2])

/// What lookup `lookup` (a literal) reads at a tap.
NtcrTexel NtcrFetch(uint lookup, NtcStfTap tap) {
    NtcrTexel texel;
    NtcStfClear(texel);
    gTexels += 1u;
#if NTCR_SET_LOOKUPS
    float channels[NTC_MAX_CHANNELS];
    if (((uint(NTCR_SET_LOOKUPS) >> lookup) & 1u) != 0u) {
        gDecoded += 1u;
        for (int i = 0; i < NTC_MAX_CHANNELS; i++)
            channels[i] = 0.0;
        NtcSampleTextureSet(gSet, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, tap.texel, tap.mip, true, channels);
    }
#endif
#if NTCR_TILED
    NtcrTile tile;
    int tiles = gMaterial.lookups[lookup].tiles;
    if (tiles >= 0)
        tile = NtcrFindTile(uint(tiles), tap);
#endif
#if NTCR_BASE_COLOR_SOURCE
    if (lookup == uint(NTCR_BASE_COLOR_LOOKUP)) {
#if NTCR_BASE_COLOR_SOURCE == 3
        texel.color.xyz = NTCR_CHANNELS3(NTCR_BASE_COLOR_CHANNEL);
#if NTCR_ALPHA
        texel.color.w = channels[NTCR_BASE_COLOR_CHANNEL + 3];
#endif
#else
        texel.color = NTCR_READ_BASE_COLOR;
#if !NTCR_BASE_COLOR_LINEAR
        texel.color.xyz = NtcrDecodeSrgb3(texel.color.xyz);
#endif
#endif
    }
#endif
#if NTCR_METALLIC_ROUGHNESS_SOURCE
    if (lookup == uint(NTCR_METALLIC_ROUGHNESS_LOOKUP)) {
#if NTCR_METALLIC_ROUGHNESS_SOURCE == 3 // sets hold metalness and roughness, images roughness and metalness as G and B
        texel.gloss.xy = vec2(channels[NTCR_METALLIC_ROUGHNESS_CHANNEL + 1],
                              channels[NTCR_METALLIC_ROUGHNESS_CHANNEL]);
#elif NTCR_METALLIC_ROUGHNESS_SOURCE == 2
        texel.gloss.xy = NTCR_READ_METALLIC_ROUGHNESS.yx;
#else
        texel.gloss.xy = NTCR_READ_METALLIC_ROUGHNESS.yz;
#endif
    }
#endif
#if NTCR_SPECULAR_GLOSSINESS_SOURCE
    if (lookup == uint(NTCR_SPECULAR_GLOSSINESS_LOOKUP)) {
#if NTCR_SPECULAR_GLOSSINESS_SOURCE == 3
        texel.gloss = vec4(NTCR_CHANNELS3(NTCR_SPECULAR_GLOSSINESS_CHANNEL),
                           channels[NTCR_SPECULAR_GLOSSINESS_CHANNEL + 3]);
#else
        texel.gloss = NTCR_READ_SPECULAR_GLOSSINESS;
#if !NTCR_SPECULAR_GLOSSINESS_LINEAR
        texel.gloss.xyz = NtcrDecodeSrgb3(texel.gloss.xyz);
#endif
#endif
    }
#endif
#if NTCR_NORMAL_SOURCE
    if (lookup == uint(NTCR_NORMAL_LOOKUP)) {
#if NTCR_NORMAL_SOURCE == 3 && NTCR_NORMAL_XY
        texel.relief.xy = vec2(channels[NTCR_NORMAL_CHANNEL], channels[NTCR_NORMAL_CHANNEL + 1]);
#elif NTCR_NORMAL_SOURCE == 3
        texel.relief.xyz = NTCR_CHANNELS3(NTCR_NORMAL_CHANNEL);
#else
        texel.relief.xyz = NTCR_READ_NORMAL.xyz;
#endif
#if NTCR_NORMAL_XY
        texel.relief.z = NtcrGetNormalZ(texel.relief.xy);
#endif
    }
#endif
#if NTCR_OCCLUSION_SOURCE
    if (lookup == uint(NTCR_OCCLUSION_LOOKUP)) {
#if NTCR_OCCLUSION_SOURCE == 3
        texel.relief.w = channels[NTCR_OCCLUSION_CHANNEL];
#else
        texel.relief.w = NTCR_READ_OCCLUSION.x;
#endif
    }
#endif
#if NTCR_EMISSIVE_SOURCE
    if (lookup == uint(NTCR_EMISSIVE_LOOKUP)) {
#if NTCR_EMISSIVE_SOURCE == 3
        texel.light.xyz = NTCR_CHANNELS3(NTCR_EMISSIVE_CHANNEL);
#elif NTCR_EMISSIVE_LINEAR
        texel.light.xyz = NTCR_READ_EMISSIVE.xyz;
#else
        texel.light.xyz = NtcrDecodeSrgb3(NTCR_READ_EMISSIVE.xyz);
#endif
    }
#endif
#if NTCR_TRANSMISSION_SOURCE
    if (lookup == uint(NTCR_TRANSMISSION_LOOKUP)) {
#if NTCR_TRANSMISSION_SOURCE == 3
        texel.light.w = channels[NTCR_TRANSMISSION_CHANNEL];
#else
        texel.light.w = NTCR_READ_TRANSMISSION.x;
#endif
    }
#endif
    return texel;
}

#if NTCR_FILTER == 0
NTC_STF_DEFINE_FILTER(NtcrFilter, NtcrTexel, uint, NtcrFetch)
#elif NTCR_FILTER == 2
NTC_STF_DEFINE_SHARING(NtcrShare, NtcrTexel, uint, NtcrFetch)
#elif NTCR_FILTER == 3
NTC_STF_DEFINE_COLLABORATION(NtcrCollaborate, NtcrTexel, uint, NtcrFetch)
#endif

uvec4 NtcrGetRandom(ivec2 pixel, uint lookup) {
    if (gFrame.randomR2 == 0u)
        return NtcStfRandomHashed(pixel, gFrame.frame, lookup, gFrame.seed);
    return NtcStfRandomR2(NtcStfPcg4d(uint(pixel.x), uint(pixel.y), lookup, gFrame.seed), gFrame.frame);
}

/// One lookup. With NTCR_FILTER 2 and 3 every lane of the wave calls this.
NtcrTexel NtcrLookUp(uint lookup, NtcrPlace place, ivec2 pixel, bool isLive) {
    NtcrLookup row = gMaterial.lookups[lookup];
    NtcrUv uv = NtcrGetUv(place, row.row0, row.row1);
    NtcStfExtent extent = NtcStfMakeExtent(row.width, row.height, row.levels);
#if defined(NTCR_KERNEL)
    row.sampling.kernelType = uint(NTCR_KERNEL);
#endif
#if defined(NTCR_MIPS)
    row.sampling.mips = uint(NTCR_MIPS);
#endif
#if NTCR_ISOTROPIC
    row.sampling.maxAnisotropy = 1u;
#endif
    NtcStfFootprint footprint = NtcStfGetFootprint(row.sampling, extent, uv.alongX, uv.alongY);
#if NTCR_FILTER == 0
    return NtcrFilter(lookup, row.sampling, extent, uv.at, footprint);
#elif NTCR_FILTER == 1
    NtcStfPair pair = NtcStfSamplePair(row.sampling, extent, uv.at, footprint, NtcrGetRandom(pixel, lookup));
    NtcrTexel sum;
    NtcStfClear(sum);
    NtcStfAdd(sum, NtcrFetch(lookup, pair.first), pair.first.scale);
    if (pair.second.scale != 0.0)
        NtcStfAdd(sum, NtcrFetch(lookup, pair.second), pair.second.scale);
    return sum;
#elif NTCR_FILTER == 2
    return NtcrShare(lookup, NtcStfMakeWaveLane(0u, isLive), 4u, row.sampling, extent, uv.at, footprint,
                     NtcrGetRandom(pixel, lookup));
#else
    return NtcrCollaborate(lookup, NtcStfMakeWaveLane(0u, isLive), row.sampling, extent, uv.at, footprint,
                           NtcrGetRandom(pixel, lookup));
#endif
}

/// All of the material's textures at a pixel: 1 where it has none.
NtcrTexel NtcrGetTexel(NtcrPlace place, ivec2 pixel, bool isLive) {
    NtcrTexel texel;
    NtcStfClear(texel);
#if NTCR_LOOKUPS > 0
    NtcStfAdd(texel, NtcrLookUp(0u, place, pixel, isLive), 1.0);
#endif
#if NTCR_LOOKUPS > 1
    NtcStfAdd(texel, NtcrLookUp(1u, place, pixel, isLive), 1.0);
#endif
#if NTCR_LOOKUPS > 2
    NtcStfAdd(texel, NtcrLookUp(2u, place, pixel, isLive), 1.0);
#endif
#if NTCR_LOOKUPS > 3
    NtcStfAdd(texel, NtcrLookUp(3u, place, pixel, isLive), 1.0);
#endif
#if NTCR_LOOKUPS > 4
    NtcStfAdd(texel, NtcrLookUp(4u, place, pixel, isLive), 1.0);
#endif
#if NTCR_LOOKUPS > 5
    NtcStfAdd(texel, NtcrLookUp(5u, place, pixel, isLive), 1.0);
#endif
#if NTCR_LOOKUPS > 6
    NtcStfAdd(texel, NtcrLookUp(6u, place, pixel, isLive), 1.0);
#endif
#if !NTCR_BASE_COLOR_SOURCE
    texel.color = vec4(1.0);
#endif
    return texel;
}

#endif
