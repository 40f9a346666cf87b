// SPDX-License-Identifier: MIT
// BC7's partitions, anchors and modes (Direct3D 11.3 functional specification 19.5.14 ... 19.5.17), and what
// the encoder's headers share.
#ifndef OPENNTC_BC7_TABLES_H
#define OPENNTC_BC7_TABLES_H

#include "openntc/bc/Lanes.h"
#include "openntc/bc/Quality.h"

#if defined(__cplusplus)
#define NTC_BC7_IN(T, name) const T& name
#if defined(__clang__)
#define NTC_BC7_UNROLL _Pragma("unroll")
#elif defined(__GNUC__)
#define NTC_BC7_UNROLL _Pragma("GCC unroll 16")
#else
#define NTC_BC7_UNROLL
#endif
#if defined(__GNUC__)
#define NTC_BC7_INLINE inline __attribute__((always_inline))
#define NTC_BC7_LEAF inline __attribute__((noinline))
#else
#define NTC_BC7_INLINE inline
#define NTC_BC7_LEAF inline
#endif
#else
#define NTC_BC7_IN(T, name) in T name
#define NTC_BC7_UNROLL NTC_UNROLL
#define NTC_BC7_INLINE
#define NTC_BC7_LEAF
#endif

#if defined(__cplusplus)
#define NtcLowestBit(x) std::countr_zero(x)
#elif defined(NTC_HLSL)
#define NtcLowestBit(x) int(firstbitlow(x))
#else
#define NtcLowestBit(x) findLSB(x)
#endif

// The texels of a block, 0 ... 255: texel t, channel c is [4 t + c] of an array of lanes; in shaders a word a
// texel, R lowest, as arrays that are indexed at run time are memory there.
#if defined(__cplusplus)
#define NTC_BC7_TEXELS(name) NTC_IN_ARRAY(NtcLane, name, 64)
#define NTC_BC7_INOUT_TEXELS(name) NTC_INOUT_ARRAY(NtcLane, name, 64)
#define NTC_BC7_DECLARE_TEXELS(name) NtcLane name[64]
#define NtcBc7Channel(name, t, c) (name)[4 * (t) + (c)]
#define NTC_BC7_SET_TEXEL(name, t, r, g, b, a)                                                               \
    {                                                                                                        \
        (name)[4 * (t)] = r;                                                                                 \
        (name)[4 * (t) + 1] = g;                                                                             \
        (name)[4 * (t) + 2] = b;                                                                             \
        (name)[4 * (t) + 3] = a;                                                                             \
    }
#else
#define NTC_BC7_TEXELS(name) NTC_IN_ARRAY(uint, name, 16)
#define NTC_BC7_INOUT_TEXELS(name) NTC_INOUT_ARRAY(uint, name, 16)
#define NTC_BC7_DECLARE_TEXELS(name) uint name[16]
#define NtcBc7Channel(name, t, c) int(((name)[t] >> uint(8 * (c))) & 255u)
#define NTC_BC7_SET_TEXEL(name, t, r, g, b, a)                                                               \
    (name)[t] = uint(r) | (uint(g) << 8) | (uint(b) << 16) | (uint(a) << 24)
#endif

#define NTC_BC7_PBITS_NONE 0
#define NTC_BC7_PBITS_EACH 1   // one an endpoint
#define NTC_BC7_PBITS_SHARED 2 // one a subset

#define NTC_BC7_SOLID 4096 // in a choice: one colour, index 1 everywhere

NTC_LANES_NAMESPACE_BEGIN

/// Two subsets: bit t is the subset of texel t.
NTC_TABLE(uint, kNtcBc7Partitions2, 64) = {
    0xCCCCu, 0x8888u, 0xEEEEu, 0xECC8u, 0xC880u, 0xFEECu, 0xFEC8u, 0xEC80u, 0xC800u, 0xFFECu, 0xFE80u,
    0xE800u, 0xFFE8u, 0xFF00u, 0xFFF0u, 0xF000u, 0xF710u, 0x008Eu, 0x7100u, 0x08CEu, 0x008Cu, 0x7310u,
    0x3100u, 0x8CCEu, 0x088Cu, 0x3110u, 0x6666u, 0x366Cu, 0x17E8u, 0x0FF0u, 0x718Eu, 0x399Cu, 0xAAAAu,
    0xF0F0u, 0x5A5Au, 0x33CCu, 0x3C3Cu, 0x55AAu, 0x9696u, 0xA55Au, 0x73CEu, 0x13C8u, 0x324Cu, 0x3BDCu,
    0x6996u, 0xC33Cu, 0x9966u, 0x0660u, 0x0272u, 0x04E4u, 0x4E40u, 0x2720u, 0xC936u, 0x936Cu, 0x39C6u,
    0x639Cu, 0x9336u, 0x9CC6u, 0x817Eu, 0xE718u, 0xCCF0u, 0x0FCCu, 0x7744u, 0xEE22u,
};

#if !defined(__cplusplus)
// Word `(pattern >> 1) & 3` of group `pattern >> 3`, else what was there.
#define NTC_BC7_OF_FOUR(group, w0, w1, w2, w3, word)                                                         \
    (pattern >> 3) != (group)                                                                                \
        ? (word)                                                                                             \
        : ((pattern & 4) != 0 ? ((pattern & 2) != 0 ? (w3) : (w2)) : ((pattern & 2) != 0 ? (w1) : (w0)))
#endif

/// The partition of that number; a table that all lanes read at one place.
NTC_FUNCTION uint NtcBc7GetPartition2(int pattern) {
#if defined(__cplusplus)
    return kNtcBc7Partitions2[pattern];
#else
    // Selections, two partitions a word: a table that is indexed at run time is copied to memory first, which
    // took a sixth of the time of the fast level.
    uint word = 0u;
    word = NTC_BC7_OF_FOUR(0, 0x8888CCCCu, 0xECC8EEEEu, 0xFEECC880u, 0xEC80FEC8u, word);
    word = NTC_BC7_OF_FOUR(1, 0xFFECC800u, 0xE800FE80u, 0xFF00FFE8u, 0xF000FFF0u, word);
    word = NTC_BC7_OF_FOUR(2, 0x008EF710u, 0x08CE7100u, 0x7310008Cu, 0x8CCE3100u, word);
    word = NTC_BC7_OF_FOUR(3, 0x3110088Cu, 0x366C6666u, 0x0FF017E8u, 0x399C718Eu, word);
    word = NTC_BC7_OF_FOUR(4, 0xF0F0AAAAu, 0x33CC5A5Au, 0x55AA3C3Cu, 0xA55A9696u, word);
    word = NTC_BC7_OF_FOUR(5, 0x13C873CEu, 0x3BDC324Cu, 0xC33C6996u, 0x06609966u, word);
    word = NTC_BC7_OF_FOUR(6, 0x04E40272u, 0x27204E40u, 0x936CC936u, 0x639C39C6u, word);
    word = NTC_BC7_OF_FOUR(7, 0x9CC69336u, 0xE718817Eu, 0x0FCCCCF0u, 0xEE227744u, word);
    return (pattern & 1) != 0 ? word >> 16 : word & 0xFFFFu;
#endif
}

/// Three subsets: bits 2 t and 2 t + 1 are the subset of texel t.
NTC_TABLE(uint, kNtcBc7Partitions3, 64) = {
    0xAA685050u, 0x6A5A5040u, 0x5A5A4200u, 0x5450A0A8u, 0xA5A50000u, 0xA0A05050u, 0x5555A0A0u, 0x5A5A5050u,
    0xAA550000u, 0xAA555500u, 0xAAAA5500u, 0x90909090u, 0x94949494u, 0xA4A4A4A4u, 0xA9A59450u, 0x2A0A4250u,
    0xA5945040u, 0x0A425054u, 0xA5A5A500u, 0x55A0A0A0u, 0xA8A85454u, 0x6A6A4040u, 0xA4A45000u, 0x1A1A0500u,
    0x0050A4A4u, 0xAAA59090u, 0x14696914u, 0x69691400u, 0xA08585A0u, 0xAA821414u, 0x50A4A450u, 0x6A5A0200u,
    0xA9A58000u, 0x5090A0A8u, 0xA8A09050u, 0x24242424u, 0x00AA5500u, 0x24924924u, 0x24499224u, 0x50A50A50u,
    0x500AA550u, 0xAAAA4444u, 0x66660000u, 0xA5A0A5A0u, 0x50A050A0u, 0x69286928u, 0x44AAAA44u, 0x66666600u,
    0xAA444444u, 0x54A854A8u, 0x95809580u, 0x96969600u, 0xA85454A8u, 0x80959580u, 0xAA141414u, 0x96960000u,
    0xAAAA1414u, 0xA05050A0u, 0xA0A5A5A0u, 0x96000000u, 0x40804080u, 0xA9A8A9A8u, 0xAAAAAA44u, 0x2A4A5254u,
};

/// The texel of subset 1 whose index has no highest bit; two subsets.
NTC_TABLE(uint, kNtcBc7Anchors2, 64) = {
    15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 15u, 2u,  8u, 2u,  2u, 8u,
    8u,  15u, 2u,  8u,  2u,  2u,  8u,  8u,  2u,  2u,  15u, 15u, 6u,  8u,  2u,  8u,  15u, 15u, 2u, 8u,  2u, 2u,
    2u,  15u, 15u, 6u,  6u,  2u,  6u,  8u,  15u, 15u, 2u,  2u,  15u, 15u, 15u, 15u, 15u, 2u,  2u, 15u,
};

/// Three subsets: that of subset 1 in the low four bits, that of subset 2 in the high ones.
NTC_TABLE(uint, kNtcBc7Anchors3, 64) = {
    0xF3u, 0x83u, 0x8Fu, 0x3Fu, 0xF8u, 0xF3u, 0x3Fu, 0x8Fu, 0xF8u, 0xF8u, 0xF6u, 0xF6u, 0xF6u,
    0xF5u, 0xF3u, 0x83u, 0xF3u, 0x83u, 0xF8u, 0x3Fu, 0xF3u, 0x83u, 0xF6u, 0x8Au, 0x35u, 0xF8u,
    0x68u, 0xA6u, 0xF8u, 0xF5u, 0xAFu, 0x8Fu, 0xF8u, 0x3Fu, 0xF3u, 0xA5u, 0xA6u, 0x8Au, 0x98u,
    0xAFu, 0x6Fu, 0xF3u, 0x8Fu, 0xF5u, 0x3Fu, 0x6Fu, 0x6Fu, 0x8Fu, 0xF3u, 0x3Fu, 0xF5u, 0xF5u,
    0xF5u, 0xF8u, 0xF5u, 0xFAu, 0xF5u, 0xFAu, 0xF8u, 0xFDu, 0x3Fu, 0xFCu, 0xF3u, 0x83u,
};

// By mode 0 ... 7. Bits of an endpoint count the p-bit. Of modes 4 and 5 alpha has bits and indices of its
// own; mode 4's index selector swaps the lengths of indices.
NTC_TABLE(int, kNtcBc7Subsets, 8) = {3, 2, 3, 2, 1, 1, 1, 2};
NTC_TABLE(int, kNtcBc7PartitionBits, 8) = {4, 6, 6, 6, 0, 0, 0, 6};
NTC_TABLE(int, kNtcBc7ColorBits, 8) = {5, 7, 5, 8, 5, 7, 8, 6};
NTC_TABLE(int, kNtcBc7AlphaBits, 8) = {0, 0, 0, 0, 6, 8, 8, 6};
NTC_TABLE(int, kNtcBc7PBits, 8) = {1, 2, 0, 1, 0, 0, 1, 1};
NTC_TABLE(int, kNtcBc7IndexBits, 8) = {3, 3, 2, 2, 2, 2, 4, 2};

/// The integer quotient, rounded towards minus infinity, of a numerator of either sign; |numerator| < 2^30,
/// |quotient| < 2^18, denominator 1 ... 2^24. A float division, of whatever rounding a device has, is off by
/// less than one; with the offset it is never negative, so that truncation rounds down.
NTC_BC7_INLINE NtcLane NtcBc7Divide(NtcLane numerator, NtcLane denominator) {
    NtcLane quotient =
        NtcLaneTruncate(NtcLaneToFloat(numerator) / NtcLaneToFloat(denominator) + 524288.0f) - 524288;
    NtcLane rest = numerator - quotient * denominator;
    return quotient +
           NtcSelect(rest < 0, NtcSplat(-1), NtcSelect(rest >= denominator, NtcSplat(1), NtcSplat(0)));
}

/// The subset of texel t in bits 2 t and 2 t + 1, of a partition of two subsets.
NTC_FUNCTION NtcLane NtcBc7SpreadBits(NtcLane mask) {
    NtcLane spread = mask & 0xFFFF;
    spread = (spread | (spread << 8)) & 0x00FF00FF;
    spread = (spread | (spread << 4)) & 0x0F0F0F0F;
    spread = (spread | (spread << 2)) & 0x33333333;
    return (spread | (spread << 1)) & 0x55555555;
}

/// What a block's coding is: mode in bits 0 ... 2, partition in 3 ... 8, rotation in 9 and 10, index selector
/// in 11.
NTC_FUNCTION int NtcBc7Hint(int mode, int pattern, int rotation, int selector) {
    return mode | (pattern << 3) | (rotation << 9) | (selector << 11);
}

NTC_LANES_NAMESPACE_END

#endif
