// SPDX-License-Identifier: MIT
// Shades a triangle as it is drawn: blended surfaces, and with --path fragment all of them.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Shade.glsl"
#include "Count.glsl"

#if NTCR_TILED && !NTCR_MASKED
layout(early_fragment_tests) in; // what is hidden asks for no tiles
#endif
layout(location = 0) flat in uvec2 gTriangle;
layout(location = 0) out vec4 gColor;

void main() {
    vec4 color = NtcrShade(gTriangle.x, gTriangle.y, ivec2(gl_FragCoord.xy), true);
    NtcrCountTexels();
#if NTCR_MASKED
    if (color.w < gMaterial.alphaCutoff)
        discard;
#endif
#if NTCR_BLENDED
    gColor = color;
#else
    gColor = vec4(color.xyz, 1.0);
#endif
}
