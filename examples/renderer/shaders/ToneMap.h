// SPDX-License-Identifier: MIT
// From radiance to the 8 bits of a picture: exposure, tone curve, sRGB. Declares no resource.
#ifndef OPENNTC_RENDERER_TONE_MAP_H
#define OPENNTC_RENDERER_TONE_MAP_H

#include "Vectors.h"
#include "openntc/ColorSpaces.h"

#define NTCR_TONE_NONE 0    // clamped to 0 ... 1
#define NTCR_TONE_NEUTRAL 1 // Khronos PBR Neutral
#define NTCR_TONE_ACES 2    // a curve fitted to ACES (Narkowicz 2015)

NTC_NAMESPACE_BEGIN

/// Khronos PBR Neutral, as the specification has it: highlights lose saturation towards their own peak, not
/// towards 1.
NTC_FUNCTION float3 NtcrToneMapNeutral(float3 color) {
    float x = min(min(color.x, color.y), color.z);
    float offset = x < 0.08f ? x - x * x / 0.16f : 0.04f;
    float3 c = color - NtcrGray(offset);
    float peak = NtcrGetLargest(c);
    if (peak <= 0.76f)
        return c;
    float compressed = 1.0f - 0.0576f / (peak - 0.52f);
    float kept = 1.0f / (0.15f * (peak - compressed) + 1.0f);
    return NtcrMix(NtcrGray(compressed), c * (compressed / peak), kept);
}

NTC_FUNCTION float NtcrToneMapAces(float x) {
    return clamp(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 0.0f, 1.0f);
}

/// `toneCurve`: NTCR_TONE_*; radiance >= 0. Linear 0 ... 1.
NTC_FUNCTION float3 NtcrToneMap(float3 radiance, int toneCurve) {
    float3 color = radiance;
    if (toneCurve == NTCR_TONE_NEUTRAL)
        color = NtcrToneMapNeutral(color);
    if (toneCurve == NTCR_TONE_ACES)
        color = float3(NtcrToneMapAces(color.x), NtcrToneMapAces(color.y), NtcrToneMapAces(color.z));
    return clamp(color, NtcrGray(0.0f), NtcrGray(1.0f));
}

/// Linear 0 ... 1 to sRGB.
NTC_FUNCTION float3 NtcrEncodeSrgb(float3 color) {
    return float3(NtcEncodeSrgb(color.x), NtcEncodeSrgb(color.y), NtcEncodeSrgb(color.z));
}

/// 0 ... 1 to 0 ... 255, rounded, without dithering.
NTC_FUNCTION uint NtcrQuantize(float value) {
    return uint(floor(255.0f * value + 0.5f));
}

/// A pixel of the picture: radiance times `exposure` (2^EV) to RGBA, red in the lowest byte, alpha 255.
NTC_FUNCTION uint NtcrMakePixel(float3 radiance, float exposure, int toneCurve) {
    float3 color = NtcrEncodeSrgb(NtcrToneMap(radiance * exposure, toneCurve));
    return NtcrQuantize(color.x) | (NtcrQuantize(color.y) << 8u) | (NtcrQuantize(color.z) << 16u) |
           0xFF000000u;
}

NTC_NAMESPACE_END

#endif
