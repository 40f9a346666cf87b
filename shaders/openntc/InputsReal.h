// SPDX-License-Identifier: MIT
// Network inputs of the maths modes FP32, FP16 and FP8: real numbers where the Int8 network has bytes.
//
// Latents. The real value of a code is x = code * step + bias (format specification, latents 6.3), and the
// Int8 network's input is X = 127.5 x, which is exactly the integer v = code * m + a (latents 6.2). So:
//   FP32  input = f32(v w), w the binary32 bilinear weight; low-res: the four products summed in corner order
//   FP16  input = f16((v / 128) f16(w)): v / 128 is a half, and no sum of the network overflows
//   FP8   x = f16(f16(code f16(step)) + f16(bias)), input = f16(x f16(w))  (network 5)
// Waves e and level of detail e: 127.5 e; f16(127.5 / 128 e); f16(e). The Int8 network saturates its inputs
// at 1, which a level of detail can exceed, so FP32 and FP16 clamp it to -1 ... 1; FP8 does not. FP8 then
// rounds every input to E4M3. Slots without a feature are 0. Generations 2 and 3: InputsMips.h.
#ifndef OPENNTC_INPUTS_REAL_H
#define OPENNTC_INPUTS_REAL_H

#include "InferenceConstants.h"
#include "InputsMips.h"
#include "InputsPosition.h"
#include "Latents.h"
#include "Network.h"
#include "Portability.h"
#include "Rounding.h"
#include "Switches.h"

#define NTC_MAX_INPUTS 96

#if NTC_WITH_REAL_INPUTS
NTC_NAMESPACE_BEGIN

/// The rounding behind each operation of a mode: to half, or none besides that of binary32.
NTC_FUNCTION float NtcRoundReal(int math, float x) {
    if (math == NTC_MATH_FP32)
        return x;
    return NtcRoundToHalf(x);
}

#if NTC_WITH_LATENT_GRIDS
/// Latent `index` (0 ... 3) of the codes from NtcLoadLatentCodes, in the units of the mode.
NTC_FUNCTION float NtcMapRealLatent(int math, uint codes, uint index, NtcLatentEncodingConstants encoding) {
    if (math == NTC_MATH_FP8) {
        uint code = (codes >> (index * uint(encoding.quantBits))) & encoding.dataMask;
        NTC_PRECISE float scaled =
            NtcRoundToHalf(float(code) * NtcRoundToHalf(asfloat(uint(encoding.quantizedScale))));
        NTC_PRECISE float x = NtcRoundToHalf(scaled + NtcRoundToHalf(asfloat(uint(encoding.quantizedBias))));
        return x;
    }
    float level = float(NtcMapLatent(codes, index, encoding));
    return math == NTC_MATH_FP16 ? level * 0.0078125f : level;
}

/// A latent times its corner's bilinear weight, rounded once.
NTC_FUNCTION float NtcWeightRealLatent(int math, uint codes, uint index, float weight,
                                       NtcLatentEncodingConstants encoding) {
    return NtcRoundReal(math, NtcMultiply(NtcMapRealLatent(math, codes, index, encoding), weight));
}

#endif

/// The network's input from a number that has been rounded to the mode's format.
NTC_FUNCTION float NtcFinishRealInput(int math, float x) {
    if (math == NTC_MATH_FP8)
        return NtcRoundToE4M3(x);
    return x;
}

/// The network's input from a wave or level of detail.
NTC_FUNCTION float NtcScaleRealInput(int math, float e) {
    NTC_PRECISE float scaled = e;
    if (math == NTC_MATH_FP32)
        scaled = NtcMultiply(NtcKeep(e), 127.5f); // or the wave's (d - 1) 127.5 becomes one rounding
    if (math == NTC_MATH_FP16)
        scaled = NtcMultiply(NtcKeep(e), 0.99609375f);
    return NtcFinishRealInput(math, NtcRoundReal(math, scaled));
}

/// The level of detail as the mode takes it; NaN is taken as 0.
NTC_FUNCTION float NtcScaleRealLod(int math, float lod) {
    if (NtcIsNan(lod))
        return 0.0f;
    if (math != NTC_MATH_FP8)
        lod = lod > 1.0f ? 1.0f : (lod < -1.0f ? -1.0f : lod);
    return NtcScaleRealInput(math, lod);
}

#if NTC_WITH_LATENT_GRIDS
/// The four corners of a bilinear sample as in NtcGridTaps, weights not quantised.
struct NtcRealTaps {
    uint pixel0;
    uint pixel1;
    uint pixel2;
    uint pixel3;
    float weight0;
    float weight1;
    float weight2;
    float weight3;
};

/// Corners and weights, rounded to the mode's format, of the sample at texel centre (u, v) of a present grid.
NTC_FUNCTION NtcRealTaps NtcGetRealTaps(int math, NtcNeuralMipConstants grid, float u, float v) {
    uint sliceWidth = grid.sliceWidthHeight & 0xFFFFu;
    NtcAxisTaps x =
        NtcGetAxisTaps(u, grid.imageWidthHeight & 0xFFFFu, grid.sliceLeftTop & 0xFFFFu, sliceWidth);
    NtcAxisTaps y =
        NtcGetAxisTaps(v, grid.imageWidthHeight >> 16, grid.sliceLeftTop >> 16, grid.sliceWidthHeight >> 16);
    NTC_PRECISE float restX = 1.0f - x.fraction;
    NTC_PRECISE float restY = 1.0f - y.fraction;
    float oppositeX = NtcKeep(restX); // or (1 - x) w becomes w - x w, rounded once
    float oppositeY = NtcKeep(restY);
    NtcRealTaps taps;
    taps.pixel0 = uint(y.first) * sliceWidth + uint(x.first);
    taps.pixel1 = uint(y.first) * sliceWidth + uint(x.second);
    taps.pixel2 = uint(y.second) * sliceWidth + uint(x.first);
    taps.pixel3 = uint(y.second) * sliceWidth + uint(x.second);
    taps.weight0 = NtcRoundReal(math, NtcMultiply(oppositeX, oppositeY));
    taps.weight1 = NtcRoundReal(math, NtcMultiply(x.fraction, oppositeY));
    taps.weight2 = NtcRoundReal(math, NtcMultiply(oppositeX, y.fraction));
    taps.weight3 = NtcRoundReal(math, NtcMultiply(x.fraction, y.fraction));
    return taps;
}

/// Input `wave` (0 ... 3) of one frequency: x, y, and the same a quarter period later (network, 2.2).
NTC_FUNCTION float NtcGetRealWave(int math, float position, float frequency, float phase) {
    NTC_PRECISE float t = position * frequency; // a power of two: exact
    t = t + phase;
    return NtcScaleRealInput(math, NtcTriangleWave(t));
}

/// NtcPrepareRealInputsFrom of generation 1; the latents are present.
NTC_FUNCTION void NtcPrepareRealGridInputs(int networkVersion, int math, NtcMip mip, NtcBuffer latents,
                                           uint latentsOffset, int2 texel,
                                           NTC_INOUT_ARRAY(float, inputs, NTC_MAX_INPUTS)) {
    NTC_PRECISE float u = NtcTexelCenter(texel.x, mip.width);
    NTC_PRECISE float v = NtcTexelCenter(texel.y, mip.height);
    uint slots = 4u * NtcGetHighResWords(networkVersion);

    NtcRealTaps taps = NtcGetRealTaps(math, mip.highRes, u, v);
    uint grid = latentsOffset + mip.highRes.dataOffset;
    NTC_UNROLL for (uint feature = 0u; feature < slots; feature += 4u) {
        bool used = feature < uint(mip.highResEncoding.numFeatures);
        uint codes0 = 0u;
        uint codes1 = 0u;
        uint codes2 = 0u;
        uint codes3 = 0u;
        if (used) {
            codes0 = NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel0, feature);
            codes1 = NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel1, feature);
            codes2 = NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel2, feature);
            codes3 = NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel3, feature);
        }
        NTC_UNROLL for (uint i = 0u; i < 4u; i++) {
            float input0 = NtcWeightRealLatent(math, codes0, i, taps.weight0, mip.highResEncoding);
            float input1 = NtcWeightRealLatent(math, codes1, i, taps.weight1, mip.highResEncoding);
            float input2 = NtcWeightRealLatent(math, codes2, i, taps.weight2, mip.highResEncoding);
            float input3 = NtcWeightRealLatent(math, codes3, i, taps.weight3, mip.highResEncoding);
            inputs[feature + i] = used ? NtcFinishRealInput(math, input0) : 0.0f;
            inputs[slots + feature + i] = used ? NtcFinishRealInput(math, input1) : 0.0f;
            inputs[2u * slots + feature + i] = used ? NtcFinishRealInput(math, input2) : 0.0f;
            inputs[3u * slots + feature + i] = used ? NtcFinishRealInput(math, input3) : 0.0f;
        }
    }

    taps = NtcGetRealTaps(math, mip.lowRes, u, v);
    grid = latentsOffset + mip.lowRes.dataOffset;
    uint base = 4u * slots;
    NTC_UNROLL for (uint lowFeature = 0u; lowFeature < 16u; lowFeature += 4u) {
        bool lowUsed = lowFeature < uint(mip.lowResEncoding.numFeatures);
        uint low0 = 0u;
        uint low1 = 0u;
        uint low2 = 0u;
        uint low3 = 0u;
        if (lowUsed) {
            low0 = NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel0, lowFeature);
            low1 = NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel1, lowFeature);
            low2 = NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel2, lowFeature);
            low3 = NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel3, lowFeature);
        }
        NTC_UNROLL for (uint j = 0u; j < 4u; j++) {
            NTC_PRECISE float sum = NtcWeightRealLatent(math, low0, j, taps.weight0, mip.lowResEncoding);
            sum = NtcKeep(sum) + NtcWeightRealLatent(math, low1, j, taps.weight1, mip.lowResEncoding);
            sum = NtcRoundReal(math, sum);
            sum = NtcKeep(sum) + NtcWeightRealLatent(math, low2, j, taps.weight2, mip.lowResEncoding);
            sum = NtcRoundReal(math, sum);
            sum = NtcKeep(sum) + NtcWeightRealLatent(math, low3, j, taps.weight3, mip.lowResEncoding);
            sum = NtcRoundReal(math, sum);
            inputs[base + lowFeature + j] = lowUsed ? NtcFinishRealInput(math, sum) : 0.0f;
        }
    }

    NTC_PRECISE float positionX = float(texel.x) * mip.colorMip.positionScale;
    NTC_PRECISE float positionY = float(texel.y) * mip.colorMip.positionScale;
    NTC_PRECISE float frequency = 0.125f;
    base += 16u;
    NTC_UNROLL for (uint wave = 0u; wave < 3u; wave++) {
        inputs[base + 4u * wave] = NtcGetRealWave(math, positionX, frequency, 0.0f);
        inputs[base + 4u * wave + 1u] = NtcGetRealWave(math, positionY, frequency, 0.0f);
        inputs[base + 4u * wave + 2u] = NtcGetRealWave(math, positionX, frequency, 0.25f);
        inputs[base + 4u * wave + 3u] = NtcGetRealWave(math, positionY, frequency, 0.25f);
        frequency = frequency * 2.0f;
    }
    float lod = NtcScaleRealLod(math, mip.colorMip.positionLod);
    inputs[base + 12u] = lod;
    inputs[base + 13u] = lod;
    inputs[base + 14u] = 0.0f;
    inputs[base + 15u] = 0.0f;
}
#endif

#if NTC_WITH_LATENT_MIPS
/// The input of a latent from 15 q.
NTC_FUNCTION float NtcScaleRealLatent(int networkVersion, int math, float sum) {
    NTC_PRECISE float x = 0.0f;
    if (math == NTC_MATH_FP8) {
        x = NtcMultiply(NtcKeep(sum), 0.133333340287208557f) - 1.0f; // 2 / 15: 0x3E088889
        return NtcRoundToE4M3(NtcRoundToHalf(x));
    }
    x = NtcMultiply(NtcKeep(sum), 17.0f) - (networkVersion == NTC_NETWORK_GENERATION_3 ? 128.0f : 127.5f);
    if (math == NTC_MATH_FP16)
        return NtcRoundToHalf(NtcKeep(x) * 0.0078125f);
    return x;
}

#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
/// The 16 inputs of a level of the latent texture, from `first` on.
NTC_FUNCTION void NtcSampleRealLatentLevel(int networkVersion, int math, uint level, NtcMip mip,
                                           NtcBuffer latents, uint latentsOffset, int2 texel, uint first,
                                           NTC_INOUT_ARRAY(float, inputs, NTC_MAX_INPUTS)) {
    float2 uv =
        float2(NtcGetLatentCoordinate(texel.x, mip.width), NtcGetLatentCoordinate(texel.y, mip.height));
    NTC_UNROLL for (uint layer = 0u; layer < 4u; layer++) {
        bool used = 4u * layer < uint(mip.highResEncoding.numFeatures);
        float4 q = float4(0.0f, 0.0f, 0.0f, 0.0f);
        if (used)
            q = NtcSampleLatents(latents, latentsOffset, uv, layer, level);
        float4 sums = float4(NtcMultiply(q.z, 15.0f), NtcMultiply(q.y, 15.0f), NtcMultiply(q.x, 15.0f),
                             NtcMultiply(q.w, 15.0f));
        inputs[first + 4u * layer] = used ? NtcScaleRealLatent(networkVersion, math, sums.x) : 0.0f;
        inputs[first + 4u * layer + 1u] = used ? NtcScaleRealLatent(networkVersion, math, sums.y) : 0.0f;
        inputs[first + 4u * layer + 2u] = used ? NtcScaleRealLatent(networkVersion, math, sums.z) : 0.0f;
        inputs[first + 4u * layer + 3u] = used ? NtcScaleRealLatent(networkVersion, math, sums.w) : 0.0f;
    }
}
#else
/// The input of code `index` (0 ... 3) of a layer, from the codes around the sample and their weights.
NTC_FUNCTION float NtcBlendRealLatent(int networkVersion, int math, NtcLatentTexels texels, uint index,
                                      float4 weights) {
    uint shift = 4u * index;
    NTC_PRECISE float sum = NtcMultiply(float((texels.texel0 >> shift) & 15u), weights.x);
    sum = NtcKeep(sum) + NtcMultiply(float((texels.texel1 >> shift) & 15u), weights.y);
    sum = NtcKeep(sum) + NtcMultiply(float((texels.texel2 >> shift) & 15u), weights.z);
    sum = NtcKeep(sum) + NtcMultiply(float((texels.texel3 >> shift) & 15u), weights.w);
    return NtcScaleRealLatent(networkVersion, math, sum);
}

/// The 16 inputs of one latent mip, from `first` on.
NTC_FUNCTION void NtcSampleRealLatentMip(int networkVersion, int math, NtcNeuralMipConstants grid, NtcMip mip,
                                         NtcBuffer latents, uint latentsOffset, int2 texel, uint first,
                                         NTC_INOUT_ARRAY(float, inputs, NTC_MAX_INPUTS)) {
    NtcAxisTaps x = NtcGetLatentMipTaps(grid, 0u, texel.x, mip.width);
    NtcAxisTaps y = NtcGetLatentMipTaps(grid, 1u, texel.y, mip.height);
    NTC_PRECISE float restX = 1.0f - x.fraction;
    NTC_PRECISE float restY = 1.0f - y.fraction;
    float oppositeX = NtcKeep(restX); // or (1 - x) w becomes w - x w, rounded once
    float oppositeY = NtcKeep(restY);
    float4 weights = float4(NtcMultiply(oppositeX, oppositeY), NtcMultiply(x.fraction, oppositeY),
                            NtcMultiply(oppositeX, y.fraction), NtcMultiply(x.fraction, y.fraction));
    uint width = grid.sliceWidthHeight & 0xFFFFu;
    uint layerSize = width * (grid.sliceWidthHeight >> 16);
    NTC_UNROLL for (uint layer = 0u; layer < 4u; layer++) {
        bool used = 4u * layer < uint(mip.highResEncoding.numFeatures);
        NtcLatentTexels texels;
        texels.texel0 = 0u;
        texels.texel1 = 0u;
        texels.texel2 = 0u;
        texels.texel3 = 0u;
        if (used)
            texels =
                NtcLoadLatentTexels(latents, latentsOffset + grid.dataOffset, layer * layerSize, width, x, y);
        NTC_UNROLL for (uint i = 0u; i < 4u; i++) {
            float blended = NtcBlendRealLatent(networkVersion, math, texels, i, weights);
            inputs[first + 4u * layer + i] = used ? blended : 0.0f;
        }
    }
}

#endif

/// Input `phase` (0 or 1/4 of a period) of one frequency of a sawtooth wave.
NTC_FUNCTION float NtcGetRealSawtooth(int math, float position, float frequency, float phase) {
    NTC_PRECISE float t = position * frequency; // a power of two: exact
    t = t + phase;
    return NtcScaleRealInput(math, NtcSawtoothWave(t));
}

/// NtcPrepareRealInputsFrom of generations 2 and 3; the latents are present.
NTC_FUNCTION void NtcPrepareRealMipInputs(int networkVersion, int math, NtcMip mip, NtcBuffer latents,
                                          uint latentsOffset, int2 texel,
                                          NTC_INOUT_ARRAY(float, inputs, NTC_MAX_INPUTS)) {
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
    uint level = uint(mip.colorMip.neuralMip);
    NtcSampleRealLatentLevel(networkVersion, math, level, mip, latents, latentsOffset, texel, 0u, inputs);
    NtcSampleRealLatentLevel(networkVersion, math, level + 1u, mip, latents, latentsOffset, texel, 16u,
                             inputs);
#else
    NtcSampleRealLatentMip(networkVersion, math, mip.highRes, mip, latents, latentsOffset, texel, 0u, inputs);
    NtcSampleRealLatentMip(networkVersion, math, mip.lowRes, mip, latents, latentsOffset, texel, 16u, inputs);
#endif
    NTC_PRECISE float positionX = float(texel.x) * mip.colorMip.positionScale;
    NTC_PRECISE float positionY = float(texel.y) * mip.colorMip.positionScale;
    NTC_PRECISE float frequency = 1.0f;
    NTC_UNROLL for (uint wave = 0u; wave < 3u; wave++) {
        inputs[32u + 4u * wave] = NtcGetRealSawtooth(math, positionX, frequency, 0.0f);
        inputs[33u + 4u * wave] = NtcGetRealSawtooth(math, positionY, frequency, 0.0f);
        inputs[34u + 4u * wave] = NtcGetRealSawtooth(math, positionX, frequency, 0.25f);
        inputs[35u + 4u * wave] = NtcGetRealSawtooth(math, positionY, frequency, 0.25f);
        frequency = frequency * 2.0f;
    }
    float lod = NtcScaleRealLod(math, mip.colorMip.positionLod);
    inputs[44] = lod;
    inputs[45] = lod;
    inputs[46] = 0.0f;
    inputs[47] = 0.0f;
}
#endif

/// The network's inputs of one texel as floats; those behind the last are left alone. False, with the inputs
/// untouched, if the mip level does not exist or its latents are not present.
NTC_FUNCTION bool NtcPrepareRealInputsFrom(int networkVersion, int math, NtcMip mip, NtcBuffer latents,
                                           uint latentsOffset, int2 texel,
                                           NTC_INOUT_ARRAY(float, inputs, NTC_MAX_INPUTS)) {
    if (!mip.exists || !NtcIsLatentImage(mip.colorMip.neuralMip) || !NtcIsGridPresent(mip.highRes) ||
        !NtcIsGridPresent(mip.lowRes))
        return false;
#if NTC_WITH_LATENT_MIPS
    if (NtcReadsLatentMips(networkVersion))
        NtcPrepareRealMipInputs(networkVersion, math, mip, latents, latentsOffset, texel, inputs);
#endif
#if NTC_WITH_LATENT_GRIDS
    if (!NtcReadsLatentMips(networkVersion))
        NtcPrepareRealGridInputs(networkVersion, math, mip, latents, latentsOffset, texel, inputs);
#endif
    return true;
}

NTC_NAMESPACE_END
#endif

#endif
