// SPDX-License-Identifier: MIT
// From the outputs of the network to a texel of a texture: channels, colour space, dither. C++ includes this
// file too, as the reference of the pass DecompressToTextures.
#ifndef OPENNTC_DECOMPRESS_TEXEL_H
#define OPENNTC_DECOMPRESS_TEXEL_H

#include "DecompressConstants.h"
#include "openntc/ColorSpaces.h"
#include "openntc/Portability.h"

// 0: no code for conversion of colour spaces, which a set whose textures are read as they are stored does not
// call for. Drivers on the CPU run such code for nothing, where a branch would leave it out.
#ifndef NTC_DECOMPRESS_CONVERT
#define NTC_DECOMPRESS_CONVERT 1
#endif
#if NTC_DECOMPRESS_CONVERT != 0 && NTC_DECOMPRESS_CONVERT != 1
#error NTC_DECOMPRESS_CONVERT must be 0 or 1
#endif
#if defined(__cplusplus) && NTC_DECOMPRESS_CONVERT != 1
#error NTC_DECOMPRESS_CONVERT is a switch of shaders, not of C++
#endif

NTC_NAMESPACE_BEGIN

/// A hash of 32 bits (format specification, "streaming" 5.4: J).
NTC_FUNCTION uint NtcHashWord(uint a) {
    a = (a + 0x7ED55D16u) + (a << 12);
    a = (a ^ 0xC761C23Cu) ^ (a >> 19);
    a = (a + 0x165667B1u) + (a << 5);
    a = (a + 0xD3A2646Cu) ^ (a << 9);
    a = (a + 0xFD7046C5u) + (a << 3);
    a = (a ^ 0xB55A4F09u) ^ (a >> 16);
    return a;
}

NTC_FUNCTION uint NtcRotateLeft(uint x, uint bits) {
    return (x << bits) | (x >> (32u - bits));
}

/// MurmurHash3 of one word (the same source: M).
NTC_FUNCTION uint NtcHashKey(uint seed, uint key) {
    uint h = seed ^ (NtcRotateLeft(key * 0xCC9E2D51u, 15u) * 0x1B873593u);
    h = NtcRotateLeft(h, 13u) * 5u + 0xE6546B64u;
    h = h ^ 4u;
    h = (h ^ (h >> 16)) * 0x85EBCA6Bu;
    h = (h ^ (h >> 13)) * 0xC2B2AE35u;
    return h ^ (h >> 16);
}

/// The seed of a texel's noise; its output number n (1 for the first) has NtcHashKey(seed, n), of which the
/// lowest byte is for the first component.
NTC_FUNCTION uint NtcGetDitherSeed(int2 texel, int mipWidth) {
    return NtcHashWord(uint(texel.x) + uint(texel.y) * uint(mipWidth));
}

/// The colour space of component k of an output.
NTC_FUNCTION int NtcGetOutputColorSpace(NtcDecompressOutput output_, uint k) {
    return int((output_.channels >> (k == 3u ? 10u : 8u)) & 3u);
}

/// The network's output that component k of an output shows.
NTC_FUNCTION int NtcGetOutputChannel(NtcDecompressOutput output_, uint k) {
    return min(int(output_.channels & 15u) + int(k), NTC_MAX_CHANNELS - 1);
}

/// Is a component of another colour space than the channel that it shows?
NTC_FUNCTION bool NtcIsConverted(NtcDecompressOutput output_, uint channelColorSpaces) {
    bool isConverted = false;
    NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
        int source = NtcGetChannelColorSpace(channelColorSpaces, NtcGetOutputChannel(output_, k));
        if (k < ((output_.channels >> 4) & 7u) && source != NtcGetOutputColorSpace(output_, k))
            isConverted = true;
    }
    return isConverted;
}

/// Does an output show four channels from a multiple of 4 on, neither converted nor dithered nor rounded?
NTC_FUNCTION bool NtcIsPlainOutput(NtcDecompressOutput output_, uint channelColorSpaces) {
    // First channel, number of components, bits of a code.
    bool isStored = (output_.channels & 0x1F073u) == 0x40u && output_.ditherScale == 0.0f;
    return isStored && !NtcIsConverted(output_, channelColorSpaces);
}

/// The code 0 ... most next to a value, the higher of two; most: 1 ... 65535. Exact, where graphics APIs let
/// the device's own conversion err (Vulkan 1.3, "Conversion from Floating-Point to Normalized Fixed-Point"):
/// the mantissa's 24 bits times 16, plus one half, without what is below 2^12 and never reaches a code. NaN
/// gives 0.
NTC_FUNCTION uint NtcQuantiseUnorm(float value, uint most) {
    uint bits = asuint(value);
    if (bits > 0x7F800000u) // NaN or negative
        return 0u;
    if (bits >= 0x3F800000u) // 1 or more
        return most;
    uint shift = 150u - (bits >> 23); // value = mantissa / 2^shift; 24 or more
    if (shift > 40u)                  // below 2^-17, half a code of 16 bits
        return 0u;
    uint mantissa = (bits & 0x7FFFFFu) | 0x800000u;
    uint product = (mantissa >> 12) * most + (((mantissa & 0xFFFu) * most) >> 12); // 2^12 of them make one
    return (product + (1u << (shift - 13u))) >> (shift - 12u);
}

/// Component k of an output before its texture's format rounds it. value: the network's output of channel
/// NtcGetOutputChannel(output_, k), as stored; noise: the output's hash. Components that the output does not
/// have are 0, the fourth 1. Neither dithered nor rounded, and of the same colour space as the channel, it is
/// the value.
NTC_FUNCTION float NtcMakeComponent(NtcDecompressOutput output_, uint channelColorSpaces, uint k, int channel,
                                    float value, uint noise) {
    if (k >= ((output_.channels >> 4) & 7u))
        return k == 3u ? 1.0f : 0.0f;
    int destination = NtcGetOutputColorSpace(output_, k);
    float converted = value;
#if NTC_DECOMPRESS_CONVERT
    converted =
        NtcConvertColorSpace(value, NtcGetChannelColorSpace(channelColorSpaces, channel), destination);
#endif
    if (output_.ditherScale != 0.0f) {
        float offset = float((noise >> (8u * k)) & 255u) / 256.0f - 0.5f; // exact
        NTC_PRECISE float dithered = converted + NtcMultiply(offset, output_.ditherScale);
        converted = dithered;
    }
    uint codeBits = (output_.channels >> 12) & 31u;
    if (codeBits != 0u) {
        // So near to the code that no device's conversion finds another.
        uint most = (1u << codeBits) - 1u;
        converted = float(NtcQuantiseUnorm(converted, most)) / float(most);
    }
    return converted;
}

/// Outputs first ... first + 3, the last one again in the place of those behind it. By the bits of `first`:
/// at an index that is known at run time only, an array is read from memory (12 % of the pass on an H100).
NTC_FUNCTION float4 NtcSelectOutputs(NTC_IN_ARRAY(float, outputs, NTC_MAX_CHANNELS), uint first) {
    float w[12];
    NTC_UNROLL for (int a = 0; a < 8; a++) w[a] = (first & 8u) != 0u ? outputs[a + 8] : outputs[a];
    NTC_UNROLL for (int b = 8; b < 12; b++) w[b] = (first & 8u) != 0u ? outputs[15] : outputs[b];
    NTC_UNROLL for (int c = 0; c < 7; c++) w[c] = (first & 4u) != 0u ? w[c + 4] : w[c];
    NTC_UNROLL for (int d = 0; d < 5; d++) w[d] = (first & 2u) != 0u ? w[d + 2] : w[d];
    NTC_UNROLL for (int e = 0; e < 4; e++) w[e] = (first & 1u) != 0u ? w[e + 1] : w[e];
    return float4(w[0], w[1], w[2], w[3]);
}

/// The noise of an output's texel; 0 where it is not dithered.
NTC_FUNCTION uint NtcGetOutputNoise(NtcDecompressOutput output_, int2 texel, int mipWidth) {
    uint noise = 0u;
    if (output_.ditherScale != 0.0f)
        noise = NtcHashKey(NtcGetDitherSeed(texel, mipWidth), output_.noise);
    return noise;
}

/// One texel of an output. texel: of the mip, whose width is mipWidth.
NTC_FUNCTION float4 NtcMakeOutputTexel(NtcDecompressOutput output_, uint channelColorSpaces,
                                       NTC_IN_ARRAY(float, outputs, NTC_MAX_CHANNELS), int2 texel,
                                       int mipWidth) {
    uint noise = NtcGetOutputNoise(output_, texel, mipWidth);
    float4 values = NtcSelectOutputs(outputs, output_.channels & 15u);
    float4 components = values;
    NTC_UNROLL for (int k = 0; k < 4; k++) components[k] = NtcMakeComponent(
        output_, channelColorSpaces, uint(k), NtcGetOutputChannel(output_, uint(k)), values[k], noise);
    return components;
}

NTC_NAMESPACE_END

#endif
