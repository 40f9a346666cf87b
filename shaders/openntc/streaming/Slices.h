// SPDX-License-Identifier: MIT
// Decoding from slices: the constants of a texture set once, and a row of 32 bytes (NtcSliceConstants) for
// each slice and latent image, which says where the slice's latents are. The engine chooses the row: by its
// page table, by its tile's number.
//
//   NtcSliceConstants row = NtcLoadSliceConstants(NTC_LATENTS, 32u * tile); // or from your own buffer
//   NtcSampleSlice(desc, row, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, mipLevel, false, outputs);
//
// Texels are those of the whole image. The row must be of the latent image that serves mipLevel, and its
// slice must hold the texel: nothing here can tell, and another texel decodes to something. An absent row
// (all zero) and a mip that does not exist give false, with the outputs untouched.
#ifndef OPENNTC_STREAMING_SLICES_H
#define OPENNTC_STREAMING_SLICES_H

#include "openntc/Inference.h"

#if !NTC_LATENT_SLICES
#error Slices.h needs NTC_LATENT_SLICES=1, which is the default (Effects.h)
#endif

NTC_NAMESPACE_BEGIN

/// A row of its eight words.
NTC_FUNCTION NtcSliceConstants NtcMakeSliceConstants(uint word0, uint word1, uint word2, uint word3,
                                                     uint word4, uint word5, uint word6, uint word7) {
    NtcSliceConstants row;
    row.highRes.dataOffset = word0;
    row.highRes.imageWidthHeight = word1;
    row.highRes.sliceLeftTop = word2;
    row.highRes.sliceWidthHeight = word3;
    row.lowRes.dataOffset = word4;
    row.lowRes.imageWidthHeight = word5;
    row.lowRes.sliceLeftTop = word6;
    row.lowRes.sliceWidthHeight = word7;
    return row;
}

/// The row at a byte offset, a multiple of 4, of a buffer.
NTC_FUNCTION NtcSliceConstants NtcLoadSliceConstants(NtcBuffer rows, uint byteOffset) {
    return NtcMakeSliceConstants(NtcBufferLoad(rows, byteOffset), NtcBufferLoad(rows, byteOffset + 4u),
                                 NtcBufferLoad(rows, byteOffset + 8u), NtcBufferLoad(rows, byteOffset + 12u),
                                 NtcBufferLoad(rows, byteOffset + 16u), NtcBufferLoad(rows, byteOffset + 20u),
                                 NtcBufferLoad(rows, byteOffset + 24u),
                                 NtcBufferLoad(rows, byteOffset + 28u));
}

NTC_NAMESPACE_END

#if defined(__cplusplus)
namespace openntc::shader {

/// The constants of a mip level with the latents of a slice.
inline NtcMip NtcGetSliceMip(const NtcTextureSetConstants& desc, const NtcSliceConstants& row, int mipLevel) {
    const NtcColorMipConstants& colorMip = desc.colorMips[min(max(mipLevel, 0), NTC_MAX_MIPS - 1)];
    return NtcMakeMip(NtcMipExists(mipLevel, desc.imageMips), desc.highResEncoding, desc.lowResEncoding,
                      row.highRes, row.lowRes, colorMip, NtcGetMipSize(desc.imageWidth, mipLevel),
                      NtcGetMipSize(desc.imageHeight, mipLevel));
}

/// NtcSampleTextureSet with the latents of a slice.
inline bool NtcSampleSlice(int networkVersion, int math, const NtcTextureSetConstants& desc,
                           const NtcSliceConstants& row, NtcBuffer latents, uint latentsOffset,
                           NtcBuffer weights, uint weightsOffset, int2 texel, int mipLevel,
                           bool convertToLinear, NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    return NtcSampleMip(networkVersion, math, NtcGetSliceMip(desc, row, mipLevel), latents, latentsOffset,
                        weights, weightsOffset, NtcGetLayerOffsets(desc), desc.channelColorSpaces, texel,
                        convertToLinear, outputs);
}

} // namespace openntc::shader
#else
// Macros that pick members of `desc`, as in Inference.h; `row` is an NtcSliceConstants variable.
#define NtcGetSliceMip(desc, row, mipLevel)                                                                  \
    NtcMakeMip(NtcMipExists(mipLevel, (desc).imageMips), (desc).highResEncoding, (desc).lowResEncoding,      \
               (row).highRes, (row).lowRes, NTC_COLOR_MIP(desc, mipLevel),                                   \
               NtcGetMipSize((desc).imageWidth, mipLevel), NtcGetMipSize((desc).imageHeight, mipLevel))
#define NtcSampleSlice(desc, row, latents, latentsOffset, weights, weightsOffset, texel, mipLevel,           \
                       convertToLinear, outputs)                                                             \
    NtcSampleMip(NETWORK_VERSION, NTC_MATH, NtcGetSliceMip(desc, row, mipLevel), latents, latentsOffset,     \
                 weights, weightsOffset, NtcGetLayerOffsets(desc), (desc).channelColorSpaces, texel,         \
                 convertToLinear, outputs)
#endif

#endif
