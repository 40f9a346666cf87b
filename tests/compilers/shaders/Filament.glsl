// SPDX-License-Identifier: MIT
// For Filament's matc: words from textures of 1024 columns, and constants from a uniform array, because its materials have neither
// buffers nor parameters that are structs.
#define NtcBuffer uint
#define NtcBufferLoad(buffer, byteOffset) LoadWord(buffer, byteOffset)
#define NTC_OPAQUE_ZERO materialParams.zero
uint LoadWord(uint buffer_, uint byteOffset) {
    ivec2 at = ivec2(int(byteOffset >> 2u) & 1023, int(byteOffset >> 12u));
    return buffer_ == 0u ? texelFetch(materialParams_latents, at, 0).x : texelFetch(materialParams_weights, at, 0).x;
}
#include "openntc/Inference.h"

NtcLatentEncodingConstants UnpackEncoding(int at) {
    NtcLatentEncodingConstants encoding;
    ivec4 a = materialParams.constants[at];
    ivec4 b = materialParams.constants[at + 1];
    encoding.numFeatures = a.x;
    encoding.quantBits = a.y;
    encoding.logElementsPerUint = a.z;
    encoding.padding0 = a.w;
    encoding.addressMask = uint(b.x);
    encoding.dataMask = uint(b.y);
    encoding.quantizedScale = b.z;
    encoding.quantizedBias = b.w;
    return encoding;
}

NtcNeuralMipConstants UnpackNeuralMip(int at) {
    NtcNeuralMipConstants mip;
    uvec4 words = uvec4(materialParams.constants[at]);
    mip.dataOffset = words.x;
    mip.imageWidthHeight = words.y;
    mip.sliceLeftTop = words.z;
    mip.sliceWidthHeight = words.w;
    return mip;
}

NtcTextureSetConstants UnpackConstants() {
    NtcTextureSetConstants desc;
    desc.highResEncoding = UnpackEncoding(0);
    desc.lowResEncoding = UnpackEncoding(2);
    for (int i = 0; i < NTC_MAX_NEURAL_MIPS; i++) {
        desc.highResNeuralMips[i] = UnpackNeuralMip(4 + i);
        desc.lowResNeuralMips[i] = UnpackNeuralMip(12 + i);
    }
    for (int i = 0; i < NTC_MAX_MIPS; i++) {
        ivec4 words = materialParams.constants[20 + i];
        desc.colorMips[i].neuralMip = words.x;
        desc.colorMips[i].positionLod = intBitsToFloat(words.y);
        desc.colorMips[i].positionScale = intBitsToFloat(words.z);
        desc.colorMips[i].padding0 = uint(words.w);
    }
    ivec4 offsets = materialParams.constants[36];
    desc.networkWeightOffset0 = offsets.x;
    desc.networkWeightOffset1 = offsets.y;
    desc.networkWeightOffset2 = offsets.z;
    desc.networkWeightOffset3 = offsets.w;
    ivec4 sizes = materialParams.constants[37];
    ivec4 rest = materialParams.constants[38];
    desc.imageWidth = sizes.x;
    desc.imageHeight = sizes.y;
    desc.imageMips = sizes.z;
    desc.networkScaleBiasOffset = sizes.w;
    desc.validChannelMask = uint(rest.x);
    desc.channelColorSpaces = uint(rest.y);
    desc.padding0 = rest.z;
    desc.padding1 = rest.w;
    return desc;
}

bool SampleMaterial(ivec2 texel, int mip, out float channels[NTC_MAX_CHANNELS]) {
    NtcTextureSetConstants desc = UnpackConstants();
    return NtcSampleTextureSet(desc, 0u, 0u, 1u, 0u, texel, mip, false, channels);
}
