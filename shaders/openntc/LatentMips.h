// SPDX-License-Identifier: MIT
// Latent mips of generations 2 and 3: addressing and bilinear sampling (format specification, generations 4
// and 5).
//
// Latents in a texture (LatentFetch.h): below are u and the conversions of q alone; the rest is the device's.
//
// A latent mip is a grid of 16-bit texels per layer, [layer][y][x], of four 4-bit codes c each, the first one
// in the lowest bits; a latent is q = c / 15. LibNTC samples such grids with texture units, whose weights no
// standard defines. Here the filter is defined bit for bit, from a buffer of bytes:
//   u = f32((x + 1/2) / W), correctly rounded (NtcTexelCenter); texels outside of the mip wrap first
//   p = f32(f32(u size) - 1/2), cell = floor(p), f = p - cell: between the texels cell and cell + 1 of an
//   axis of `size`, which wrap: -1 is size - 1, and size is 0
//   INT8   w = trunc(f32(256 f + 1/2)), 0 ... 256, is the weight of the second texel, 256 - w of the first;
//          S = sum of code * (product of two weights), so that q = S / (15 * 2^16). From w on these are
//          integers: every compiler gets the same, however it fuses or reorders. Eight bits are what texture
//          units keep, and exact where texels lie on multiples of 1/256 of a latent texel: with every power
//          of two between the sizes
//   others S = sum of f32(code * f32(product of two binary32 weights)) in the order (x0, y0), (x1, y0),
//          (x0, y1), (x1, y1), so that q = S / 15
#ifndef OPENNTC_LATENT_MIPS_H
#define OPENNTC_LATENT_MIPS_H

#include "Buffers.h"
#include "Effects.h"
#include "InferenceConstants.h"
#include "Latents.h"
#include "Portability.h"
#include "Switches.h"
#include "TexelCoords.h"

#if NTC_WITH_LATENT_MIPS
NTC_NAMESPACE_BEGIN

/// u of a texel of a colour mip of mipSize, along one axis: the same in every latent mip.
NTC_FUNCTION float NtcGetLatentCoordinate(int texel, int mipSize) {
#if NTC_CLAMP_TEXELS
    if (texel < 0 || texel >= mipSize)
        texel = NtcModulo(texel, mipSize);
#endif
    return NtcTexelCenter(texel, mipSize);
}

#if NTC_LATENT_FETCH == NTC_LATENTS_BUFFER
/// The taps of an axis of a latent mip that is present (axis: 0 along x, 1 along y), at a texel of a colour
/// mip of mipSize: latent texels relative to the slice. Those that a slice lacks are its last.
NTC_FUNCTION NtcAxisTaps NtcGetLatentMipTaps(NtcNeuralMipConstants grid, uint axis, int texel, int mipSize) {
    uint shift = 16u * axis;
    int size = int((grid.imageWidthHeight >> shift) & 0xFFFFu);
    NTC_PRECISE float scaled = NtcMultiply(NtcGetLatentCoordinate(texel, mipSize), float(size));
    NTC_PRECISE float position = NtcKeep(scaled) - 0.5f;
    NTC_PRECISE float cell = floor(position);
    NtcAxisTaps taps;
    NTC_PRECISE float fraction = NtcKeep(position) - cell;
    taps.fraction = NtcKeep(fraction);
    int index = int(cell); // -1 ... size - 1
    taps.first = index < 0 ? size - 1 : index;
    taps.second = index + 1 < size ? index + 1 : 0;
#if NTC_LATENT_SLICES
    int start = int((grid.sliceLeftTop >> shift) & 0xFFFFu);
    int last = int((grid.sliceWidthHeight >> shift) & 0xFFFFu) - 1;
    taps.first = taps.first < start ? taps.first - start + size : taps.first - start;
    taps.second = taps.second < start ? taps.second - start + size : taps.second - start;
    taps.first = min(max(taps.first, 0), last);
    taps.second = min(max(taps.second, 0), last);
#endif
    return taps;
}

/// The four texels of a layer around a sample, in the order (x0, y0), (x1, y0), (x0, y1), (x1, y1). element:
/// of the layer's first texel in its latent mip, which begins at the byte `grid`.
struct NtcLatentTexels {
    uint texel0;
    uint texel1;
    uint texel2;
    uint texel3;
};

/// Four codes in the lower half of a word; above are those of another texel.
NTC_FUNCTION uint NtcLoadLatentTexel(NtcBuffer latents, uint grid, uint element) {
    return NtcBufferLoad(latents, grid + 4u * (element >> 1)) >> (16u * (element & 1u));
}

NTC_FUNCTION NtcLatentTexels NtcLoadLatentTexels(NtcBuffer latents, uint grid, uint element, uint width,
                                                 NtcAxisTaps x, NtcAxisTaps y) {
    uint top = element + uint(y.first) * width;
    uint bottom = element + uint(y.second) * width;
    NtcLatentTexels texels;
    texels.texel0 = NtcLoadLatentTexel(latents, grid, top + uint(x.first));
    texels.texel1 = NtcLoadLatentTexel(latents, grid, top + uint(x.second));
    texels.texel2 = NtcLoadLatentTexel(latents, grid, bottom + uint(x.first));
    texels.texel3 = NtcLoadLatentTexel(latents, grid, bottom + uint(x.second));
    return texels;
}

/// The weight of an axis' second texel, 0 ... 256.
NTC_FUNCTION uint NtcGetLatentWeight(float fraction) {
    NTC_PRECISE float scaled = fraction * 256.0f + 0.5f; // the product is exact: fusing changes nothing
    return uint(int(scaled));
}

/// 17 times the weights of the four texels of a sample, for codes in bits 0-3 of a word, and 16 times that
/// for those in bits 4-7, whose sums are 2^24 a step instead of 2^16.
struct NtcLatentWeights {
    uint4 low;
    uint4 high;
};

/// weightX, weightY: of the second texel of each axis, 0 ... 256.
NTC_FUNCTION NtcLatentWeights NtcMakeLatentWeights(uint weightX, uint weightY) {
    uint restX = 17u * (256u - weightX);
    uint secondX = 17u * weightX;
    uint restY = 256u - weightY;
    NtcLatentWeights weights;
    weights.low = uint4(restX * restY, secondX * restY, restX * weightY, secondX * weightY);
    weights.high = uint4(16u * weights.low.x, 16u * weights.low.y, 16u * weights.low.z, 16u * weights.low.w);
    return weights;
}

/// 17 S of the codes in bits 0-3 of four words, 0 ... 255 * 2^16, and 17 * 2^8 S of those in bits 4-7, both
/// after what `low` and `high` are before.
NTC_FUNCTION void NtcAddLatents(NtcLatentTexels words, NtcLatentWeights weights, NTC_INOUT(uint, low),
                                NTC_INOUT(uint, high)) {
    low += (words.texel0 & 0xFu) * weights.low.x + (words.texel1 & 0xFu) * weights.low.y +
           (words.texel2 & 0xFu) * weights.low.z + (words.texel3 & 0xFu) * weights.low.w;
    high += (words.texel0 & 0xF0u) * weights.high.x + (words.texel1 & 0xF0u) * weights.high.y +
            (words.texel2 & 0xF0u) * weights.high.z + (words.texel3 & 0xF0u) * weights.high.w;
}

/// Codes 2 and 3 in the place of 0 and 1.
NTC_FUNCTION NtcLatentTexels NtcShiftLatentTexels(NtcLatentTexels texels) {
    NtcLatentTexels shifted;
    shifted.texel0 = texels.texel0 >> 8;
    shifted.texel1 = texels.texel1 >> 8;
    shifted.texel2 = texels.texel2 >> 8;
    shifted.texel3 = texels.texel3 >> 8;
    return shifted;
}
#endif

NTC_NAMESPACE_END
#endif

#endif
