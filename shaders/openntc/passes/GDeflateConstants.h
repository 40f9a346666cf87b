// SPDX-License-Identifier: MIT
// Tiles and constants of DecompressGDeflate, shared by C++, GLSL and HLSL.
#ifndef OPENNTC_GDEFLATE_CONSTANTS_H
#define OPENNTC_GDEFLATE_CONSTANTS_H

// Workgroups along x.
#define NTC_GDEFLATE_GROUPS 32768
// Blocks of a tile at most, as container/GDeflate.h has it: a tile of empty blocks would take seconds.
#define NTC_GDEFLATE_MAX_BLOCKS 256

#if defined(__cplusplus)
#include <cstddef>
#include <cstdint>
namespace openntc {
#define NTC_FIELD_UINT std::uint32_t
#else
#define NTC_FIELD_UINT uint
#endif

/// A tile, 16 bytes.
struct NtcGDeflateTile {
    NTC_FIELD_UINT firstWord;  // compressed
    NTC_FIELD_UINT words;      // beyond them zeros are read
    NTC_FIELD_UINT outputWord; // the first; the tile owns every word that it has bytes of
    NTC_FIELD_UINT bytes;      // decompressed, 1 to 65536
};

/// Push constants of DecompressGDeflate, 8 bytes.
struct NtcGDeflateConstants {
    NTC_FIELD_UINT firstTile; // of the buffer
    NTC_FIELD_UINT tiles;
};

#if defined(__cplusplus)
static_assert(sizeof(NtcGDeflateTile) == 16);
static_assert(offsetof(NtcGDeflateTile, words) == 4);
static_assert(offsetof(NtcGDeflateTile, outputWord) == 8);
static_assert(offsetof(NtcGDeflateTile, bytes) == 12);
static_assert(sizeof(NtcGDeflateConstants) == 8);
static_assert(offsetof(NtcGDeflateConstants, tiles) == 4);
} // namespace openntc
#endif

#undef NTC_FIELD_UINT

#endif
