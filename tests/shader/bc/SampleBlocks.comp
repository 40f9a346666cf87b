// SPDX-License-Identifier: MIT
// What a device's sampler makes of blocks: the bits of four floats a texel.
#version 460
#extension GL_EXT_samplerless_texture_functions : require

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform texture2D gBlocks;
layout(set = 0, binding = 1, std430) writeonly buffer Texels {
    uvec4 texels[];
} gTexels;

void main() {
    ivec2 size = textureSize(gBlocks, 0);
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (texel.x < size.x && texel.y < size.y)
        gTexels.texels[texel.y * size.x + texel.x] = floatBitsToUint(texelFetch(gBlocks, texel, 0));
}
