// SPDX-License-Identifier: MIT
// A ray per pixel against the ground; one texel of the field's texture set, of the mip that the pixel's
// footprint asks for, makes its colour. LANDSCAPE_TILED 1: latents are tiles that come and go (PageTable.h).
// 0: all of them are there, one set behind the other, and the ordinary functions read them; everything else
// is the same, so that both make the same picture.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/streaming/StreamingConstants.h"

#include "LandscapeConstants.h"
#include "LandscapeTerrain.h"
#if LANDSCAPE_TILED
#include "openntc/streaming/PageTable.h"
#else
#include "openntc/Inference.h"
#include "openntc/streaming/TileMaths.h"
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0, std140) uniform Scene { LandscapeScene scene; } gScene;
layout(set = 0, binding = 3, std430) readonly buffer Sets { NtcTextureSetConstants sets[]; } gSets;
layout(set = 0, binding = 4, std430) readonly buffer Fields { LandscapeField fields[]; } gFields;
layout(set = 0, binding = 5, std430) writeonly buffer Pixels { LandscapePixel pixels[]; } gPixels;
layout(set = 0, binding = 6, std430) writeonly buffer Colors { uint colors[]; } gColors;

const uint kMostTaps = 8u; // along a footprint's longer side

float GetRandom(uint seed, uint number) {
    return float(NtcHash(seed, number) >> 8) * 5.9604645e-8; // 2^-24
}

/// Distance along the ray to the ground, below 0 for none. Steps no further than the steepest slope allows.
float FindGround(vec3 eye, vec3 direction) {
    float approach = max(-direction.y, 0.0) + LANDSCAPE_STEEPEST * length(direction.xz);
    float distance = 0.0;
    if (eye.y > LANDSCAPE_HIGHEST) {
        if (direction.y >= 0.0)
            return -1.0;
        distance = (LANDSCAPE_HIGHEST - eye.y) / direction.y;
    }
    for (int i = 0; i < 160 && distance < 2000.0; i++) {
        vec3 p = eye + distance * direction;
        float above = p.y - GetTerrainHeight(p.x, p.z);
        if (above < 0.0005 * distance + 0.0005)
            return distance;
        distance += above / approach;
        if (p.y > LANDSCAPE_HIGHEST && direction.y >= 0.0)
            return -1.0;
    }
    return -1.0;
}

vec3 GetGroundNormal(vec3 p) {
    float step = 0.25;
    float x = GetTerrainHeight(p.x + step, p.z) - GetTerrainHeight(p.x - step, p.z);
    float z = GetTerrainHeight(p.x, p.z + step) - GetTerrainHeight(p.x, p.z - step);
    return normalize(vec3(-x, 2.0 * step, -z));
}

/// Where a neighbouring pixel's ray meets the tangent plane, in fields; far away for one that does not.
vec2 GetStep(vec3 eye, vec3 hit, vec3 normal, vec3 direction) {
    float towards = -dot(normal, direction);
    if (towards < 1e-4)
        return vec2(1e6);
    vec3 other = eye + (dot(normal, eye - hit) / towards) * direction;
    return (other.xz - hit.xz) / gScene.scene.fieldSize;
}

vec3 GetSky(vec3 direction) {
    float up = clamp(direction.y, 0.0, 1.0);
    return mix(vec3(0.71, 0.78, 0.84), vec3(0.26, 0.45, 0.72), sqrt(up));
}

uint PackColor(vec3 linear) {
    vec3 stored = pow(clamp(linear, 0.0, 1.0), vec3(1.0 / 2.2));
    uvec3 bytes = uvec3(stored * 255.0 + 0.5);
    return bytes.x | (bytes.y << 8) | (bytes.z << 16) | 0xFF000000u;
}

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= gScene.scene.width || at.y >= gScene.scene.height)
        return;
    uint index = at.y * gScene.scene.width + at.x;
    vec3 eye = gScene.scene.eye.xyz;
    vec3 ray = gScene.scene.first.xyz + float(at.x) * gScene.scene.right.xyz + float(at.y) * gScene.scene.down.xyz;
    vec3 direction = normalize(ray);

    LandscapePixel pixel;
    pixel.field = LANDSCAPE_SKY;
    pixel.x = 0;
    pixel.y = 0;
    pixel.state = 0u;
    float outputs[NTC_MAX_CHANNELS];
    for (int c = 0; c < NTC_MAX_CHANNELS; c++)
        outputs[c] = 0.0;

    vec3 color = GetSky(direction);
    float distance = FindGround(eye, direction);
    vec3 hit = eye + max(distance, 0.0) * direction;
    vec2 place = hit.xz / gScene.scene.fieldSize;
    vec2 end = vec2(float(gScene.scene.columns), float(gScene.scene.rows));
    if (distance >= 0.0 && all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, end))) {
        // Level and place: one tap of those that an anisotropic, trilinear filter would take, chosen at
        // random.
        vec3 normal = GetGroundNormal(hit);
        vec2 ddx = GetStep(eye, hit, normal, ray + gScene.scene.right.xyz);
        vec2 ddy = GetStep(eye, hit, normal, ray + gScene.scene.down.xyz);
        uint size = gScene.scene.setSize;
        NtcSampleShape shape = NtcGetSampleShape(size, size, kMostTaps << 16, 0.0, ddx, ddy);
        uint seed = NtcHash(index, gScene.scene.frame);
        uint tap = NtcHash(seed, 0u) % shape.taps;
        vec2 moved = place + NtcGetTapPlace(tap, shape.taps) * shape.axis;
        float lod = NtcClampLod(shape.lod, int(gScene.scene.mips));
        int mip = min(int(floor(lod + GetRandom(seed, 1u))), int(gScene.scene.mips) - 1);
        uvec2 cell = uvec2(place);
        int texels = NtcGetMipSize(int(size), mip);
        int2 texel = int2(floor((moved - vec2(cell)) * float(texels) +
                                vec2(GetRandom(seed, 2u), GetRandom(seed, 3u)) - 0.5));
        texel = clamp(texel, int2(0), int2(texels - 1));

        pixel.field = cell.y * gScene.scene.columns + cell.x;
        LandscapeField field = gFields.fields[pixel.field];
        int sampledMip = mip;
        bool resident = true;
#if LANDSCAPE_TILED
        NtcStreamingContext context = NtcMakeStreamingContext(gScene.scene.launch, NtcGetThreadSeed(index));
        bool decoded = NtcSampleTextureSetTiled(context, field.textureId, gSets.sets[field.set], NTC_LATENTS, 0u,
                                                NTC_WEIGHTS, field.weightsOffset, texel, mip, false, outputs,
                                                resident, sampledMip);
        if (decoded)
            texel = NtcGetTiledTexel(context, field.textureId, texel, mip, sampledMip);
#else
        bool decoded = NtcSampleTextureSet(gSets.sets[field.set], NTC_LATENTS, field.latentsOffset, NTC_WEIGHTS,
                                           field.weightsOffset, texel, mip, false, outputs);
#endif
        pixel.x = texel.x;
        pixel.y = texel.y;
        pixel.state = (uint(max(sampledMip, 0)) & 255u) | (uint(mip) << 8) |
                      (resident ? LANDSCAPE_RESIDENT : 0u) | (decoded ? LANDSCAPE_DECODED : 0u);

        vec3 bump = vec3(0.0, 0.0, 1.0);
        if (field.normal < 14u)
            bump = 2.0 * vec3(outputs[field.normal], outputs[field.normal + 1u], outputs[field.normal + 2u]) - 1.0;
        vec3 bent = normalize(normal + vec3(bump.x, 0.0, bump.y));
        vec3 base = vec3(outputs[field.color], outputs[field.color + 1u], outputs[field.color + 2u]);
        base = pow(clamp(base, 0.0, 1.0), vec3(2.2)) * field.tint.xyz;
        float light = max(dot(bent, gScene.scene.sun.xyz), 0.0);
        vec3 lit = base * (vec3(0.30, 0.34, 0.40) + 1.5 * light * vec3(1.0, 0.94, 0.82));
        float haze = 1.0 - exp(-distance * 0.0022);
        color = mix(lit, GetSky(vec3(direction.x, 0.0, direction.z)), haze);
    } else if (distance >= 0.0) { // beyond the landscape: the sea
        color = mix(vec3(0.05, 0.12, 0.18), GetSky(vec3(0.0)), 1.0 - exp(-distance * 0.0022));
    }
    pixel.outputs = outputs;
    gPixels.pixels[index] = pixel;
    gColors.colors[index] = PackColor(color);
}
