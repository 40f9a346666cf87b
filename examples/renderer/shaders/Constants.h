// SPDX-License-Identifier: MIT
// What host and shaders share: uniform and storage structures, with one layout in C++, std140 and std430.
#ifndef OPENNTC_RENDERER_CONSTANTS_H
#define OPENNTC_RENDERER_CONSTANTS_H

#include "Lighting.h"
#include "openntc/filtering/StfTypes.h"

#define NTCR_MOST_LOOKUPS 7 // a texture slot each

// NtcrInstance::flags
#define NTCR_FLIPPED 1u  // negative determinant: front faces are clockwise
#define NTCR_TANGENTS 2u // the vertices have tangents
#define NTCR_NORMALS 4u  // the vertices have normals

#if defined(__cplusplus)
#include <glm/mat4x4.hpp>
namespace openntc::shader {
using float4x4 = glm::mat4;
} // namespace openntc::shader
#else
#define float4x4 mat4
#endif

NTC_NAMESPACE_BEGIN

/// Of a frame.
struct NtcrFrame {
    float4x4 toClip;  // world to clip space, with the frame's jitter
    float4 eye;       // position; w 0: orthographic
    float4 rayCenter; // direction of view through clip space x, y: rayCenter + x rayX + y rayY
    float4 rayX;
    float4 rayY;
    NtcrLights lights;
    int width; // pixels
    int height;
    uint frame;
    uint seed;
    uint randomR2;   // 0: hashed numbers
    float exposure;  // factor
    int toneCurve;   // NTCR_TONE_*
    float newWeight; // of this frame in the mean
};

struct NtcrInstance {
    float4x4 toWorld;
    uint firstIndex; // of its primitive
    uint flags;
    uint material;
    uint padding0;
};

/// Of the vertex buffer.
struct NtcrVertex {
    float4 position; // w: first texture coordinates, u
    float4 normal;   // w: v
    float4 tangent;
    float4 color;
    float4 uv1; // second texture coordinates
};

/// Textures that are read at the same coordinates of the same size.
struct NtcrLookup {
    NtcStfSampler sampling;
    float4 row0; // of the transform of the coordinates; w: which set of them
    float4 row1;
    int width;
    int height;
    int levels;
    int tiles; // the set in the page table, of textures that are decoded on demand; -1: none are
};

struct NtcrMaterial {
    float4 baseColor;
    float4 specularGlossiness;
    float4 emissive; // w: transmission
    float metallic;
    float roughness;
    float normalScale;
    float occlusionStrength;
    float alphaCutoff;
    uint index;
    uint padding0;
    uint padding1;
    NtcrLookup lookups[NTCR_MOST_LOOKUPS];
};

NTC_NAMESPACE_END

#endif
