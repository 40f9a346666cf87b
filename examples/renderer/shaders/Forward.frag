// SPDX-License-Identifier: MIT
// Shades a triangle as it is drawn: blended surfaces, and with --path fragment all of them. With NTCR_VISIBLE only where the
// visibility buffer shows it: what is hidden asks for no tiles.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "Shade.glsl"
#include "Count.glsl"

#if NTCR_TILED && NTCR_BLENDED
layout(early_fragment_tests) in; // likewise; no depth is written
#endif
#if NTCR_VISIBLE
layout(set = 0, binding = 6) uniform utexture2D gVisible;
#endif
layout(location = 0) flat in uvec2 gTriangle;
layout(location = 0) out vec4 gColor;

void main() {
#if NTCR_VISIBLE
    if (texelFetch(gVisible, ivec2(gl_FragCoord.xy), 0).xy != uvec2(gTriangle.x + 1u, gTriangle.y))
        discard;
#endif
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
