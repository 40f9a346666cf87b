// SPDX-License-Identifier: MIT
// Latent grids: addressing, unpacking, and bilinear sampling with the integer weights of the Int8 network
// (format specification, latents 6 and 7, network 2.1 and 3.1).
#ifndef OPENNTC_LATENTS_H
#define OPENNTC_LATENTS_H

#include "Buffers.h"
#include "Effects.h"
#include "InferenceConstants.h"
#include "Portability.h"
#include "Switches.h"

NTC_NAMESPACE_BEGIN

/// Rounds n / d (in [1, 2), n < 2^25, 2^23 <= d < 2^24) to 24 bits, nearest, ties to even, and returns it
/// times 2^23. `estimate` is n / d to within 4 units of 2^-23. GPUs divide to 2.5 ulp only, so the remainder
/// is worked out in integers (it is small, so the two products may wrap) and moves the estimate to the exact
/// integer quotient.
NTC_FUNCTION uint NtcRoundQuotient(uint n, uint d, float estimate) {
    uint quotient = uint(estimate * 8388608.0f);
    int divisor = int(d);
    int remainder = int((n << 23) - quotient * d);
    for (int i = 0; i < 5; i++) {
        if (remainder < 0) {
            remainder += divisor;
            quotient -= 1u;
        }
    }
    for (int j = 0; j < 5; j++) {
        if (remainder >= divisor) {
            remainder -= divisor;
            quotient += 1u;
        }
    }
    int twice = 2 * remainder;
    if (twice > divisor || (twice == divisor && (quotient & 1u) != 0u))
        quotient += 1u;
    return quotient;
}

/// The binary32 nearest to (texel + 1/2) / size, ties to even: the same bits on every device. size is 1 ...
/// 2^20; texels beyond +-2^22 (the format goes to 2^20) are taken as +-2^22.
NTC_FUNCTION float NtcTexelCenter(int texel, int size) {
#if NTC_CLAMP_TEXELS
    int odd = 2 * min(max(texel, -4194304), 4194303) + 1;
    uint sign = odd < 0 ? 0x80000000u : 0u;
    uint nBits = asuint(float(odd < 0 ? -odd : odd)); // both are below 2^24: exact
#else
    uint sign = 0u;
    uint nBits = asuint(float(2 * texel + 1));
#endif
    uint dBits = asuint(float(2 * size));
    uint n = (nBits & 0x7FFFFFu) | 0x800000u;
    uint d = (dBits & 0x7FFFFFu) | 0x800000u;
    uint exponent = 127u + (nBits >> 23) - (dBits >> 23);
    if (n < d) {
        n = n << 1;
        exponent -= 1u;
    }
    NTC_PRECISE float estimate = float(n) / float(d); // n has 24 significant bits: both exact
    // The leading one of the quotient adds 1 to the exponent; a quotient rounded up to 2 adds 2, as it
    // should.
    return asfloat(sign | (((exponent - 1u) << 23) + NtcRoundQuotient(n, d, estimate)));
}

/// The two taps of one axis: latent pixels relative to the slice, and the fraction between them.
struct NtcAxisTaps {
    int first;
    int second;
    float fraction;
};

/// Taps at texel centre u (0 ... 1 over the image) of an axis with `size` latent pixels of which those from
/// `sliceStart`, `sliceSize` many, are present. Taps are clamped to the slice; the fraction is not altered by
/// that.
NTC_FUNCTION NtcAxisTaps NtcGetAxisTaps(float u, uint size, uint sliceStart, uint sliceSize) {
    NTC_PRECISE float scaled = NtcMultiply(u, float(size));
#if NTC_LATENT_SLICES
    scaled = scaled - float(sliceStart);
#endif
    NTC_PRECISE float position = NtcKeep(scaled) - 0.5f;
    NTC_PRECISE float cell = floor(position);
    NtcAxisTaps taps;
    NTC_PRECISE float fraction = NtcKeep(position) - cell; // or it is taken for fract(), which differs
    taps.fraction = NtcKeep(fraction);
    int last = int(sliceSize) - 1;
#if NTC_CLAMP_TEXELS
    // Before the conversion: far outside the image the cell does not fit an int. Sizes are below 2^16.
    int index = int(cell < -2.0f ? -2.0f : (cell > 65536.0f ? 65536.0f : cell));
#else
    int index = int(cell);
#endif
    taps.first = min(max(index, 0), last);
    taps.second = min(max(index + 1, 0), last);
    return taps;
}

/// The four corners of a bilinear sample, in the order (x0, y0), (x1, y0), (x0, y1), (x1, y1).
struct NtcGridTaps {
    uint pixel0;
    uint pixel1;
    uint pixel2;
    uint pixel3; // y * slice width + x
    int weight0;
    int weight1;
    int weight2;
    int weight3; // truncated to 1/256; their sum is 253 ... 256
};

NTC_FUNCTION int NtcQuantizeBilinearWeight(float x, float y) {
    NTC_PRECISE float weight = x * y;
    NTC_PRECISE float scaled = weight * 256.0f;
    return int(scaled);
}

/// True if a latent image of this number can be sampled.
NTC_FUNCTION bool NtcIsLatentImage(int neuralMip) {
#if NTC_SINGLE_MIP
    return neuralMip == 0;
#else
    return neuralMip >= 0 && neuralMip < NTC_MAX_NEURAL_MIPS;
#endif
}

/// True if the grid is part of the latents that the constants describe; without NTC_LATENT_SLICES, and in a
/// texture, all of it.
NTC_FUNCTION bool NtcIsGridPresent(NtcNeuralMipConstants grid) {
#if !NTC_LATENT_SLICES || NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
    if (grid.sliceWidthHeight != grid.imageWidthHeight)
        return false;
#endif
    return (grid.sliceWidthHeight & 0xFFFFu) != 0u && (grid.sliceWidthHeight >> 16) != 0u;
}

/// Taps of one axis of a grid that is present, at texel centre u. axis: 0 along x, 1 along y.
NTC_FUNCTION NtcAxisTaps NtcGetGridAxisTaps(NtcNeuralMipConstants grid, float u, uint axis) {
    uint shift = 16u * axis;
    return NtcGetAxisTaps(u, (grid.imageWidthHeight >> shift) & 0xFFFFu,
                          (grid.sliceLeftTop >> shift) & 0xFFFFu, (grid.sliceWidthHeight >> shift) & 0xFFFFu);
}

/// Corners and weights of the sample at the taps of both axes.
NTC_FUNCTION NtcGridTaps NtcCombineAxisTaps(NtcNeuralMipConstants grid, NtcAxisTaps x, NtcAxisTaps y) {
    uint sliceWidth = grid.sliceWidthHeight & 0xFFFFu;
    NTC_PRECISE float oppositeX = 1.0f - x.fraction;
    NTC_PRECISE float oppositeY = 1.0f - y.fraction;
    NtcGridTaps taps;
    taps.pixel0 = uint(y.first) * sliceWidth + uint(x.first);
    taps.pixel1 = uint(y.first) * sliceWidth + uint(x.second);
    taps.pixel2 = uint(y.second) * sliceWidth + uint(x.first);
    taps.pixel3 = uint(y.second) * sliceWidth + uint(x.second);
    taps.weight0 = NtcQuantizeBilinearWeight(oppositeX, oppositeY);
    taps.weight1 = NtcQuantizeBilinearWeight(x.fraction, oppositeY);
    taps.weight2 = NtcQuantizeBilinearWeight(oppositeX, y.fraction);
    taps.weight3 = NtcQuantizeBilinearWeight(x.fraction, y.fraction);
    return taps;
}

/// Corners and weights of the sample at texel centre (u, v) of a grid that is present.
NTC_FUNCTION NtcGridTaps NtcGetGridTaps(NtcNeuralMipConstants grid, float u, float v) {
    return NtcCombineAxisTaps(grid, NtcGetGridAxisTaps(grid, u, 0u), NtcGetGridAxisTaps(grid, v, 1u));
}

/// The word that holds four consecutive latents of a pixel, shifted so that the first one is in its lowest
/// bits. `feature` is a multiple of 4; four latents never cross a word. gridOffset is the grid's byte offset
/// in the buffer.
NTC_FUNCTION uint NtcLoadLatentCodes(NtcBuffer latents, uint gridOffset, NtcLatentEncodingConstants encoding,
                                     uint pixel, uint feature) {
    uint element = pixel * uint(encoding.numFeatures) + feature;
    uint word = NtcBufferLoad(latents, gridOffset + 4u * (element >> uint(encoding.logElementsPerUint)));
    return word >> ((element & encoding.addressMask) * uint(encoding.quantBits));
}

/// Latent `index` (0 ... 3) of the codes from NtcLoadLatentCodes as the network's integer: code * scale +
/// bias.
NTC_FUNCTION int NtcMapLatent(uint codes, uint index, NtcLatentEncodingConstants encoding) {
    uint code = (codes >> (index * uint(encoding.quantBits))) & encoding.dataMask;
    return int(code * uint(encoding.quantizedScale) + uint(encoding.quantizedBias));
}

/// Codes `first` and `first` + 2 of four as the halves of a word. first: 0 or 1.
NTC_FUNCTION uint NtcPairCodes(uint codes, uint first, NtcLatentEncodingConstants encoding) {
    uint low = codes >> (first * uint(encoding.quantBits));
    uint high = low << uint(16 - 2 * encoding.quantBits);
    return (low & encoding.dataMask) | (high & (encoding.dataMask << 16));
}

// Weighted latents, two in the halves of a word: a mapped latent (-126 ... 129) times its weights (0 ... 256
// in all) and 126 * 256 is 0 ... 65280, so that neither half reaches the other one.
#define NTC_WEIGHTED_BIAS 32256u

/// Bits 8-15 and 24-31 of two such words, without the bias, as bytes 0, 2 and 1, 3: sums without carries
/// between bytes.
NTC_FUNCTION uint NtcPackWeightedLatents(uint even, uint odd) {
    uint bytes = ((even >> 8) & 0x00FF00FFu) | (odd & 0xFF00FF00u);
    uint sums = (bytes & 0x7F7F7F7Fu) + 0x02020202u; // - 126 is + 0x82 in a byte
    return sums ^ (~bytes & 0x80808080u);
}

/// Four high-resolution inputs of one corner, each weighted, floored and packed as a byte.
NTC_FUNCTION uint NtcWeightLatents(uint codes, int weight, NtcLatentEncodingConstants encoding) {
    uint scale = uint(encoding.quantizedScale * weight);
    uint bias = (uint(encoding.quantizedBias * weight) + NTC_WEIGHTED_BIAS) * 65537u;
    return NtcPackWeightedLatents(NtcPairCodes(codes, 0u, encoding) * scale + bias,
                                  NtcPairCodes(codes, 1u, encoding) * scale + bias);
}

/// Four low-resolution inputs: the blend of four corners, floored once and packed as a byte each.
NTC_FUNCTION uint NtcBlendLatents(uint codes0, uint codes1, uint codes2, uint codes3, NtcGridTaps taps,
                                  NtcLatentEncodingConstants encoding) {
    uint scale0 = uint(encoding.quantizedScale * taps.weight0);
    uint scale1 = uint(encoding.quantizedScale * taps.weight1);
    uint scale2 = uint(encoding.quantizedScale * taps.weight2);
    uint scale3 = uint(encoding.quantizedScale * taps.weight3);
    int weights = taps.weight0 + taps.weight1 + taps.weight2 + taps.weight3;
    uint bias = (uint(encoding.quantizedBias * weights) + NTC_WEIGHTED_BIAS) * 65537u;
    uint even = NtcPairCodes(codes0, 0u, encoding) * scale0 + NtcPairCodes(codes1, 0u, encoding) * scale1 +
                NtcPairCodes(codes2, 0u, encoding) * scale2 + NtcPairCodes(codes3, 0u, encoding) * scale3;
    uint odd = NtcPairCodes(codes0, 1u, encoding) * scale0 + NtcPairCodes(codes1, 1u, encoding) * scale1 +
               NtcPairCodes(codes2, 1u, encoding) * scale2 + NtcPairCodes(codes3, 1u, encoding) * scale3;
    return NtcPackWeightedLatents(even + bias, odd + bias);
}

/// What one mip level of a texture set is to a decoder.
struct NtcMip {
    bool exists;
    int width;
    int height;
    NtcColorMipConstants colorMip;
    NtcLatentEncodingConstants highResEncoding;
    NtcLatentEncodingConstants lowResEncoding;
    NtcNeuralMipConstants highRes;
    NtcNeuralMipConstants lowRes;
};

NTC_FUNCTION NtcMip NtcMakeMip(bool exists, NtcLatentEncodingConstants highResEncoding,
                               NtcLatentEncodingConstants lowResEncoding, NtcNeuralMipConstants highRes,
                               NtcNeuralMipConstants lowRes, NtcColorMipConstants colorMip, int width,
                               int height) {
    NtcMip mip;
    mip.exists = exists;
    mip.width = width;
    mip.height = height;
    mip.colorMip = colorMip;
    mip.highResEncoding = highResEncoding;
    mip.lowResEncoding = lowResEncoding;
    mip.highRes = highRes;
    mip.lowRes = lowRes;
    return mip;
}

NTC_NAMESPACE_END

#endif
