// SPDX-License-Identifier: MIT
// Network inputs of the maths modes INT8 and INT8_HALF: bytes (format specification, network 2 and 3.1).
#ifndef OPENNTC_INPUTS_INT8_H
#define OPENNTC_INPUTS_INT8_H

#include "InferenceConstants.h"
#include "InputsMips.h"
#include "InputsPosition.h"
#include "Latents.h"
#include "Network.h"
#include "Portability.h"

NTC_NAMESPACE_BEGIN

#if NTC_WITH_LATENT_GRIDS
/// NtcMakeAxisInputs of generation 1.
NTC_FUNCTION NtcAxisInputs NtcMakeGridAxisInputs(NtcMip mip, int texel, uint axis) {
    NtcAxisInputs inputs;
    NTC_PRECISE float center = NtcTexelCenter(texel, axis == 0u ? mip.width : mip.height);
    inputs.highRes = NtcGetGridAxisTaps(mip.highRes, center, axis);
    inputs.lowRes = NtcGetGridAxisTaps(mip.lowRes, center, axis);
    NTC_PRECISE float position = float(texel) * mip.colorMip.positionScale;
    inputs.waves[0] = NtcEncodeAxisPosition(position, 0.125f);
    inputs.waves[1] = NtcEncodeAxisPosition(position, 0.25f);
    inputs.waves[2] = NtcEncodeAxisPosition(position, 0.5f);
    return inputs;
}

/// NtcCombineAxisInputs of generation 1.
NTC_FUNCTION void NtcCombineGridAxisInputs(int networkVersion, NtcMip mip, NtcBuffer latents,
                                           uint latentsOffset, NtcAxisInputs column, NtcAxisInputs row,
                                           NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    uint highResWords = NtcGetHighResWords(networkVersion);

    NtcGridTaps taps = NtcCombineAxisTaps(mip.highRes, column.highRes, row.highRes);
    uint grid = latentsOffset + mip.highRes.dataOffset;
    NTC_UNROLL for (uint i = 0u; i < highResWords; i++) {
        uint feature = 4u * i;
        bool used = feature < uint(mip.highResEncoding.numFeatures);
        inputs[i] = 0u;
        inputs[highResWords + i] = 0u;
        inputs[2u * highResWords + i] = 0u;
        inputs[3u * highResWords + i] = 0u;
        if (used) {
            inputs[i] =
                NtcWeightLatents(NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel0, feature),
                                 taps.weight0, mip.highResEncoding);
            inputs[highResWords + i] =
                NtcWeightLatents(NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel1, feature),
                                 taps.weight1, mip.highResEncoding);
            inputs[2u * highResWords + i] =
                NtcWeightLatents(NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel2, feature),
                                 taps.weight2, mip.highResEncoding);
            inputs[3u * highResWords + i] =
                NtcWeightLatents(NtcLoadLatentCodes(latents, grid, mip.highResEncoding, taps.pixel3, feature),
                                 taps.weight3, mip.highResEncoding);
        }
    }

    taps = NtcCombineAxisTaps(mip.lowRes, column.lowRes, row.lowRes);
    grid = latentsOffset + mip.lowRes.dataOffset;
    NTC_UNROLL for (uint j = 0u; j < 4u; j++) {
        uint feature = 4u * j;
        uint blended = 0u;
        if (feature < uint(mip.lowResEncoding.numFeatures))
            blended =
                NtcBlendLatents(NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel0, feature),
                                NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel1, feature),
                                NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel2, feature),
                                NtcLoadLatentCodes(latents, grid, mip.lowResEncoding, taps.pixel3, feature),
                                taps, mip.lowResEncoding);
        inputs[4u * highResWords + j] = blended;
    }

    NTC_UNROLL for (uint w = 0u; w < 3u; w++) inputs[4u * highResWords + 4u + w] =
        column.waves[w] | (row.waves[w] << 8);
    uint lod = uint(NtcQuantizeInput(mip.colorMip.positionLod)) & 255u;
    inputs[4u * highResWords + 7u] = lod | (lod << 8);
}

#endif

/// axis: 0 of a column, 1 of a row; the mip level exists and its latents are present (NtcHasInputs).
NTC_FUNCTION NtcAxisInputs NtcMakeAxisInputs(int networkVersion, NtcMip mip, int texel, uint axis) {
#if !NTC_WITH_LATENT_MIPS
    return NtcMakeGridAxisInputs(mip, texel, axis);
#elif !NTC_WITH_LATENT_GRIDS
    return NtcMakeMipAxisInputs(mip, texel, axis);
#else
    return NtcReadsLatentMips(networkVersion) ? NtcMakeMipAxisInputs(mip, texel, axis)
                                              : NtcMakeGridAxisInputs(mip, texel, axis);
#endif
}

/// The network's input vector of the texel of a column and a row, four signed bytes to a word; the words
/// behind the last are left alone.
NTC_FUNCTION void NtcCombineAxisInputs(int networkVersion, NtcMip mip, NtcBuffer latents, uint latentsOffset,
                                       NtcAxisInputs column, NtcAxisInputs row,
                                       NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
#if NTC_WITH_LATENT_MIPS
    if (NtcReadsLatentMips(networkVersion))
        NtcCombineMipAxisInputs(networkVersion, mip, latents, latentsOffset, column, row, inputs);
#endif
#if NTC_WITH_LATENT_GRIDS
    if (!NtcReadsLatentMips(networkVersion))
        NtcCombineGridAxisInputs(networkVersion, mip, latents, latentsOffset, column, row, inputs);
#endif
}

/// True if the mip level exists and its latents are present.
NTC_FUNCTION bool NtcHasInputs(NtcMip mip) {
    return mip.exists && NtcIsLatentImage(mip.colorMip.neuralMip) && NtcIsGridPresent(mip.highRes) &&
           NtcIsGridPresent(mip.lowRes);
}

/// NtcCombineAxisInputs of a texel. False, with the inputs untouched, if the mip level does not exist or its
/// latents are not present.
NTC_FUNCTION bool NtcPrepareNetworkInputsFrom(int networkVersion, NtcMip mip, NtcBuffer latents,
                                              uint latentsOffset, int2 texel,
                                              NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    if (!NtcHasInputs(mip))
        return false;
    NtcAxisInputs column = NtcMakeAxisInputs(networkVersion, mip, texel.x, 0u);
    NtcAxisInputs row = NtcMakeAxisInputs(networkVersion, mip, texel.y, 1u);
    NtcCombineAxisInputs(networkVersion, mip, latents, latentsOffset, column, row, inputs);
    return true;
}

NTC_NAMESPACE_END

#endif
