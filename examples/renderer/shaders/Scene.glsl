// SPDX-License-Identifier: MIT
// The frame's resources, and what is at a pixel of a triangle: attributes, interpolated in perspective, and how they
// change from pixel to pixel. All of it from the three vertices, the same in fragment and compute shaders.
#ifndef OPENNTC_RENDERER_SCENE_GLSL
#define OPENNTC_RENDERER_SCENE_GLSL

#include "Constants.h"

layout(set = 0, binding = 0, std140) uniform Frame {
    NtcrFrame gFrame;
};
layout(set = 0, binding = 1, std430) readonly buffer Vertices {
    NtcrVertex gVertices[];
};
layout(set = 0, binding = 2, std430) readonly buffer Indices {
    uint gIndices[];
};
layout(set = 0, binding = 3, std430) readonly buffer Instances {
    NtcrInstance gInstances[];
};

vec4 NtcrGetClip(uint instance, uint vertex) {
    vec4 world = gInstances[instance].toWorld * vec4(gVertices[vertex].position.xyz, 1.0);
    return gFrame.toClip * world;
}

/// Barycentric coordinates of a pixel and their derivatives towards the pixel to the right and the one below.
struct NtcrPlace {
    vec3 at;
    vec3 alongX;
    vec3 alongY;
    uint vertices[3];
    bool isBack;
};

/// In homogeneous coordinates (Olano and Greer 1997), moved so that the pixel is the origin: small triangles far away
/// keep their digits, and vertices behind the eye do no harm.
NtcrPlace NtcrGetPlace(uint instance, uint triangle, ivec2 pixel) {
    NtcrPlace place;
    vec2 size = vec2(gFrame.width, gFrame.height);
    vec2 center = (vec2(pixel) + 0.5) * 2.0 / size - 1.0;
    vec3 p[3];
    uint first = gInstances[instance].firstIndex + 3u * triangle;
    for (int i = 0; i < 3; i++) {
        place.vertices[i] = gIndices[first + uint(i)];
        vec4 clip = NtcrGetClip(instance, place.vertices[i]);
        p[i] = vec3(clip.xy - center * clip.w, clip.w);
    }
    vec3 a = cross(p[1], p[2]), b = cross(p[2], p[0]), c = cross(p[0], p[1]);
    vec3 q = vec3(a.z, b.z, c.z);
    float sum = q.x + q.y + q.z;
    float inverse = sum != 0.0 ? 1.0 / sum : 0.0;
    place.at = q * inverse;
    vec3 x = vec3(a.x, b.x, c.x) * (2.0 / size.x), y = vec3(a.y, b.y, c.y) * (2.0 / size.y);
    place.alongX = (x - place.at * (x.x + x.y + x.z)) * inverse;
    place.alongY = (y - place.at * (y.x + y.y + y.z)) * inverse;
    // With y down, front faces turn the other way round.
    bool isFlipped = (gInstances[instance].flags & NTCR_FLIPPED) != 0u;
    place.isBack = (sum > 0.0) != isFlipped;
    return place;
}

vec3 NtcrMix3(vec3 weights, vec3 a, vec3 b, vec3 c) {
    return a * weights.x + b * weights.y + c * weights.z;
}

vec2 NtcrGetVertexUv(uint vertex, int uvSet) {
    NtcrVertex v = gVertices[vertex];
    return uvSet == 0 ? vec2(v.position.w, v.normal.w) : v.uv1.xy;
}

/// Texture coordinates of a lookup, with derivatives.
struct NtcrUv {
    vec2 at;
    vec2 alongX;
    vec2 alongY;
};

NtcrUv NtcrGetUv(NtcrPlace place, vec4 row0, vec4 row1) {
    int uvSet = int(row0.w);
    vec2 a = NtcrGetVertexUv(place.vertices[0], uvSet), b = NtcrGetVertexUv(place.vertices[1], uvSet),
         c = NtcrGetVertexUv(place.vertices[2], uvSet);
    mat3x2 corners = mat3x2(a, b, c);
    mat2 turn = transpose(mat2(row0.xy, row1.xy));
    NtcrUv uv;
    uv.at = NtcrTransformUv(corners * place.at, row0.xyz, row1.xyz);
    uv.alongX = turn * (corners * place.alongX);
    uv.alongY = turn * (corners * place.alongY);
    return uv;
}

vec4 NtcrGetColor(NtcrPlace place) {
    return gVertices[place.vertices[0]].color * place.at.x + gVertices[place.vertices[1]].color * place.at.y +
           gVertices[place.vertices[2]].color * place.at.z;
}

/// World-space geometry at a pixel. `normal` and `tangent` as interpolated; without normals flat.
struct NtcrGeometry {
    vec3 position;
    vec3 alongX;
    vec3 alongY;
    vec3 normal;
    vec4 tangent; // w 0: none
};

NtcrGeometry NtcrGetGeometry(uint instance, NtcrPlace place) {
    NtcrInstance object = gInstances[instance];
    mat3 turn = mat3(object.toWorld);
    float side = (object.flags & NTCR_FLIPPED) != 0u ? -1.0 : 1.0;
    NtcrVertex a = gVertices[place.vertices[0]], b = gVertices[place.vertices[1]],
               c = gVertices[place.vertices[2]];
    vec3 p0 = turn * a.position.xyz, p1 = turn * b.position.xyz, p2 = turn * c.position.xyz;
    NtcrGeometry geometry;
    geometry.position = NtcrMix3(place.at, p0, p1, p2) + object.toWorld[3].xyz;
    geometry.alongX = NtcrMix3(place.alongX, p0, p1, p2);
    geometry.alongY = NtcrMix3(place.alongY, p0, p1, p2);
    geometry.tangent = vec4(0.0);
    if ((object.flags & NTCR_NORMALS) == 0u) {
        geometry.normal = normalize(cross(p1 - p0, p2 - p0)) * side;
        return geometry;
    }
    // Cofactors are the inverse transpose times the determinant; vertices' normals become unit vectors again.
    mat3 cofactors =
        mat3(cross(turn[1], turn[2]), cross(turn[2], turn[0]), cross(turn[0], turn[1])) * side;
    geometry.normal = NtcrMix3(place.at, normalize(cofactors * a.normal.xyz), normalize(cofactors * b.normal.xyz),
                               normalize(cofactors * c.normal.xyz));
    if ((object.flags & NTCR_TANGENTS) != 0u) {
        geometry.tangent.xyz = NtcrMix3(place.at, normalize(turn * a.tangent.xyz),
                                        normalize(turn * b.tangent.xyz), normalize(turn * c.tangent.xyz));
        geometry.tangent.w = a.tangent.w < 0.0 ? -side : side;
    }
    return geometry;
}

#endif
