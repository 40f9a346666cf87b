// SPDX-License-Identifier: MIT
// Decoding one texel; included by Inference.h, which says what a shader defines before.
#ifndef OPENNTC_INFERENCE_TEXEL_H
#define OPENNTC_INFERENCE_TEXEL_H

#include "Buffers.h"
#include "ColorSpaces.h"
#include "Effects.h"
#include "InferenceConstants.h"
#include "InputsInt8.h"
#include "InputsReal.h"
#include "Latents.h"
#include "Network.h"
#include "NetworkFP8.h"
#include "NetworkFloat.h"
#include "NetworkTexels.h"
#include "Portability.h"
#include "Switches.h"
#if NTC_WITH_COOPVEC
#include "InferenceCoopVec.h"
#endif

#if defined(NETWORK_VERSION)
#if NETWORK_VERSION < NTC_NETWORK_SMALL || NETWORK_VERSION > NTC_NETWORK_GENERATION_3
#error NETWORK_VERSION must be NTC_NETWORK_SMALL, _MEDIUM, _LARGE, _XLARGE, _GENERATION_2 or _GENERATION_3
#endif
#elif !defined(__cplusplus)
#error NETWORK_VERSION is not defined: it must be NTC_NETWORK_SMALL, _MEDIUM, _LARGE, _XLARGE, _GENERATION_2 or _GENERATION_3
#endif

NTC_NAMESPACE_BEGIN

/// Bits firstChannel ... firstChannel + channels - 1; bits outside 0 ... 31 do not exist.
NTC_FUNCTION uint NtcGetChannelMask(int firstChannel, int channels) {
    int first = min(max(firstChannel, 0), 32);
    // The end, without overflow for any arguments.
    int count =
        firstChannel < 0 ? max(channels, 0) - min(-(firstChannel + 1), max(channels, 0)) - 1 : channels;
    count = min(max(count, 0), 32 - first);
    if (count == 0)
        return 0u;
    return (0xFFFFFFFFu >> uint(32 - count)) << uint(first);
}

/// Size of one axis at a mip level.
NTC_FUNCTION int NtcGetMipSize(int size, int mipLevel) {
    return max(size >> uint(min(max(mipLevel, 0), 31)), 1);
}

NTC_FUNCTION bool NtcMipExists(int mipLevel, int imageMips) {
#if NTC_SINGLE_MIP
    return mipLevel == 0 && imageMips > 0;
#else
    return mipLevel >= 0 && mipLevel < imageMips && mipLevel < NTC_MAX_MIPS;
#endif
}

/// On request, the outputs that are read to linear light; the request must have passed NtcCanLinearise.
NTC_FUNCTION void NtcLineariseOutputs(bool convertToLinear, uint channelColorSpaces,
                                      NTC_INOUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
#if NTC_LINEARISE == NTC_LINEARISE_RUNTIME
    if (convertToLinear) {
        NTC_LOOP for (int c = int(NTC_FIRST_OUTPUT); c < int(NTC_END_OUTPUT); c++) {
            if (NtcIsOutputRead(uint(c)))
                outputs[c] = NtcConvertChannelToLinearColorSpace(outputs[c], c, channelColorSpaces);
        }
    }
#elif NTC_LINEARISE == NTC_LINEARISE_CHANNELS
    if (convertToLinear) {
        // Unrolled, so that every test folds and no output is indexed at run time.
        if (NTC_SRGB_BITS != 0u) {
            NTC_UNROLL for (uint c = NTC_FIRST_OUTPUT; c < NTC_END_OUTPUT; c++) {
                if (((NTC_SRGB_BITS >> (2u * c)) & 1u) != 0u && NtcIsOutputRead(c))
                    outputs[c] = NtcDecodeSrgb(outputs[c]);
            }
        }
        if (NTC_HLG_BITS != 0u) {
            NTC_UNROLL for (uint h = NTC_FIRST_OUTPUT; h < NTC_END_OUTPUT; h++) {
                if (((NTC_HLG_BITS >> (2u * h)) & 1u) != 0u && NtcIsOutputRead(h))
                    outputs[h] = NtcDecodeHlg(outputs[h]);
            }
        }
    }
#endif
}

#if !NTC_WITH_COOPMAT
/// Decodes one texel of a mip level whose constants have been picked out: inputs, network in the maths mode
/// `math`, and on request every channel to linear by its 2-bit storage colour space. False, with the outputs
/// untouched, if the mip level does not exist, its latents are not present or the shader was compiled without
/// what they need (Effects.h).
NTC_FUNCTION bool NtcSampleMip(int networkVersion, int math, NtcMip mip, NtcBuffer latents,
                               uint latentsOffset, NtcBuffer weights, uint weightsOffset,
                               NtcLayerOffsets layers, uint channelColorSpaces, int2 texel,
                               bool convertToLinear, NTC_INOUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    if (!NtcCanLinearise(convertToLinear, channelColorSpaces))
        return false;
#if NTC_WITH_INT8_INPUTS
    if (math == NTC_MATH_INT8 || math == NTC_MATH_INT8_HALF || math == NTC_MATH_COOPVEC_INT8) {
        uint inputs[NTC_MAX_INPUT_WORDS];
        if (!NtcPrepareNetworkInputsFrom(networkVersion, mip, latents, latentsOffset, texel, inputs))
            return false;
#if NTC_MATH == NTC_MATH_COOPVEC_INT8
        NtcEvaluateInt8CoopVec(weightsOffset, layers, inputs, outputs);
#elif NTC_WITH_NETWORK_TEXELS && NTC_TEXELS_PER_INVOCATION == 1
        NtcEvaluateNetworkOfTexels(networkVersion, math, weights, weightsOffset, layers, inputs, outputs);
#else
        NtcEvaluateNetwork(networkVersion, math, weights, weightsOffset, layers, inputs, outputs);
#endif
    }
#endif
#if NTC_WITH_REAL_INPUTS
    if (math == NTC_MATH_FP8 || math == NTC_MATH_FP16 || math == NTC_MATH_FP32 ||
        math == NTC_MATH_COOPVEC_FP8) {
        float realInputs[NTC_MAX_INPUTS];
        int inputMath = math == NTC_MATH_COOPVEC_FP8 ? NTC_MATH_FP8 : math;
        if (!NtcPrepareRealInputsFrom(networkVersion, inputMath, mip, latents, latentsOffset, texel,
                                      realInputs))
            return false;
#if NTC_MATH == NTC_MATH_COOPVEC_FP8
        NtcEvaluateE4M3CoopVec(weightsOffset, layers, realInputs, outputs);
#endif
#if NTC_WITH_FP8
        if (math == NTC_MATH_FP8)
            NtcEvaluateE4M3Network(networkVersion, weights, weightsOffset, layers, realInputs, outputs);
#endif
#if NTC_WITH_FP16
        if (math == NTC_MATH_FP16)
            NtcEvaluateHalfNetwork(networkVersion, weights, weightsOffset, layers, realInputs, outputs);
#endif
#if NTC_WITH_FP32
        if (math == NTC_MATH_FP32)
            NtcEvaluateRealNetwork(networkVersion, weights, weightsOffset, layers, realInputs, outputs);
#endif
    }
#endif
    NtcLineariseOutputs(convertToLinear, channelColorSpaces, outputs);
    return true;
}
#endif

NTC_NAMESPACE_END

#if defined(__cplusplus)
namespace openntc::shader {

/// Number of mip levels.
inline int NtcGetTextureMipLevels(const NtcTextureSetConstants& desc) {
    return desc.imageMips;
}

/// Width and height of a mip level in texels, at least 1.
inline int2 NtcGetTextureDimensions(const NtcTextureSetConstants& desc, int mipLevel) {
    return int2(NtcGetMipSize(desc.imageWidth, mipLevel), NtcGetMipSize(desc.imageHeight, mipLevel));
}

/// Bit c: output c is covered by a texture.
inline uint NtcGetValidChannelMask(const NtcTextureSetConstants& desc) {
    return desc.validChannelMask;
}

/// True if every channel of the mask is covered by a texture.
inline bool NtcTextureSetHasChannels(const NtcTextureSetConstants& desc, uint channelMask) {
    return (desc.validChannelMask & channelMask) == channelMask;
}

/// The constants of a mip level; the level may be any number.
inline NtcMip NtcGetMip(const NtcTextureSetConstants& desc, int mipLevel) {
    const NtcColorMipConstants& colorMip = desc.colorMips[min(max(mipLevel, 0), NTC_MAX_MIPS - 1)];
    const int neuralMip = min(max(colorMip.neuralMip, 0), NTC_MAX_NEURAL_MIPS - 1);
    return NtcMakeMip(NtcMipExists(mipLevel, desc.imageMips), desc.highResEncoding, desc.lowResEncoding,
                      desc.highResNeuralMips[neuralMip], desc.lowResNeuralMips[neuralMip], colorMip,
                      NtcGetMipSize(desc.imageWidth, mipLevel), NtcGetMipSize(desc.imageHeight, mipLevel));
}

inline NtcLayerOffsets NtcGetLayerOffsets(const NtcTextureSetConstants& desc) {
    return NtcMakeLayerOffsets(desc.networkWeightOffset0, desc.networkWeightOffset1,
                               desc.networkWeightOffset2, desc.networkWeightOffset3,
                               desc.networkScaleBiasOffset);
}

/// The network's input vector of one texel (see NtcPrepareNetworkInputsFrom). False, with the inputs
/// untouched, if the mip level does not exist or its latents are not present.
inline bool NtcPrepareNetworkInputs(int networkVersion, const NtcTextureSetConstants& desc, NtcBuffer latents,
                                    uint latentsOffset, int2 texel, int mipLevel,
                                    NTC_OUT_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS)) {
    return NtcPrepareNetworkInputsFrom(networkVersion, NtcGetMip(desc, mipLevel), latents, latentsOffset,
                                       texel, inputs);
}

/// Decodes one texel (see the macro of the same name below).
inline bool NtcSampleTextureSet(int networkVersion, int math, const NtcTextureSetConstants& desc,
                                NtcBuffer latents, uint latentsOffset, NtcBuffer weights, uint weightsOffset,
                                int2 texel, int mipLevel, bool convertToLinear,
                                NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    return NtcSampleMip(networkVersion, math, NtcGetMip(desc, mipLevel), latents, latentsOffset, weights,
                        weightsOffset, NtcGetLayerOffsets(desc), desc.channelColorSpaces, texel,
                        convertToLinear, outputs);
}

#if defined(NETWORK_VERSION)
/// With NETWORK_VERSION defined: the call as it is in shaders.
static inline bool NtcSampleTextureSet(const NtcTextureSetConstants& desc, NtcBuffer latents,
                                       uint latentsOffset, NtcBuffer weights, uint weightsOffset, int2 texel,
                                       int mipLevel, bool convertToLinear,
                                       NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    return NtcSampleTextureSet(NETWORK_VERSION, NTC_MATH, desc, latents, latentsOffset, weights,
                               weightsOffset, texel, mipLevel, convertToLinear, outputs);
}
#endif

} // namespace openntc::shader

#else
// In shaders these are macros that pick members of `desc` where they are called: passed by value, the 624
// bytes would be copied to private memory for every texel. Arguments may be evaluated more than once.

#define NtcGetTextureMipLevels(desc) ((desc).imageMips)
#define NtcGetTextureDimensions(desc, mipLevel)                                                              \
    int2(NtcGetMipSize((desc).imageWidth, mipLevel), NtcGetMipSize((desc).imageHeight, mipLevel))
#define NtcGetValidChannelMask(desc) ((desc).validChannelMask)
#define NtcTextureSetHasChannels(desc, channelMask)                                                          \
    (((desc).validChannelMask & (channelMask)) == (channelMask))

#if NTC_SINGLE_MIP
// Literal indices: constants at fixed addresses.
#define NTC_COLOR_MIP(desc, mipLevel) (desc).colorMips[0]
#define NTC_NEURAL_MIP(desc, mipLevel) 0
#else
#define NTC_COLOR_MIP(desc, mipLevel) (desc).colorMips[min(max(mipLevel, 0), NTC_MAX_MIPS - 1)]
#define NTC_NEURAL_MIP(desc, mipLevel)                                                                       \
    min(max(NTC_COLOR_MIP(desc, mipLevel).neuralMip, 0), NTC_MAX_NEURAL_MIPS - 1)
#endif

/// NtcMip and NtcLayerOffsets of a texture set: what follows is functions again.
#define NtcGetMip(desc, mipLevel)                                                                            \
    NtcMakeMip(NtcMipExists(mipLevel, (desc).imageMips), (desc).highResEncoding, (desc).lowResEncoding,      \
               (desc).highResNeuralMips[NTC_NEURAL_MIP(desc, mipLevel)],                                     \
               (desc).lowResNeuralMips[NTC_NEURAL_MIP(desc, mipLevel)], NTC_COLOR_MIP(desc, mipLevel),       \
               NtcGetMipSize((desc).imageWidth, mipLevel), NtcGetMipSize((desc).imageHeight, mipLevel))
#define NtcGetLayerOffsets(desc)                                                                             \
    NtcMakeLayerOffsets((desc).networkWeightOffset0, (desc).networkWeightOffset1,                            \
                        (desc).networkWeightOffset2, (desc).networkWeightOffset3,                            \
                        (desc).networkScaleBiasOffset)

#define NtcPrepareNetworkInputs(desc, latents, latentsOffset, texel, mipLevel, inputs)                       \
    NtcPrepareNetworkInputsFrom(NETWORK_VERSION, NtcGetMip(desc, mipLevel), latents, latentsOffset, texel,   \
                                inputs)
#if !NTC_WITH_COOPMAT
#define NtcSampleTextureSet(desc, latents, latentsOffset, weights, weightsOffset, texel, mipLevel,           \
                            convertToLinear, outputs)                                                        \
    NtcSampleMip(NETWORK_VERSION, NTC_MATH, NtcGetMip(desc, mipLevel), latents, latentsOffset, weights,      \
                 weightsOffset, NtcGetLayerOffsets(desc), (desc).channelColorSpaces, texel, convertToLinear, \
                 outputs)
#endif
#endif

#endif
