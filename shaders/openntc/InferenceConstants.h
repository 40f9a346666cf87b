// SPDX-License-Identifier: MIT
// The one file that C++, GLSL and HLSL share: limits, enumerations and the layout of the texture-set
// constants.
//
// Every struct is made of 4-byte scalars in groups of 16 bytes and is a multiple of 16 bytes long, so that
// std140, HLSL cbuffer rules, scalar layout and C++ agree. Fields keep the byte offsets of LibNTC's
// NtcTextureSetConstants.
#ifndef OPENNTC_INFERENCE_CONSTANTS_H
#define OPENNTC_INFERENCE_CONSTANTS_H

// Network versions: the decoder network of a texture set (values of the NETWORK_VERSION macro). Files of
// generation 1 have one of four sizes, those of generations 2 and 3 the one of their generation.
#define NTC_NETWORK_UNKNOWN 0
#define NTC_NETWORK_SMALL 1
#define NTC_NETWORK_MEDIUM 2
#define NTC_NETWORK_LARGE 3
#define NTC_NETWORK_XLARGE 4
#define NTC_NETWORK_GENERATION_2 5
#define NTC_NETWORK_GENERATION_3 6

// Colour spaces, 2 bits per channel in channelColorSpaces.
#define NTC_COLOR_SPACE_LINEAR 0
#define NTC_COLOR_SPACE_SRGB 1
#define NTC_COLOR_SPACE_HLG 2

#define NTC_MAX_CHANNELS 16
#define NTC_MAX_MIPS 16
#define NTC_MAX_NEURAL_MIPS 8

#if defined(__cplusplus)
// With a space: bundlers of web engines paste every #include that they see, whatever #if it is under.
// clang-format off
# include <cstddef>
# include <cstdint>
// clang-format on
namespace openntc {
#define NTC_FIELD_INT std::int32_t
#define NTC_FIELD_UINT std::uint32_t
#define NTC_FIELD_FLOAT float
#else
#define NTC_FIELD_INT int
#define NTC_FIELD_UINT uint
#define NTC_FIELD_FLOAT float
#endif

/// How the latents of one grid are packed, 32 bytes.
struct NtcLatentEncodingConstants {
    NTC_FIELD_INT numFeatures;        // 4, 8, 12 or 16 latents per latent pixel
    NTC_FIELD_INT quantBits;          // 1, 2, 4 or 8 bits per latent
    NTC_FIELD_INT logElementsPerUint; // log2 of the latents in a 32-bit word: 5 - log2(quantBits)
    NTC_FIELD_INT padding0;
    NTC_FIELD_UINT addressMask;   // latents per word - 1
    NTC_FIELD_UINT dataMask;      // 2^quantBits - 1
    NTC_FIELD_INT quantizedScale; // Int8 weights: code * scale + bias is the network input;
    NTC_FIELD_INT quantizedBias;  // FP8 weights: bit patterns of the binary32 step and bias
};

/// One grid of one latent image ("neural mip"), 16 bytes. 16-bit pairs hold the first number in the low half.
struct NtcNeuralMipConstants {
    NTC_FIELD_UINT dataOffset;       // bytes from the start of the latent range, multiple of 4
    NTC_FIELD_UINT imageWidthHeight; // size of the whole grid in latent pixels
    NTC_FIELD_UINT sliceLeftTop;     // part of the grid that is present
    NTC_FIELD_UINT sliceWidthHeight; // 0: this latent image is absent
};

/// The present part of one latent image, 32 bytes: all that differs between two slices of a texture set. An
/// engine that streams tiles keeps one row for each and the 624 bytes once. dataOffset is in bytes from where
/// the shader's latentsOffset points: MakeSliceConstants counts from the start of the slice's own bytes,
/// MoveSliceConstants (PartialInference.h) adds the place of those bytes in a larger buffer.
struct NtcSliceConstants {
    NtcNeuralMipConstants highRes;
    NtcNeuralMipConstants lowRes;
};

/// One colour mip, 16 bytes.
struct NtcColorMipConstants {
    NTC_FIELD_INT neuralMip;       // latent image that serves it
    NTC_FIELD_FLOAT positionLod;   // (mip - 2 * neuralMip) / 3
    NTC_FIELD_FLOAT positionScale; // 2^(mip - 2 * neuralMip)
    NTC_FIELD_UINT padding0;
};

/// Everything a shader needs to know about a texture set besides its weights and latents, 624 bytes. Our
/// decoders read it for every generation. Sets of generations 2 and 3, whose latents are one buffer of 16-bit
/// texels [latent mip][layer][y][x], four codes to a texel, every latent mip from a multiple of 4 bytes on,
/// are described as follows:
///   highResEncoding, lowResEncoding   both: numFeatures of the set, 4 bits (3, 7 and 15 in the other
///                                     fields), quantizedScale and quantizedBias 0
///   highResNeuralMips[n]              latent mip n
///   lowResNeuralMips[n]               latent mip n + 1 (0 if there is none): a colour mip reads both. Slices
///                                     wrap: sliceLeftTop lies inside the grid, and what goes beyond its
///                                     right or lower edge continues at 0; no slice is larger than its grid
///   colorMips[m].neuralMip            latent mip n; positionLod and positionScale as the file has them
///   network...Offset                  as in generation 1: matrices, then all scales and all biases
///                                     (GenericInt8) or biases, scales, biases (GenericFP8) of the layout in
///                                     NetworkDescription.h
struct NtcTextureSetConstants {
    NtcLatentEncodingConstants highResEncoding;
    NtcLatentEncodingConstants lowResEncoding;
    NtcNeuralMipConstants highResNeuralMips[NTC_MAX_NEURAL_MIPS];
    NtcNeuralMipConstants lowResNeuralMips[NTC_MAX_NEURAL_MIPS];
    NtcColorMipConstants colorMips[NTC_MAX_MIPS];
    NTC_FIELD_INT networkWeightOffset0; // bytes from the start of the weights to the matrix of layer 0
    NTC_FIELD_INT networkWeightOffset1;
    NTC_FIELD_INT networkWeightOffset2;
    NTC_FIELD_INT networkWeightOffset3;
    NTC_FIELD_INT imageWidth; // mip 0, texels
    NTC_FIELD_INT imageHeight;
    NTC_FIELD_INT imageMips;
    NTC_FIELD_INT networkScaleBiasOffset; // bytes to the scales (Int8) or biases (FP8)
    NTC_FIELD_UINT validChannelMask;      // bit c: output c is covered by a texture
    NTC_FIELD_UINT channelColorSpaces;    // 2 bits per channel: NTC_COLOR_SPACE_*
    NTC_FIELD_INT padding0;
    NTC_FIELD_INT padding1;
};

/// What a shader with NTC_SINGLE_MIP reads of NtcTextureSetConstants, under the same names: 160 bytes, few
/// enough for push constants on most GPUs. Shaders pass it to the functions in the place of the whole.
struct NtcSingleMipConstants {
    NtcLatentEncodingConstants highResEncoding;
    NtcLatentEncodingConstants lowResEncoding;
    NtcNeuralMipConstants highResNeuralMips[1];
    NtcNeuralMipConstants lowResNeuralMips[1];
    NtcColorMipConstants colorMips[1];
    NTC_FIELD_INT networkWeightOffset0;
    NTC_FIELD_INT networkWeightOffset1;
    NTC_FIELD_INT networkWeightOffset2;
    NTC_FIELD_INT networkWeightOffset3;
    NTC_FIELD_INT imageWidth;
    NTC_FIELD_INT imageHeight;
    NTC_FIELD_INT imageMips;
    NTC_FIELD_INT networkScaleBiasOffset;
    NTC_FIELD_UINT validChannelMask;
    NTC_FIELD_UINT channelColorSpaces;
    NTC_FIELD_INT padding0;
    NTC_FIELD_INT padding1;
};

/// The constants of LibNTC 0.8 and 0.9 (generations 2 and 3), 336 bytes: for shaders written for those, which
/// sample latents from textures. Our decoders read NtcTextureSetConstants.
struct NtcTextureSetConstants2 {
    NtcColorMipConstants colorMips[NTC_MAX_MIPS]; // neuralMip: the finer of its two latent mips
    NTC_FIELD_INT networkWeightOffset0;           // bytes from the start of the weights, per layer
    NTC_FIELD_INT networkWeightOffset1;
    NTC_FIELD_INT networkWeightOffset2;
    NTC_FIELD_INT networkWeightOffset3;
    NTC_FIELD_INT networkBiasOffset0;
    NTC_FIELD_INT networkBiasOffset1;
    NTC_FIELD_INT networkBiasOffset2;
    NTC_FIELD_INT networkBiasOffset3;
    NTC_FIELD_INT networkScaleOffset0; // FP8 weights: layer 3 only, others 0
    NTC_FIELD_INT networkScaleOffset1;
    NTC_FIELD_INT networkScaleOffset2;
    NTC_FIELD_INT networkScaleOffset3;
    NTC_FIELD_INT imageWidth; // mip 0, texels
    NTC_FIELD_INT imageHeight;
    NTC_FIELD_INT imageMips;
    NTC_FIELD_INT padding0;
    NTC_FIELD_UINT validChannelMask;   // bit c: output c is covered by a texture
    NTC_FIELD_UINT channelColorSpaces; // 2 bits per channel: NTC_COLOR_SPACE_*
    NTC_FIELD_INT padding1;
    NTC_FIELD_INT padding2;
};

#if defined(__cplusplus)
static_assert(sizeof(NtcLatentEncodingConstants) == 32);
static_assert(offsetof(NtcLatentEncodingConstants, numFeatures) == 0);
static_assert(offsetof(NtcLatentEncodingConstants, quantBits) == 4);
static_assert(offsetof(NtcLatentEncodingConstants, logElementsPerUint) == 8);
static_assert(offsetof(NtcLatentEncodingConstants, padding0) == 12);
static_assert(offsetof(NtcLatentEncodingConstants, addressMask) == 16);
static_assert(offsetof(NtcLatentEncodingConstants, dataMask) == 20);
static_assert(offsetof(NtcLatentEncodingConstants, quantizedScale) == 24);
static_assert(offsetof(NtcLatentEncodingConstants, quantizedBias) == 28);
static_assert(sizeof(NtcNeuralMipConstants) == 16);
static_assert(offsetof(NtcNeuralMipConstants, dataOffset) == 0);
static_assert(offsetof(NtcNeuralMipConstants, imageWidthHeight) == 4);
static_assert(offsetof(NtcNeuralMipConstants, sliceLeftTop) == 8);
static_assert(offsetof(NtcNeuralMipConstants, sliceWidthHeight) == 12);
static_assert(sizeof(NtcSliceConstants) == 32);
static_assert(offsetof(NtcSliceConstants, highRes) == 0);
static_assert(offsetof(NtcSliceConstants, lowRes) == 16);
static_assert(sizeof(NtcColorMipConstants) == 16);
static_assert(offsetof(NtcColorMipConstants, neuralMip) == 0);
static_assert(offsetof(NtcColorMipConstants, positionLod) == 4);
static_assert(offsetof(NtcColorMipConstants, positionScale) == 8);
static_assert(offsetof(NtcColorMipConstants, padding0) == 12);
static_assert(sizeof(NtcTextureSetConstants) == 624);
static_assert(offsetof(NtcTextureSetConstants, highResEncoding) == 0);
static_assert(offsetof(NtcTextureSetConstants, lowResEncoding) == 32);
static_assert(offsetof(NtcTextureSetConstants, highResNeuralMips) == 64);
static_assert(offsetof(NtcTextureSetConstants, lowResNeuralMips) == 192);
static_assert(offsetof(NtcTextureSetConstants, colorMips) == 320);
static_assert(offsetof(NtcTextureSetConstants, networkWeightOffset0) == 576);
static_assert(offsetof(NtcTextureSetConstants, networkWeightOffset1) == 580);
static_assert(offsetof(NtcTextureSetConstants, networkWeightOffset2) == 584);
static_assert(offsetof(NtcTextureSetConstants, networkWeightOffset3) == 588);
static_assert(offsetof(NtcTextureSetConstants, imageWidth) == 592);
static_assert(offsetof(NtcTextureSetConstants, imageHeight) == 596);
static_assert(offsetof(NtcTextureSetConstants, imageMips) == 600);
static_assert(offsetof(NtcTextureSetConstants, networkScaleBiasOffset) == 604);
static_assert(offsetof(NtcTextureSetConstants, validChannelMask) == 608);
static_assert(offsetof(NtcTextureSetConstants, channelColorSpaces) == 612);
static_assert(offsetof(NtcTextureSetConstants, padding0) == 616);
static_assert(offsetof(NtcTextureSetConstants, padding1) == 620);
static_assert(sizeof(NtcSingleMipConstants) == 160);
static_assert(offsetof(NtcSingleMipConstants, highResNeuralMips) == 64);
static_assert(offsetof(NtcSingleMipConstants, lowResNeuralMips) == 80);
static_assert(offsetof(NtcSingleMipConstants, colorMips) == 96);
static_assert(offsetof(NtcSingleMipConstants, networkWeightOffset0) == 112);
static_assert(offsetof(NtcSingleMipConstants, imageWidth) == 128);
static_assert(offsetof(NtcSingleMipConstants, validChannelMask) == 144);
static_assert(sizeof(NtcTextureSetConstants2) == 336);
static_assert(offsetof(NtcTextureSetConstants2, colorMips) == 0);
static_assert(offsetof(NtcTextureSetConstants2, networkWeightOffset0) == 256);
static_assert(offsetof(NtcTextureSetConstants2, networkBiasOffset0) == 272);
static_assert(offsetof(NtcTextureSetConstants2, networkScaleOffset0) == 288);
static_assert(offsetof(NtcTextureSetConstants2, imageWidth) == 304);
static_assert(offsetof(NtcTextureSetConstants2, imageHeight) == 308);
static_assert(offsetof(NtcTextureSetConstants2, imageMips) == 312);
static_assert(offsetof(NtcTextureSetConstants2, validChannelMask) == 320);
static_assert(offsetof(NtcTextureSetConstants2, channelColorSpaces) == 324);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT
#undef NTC_FIELD_FLOAT

#endif
