// SPDX-License-Identifier: MIT
// Colour spaces of stored channels: linear, sRGB (IEC 61966-2-1) and HLG (ITU-R BT.2100 with scene-linear 1
// at half signal, 12 at full). Scalars in binary32; pow, exp, log and sqrt are the platform's, so results are
// close, not equal, between devices.
#ifndef OPENNTC_COLOR_SPACES_H
#define OPENNTC_COLOR_SPACES_H

#include "InferenceConstants.h"
#include "Portability.h"

NTC_NAMESPACE_BEGIN

/// sRGB to linear. Negative numbers take the linear branch; nothing is clamped.
NTC_FUNCTION float NtcDecodeSrgb(float c) {
    if (c <= 0.04045f)
        return c / 12.92f;
    return pow((c + 0.055f) / 1.055f, 2.4f);
}

/// Linear to sRGB.
NTC_FUNCTION float NtcEncodeSrgb(float e) {
    if (e <= 0.0031308f)
        return 12.92f * e;
    return 1.055f * pow(e, 1.0f / 2.4f) - 0.055f;
}

/// HLG signal to scene-linear light, odd.
NTC_FUNCTION float NtcDecodeHlg(float h) {
    float magnitude = abs(h);
    float e = 0.0f;
    if (magnitude < 0.5f)
        e = 4.0f * magnitude * magnitude;
    else
        e = exp((magnitude - 0.55991073f) / 0.17883277f) + 0.28466892f;
    return h < 0.0f ? -e : e;
}

/// Scene-linear light to HLG signal, odd.
NTC_FUNCTION float NtcEncodeHlg(float e) {
    float magnitude = abs(e);
    float h = 0.0f;
    if (magnitude < 1.0f)
        h = 0.5f * sqrt(magnitude);
    else
        h = 0.17883277f * log(magnitude - 0.28466892f) + 0.55991073f;
    return e < 0.0f ? -h : h;
}

/// The 2-bit colour space (NTC_COLOR_SPACE_*) of one channel.
NTC_FUNCTION int NtcGetChannelColorSpace(uint channelColorSpaces, int channel) {
    return int((channelColorSpaces >> uint(2 * channel)) & 3u);
}

/// From a colour space (NTC_COLOR_SPACE_*) to linear; linear and unknown spaces leave the number untouched.
NTC_FUNCTION float NtcConvertToLinear(float value, int colorSpace) {
    if (colorSpace == NTC_COLOR_SPACE_SRGB)
        return NtcDecodeSrgb(value);
    if (colorSpace == NTC_COLOR_SPACE_HLG)
        return NtcDecodeHlg(value);
    return value;
}

/// From linear to a colour space.
NTC_FUNCTION float NtcConvertFromLinear(float value, int colorSpace) {
    if (colorSpace == NTC_COLOR_SPACE_SRGB)
        return NtcEncodeSrgb(value);
    if (colorSpace == NTC_COLOR_SPACE_HLG)
        return NtcEncodeHlg(value);
    return value;
}

/// From one colour space to another; untouched when they are equal.
NTC_FUNCTION float NtcConvertColorSpace(float value, int source, int destination) {
    if (source == destination)
        return value;
    return NtcConvertFromLinear(NtcConvertToLinear(value, source), destination);
}

/// A stored output of `channel` to linear, by the 2-bit colour spaces of the texture-set constants.
NTC_FUNCTION float NtcConvertChannelToLinearColorSpace(float value, int channel, uint channelColorSpaces) {
    return NtcConvertToLinear(value, NtcGetChannelColorSpace(channelColorSpaces, channel));
}

NTC_NAMESPACE_END

#endif
