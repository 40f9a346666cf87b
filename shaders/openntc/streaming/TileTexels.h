// SPDX-License-Identifier: MIT
// Texels of ordinary images in tiles. A tile's texels lie row by row, as wide as a whole tile; the mips of a
// tail lie one behind the other, row by row, through its slots.
//
// NtcSlotLoad(context, pool, word) reads the buffer with the slots: declared at NTC_SLOTS_BINDING (3) of
// NTC_STREAMING_SET, register NTC_SLOTS_REGISTER (t17), for all pools, unless the macro is defined.
#ifndef OPENNTC_TILE_TEXELS_H
#define OPENNTC_TILE_TEXELS_H

#include "TileLookup.h"
#include "openntc/ColorSpaces.h"
#include "openntc/Portability.h"

#ifndef NTC_SLOTS_BINDING
#define NTC_SLOTS_BINDING 3
#endif
#ifndef NTC_SLOTS_REGISTER
#define NTC_SLOTS_REGISTER t17
#endif

NTC_NAMESPACE_BEGIN

#if !defined(NtcSlotLoad)
#if defined(__cplusplus)
#define NtcSlotLoad(context, pool, word)                                                                     \
    ((pool) < (context).memory->poolCount ? NtcLoadStreamingWord((context).memory->pools[pool], word) : 0u)
#elif defined(NTC_HLSL)
[[vk::binding(NTC_SLOTS_BINDING, NTC_STREAMING_SET)]] ByteAddressBuffer ntcSlots
    : register(NTC_SLOTS_REGISTER);
#define NtcSlotLoad(context, pool, word) ntcSlots.Load(4u * (word))
#else
layout(set = NTC_STREAMING_SET, binding = NTC_SLOTS_BINDING, std430) readonly buffer NtcSlotsBlock {
    uint words[];
}
ntcSlots;
#define NtcSlotLoad(context, pool, word) ntcSlots.words[word]
#endif
#endif

/// A binary16 number.
NTC_FUNCTION float NtcDecodeHalf(uint bits) {
    uint magnitude = bits & 0x7FFFu;
    uint sign = (bits & 0x8000u) << 16;
    if (magnitude < 0x400u) // zero and subnormal: multiples of 2^-24
        return asfloat(asuint(float(magnitude) * 5.9604645e-8f) | sign);
    if (magnitude >= 0x7C00u)
        return asfloat(((magnitude & 0x3FFu) << 13) | 0x7F800000u | sign);
    return asfloat(((magnitude << 13) + 0x38000000u) | sign);
}

/// Byte `index` of a word as 0 ... 1: the product with the binary32 nearest to 1 / 255, rounded once, which
/// is 1 for 255.
NTC_FUNCTION float NtcDecodeByte(uint word, uint index) {
    return NtcMultiply(float((word >> (8u * index)) & 255u), 0.003921569f);
}

/// log2 of the bytes of a texel.
NTC_FUNCTION uint NtcGetTexelShift(uint format) {
    if (format == uint(NTC_TILES_R8))
        return 0u;
    if (format == uint(NTC_TILES_RG8) || format == uint(NTC_TILES_R16F))
        return 1u;
    if (format == uint(NTC_TILES_RGBA16F) || format == uint(NTC_TILES_RG32F))
        return 3u;
    return format == uint(NTC_TILES_RGBA32F) ? 4u : 2u;
}

/// A texel of an image, from the word that holds its first byte on. Components that a format lacks are 0, 0
/// and 1.
NTC_FUNCTION float4 NtcDecodeTexel(NtcStreamingContext context, uint pool, uint format, uint word,
                                   uint byteInWord) {
    uint first = NtcSlotLoad(context, pool, word);
    float4 color = float4(0.0f, 0.0f, 0.0f, 1.0f);
    if (format == uint(NTC_TILES_RGBA8) || format == uint(NTC_TILES_RGBA8_SRGB)) {
        color = float4(NtcDecodeByte(first, 0u), NtcDecodeByte(first, 1u), NtcDecodeByte(first, 2u),
                       NtcDecodeByte(first, 3u));
        if (format == uint(NTC_TILES_RGBA8_SRGB)) {
            color.x = NtcDecodeSrgb(color.x);
            color.y = NtcDecodeSrgb(color.y);
            color.z = NtcDecodeSrgb(color.z);
        }
    } else if (format == uint(NTC_TILES_R8) || format == uint(NTC_TILES_RG8)) {
        color.x = NtcDecodeByte(first, byteInWord);
        if (format == uint(NTC_TILES_RG8))
            color.y = NtcDecodeByte(first, byteInWord + 1u);
    } else if (format == uint(NTC_TILES_R16F) || format == uint(NTC_TILES_RG16F) ||
               format == uint(NTC_TILES_RGBA16F)) {
        color.x = NtcDecodeHalf((first >> (8u * byteInWord)) & 0xFFFFu);
        if (format != uint(NTC_TILES_R16F))
            color.y = NtcDecodeHalf(first >> 16);
        if (format == uint(NTC_TILES_RGBA16F)) {
            uint second = NtcSlotLoad(context, pool, word + 1u);
            color.z = NtcDecodeHalf(second & 0xFFFFu);
            color.w = NtcDecodeHalf(second >> 16);
        }
    } else {
        color.x = asfloat(first);
        if (format != uint(NTC_TILES_R32F))
            color.y = asfloat(NtcSlotLoad(context, pool, word + 1u));
        if (format == uint(NTC_TILES_RGBA32F)) {
            color.z = asfloat(NtcSlotLoad(context, pool, word + 2u));
            color.w = asfloat(NtcSlotLoad(context, pool, word + 3u));
        }
    }
    return color;
}

/// A texel of an image's mip, inside it, whose tile (NtcUseTexel) is there.
NTC_FUNCTION float4 NtcFetchImageTexel(NtcStreamingContext context, NtcTextureHeader header, int2 texel,
                                       int mip) {
    uint slotWords = NtcPageTableLoad(context, header.word + NTC_HEADER_SLOT_WORDS);
    uint shift = NtcGetTexelShift(header.format);
    uint tile = header.firstTailTile;
    uint byteOffset = 0u;
    if (mip < header.firstTailMip) {
        NtcLevel level = NtcLoadLevel(context, header, NtcGetLevelOfMip(context, header, mip));
        tile = NtcGetTile(header, level, texel, mip);
        byteOffset =
            ((uint(texel.y) % header.tileHeight) * header.tileWidth + uint(texel.x) % header.tileWidth)
            << shift;
    } else {
        uint before = 0u;
        NTC_LOOP for (int finer = header.firstTailMip; finer < mip; finer++) before +=
            NtcGetTiledMipSize(header.width, finer) * NtcGetTiledMipSize(header.height, finer);
        byteOffset = (before + uint(texel.y) * NtcGetTiledMipSize(header.width, mip) + uint(texel.x))
                     << shift;
        uint slotBytes = slotWords > 0u ? 4u * slotWords : 4u;
        tile += byteOffset / slotBytes;
        byteOffset = byteOffset % slotBytes;
    }
    uint slot = NtcGetTileSlot(context, header, tile);
    uint word =
        NtcPageTableLoad(context, header.word + NTC_HEADER_SLOTS_WORD) + slot * slotWords + (byteOffset >> 2);
    return NtcDecodeTexel(context, NtcPageTableLoad(context, header.word + NTC_HEADER_POOL), header.format,
                          word, byteOffset & 3u);
}

NTC_NAMESPACE_END

#endif
