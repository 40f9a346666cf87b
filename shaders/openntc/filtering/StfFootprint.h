// SPDX-License-Identifier: MIT
// Derivatives to level of detail and to anisotropic taps, in integers but for sums and products of two, each
// rounded once.
#ifndef OPENNTC_STF_FOOTPRINT_H
#define OPENNTC_STF_FOOTPRINT_H

#include "StfTypes.h"
#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

/// Base-2 logarithm of a number >= 0 in 2^-16, exact at powers of two, else off by at most 3.6 of them: -127
/// for 0, 128 and more for infinities and NaN. The mantissa's polynomial is z + z (1 - z) p(z).
NTC_FUNCTION int NtcStfLog2(float x) {
    uint bits = asuint(x);
    int exponent = int((bits >> 23) & 255u) - 127;
    uint z = (bits & 0x7FFFFFu) >> 7;
    uint h = (z * (65536u - z)) >> 15;
    uint z2 = (z * z) >> 16;
    uint z3 = (z2 * z) >> 16;
    uint p = 14481u - ((8755u * z) >> 16) + ((4864u * z2) >> 16) - ((1479u * z3) >> 16);
    return exponent * 65536 + int(z + ((h * p) >> 16));
}

/// Squared length of a derivative in texels of mip 0, without a sign even where it is NaN.
NTC_FUNCTION float NtcStfGetLength2(float2 gradient, NtcStfExtent extent) {
    float x = NtcMultiply(gradient.x, float(extent.width));
    float y = NtcMultiply(gradient.y, float(extent.height));
    NTC_PRECISE float sum = NtcMultiply(x, x) + NtcMultiply(y, y);
    return asfloat(asuint(NtcKeep(sum)) & 0x7FFFFFFFu);
}

/// A level of detail with the sampler's bias, brought inside the mips.
NTC_FUNCTION int NtcStfClampLod(NtcStfSampler settings, int lod, int levels) {
    return min(max(lod + settings.lodBias, 0), (levels - 1) * 65536);
}

/// What a pixel covers. `ddx`, `ddy`: derivatives of the texture coordinates towards the pixel to the right
/// and below, taken before the coordinates are wrapped by hand. Vulkan's isotropic and anisotropic rules
/// with rho = max(|A|, |B|). NaN and infinities give the coarsest mip, derivatives of 0 the finest.
NTC_FUNCTION NtcStfFootprint NtcStfGetFootprint(NtcStfSampler settings, NtcStfExtent extent, float2 ddx,
                                                float2 ddy) {
    float lengthX = NtcStfGetLength2(ddx, extent);
    float lengthY = NtcStfGetLength2(ddy, extent);
    bool alongX = asuint(lengthX) >= asuint(lengthY); // like the numbers, and NaN is the largest
    int major = NtcStfLog2(alongX ? lengthX : lengthY) >> 1;
    int minor = NtcStfLog2(alongX ? lengthY : lengthX) >> 1;
    NtcStfFootprint footprint;
    footprint.taps = 1u;
    footprint.axis = alongX ? ddx : ddy;
    int most = int(settings.maxAnisotropy > 16u ? 16u : settings.maxAnisotropy);
    if (most > 1) {
        int lod = max(minor, major - NtcStfLog2(float(most)));
        int ratio = major - lod;
        NTC_LOOP for (int k = 1; k < most; k++) {
            if (NtcStfLog2(float(k)) < ratio)
                footprint.taps += 1u;
        }
        major = lod;
    }
    footprint.lod = NtcStfClampLod(settings, major, extent.levels);
    return footprint;
}

/// A level of detail that is known, in 2^-16 of a mip, without anisotropy.
NTC_FUNCTION NtcStfFootprint NtcStfMakeFootprint(NtcStfSampler settings, NtcStfExtent extent, int lod) {
    NtcStfFootprint footprint;
    footprint.lod = NtcStfClampLod(settings, lod, extent.levels);
    footprint.taps = 1u;
    footprint.axis = float2(0.0f, 0.0f);
    return footprint;
}

/// 0.5 / taps in binary32 for 1 ... 16, by a division in integers: those of floats are not the same
/// everywhere.
NTC_FUNCTION float NtcStfGetHalfStep(uint taps) {
    uint shift = taps >= 16u ? 4u : (taps >= 8u ? 3u : (taps >= 4u ? 2u : (taps >= 2u ? 1u : 0u)));
    uint mantissa = (((1u << (25u + shift)) / taps) + 1u) >> 1; // at most 2^24
    return float(mantissa) * asfloat((127u - 25u - shift) << 23);
}

/// Where anisotropic tap `tap` of a footprint is: midpoints of equal parts of its axis.
NTC_FUNCTION float2 NtcStfGetTapPlace(float2 uv, NtcStfFootprint footprint, uint tap) {
    if (footprint.taps <= 1u)
        return uv;
    float offset =
        NtcMultiply(float(2 * int(tap) + 1 - int(footprint.taps)), NtcStfGetHalfStep(footprint.taps));
    NTC_PRECISE float u = uv.x + NtcMultiply(offset, footprint.axis.x);
    NTC_PRECISE float v = uv.y + NtcMultiply(offset, footprint.axis.y);
    return float2(NtcKeep(u), NtcKeep(v));
}

NTC_NAMESPACE_END

#endif
