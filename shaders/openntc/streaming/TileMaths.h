// SPDX-License-Identifier: MIT
// Where a sample falls: coordinates to texels, texels to tiles and regions, gradients to levels of detail.
// Integers, and floats whose every operation is exact or rounded once, so that the same coordinates give the
// same tiles on every device and on the host. Declares no resource.
#ifndef OPENNTC_TILE_MATHS_H
#define OPENNTC_TILE_MATHS_H

#include "StreamingConstants.h"
#include "openntc/Portability.h"
#include "openntc/TexelCoords.h"

NTC_NAMESPACE_BEGIN

/// Size of one axis at a mip.
NTC_FUNCTION uint NtcGetTiledMipSize(uint size, int mip) {
    uint shifted = size >> uint(min(max(mip, 0), 31));
    return shifted > 1u ? shifted : 1u;
}

/// The texel of an axis of `toSize` that holds the centre of a texel of an axis of `fromSize`, where toSize
/// is fromSize or at most half of it.
NTC_FUNCTION uint NtcScaleTexel(uint texel, uint fromSize, uint toSize) {
    if (fromSize == toSize)
        return texel;
    return ((2u * texel + 1u) * toSize) / (2u * fromSize);
}

/// Base-2 logarithm of a positive normal number, exact at powers of two, else within 2^-19. The polynomial
/// interpolates (log2(1 + t) - t) / (t (1 - t)) at Chebyshev points of 0 ... 1.
NTC_FUNCTION float NtcLog2(float x) {
    NTC_PRECISE float t = asfloat((asuint(x) & 0x7FFFFFu) | 0x3F800000u) - 1.0f;
    NTC_PRECISE float sum = NtcMultiply(-0.015125447f, t) + 0.0640729368f;
    sum = NtcMultiply(NtcKeep(sum), t) + -0.13144654f;
    sum = NtcMultiply(NtcKeep(sum), t) + 0.196660995f;
    sum = NtcMultiply(NtcKeep(sum), t) + -0.278201669f;
    sum = NtcMultiply(NtcKeep(sum), t) + 0.442688853f;
    NTC_PRECISE float opposite = 1.0f - t;
    NTC_PRECISE float fraction = t + NtcMultiply(NtcMultiply(NtcKeep(sum), NtcKeep(opposite)), t);
    NTC_PRECISE float result = float(int(asuint(x) >> 23) - 127) + NtcKeep(fraction);
    return result;
}

/// How a sample with gradients reads a texture: level of detail, bias included, before it is clamped to mips;
/// `taps` of them along `axis` (texture coordinates) where sampling is anisotropic; `gradients`, the larger
/// of both for each axis.
struct NtcSampleShape {
    float lod;
    uint taps;
    float2 axis;
    float2 gradients;
};

/// 1024: beyond every mip.
#define NTC_COARSEST_LOD 1024.0f

/// True for NaN and infinities.
NTC_FUNCTION bool NtcIsNotFinite(float x) {
    return (asuint(x) & 0x7F800000u) == 0x7F800000u;
}

NTC_FUNCTION float NtcGetLength2(float2 gradient, uint width, uint height) {
    // More than the whole texture per pixel needs no distinction, and this keeps squares finite.
    float x = gradient.x > 65536.0f ? 65536.0f : (gradient.x < -65536.0f ? -65536.0f : gradient.x);
    float y = gradient.y > 65536.0f ? 65536.0f : (gradient.y < -65536.0f ? -65536.0f : gradient.y);
    float texelsX = NtcMultiply(x, float(width));
    float texelsY = NtcMultiply(y, float(height));
    NTC_PRECISE float sum = NtcMultiply(texelsX, texelsX) + NtcMultiply(texelsY, texelsY);
    return NtcKeep(sum);
}

/// Gradients are those of texture coordinates for one pixel to the right and one down. NaN and infinities
/// give the coarsest mip, gradients of 0 the finest. `sampling` is NtcTiledTexture's.
NTC_FUNCTION NtcSampleShape NtcGetSampleShape(uint width, uint height, uint sampling, float mipBias,
                                              float2 ddx, float2 ddy) {
    NtcSampleShape shape;
    shape.lod = NTC_COARSEST_LOD;
    shape.taps = 1u;
    shape.axis = float2(0.0f, 0.0f);
    shape.gradients = float2(0.0f, 0.0f);
    if (NtcIsNotFinite(ddx.x) || NtcIsNotFinite(ddx.y) || NtcIsNotFinite(ddy.x) || NtcIsNotFinite(ddy.y))
        return shape;
    float lengthX = NtcGetLength2(ddx, width, height);
    float lengthY = NtcGetLength2(ddy, width, height);
    bool alongX = lengthX >= lengthY;
    float major = alongX ? lengthX : lengthY;
    float minor = alongX ? lengthY : lengthX;
    if (major < 7.8886091e-31f) // 2^-100: far below a texel of any mip, and safe to be flushed to 0
        major = 7.8886091e-31f;
    uint mostTaps = (sampling >> 16) & 255u;
    float logarithm = NtcLog2(major);
    NTC_PRECISE float lod = NtcMultiply(0.5f, logarithm) + mipBias;
    if (mostTaps > 1u && major > 7.8886091e-31f) {
        uint taps = 1u;
        NTC_LOOP while (taps < mostTaps && NtcMultiply(float(taps * taps), minor) < major) {
            taps += 1u;
        }
        shape.taps = taps;
        shape.axis = alongX ? ddx : ddy;
        shape.gradients = float2(abs(ddx.x) > abs(ddy.x) ? abs(ddx.x) : abs(ddy.x),
                                 abs(ddx.y) > abs(ddy.y) ? abs(ddx.y) : abs(ddy.y));
        lod = NtcKeep(lod) - NtcLog2(float(taps));
    }
    shape.lod = NtcKeep(lod);
    return shape;
}

/// Level of detail inside 0 ... mips - 1.
NTC_FUNCTION float NtcClampLod(float lod, int mips) {
    float last = float(mips - 1);
    return lod > last ? last : (lod > 0.0f ? lod : 0.0f);
}

/// 1 / n for n of 1 ... 32, rounded down to 24 bits: the same on every device, which a division is not.
NTC_FUNCTION float NtcGetReciprocal(uint n) {
    uint units = 16777216u / n; // of 2^-24
    return float(units) * 5.9604645e-8f;
}

/// Displacement of anisotropic tap `tap` along the axis, -1/2 ... 1/2 of it.
NTC_FUNCTION float NtcGetTapPlace(uint tap, uint taps) {
    return NtcMultiply(float(int(2u * tap + 1u) - int(taps)), NtcGetReciprocal(2u * taps));
}

/// A random word of two others (PCG's permutation, Jarzynski and Olano 2020).
NTC_FUNCTION uint NtcHash(uint a, uint b) {
    uint state = (a ^ (b * 0x9E3779B9u)) * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

/// The finest mip of a region's bits, NTC_NO_MIP for none.
NTC_FUNCTION uint NtcGetFinestMip(uint bits) {
    if (bits == 0u)
        return NTC_NO_MIP;
    uint lowest = bits & (~bits + 1u); // one bit, whose float has it as exponent
    return (asuint(float(lowest)) >> 23) - 127u;
}

/// Up to two ranges of texels of an axis, both ends included; the second is empty if it ends at -1.
struct NtcTexelRanges {
    int first0;
    int last0;
    int first1;
    int last1;
};

/// What the indices first ... last, first <= last, are after addressing.
NTC_FUNCTION NtcTexelRanges NtcAddressRange(int first, int last, int size, uint wrap) {
    NtcTexelRanges ranges;
    ranges.first0 = 0;
    ranges.last0 = size - 1;
    ranges.first1 = 0;
    ranges.last1 = -1;
    int span = last - first;
    if (wrap == uint(NTC_WRAP_CLAMP)) {
        ranges.first0 = min(max(first, 0), size - 1);
        ranges.last0 = min(max(last, 0), size - 1);
    } else if (wrap == uint(NTC_WRAP_REPEAT)) {
        if (span < size - 1) {
            int begin = NtcModulo(first, size);
            ranges.first0 = begin;
            ranges.last0 = min(begin + span, size - 1);
            ranges.last1 = begin + span - size; // below 0 if nothing is left
            ranges.last1 = max(ranges.last1, -1);
        }
    } else if (span < size - 1) {
        int begin = NtcModulo(first, 2 * size);
        int end = begin + span;
        if (end < size) {
            ranges.first0 = begin;
            ranges.last0 = end;
        } else if (begin < size) { // over the upper end and back
            ranges.first0 = min(begin, 2 * size - 1 - end);
        } else if (end < 2 * size) {
            ranges.first0 = 2 * size - 1 - end;
            ranges.last0 = 2 * size - 1 - begin;
        } else { // over the lower end and back
            ranges.last0 = max(2 * size - 1 - begin, end - 2 * size);
        }
    }
    return ranges;
}

/// The region of an axis that holds the lower edge of a texel of a mip.
NTC_FUNCTION uint NtcGetFirstRegion(int texel, uint mipSize, uint size, uint regionSize) {
    return ((uint(texel) * size) / mipSize) / regionSize;
}

/// The region that holds its upper edge, or ends there. (texel + 1) size is at most 2^32, where it wraps and
/// the subtraction wraps it back.
NTC_FUNCTION uint NtcGetLastRegion(int texel, uint mipSize, uint size, uint regionSize) {
    return (((uint(texel) + 1u) * size - 1u) / mipSize) / regionSize;
}

NTC_NAMESPACE_END

#endif
