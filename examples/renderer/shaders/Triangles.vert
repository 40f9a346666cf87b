// SPDX-License-Identifier: MIT
// Triangles of an instance, read from buffers: which instance, which triangle.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Scene.glsl"

layout(location = 0) flat out uvec2 gTriangle;

void main() {
    uint instance = uint(gl_InstanceIndex);
    uint corner = uint(gl_VertexIndex);
    gTriangle = uvec2(instance, corner / 3u);
    gl_Position = NtcrGetClip(instance, gIndices[gInstances[instance].firstIndex + corner]);
}
