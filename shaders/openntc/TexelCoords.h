// SPDX-License-Identifier: MIT
// Texture coordinates to texels, in integers and in floats whose every operation is exact: the same on every
// device and on the host, whatever rounds there. Declares no resource.
#ifndef OPENNTC_TEXEL_COORDS_H
#define OPENNTC_TEXEL_COORDS_H

#include "Portability.h"
#include "WrapModes.h"

NTC_NAMESPACE_BEGIN

/// Where a coordinate lies along an axis of texels: texel index, any integer, and 16 bits of fraction.
struct NtcTexelCoord {
    int texel;
    uint fraction;
};

/// u (1 is the whole axis) in texels of an axis of `size`, 1 ... 65536, rounded down to 2^-16 of a texel.
/// Coordinates beyond 2^24 are 0 where they repeat; beyond +-64 they are +-64 where they are clamped or
/// outside; NaN is 0.
NTC_FUNCTION NtcTexelCoord NtcGetTexelCoord(float u, uint size, uint wrap) {
    float magnitude = asfloat(asuint(u) & 0x7FFFFFFFu);
    if (NtcIsNan(u))
        magnitude = 0.0f;
    if (wrap == uint(NTC_WRAP_CLAMP) || wrap == uint(NTC_WRAP_BORDER))
        magnitude = magnitude > 64.0f ? 64.0f : magnitude;
    else
        magnitude = magnitude >= 16777216.0f ? 0.0f : magnitude;
    float whole = floor(magnitude);
    uint periods = uint(whole);
    uint part = uint((magnitude - whole) * 16777216.0f); // both operations are exact
    uint scaled = (part >> 12) * size * 16u + (((part & 4095u) * size) >> 8);
    if (wrap == uint(NTC_WRAP_REPEAT))
        periods = 0u;
    if (wrap == uint(NTC_WRAP_MIRROR))
        periods = periods & 1u;
    NtcTexelCoord coord;
    coord.texel = int(periods * size + (scaled >> 16));
    coord.fraction = scaled & 0xFFFFu;
    if ((asuint(u) & 0x80000000u) != 0u) {
        coord.texel = coord.fraction != 0u ? -coord.texel - 1 : -coord.texel;
        coord.fraction = (65536u - coord.fraction) & 0xFFFFu;
    }
    return coord;
}

/// The first of the two texels of a bilinear tap, and the fraction towards the second.
NTC_FUNCTION NtcTexelCoord NtcGetBilinearCoord(NtcTexelCoord coord) {
    NtcTexelCoord first;
    uint moved = coord.fraction + 32768u;
    first.texel = coord.texel - 1 + int(moved >> 16);
    first.fraction = moved & 0xFFFFu;
    return first;
}

/// index modulo size, from 0 on.
NTC_FUNCTION int NtcModulo(int index, int size) {
    if (index >= 0)
        return int(uint(index) % uint(size));
    return size - 1 - int(uint(-1 - index) % uint(size));
}

/// The texel, 0 ... size - 1, that an index outside stands for; -1 for none (NTC_WRAP_BORDER).
NTC_FUNCTION int NtcAddressTexel(int index, int size, uint wrap) {
    if (wrap == uint(NTC_WRAP_CLAMP))
        return min(max(index, 0), size - 1);
    if (wrap == uint(NTC_WRAP_BORDER))
        return index >= 0 && index < size ? index : -1;
    if (wrap == uint(NTC_WRAP_REPEAT))
        return NtcModulo(index, size);
    int place = NtcModulo(index, 2 * size);
    return place < size ? place : 2 * size - 1 - place;
}

NTC_NAMESPACE_END

#endif
