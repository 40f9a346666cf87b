// SPDX-License-Identifier: MIT
// Texels of texture sets whose latents are in tiles: NtcSampleTextureSetTiled. Included by PageTable.h where
// a network is decoded (NETWORK_VERSION is defined).
#ifndef OPENNTC_TEXTURE_SET_TILES_H
#define OPENNTC_TEXTURE_SET_TILES_H

#include "Slices.h"
#include "TileLookup.h"
#include "openntc/Inference.h"

#if NTC_SINGLE_MIP || !NTC_LATENT_SLICES
#error Tiles of texture sets are slices of several mips: NTC_SINGLE_MIP must be 0 and NTC_LATENT_SLICES 1
#endif

NTC_NAMESPACE_BEGIN

/// The slice that holds a texel of a mip, which NtcFindResidentMip has found to be there. Elsewhere some
/// slice, or an empty one.
NTC_FUNCTION NtcSliceConstants NtcLoadSlice(NtcStreamingContext context, NtcTextureHeader header, int2 texel,
                                            int mip) {
    uint row = 0u;
    if (mip >= header.firstTailMip) {
        row = NtcPageTableLoad(context, header.word + NTC_HEADER_FIRST_TAIL_ROW) +
              uint(min(mip, NTC_MAX_MIPS - 1) - header.firstTailMip);
    } else if (mip >= 0) {
        NtcLevel level = NtcLoadLevel(context, header, NtcGetLevelOfMip(context, header, mip));
        uint slot = NtcGetTileSlot(context, header, NtcGetTile(header, level, texel, mip));
        row = slot == NTC_TILE_MISSING ? 0u : header.firstSlot + slot;
    }
    uint word = context.launch.slicesWord + 8u * row;
    return NtcMakeSliceConstants(NtcPageTableLoad(context, word), NtcPageTableLoad(context, word + 1u),
                                 NtcPageTableLoad(context, word + 2u), NtcPageTableLoad(context, word + 3u),
                                 NtcPageTableLoad(context, word + 4u), NtcPageTableLoad(context, word + 5u),
                                 NtcPageTableLoad(context, word + 6u), NtcPageTableLoad(context, word + 7u));
}

/// A mip whose latents are those of a slice.
NTC_FUNCTION NtcMip NtcPatchMip(NtcMip mip, NtcSliceConstants slice) {
    NtcMip patched = mip;
    patched.highRes = slice.highRes;
    patched.lowRes = slice.lowRes;
    return patched;
}

/// `mip` (of sampledMip) with the latents of the tile that holds the texel of mip `mipLevel`.
NTC_FUNCTION NtcMip NtcGetTiledMip(NtcStreamingContext context, uint textureId, NtcMip mip, int2 texel,
                                   int mipLevel, int sampledMip) {
    NtcTextureHeader header = NtcLoadTextureHeader(context, textureId);
    return NtcPatchMip(
        mip, NtcLoadSlice(context, header, NtcMoveTexel(header, texel, mipLevel, sampledMip), sampledMip));
}

/// The texel of sampledMip at the centre of one of mipLevel.
NTC_FUNCTION int2 NtcGetTiledTexel(NtcStreamingContext context, uint textureId, int2 texel, int mipLevel,
                                   int sampledMip) {
    return NtcMoveTexel(NtcLoadTextureHeader(context, textureId), texel, mipLevel, sampledMip);
}

NTC_NAMESPACE_END

#if defined(__cplusplus)
namespace openntc::shader {

/// What the shader has as separate arguments.
struct NtcTextureSetSource {
    const NtcTextureSetConstants* desc;
    NtcBuffer latents;
    uint latentsOffset;
    NtcBuffer weights;
    uint weightsOffset;
};

/// Decodes a texel from the tile that holds it (see the macro of the same name below).
inline bool NtcSampleTextureSetTiled(int networkVersion, int math, const NtcStreamingContext& context,
                                     uint textureId, const NtcTextureSetSource& source, int2 texel,
                                     int mipLevel, bool convertToLinear,
                                     NTC_INOUT_ARRAY(float, outputs, NTC_MAX_CHANNELS), bool& resident,
                                     int& sampledMip) {
    if (!NtcFindResidentMip(context, textureId, texel, mipLevel, resident, sampledMip))
        return false;
    const NtcTextureSetConstants& desc = *source.desc;
    const NtcMip mip =
        NtcGetTiledMip(context, textureId, NtcGetMip(desc, sampledMip), texel, mipLevel, sampledMip);
    return NtcSampleMip(networkVersion, math, mip, source.latents, source.latentsOffset, source.weights,
                        source.weightsOffset, NtcGetLayerOffsets(desc), desc.channelColorSpaces,
                        NtcGetTiledTexel(context, textureId, texel, mipLevel, sampledMip), convertToLinear,
                        outputs);
}

} // namespace openntc::shader
#else
/// bool NtcSampleTextureSetTiled(NtcStreamingContext context, uint textureId, NtcTextureSetConstants desc,
///                               NtcBuffer latents, uint latentsOffset, NtcBuffer weights,
///                               uint weightsOffset, int2 texel, int mipLevel,
///                               bool convertToLinear, inout float outputs[16], out bool resident,
///                               out int sampledMip)
/// NtcSampleTextureSet for a texture set in tiles: decodes the texel of mipLevel if its tile is there, else
/// requests the tile and decodes the texel at the same place of the finest coarser mip that is. `desc` is the
/// whole set's; its rows of latent images are not read. False, with the outputs untouched: nothing is there,
/// not even the tail, or no such mip or texture exists. Arguments may be evaluated more than once; resident
/// and sampledMip are variables.
#define NtcSampleTextureSetTiled(context, textureId, desc, latents, latentsOffset, weights, weightsOffset,   \
                                 texel, mipLevel, convertToLinear, outputs, resident, sampledMip)            \
    (NtcFindResidentMip(context, textureId, texel, mipLevel, resident, sampledMip) &&                        \
     NtcSampleMip(                                                                                           \
         NETWORK_VERSION, NTC_MATH,                                                                          \
         NtcGetTiledMip(context, textureId, NtcGetMip(desc, sampledMip), texel, mipLevel, sampledMip),       \
         latents, latentsOffset, weights, weightsOffset, NtcGetLayerOffsets(desc),                           \
         (desc).channelColorSpaces, NtcGetTiledTexel(context, textureId, texel, mipLevel, sampledMip),       \
         convertToLinear, outputs))
#endif

#endif
