// SPDX-License-Identifier: MIT
// Positional inputs of the network: triangle waves of the texel coordinates (format specification,
// network, 2.2).
#ifndef OPENNTC_INPUTS_POSITION_H
#define OPENNTC_INPUTS_POSITION_H

#include "Portability.h"

NTC_NAMESPACE_BEGIN

/// Triangle wave of period 1: 1 at 0, 0 at 1/4, -1 at 1/2, 0 at 3/4. Numbers of 2^23 and above have no
/// fraction; infinities and NaN are treated as such.
NTC_FUNCTION float NtcTriangleWave(float t) {
    NTC_PRECISE float fraction = 0.0f;
    if ((asuint(t) & 0x7FFFFFFFu) < 0x4B000000u)
        fraction = NtcKeep(t) - floor(t);
    NTC_PRECISE float distance = 4.0f * fraction - 2.0f; // 4 x is exact, so fusing it would change nothing
    NTC_PRECISE float wave = abs(distance) - 1.0f;
    return wave;
}

/// Input number in -1 ... 1 to a signed byte: trunc(clamp(127.5 e, -128, 127)); NaN becomes 0.
NTC_FUNCTION int NtcQuantizeInput(float e) {
    NTC_PRECISE float scaled = NtcKeep(e) * 127.5f;
    if (NtcIsNan(scaled))
        return 0;
    if (scaled >= 127.0f)
        return 127;
    if (scaled <= -128.0f)
        return -128;
    return int(scaled);
}

/// The two inputs of one wave along one axis, at bits 0 and 16: at the position, and a quarter period later.
/// `frequency` is a power of two; position is texel * positionScale.
NTC_FUNCTION uint NtcEncodeAxisPosition(float position, float frequency) {
    NTC_PRECISE float at = position * frequency;
    NTC_PRECISE float shifted = at + 0.25f;
    return (uint(NtcQuantizeInput(NtcTriangleWave(at))) & 255u) |
           ((uint(NtcQuantizeInput(NtcTriangleWave(shifted))) & 255u) << 16);
}

/// The four inputs of one wave, packed into a word: (x, y) and the same a quarter period later.
NTC_FUNCTION uint NtcEncodePosition(float positionX, float positionY, float frequency) {
    return NtcEncodeAxisPosition(positionX, frequency) | (NtcEncodeAxisPosition(positionY, frequency) << 8);
}

NTC_NAMESPACE_END

#endif
