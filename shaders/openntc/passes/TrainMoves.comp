// SPDX-License-Identifier: MIT
// Compute pass: which moves of a class of latent pixels lower the loss of the texels that read them. Of
// such a class a texel reads one pixel at most, so that each is decided by itself, exactly
// (encode/detail/LatentRefiner.h); a move that is kept changes the latent, and the losses of its texels are
// those that were tried.
//
// Set 0, storage buffers: 0 and 1 as TrainTexels, 8 latents, 14 the number of moves that were kept is added
// to the first word of slot NtcTrainStep::lossSlot, 15 ranges of texels (begin | end << 16) that read a
// pixel, along each axis, 16 losses that are kept and 17 those that were tried. Push constants:
// NtcTrainStep; a lane a pixel of the class of one neural mip's grid.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/encode/TrainConstants.h"

layout(local_size_x = NTC_TRAIN_MOVES) in;

layout(set = 0, binding = 0, std430) readonly buffer Constants {
    NtcTrainConstants gConstants;
};
layout(set = 0, binding = 1, std430) readonly buffer Mips {
    NtcTrainMip mips[];
} gMips;
layout(set = 0, binding = 8, std430) buffer Latents {
    float values[];
} gLatents;
layout(set = 0, binding = 14, std430) buffer Losses {
    uint counts[];
} gLosses;
layout(set = 0, binding = 15, std430) readonly buffer Ranges {
    uint ranges[];
} gRanges;
layout(set = 0, binding = 16, std430) buffer Kept {
    float values[];
} gKept;
layout(set = 0, binding = 17, std430) readonly buffer Tried {
    float values[];
} gTried;
layout(push_constant) uniform TrainPush {
    NtcTrainStep gStep;
};

NtcTrainGrid getGrid(uint mip) {
    if ((gStep.move & 1u) == 1u)
        return gMips.mips[mip].low;
    return gMips.mips[mip].high;
}

/// Texels of a mip that read a pixel: x, y, end of x, end of y. Where latents wrap around, ends may lie
/// beyond the mip, of texels that are counted from 0 again.
uvec4 getTexels(uint mip, uvec2 pixel) {
    NtcTrainGrid grid = getGrid(mip);
    uint x = gRanges.ranges[grid.rangesX + pixel.x], y = gRanges.ranges[grid.rangesY + pixel.y];
    return uvec4(x & 0xFFFFu, y & 0xFFFFu, x >> 16, y >> 16);
}

uint getTexel(uint mip, uint x, uint y) {
    uint width = uint(gMips.mips[mip].width), height = uint(gMips.mips[mip].height);
    x = x < width ? x : x - width;
    y = y < height ? y : y - height;
    uint tile = gMips.mips[mip].firstTile + (y >> 3) * ((width + 15u) >> 4) + (x >> 4);
    return tile * uint(NTC_TRAIN_TILE_TEXELS) + (y & 7u) * 16u + (x & 15u);
}

float getChange(uint mip, uvec2 pixel) {
    uvec4 texels = getTexels(mip, pixel);
    float change = 0.0;
    for (uint y = texels.y; y < texels.w; y++) {
        for (uint x = texels.x; x < texels.z; x++) {
            uint at = getTexel(mip, x, y);
            change += gTried.values[at] - gKept.values[at];
        }
    }
    return change;
}

void keep(uint mip, uvec2 pixel) {
    uvec4 texels = getTexels(mip, pixel);
    for (uint y = texels.y; y < texels.w; y++) {
        for (uint x = texels.x; x < texels.z; x++) {
            uint at = getTexel(mip, x, y);
            gKept.values[at] = gTried.values[at];
        }
    }
}

/// Pixels along an axis that may move: see AxisClass of encode/detail/LatentRefiner.h.
uvec2 getMovable(uvec2 size) {
    if ((gStep.flags & NTC_TRAIN_WRAPS) == 0u)
        return size;
    return uvec2(size.x > 1u ? size.x & ~1u : 1u, size.y > 1u ? size.y & ~1u : 1u);
}

void main() {
    uint mips = gMips.mips.length(), first = 0u;
    while (first + 1u < mips && gMips.mips[first].neuralMip != gStep.neuralMip) first++;
    NtcTrainGrid grid = getGrid(first);
    uvec2 odd = uvec2(gStep.move >> 1 & 1u, gStep.move >> 2 & 1u);
    uvec2 size = uvec2(grid.width, grid.height), count = (getMovable(size) - odd + 1u) / 2u;
    uint index = gl_GlobalInvocationID.x;
    if (count.x == 0u || index >= count.x * count.y)
        return;
    uvec2 pixel = (odd + 2u * uvec2(index % count.x, index / count.x) + gStep.turn) % size;
    float change = 0.0;
    for (uint mip = first; mip < mips && gMips.mips[mip].neuralMip == gStep.neuralMip; mip++)
        change += getChange(mip, pixel);
    if (!(change < 0.0)) // nor when a move ends at the range's end and changes nothing
        return;
    for (uint mip = first; mip < mips && gMips.mips[mip].neuralMip == gStep.neuralMip; mip++)
        keep(mip, pixel);
    bool low = (gStep.move & 1u) == 1u;
    float scale = low ? gConstants.low.scale : gConstants.high.scale;
    vec2 range = low ? vec2(gConstants.low.lowest, gConstants.low.highest)
                     : vec2(gConstants.high.lowest, gConstants.high.highest);
    uint at = grid.base + (gStep.move >> 3) * grid.plane + pixel.y * grid.width + pixel.x;
    float level = floor(gLatents.values[at] * scale + 0.5) + gStep.levels;
    gLatents.values[at] = clamp(level, range.x, range.y) / scale;
    atomicAdd(gLosses.counts[16u * gStep.lossSlot], 1u);
}
