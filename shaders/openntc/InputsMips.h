// SPDX-License-Identifier: MIT
// Network inputs of generations 2 and 3 (format specification, generations 5): features of two latent mips
// at the same place, sawtooth waves of the texel coordinates and the level of detail. 48 inputs: 16 of latent
// mip n, 16 of n + 1, 12 of waves, 2 of the level of detail and 2 that are 0.
//
// INT8, with S of the filter (LatentMips.h):
//   generation 3  floor(255 q - 127.5 - 1/2) = floor(17 S / 2^16) - 128
//   generation 2  trunc(255 q - 127.5) = trunc((17 S - 127.5 * 2^16) / 2^16)
//   waves and level of detail e: trunc(127.5 e), the lowest 8 bits
// What INT8 quantises is for the other modes, with S / 15 = q:
//   FP32  generation 3: f32(f32(17 S) - 128), whose integers are those of a code without neighbours;
//         generation 2: f32(f32(17 S) - 127.5). Waves and level of detail as in generation 1 (InputsReal.h)
//   FP16  f16(that / 128)
//   FP8   f16(f32(f32(S f32(2 / 15)) - 1)), then E4M3
// Layers that a set does not have are 0.
#ifndef OPENNTC_INPUTS_MIPS_H
#define OPENNTC_INPUTS_MIPS_H

#include "InferenceConstants.h"
#include "InputsPosition.h"
#include "LatentMips.h"
#include "Network.h"
#include "Portability.h"
#include "Switches.h"

NTC_NAMESPACE_BEGIN

/// What the inputs of a texel need of one of its coordinates: texels of a column, or of a row, share it. Of
/// generations 2 and 3 highRes is latent mip n, and lowRes n + 1.
struct NtcAxisInputs {
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
    float coordinate; // in every level of the texture
#else
    NtcAxisTaps highRes;
    NtcAxisTaps lowRes;
#endif
    uint waves[3]; // of NtcEncodeAxisPosition
};

#if NTC_WITH_LATENT_MIPS
/// Sawtooth wave of period 1: from -1 at 0 up to 1. Numbers of 2^23 and above have no fraction; infinities
/// and NaN are treated as such.
NTC_FUNCTION float NtcSawtoothWave(float t) {
    NTC_PRECISE float fraction = 0.0f;
    if ((asuint(t) & 0x7FFFFFFFu) < 0x4B000000u)
        fraction = NtcKeep(t) - floor(t);
    NTC_PRECISE float wave = 2.0f * fraction - 1.0f; // 2 x is exact, so fusing it would change nothing
    return wave;
}

/// trunc(127.5 e), the lowest 8 bits: not clamped. 0 for NaN and beyond 2^31.
NTC_FUNCTION uint NtcTruncateInput(float e) {
    NTC_PRECISE float scaled = NtcKeep(e) * 127.5f;
    if ((asuint(scaled) & 0x7FFFFFFFu) >= 0x4F000000u)
        return 0u;
    return uint(int(scaled)) & 255u;
}

/// The two inputs of one wave along one axis, at bits 0 and 16: at the position, and a quarter period later.
/// `frequency` is a power of two; position is texel * positionScale.
NTC_FUNCTION uint NtcEncodeAxisSawtooth(float position, float frequency) {
    NTC_PRECISE float at = position * frequency;
    NTC_PRECISE float shifted = at + 0.25f;
    return NtcTruncateInput(NtcSawtoothWave(at)) | (NtcTruncateInput(NtcSawtoothWave(shifted)) << 16);
}

/// NtcMakeAxisInputs of generations 2 and 3.
NTC_FUNCTION NtcAxisInputs NtcMakeMipAxisInputs(NtcMip mip, int texel, uint axis) {
    NtcAxisInputs inputs;
    int mipSize = axis == 0u ? mip.width : mip.height;
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
    inputs.coordinate = NtcGetLatentCoordinate(texel, mipSize);
#else
    inputs.highRes = NtcGetLatentMipTaps(mip.highRes, axis, texel, mipSize);
    inputs.lowRes = NtcGetLatentMipTaps(mip.lowRes, axis, texel, mipSize);
#endif
    NTC_PRECISE float position = float(texel) * mip.colorMip.positionScale;
    inputs.waves[0] = NtcEncodeAxisSawtooth(position, 1.0f);
    inputs.waves[1] = NtcEncodeAxisSawtooth(position, 2.0f);
    inputs.waves[2] = NtcEncodeAxisSawtooth(position, 4.0f);
    return inputs;
}

#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE || defined(__cplusplus) // which tests it
/// A latent q as an INT8 input of generation 2, the lowest 8 bits.
NTC_FUNCTION uint NtcTruncateLatent(float q) {
    NTC_PRECISE float scaled = NtcMultiply(q, 255.0f) - 127.5f;
    return uint(int(scaled)) & 255u;
}

/// A latent q of generation 3: floor(255 q) in bits 8-15, below and above anything. The quantiser's steps lie
/// on codes and on multiples of 1/255: 1/16 of a step keeps what a device rounds down there, to binary16 at
/// worst (255 / 4096 of a step), from losing a whole one. From 2^15 on floats are multiples of 1/256: the sum
/// is rounded to one, and its bits from 2^0 on are the floor.
NTC_FUNCTION uint NtcFloorLatent(float q) {
    NTC_PRECISE float raised = NtcMultiply(q, 255.0f) + 32768.0625f;
    return asuint(raised);
}

/// The four inputs of a texel of the latent texture.
NTC_FUNCTION uint NtcQuantizeLatents(int networkVersion, float4 q) {
    if (networkVersion == NTC_NETWORK_GENERATION_2)
        return NtcTruncateLatent(q.z) | (NtcTruncateLatent(q.y) << 8) | (NtcTruncateLatent(q.x) << 16) |
               (NtcTruncateLatent(q.w) << 24);
    uint word = ((NtcFloorLatent(q.z) >> 8) & 0xFFu) | (NtcFloorLatent(q.y) & 0xFF00u) |
                ((NtcFloorLatent(q.x) << 8) & 0xFF0000u) | ((NtcFloorLatent(q.w) << 16) & 0xFF000000u);
    return word ^ 0x80808080u; // - 128 in every byte
}
#endif

#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
/// The four words of the features of a level of the latent texture, from `firstWord` on.
NTC_FUNCTION void NtcSampleLatentLevel(int networkVersion, uint level, uint features, NtcBuffer latents,
                                       uint latentsOffset, float2 uv, uint firstWord,
                                       NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    NTC_UNROLL for (uint layer = 0u; layer < 4u; layer++) {
        uint word = 0u;
        if (4u * layer < features) {
            word = NtcQuantizeLatents(networkVersion,
                                      NtcSampleLatents(latents, latentsOffset, uv, layer, level));
        }
        inputs[firstWord + layer] = word;
    }
}
#else
/// The inputs of codes 0 and 1 of a layer in bits 16-31. What is taken away before rounding is there first.
NTC_FUNCTION uint NtcBlendLatentPair(int networkVersion, NtcLatentTexels texels, NtcLatentWeights weights) {
    bool truncates = networkVersion == NTC_NETWORK_GENERATION_2;
    uint low = truncates ? 0xFF808000u : 0xFF800000u;  // -127.5 and -128 times 2^16
    uint high = truncates ? 0x80800000u : 0x80000000u; // and times 2^24
    NtcAddLatents(texels, weights, low, high);
    if (truncates) { // towards 0, where bits that are cut off are a floor
        low += int(low) < 0 ? 0xFFFFu : 0u;
        high += int(high) < 0 ? 0xFFFFFFu : 0u;
    }
    return (low & 0xFF0000u) | (high & 0xFF000000u);
}

/// The four inputs of a layer.
NTC_FUNCTION uint NtcBlendLatentTexels(int networkVersion, NtcLatentTexels texels, NtcLatentWeights weights) {
    return (NtcBlendLatentPair(networkVersion, texels, weights) >> 16) |
           NtcBlendLatentPair(networkVersion, NtcShiftLatentTexels(texels), weights);
}

/// The four words of the features of one latent mip, from `firstWord` on.
NTC_FUNCTION void NtcSampleLatentMip(int networkVersion, NtcNeuralMipConstants mip, uint features,
                                     NtcBuffer latents, uint latentsOffset, NtcAxisTaps x, NtcAxisTaps y,
                                     uint firstWord, NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    uint width = mip.sliceWidthHeight & 0xFFFFu;
    uint layerSize = width * (mip.sliceWidthHeight >> 16);
    uint grid = latentsOffset + mip.dataOffset;
    NtcLatentWeights weights =
        NtcMakeLatentWeights(NtcGetLatentWeight(x.fraction), NtcGetLatentWeight(y.fraction));
    NTC_UNROLL for (uint layer = 0u; layer < 4u; layer++) {
        uint word = 0u;
        if (4u * layer < features) {
            NtcLatentTexels texels = NtcLoadLatentTexels(latents, grid, layer * layerSize, width, x, y);
            word = NtcBlendLatentTexels(networkVersion, texels, weights);
        }
        inputs[firstWord + layer] = word;
    }
}

#endif

/// NtcCombineAxisInputs of generations 2 and 3.
NTC_FUNCTION void NtcCombineMipAxisInputs(int networkVersion, NtcMip mip, NtcBuffer latents,
                                          uint latentsOffset, NtcAxisInputs column, NtcAxisInputs row,
                                          NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    uint features = uint(mip.highResEncoding.numFeatures);
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
    float2 uv = float2(column.coordinate, row.coordinate);
    uint level = uint(mip.colorMip.neuralMip);
    NtcSampleLatentLevel(networkVersion, level, features, latents, latentsOffset, uv, 0u, inputs);
    NtcSampleLatentLevel(networkVersion, level + 1u, features, latents, latentsOffset, uv, 4u, inputs);
#else
    NtcSampleLatentMip(networkVersion, mip.highRes, features, latents, latentsOffset, column.highRes,
                       row.highRes, 0u, inputs);
    NtcSampleLatentMip(networkVersion, mip.lowRes, features, latents, latentsOffset, column.lowRes,
                       row.lowRes, 4u, inputs);
#endif
    NTC_UNROLL for (uint w = 0u; w < 3u; w++) inputs[8u + w] = column.waves[w] | (row.waves[w] << 8);
    inputs[11u] = NtcTruncateInput(mip.colorMip.positionLod) * 257u;
}
#endif

NTC_NAMESPACE_END

#endif
