// SPDX-License-Identifier: MIT
// The decoder for Filament's matc (GLSL ES 3.00): latents and weights are words of R32UI textures, 1024 a row; one mip's constants are
// ten int4, since parameters cannot be structs.
#define NTC_SINGLE_MIP 1
#define NTC_NO_LOOP_ATTRIBUTES
#define NTC_NO_PRECISE
#define NTC_OPAQUE_ZERO materialParams.ntcZero
#define NtcBuffer highp usampler2D
#define NtcBufferLoad(buffer, byteOffset) texelFetch(buffer, ivec2(int((byteOffset) >> 2) & 1023, int((byteOffset) >> 12)), 0).x
#include "openntc/Inference.h"

/// NtcSingleMipConstants from its 160 bytes.
NtcSingleMipConstants MakeConstants(ivec4 words[10]) {
    NtcSingleMipConstants desc;
    desc.highResEncoding = NtcLatentEncodingConstants(words[0].x, words[0].y, words[0].z, words[0].w, uint(words[1].x), uint(words[1].y),
                                                      words[1].z, words[1].w);
    desc.lowResEncoding = NtcLatentEncodingConstants(words[2].x, words[2].y, words[2].z, words[2].w, uint(words[3].x), uint(words[3].y),
                                                     words[3].z, words[3].w);
    uvec4 high = uvec4(words[4]), low = uvec4(words[5]);
    desc.highResNeuralMips[0] = NtcNeuralMipConstants(high.x, high.y, high.z, high.w);
    desc.lowResNeuralMips[0] = NtcNeuralMipConstants(low.x, low.y, low.z, low.w);
    desc.colorMips[0] = NtcColorMipConstants(words[6].x, intBitsToFloat(words[6].y), intBitsToFloat(words[6].z), 0u);
    desc.networkWeightOffset0 = words[7].x;
    desc.networkWeightOffset1 = words[7].y;
    desc.networkWeightOffset2 = words[7].z;
    desc.networkWeightOffset3 = words[7].w;
    desc.imageWidth = words[8].x;
    desc.imageHeight = words[8].y;
    desc.imageMips = words[8].z;
    desc.networkScaleBiasOffset = words[8].w;
    desc.validChannelMask = uint(words[9].x);
    desc.channelColorSpaces = uint(words[9].y);
    return desc;
}

/// All channels of a texel of that mip.
bool SampleMaterial(ivec4 words[10], highp usampler2D latents, highp usampler2D weights, ivec2 texel, int mip,
                    out float channels[NTC_MAX_CHANNELS]) {
    return NtcSampleTextureSet(MakeConstants(words), latents, 0u, weights, 0u, texel, mip, false, channels);
}
