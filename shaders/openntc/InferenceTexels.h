// SPDX-License-Identifier: MIT
// Decoding NTC_TEXELS_PER_INVOCATION texels of one mip level at once (shaders, maths modes INT8 and
// INT8_HALF); included by Inference.h.
#ifndef OPENNTC_INFERENCE_TEXELS_H
#define OPENNTC_INFERENCE_TEXELS_H

#include "InferenceTexel.h"

#if NTC_WITH_NETWORK_TEXELS
#if NTC_MATH != NTC_MATH_INT8 && NTC_MATH != NTC_MATH_INT8_HALF && NTC_TEXELS_PER_INVOCATION > 1
#error NTC_TEXELS_PER_INVOCATION: above 1 NTC_MATH must be NTC_MATH_INT8 or NTC_MATH_INT8_HALF
#endif

#if NTC_WITH_INT8_INPUTS
#ifndef NTC_TEXEL_LOOP
#define NTC_TEXEL_LOOP NTC_UNROLL
#endif

/// NtcSampleMip for several texels; outputs[NTC_MAX_CHANNELS t + channel]. Lanes whose mip level is missing
/// take part in the network with inputs of 0, so that subgroups stay whole.
NTC_FUNCTION bool NtcSampleMipTexels(int networkVersion, int math, NtcMip mip, NtcBuffer latents,
                                     uint latentsOffset, NtcBuffer weights, uint weightsOffset,
                                     NtcLayerOffsets layers, uint channelColorSpaces,
                                     NTC_IN_ARRAY(int2, texels, NTC_TEXELS_PER_INVOCATION),
                                     bool convertToLinear,
                                     NTC_INOUT_ARRAY(float, outputs, NTC_TEXELS_OUTPUTS)) {
    bool present = NtcCanLinearise(convertToLinear, channelColorSpaces);
    uint inputs[NTC_TEXELS_INPUT_WORDS];
    NTC_TEXEL_LOOP for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) {
        uint inputsOfOne[NTC_MAX_INPUT_WORDS];
        NTC_UNROLL for (uint k = 0u; k < uint(NTC_MAX_INPUT_WORDS); k++) inputsOfOne[k] = 0u;
        bool ok =
            NtcPrepareNetworkInputsFrom(networkVersion, mip, latents, latentsOffset, texels[t], inputsOfOne);
        present = present && ok;
        NTC_UNROLL for (uint i = 0u; i < uint(NTC_MAX_INPUT_WORDS); i++)
            inputs[uint(NTC_MAX_INPUT_WORDS) * t + i] = inputsOfOne[i];
    }
    float results[NTC_TEXELS_OUTPUTS];
    NtcEvaluateNetworkOfTexels(networkVersion, math, weights, weightsOffset, layers, inputs, results);
    if (!present)
        return false;
    NTC_TEXEL_LOOP for (uint texel = 0u; texel < uint(NTC_TEXELS_PER_INVOCATION); texel++) {
        float outputsOfOne[NTC_MAX_CHANNELS];
        NTC_UNROLL for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) outputsOfOne[c] =
            results[uint(NTC_MAX_CHANNELS) * texel + c];
        NtcLineariseOutputs(convertToLinear, channelColorSpaces, outputsOfOne);
        NTC_UNROLL for (uint n = 0u; n < uint(NTC_MAX_CHANNELS); n++)
            outputs[uint(NTC_MAX_CHANNELS) * texel + n] = outputsOfOne[n];
    }
    return true;
}

/// bool NtcSampleTextureSetTexels(NtcTextureSetConstants desc, NtcBuffer latents, uint latentsOffset,
/// NtcBuffer weights,
///                                uint weightsOffset, int2 texels[NTC_TEXELS_PER_INVOCATION], int mipLevel,
///                                bool convertToLinear, inout float outputs[NTC_TEXELS_OUTPUTS])
/// NtcSampleTextureSet for several texels of one mip level; what one texel reads there, each reads here.
#define NtcSampleTextureSetTexels(desc, latents, latentsOffset, weights, weightsOffset, texels, mipLevel,    \
                                  convertToLinear, outputs)                                                  \
    NtcSampleMipTexels(NETWORK_VERSION, NTC_MATH, NtcGetMip(desc, mipLevel), latents, latentsOffset,         \
                       weights, weightsOffset, NtcGetLayerOffsets(desc), (desc).channelColorSpaces, texels,  \
                       convertToLinear, outputs)
#endif
#endif

#endif
