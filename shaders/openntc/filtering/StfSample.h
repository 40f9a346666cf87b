// SPDX-License-Identifier: MIT
// One texel, or two, of a filter.
#ifndef OPENNTC_STF_SAMPLE_H
#define OPENNTC_STF_SAMPLE_H

#include "StfFootprint.h"
#include "StfKernels.h"
#include "StfTypes.h"
#include "openntc/Portability.h"
#include "openntc/TexelCoords.h"

NTC_NAMESPACE_BEGIN

/// Texel x, y of a mip, before addressing.
NTC_FUNCTION NtcStfTap NtcStfPlaceTap(NtcStfSampler settings, NtcStfExtent extent, int x, int y, int mip) {
    NtcStfTap tap;
    int column = NtcAddressTexel(x, NtcStfGetMipSize(extent.width, mip), settings.wrapX);
    int row = NtcAddressTexel(y, NtcStfGetMipSize(extent.height, mip), settings.wrapY);
    tap.texel = int2(column, row);
    tap.mip = mip;
    tap.scale = 1.0f;
    tap.isBorder = column < 0 || row < 0;
    return tap;
}

/// The mip of a lookup: the nearest, or one of two with the probability of its weight.
NTC_FUNCTION int NtcStfDrawMip(NtcStfSampler settings, NtcStfExtent extent, int lod, uint random) {
    int inside = min(max(lod, 0), (extent.levels - 1) * 65536);
    return (inside + (settings.mips == uint(NTC_MIPS_LINEAR) ? int(random) : 32768)) >> 16;
}

/// Where a lookup reads, once mip and anisotropic tap are drawn.
struct NtcStfPlace {
    NtcTexelCoord x;
    NtcTexelCoord y;
    int mip;
};

NTC_FUNCTION NtcStfPlace NtcStfGetPlace(NtcStfSampler settings, NtcStfExtent extent, float2 uv, int mip) {
    NtcStfPlace place;
    place.x = NtcGetTexelCoord(uv.x, uint(NtcStfGetMipSize(extent.width, mip)), settings.wrapX);
    place.y = NtcGetTexelCoord(uv.y, uint(NtcStfGetMipSize(extent.height, mip)), settings.wrapY);
    place.mip = mip;
    return place;
}

NTC_FUNCTION NtcStfPlace NtcStfDrawPlace(NtcStfSampler settings, NtcStfExtent extent, float2 uv,
                                         NtcStfFootprint footprint, uint4 random) {
    float2 at = NtcStfGetTapPlace(uv, footprint, (random.w * footprint.taps) >> 16);
    return NtcStfGetPlace(settings, extent, at, NtcStfDrawMip(settings, extent, footprint.lod, random.z));
}

/// One texel. The expectation of scale * f(texel) over `random`, four uniform numbers of 16 bits, is the
/// filter over f, for any f: shading, too. scale is 1 for kernels without negative weights; with them it is
/// a sign and a factor up to 1.57, and so noisy that NtcStfSamplePair is the better choice.
NTC_FUNCTION NtcStfTap NtcStfSample(NtcStfSampler settings, NtcStfExtent extent, float2 uv,
                                    NtcStfFootprint footprint, uint4 random) {
    NtcStfPlace place = NtcStfDrawPlace(settings, extent, uv, footprint, random);
    if (settings.kernelType == uint(NTC_KERNEL_NEAREST))
        return NtcStfPlaceTap(settings, extent, place.x.texel, place.y.texel, place.mip);
    if (settings.kernelType == uint(NTC_KERNEL_BILINEAR)) {
        NtcTexelCoord x = NtcGetBilinearCoord(place.x);
        NtcTexelCoord y = NtcGetBilinearCoord(place.y);
        return NtcStfPlaceTap(settings, extent, x.texel + (random.x < x.fraction ? 1 : 0),
                              y.texel + (random.y < y.fraction ? 1 : 0), place.mip);
    }
    NtcStfAxis x = NtcStfGetAxis(settings, place.x);
    NtcStfAxis y = NtcStfGetAxis(settings, place.y);
    int column = NtcStfDraw(x, random.x, uint(NTC_STF_ALL));
    int row = NtcStfDraw(y, random.y, uint(NTC_STF_ALL));
    NtcStfTap tap = NtcStfPlaceTap(settings, extent, x.first + column, y.first + row, place.mip);
    if (NtcStfIsSigned(settings)) {
        float norm = NtcMultiply(NtcMultiply(float(NtcStfGetTotal(x, uint(NTC_STF_ALL))), x.unit),
                                 NtcMultiply(float(NtcStfGetTotal(y, uint(NTC_STF_ALL))), y.unit));
        tap.scale = (x.weights[column] < 0) != (y.weights[row] < 0) ? -norm : norm;
    }
    return tap;
}

/// Two texels whose scaled values are added. Where second.scale is 0 there is nothing to read for the
/// second: always with kernels without negative weights.
struct NtcStfPair {
    NtcStfTap first;
    NtcStfTap second;
};

/// One texel of a part of the weights of each axis.
NTC_FUNCTION NtcStfTap NtcStfDrawPart(NtcStfSampler settings, NtcStfExtent extent, NtcStfAxis x, NtcStfAxis y,
                                      int mip, uint4 random, uint partX, uint partY) {
    return NtcStfPlaceTap(settings, extent, x.first + NtcStfDraw(x, random.x, partX),
                          y.first + NtcStfDraw(y, random.y, partY), mip);
}

/// One texel for the kernel's positive weights and one for its negative ones: scales are Q and 1 - Q, so
/// that constants come out as they are. Kernels without negative weights get what NtcStfSample gives.
NTC_FUNCTION NtcStfPair NtcStfSamplePair(NtcStfSampler settings, NtcStfExtent extent, float2 uv,
                                         NtcStfFootprint footprint, uint4 random) {
    NtcStfPair pair;
    if (!NtcStfIsSigned(settings)) {
        pair.first = NtcStfSample(settings, extent, uv, footprint, random);
        pair.second = pair.first;
        pair.second.scale = 0.0f;
        return pair;
    }
    const uint positive = uint(NTC_STF_POSITIVE);
    const uint negative = uint(NTC_STF_NEGATIVE);
    NtcStfPlace place = NtcStfDrawPlace(settings, extent, uv, footprint, random);
    NtcStfAxis x = NtcStfGetAxis(settings, place.x);
    NtcStfAxis y = NtcStfGetAxis(settings, place.y);
    float px = NtcMultiply(float(NtcStfGetTotal(x, positive)), x.unit);
    float py = NtcMultiply(float(NtcStfGetTotal(y, positive)), y.unit);
    float mx = NtcMultiply(float(NtcStfGetTotal(x, negative)), x.unit);
    float my = NtcMultiply(float(NtcStfGetTotal(y, negative)), y.unit);
    float both = NtcMultiply(px, py); // of which are positive: + + and - -
    float crossed = NtcMultiply(px, my);
    NTC_PRECISE float gain = both + NtcMultiply(mx, my);
    NTC_PRECISE float loss = crossed + NtcMultiply(mx, py);
    float at = float(random.w); // 16 bits decide, whatever the anisotropic tap has used of them
    if (footprint.taps > 1u)
        at = float((random.w * footprint.taps) & 0xFFFFu);
    bool isBoth = NtcMultiply(at, NtcKeep(gain)) < NtcMultiply(65536.0f, both);
    bool isCrossed = NtcMultiply(at, NtcKeep(loss)) < NtcMultiply(65536.0f, crossed);
    pair.first = NtcStfDrawPart(settings, extent, x, y, place.mip, random, isBoth ? positive : negative,
                                isBoth ? positive : negative);
    pair.second = NtcStfDrawPart(settings, extent, x, y, place.mip, random, isCrossed ? positive : negative,
                                 isCrossed ? negative : positive);
    pair.first.scale = NtcKeep(gain);
    pair.second.scale = -NtcKeep(loss);
    return pair;
}

NTC_NAMESPACE_END

#endif
