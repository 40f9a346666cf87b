// SPDX-License-Identifier: MIT
// Network inputs of the maths modes INT8 and INT8_HALF: bytes (format specification, network 2 and 3.1).
#ifndef OPENNTC_INPUTS_INT8_H
#define OPENNTC_INPUTS_INT8_H

#include "InferenceConstants.h"
#include "InputsPosition.h"
#include "Latents.h"
#include "Network.h"
#include "Portability.h"

NTC_NAMESPACE_BEGIN

/// The network's input vector of one texel, four signed bytes to a word; the words behind the last are left
/// alone. False, with the inputs untouched, if the mip level does not exist or its latents are not present.
NTC_FUNCTION bool NtcPrepareNetworkInputsFrom(int networkVersion, NtcMip mip, NtcBuffer latents,
                                              uint latentsOffset, int2 texel,
                                              NTC_INOUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    if (!mip.exists || !NtcIsLatentImage(mip.colorMip.neuralMip) || !NtcIsGridPresent(mip.highRes) ||
        !NtcIsGridPresent(mip.lowRes))
        return false;
    NTC_PRECISE float u = NtcTexelCenter(texel.x, mip.width);
    NTC_PRECISE float v = NtcTexelCenter(texel.y, mip.height);
    uint highResWords = NtcGetHighResWords(networkVersion);

    NtcGridTaps taps = NtcGetGridTaps(mip.highRes, u, v);
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

    taps = NtcGetGridTaps(mip.lowRes, u, v);
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

    NTC_PRECISE float positionX = float(texel.x) * mip.colorMip.positionScale;
    NTC_PRECISE float positionY = float(texel.y) * mip.colorMip.positionScale;
    inputs[4u * highResWords + 4u] = NtcEncodePosition(positionX, positionY, 0.125f);
    inputs[4u * highResWords + 5u] = NtcEncodePosition(positionX, positionY, 0.25f);
    inputs[4u * highResWords + 6u] = NtcEncodePosition(positionX, positionY, 0.5f);
    uint lod = uint(NtcQuantizeInput(mip.colorMip.positionLod)) & 255u;
    inputs[4u * highResWords + 7u] = lod | (lod << 8);
    return true;
}

NTC_NAMESPACE_END

#endif
