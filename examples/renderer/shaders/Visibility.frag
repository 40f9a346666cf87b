// SPDX-License-Identifier: MIT
// The visibility buffer: instance + 1 and triangle. With NTCR_MASKED (and MaterialTexels.glsl's definitions for the one
// texture with the mask) what the mask cuts out is not there.
#version 460
#extension GL_GOOGLE_include_directive : require
#if NTCR_MASKED
#include "Mask.glsl"
#include "Count.glsl"
#endif

layout(location = 0) flat in uvec2 gTriangle;
layout(location = 0) out uvec2 gVisible;

void main() {
#if NTCR_MASKED
    bool isThere = NtcrIsThere(gTriangle.x, gTriangle.y, ivec2(gl_FragCoord.xy));
    NtcrCountTexels();
    if (!isThere)
        discard;
#endif
    gVisible = uvec2(gTriangle.x + 1u, gTriangle.y);
}
