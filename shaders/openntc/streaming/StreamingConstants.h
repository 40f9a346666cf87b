// SPDX-License-Identifier: MIT
// What the host writes and shaders read of tiled textures, and what shaders write and the host reads: the one
// layout that C++, GLSL and HLSL share. Fields are 4-byte scalars, structs are multiples of 16 bytes long.
//
// Page table (read-only in shaders), one buffer of 32-bit words with three parts, whose first words are in
// NtcStreamingConstants:
//   headers   NtcTiledTexture, one per texture identifier; all zero: no such texture
//   entries   one word per tile: its slot, or NTC_TILE_MISSING
//   slices    8 words, NtcSliceConstants, one per slot, and one per mip in the tail of a texture set; offsets
//             count from the start of the pool's buffer
// Launch state (read and written by shaders), one buffer of words with three parts:
//   queue     NtcRequestQueue, then NtcTileRequest[capacity]
//   bits      one bit per entry: requested in this round
//   stamps    one word per slot: the last round that read it; 0: never
// Feedback (read and written by shaders): one word per region, bit m: mip m is wanted.
//
// Tiles of a texture are numbered level by level, the finest first, row by row, then the tail. Level l holds
// mips firstMip ... lastMip, and its tiles are counted in texels of lastMip. An ordinary image has one mip a
// level; a texture set has one level for every latent image that is not in the tail. The tail, one or more
// tiles, holds all mips from firstTailMip on.
#ifndef OPENNTC_STREAMING_CONSTANTS_H
#define OPENNTC_STREAMING_CONSTANTS_H

#include "openntc/WrapModes.h"

#define NTC_TILE_MISSING 0xFFFFFFFFu
#define NTC_MAX_LEVELS 16
#define NTC_MAX_TILED_SIZE 65536 // texels per side of a tiled texture

#define NTC_NO_MIP 255u               // of a region that nobody has read
#define NTC_RESOLVE_FEEDBACK_GROUP 64 // invocations of ResolveFeedback along x, of 4 regions each

// NtcTiledTexture::format
#define NTC_TILES_NONE 0        // no such texture
#define NTC_TILES_TEXTURE_SET 1 // latents
#define NTC_TILES_R8 2          // 8-bit numbers: 0 ... 255 are 0 ... 1
#define NTC_TILES_RG8 3
#define NTC_TILES_RGBA8 4
#define NTC_TILES_RGBA8_SRGB 5 // red, green and blue are sRGB
#define NTC_TILES_R16F 6
#define NTC_TILES_RG16F 7
#define NTC_TILES_RGBA16F 8
#define NTC_TILES_R32F 9
#define NTC_TILES_RG32F 10
#define NTC_TILES_RGBA32F 11
#define NTC_TILES_FORMAT_COUNT 12
#define NTC_TILES_PAGES 12 // no texture: entries are values of the engine's own

// NtcTiledTexture::sampling: filter, bits 0 ... 3; wrap of u, bits 4 ... 7; wrap of v, bits 8 ... 11;
// largest anisotropy (1 ... 16), bits 16 ... 23.
#define NTC_FILTER_POINT 0     // nearest texel of the nearest mip
#define NTC_FILTER_BILINEAR 1  // of the nearest mip
#define NTC_FILTER_TRILINEAR 2 // of the two mips

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

/// A level of tiles, 16 bytes.
struct NtcTiledLevel {
    NTC_FIELD_UINT widthFirstMip; // texels of the level's last mip, bits 0 ... 19; first mip, bits 24 ... 31
    NTC_FIELD_UINT heightLastMip;
    NTC_FIELD_UINT tilesXY;   // 16 bits each: tiles across, tiles down
    NTC_FIELD_UINT firstTile; // the number of its first tile in the texture
};

/// Everything about a tiled texture but where its tiles are, 352 bytes.
struct NtcTiledTexture {
    NTC_FIELD_UINT firstEntry;    // of the page table: tile t is entry firstEntry + t
    NTC_FIELD_UINT tileCount;     // with the tail
    NTC_FIELD_UINT levelsMips;    // bytes: levels (without the tail), mips, first tail mip, 0
    NTC_FIELD_UINT firstTailTile; // tail tiles: tileCount - firstTailTile
    NTC_FIELD_UINT width;         // texels of mip 0
    NTC_FIELD_UINT height;
    NTC_FIELD_UINT tileSize;  // 16 bits each: width, height of a tile in texels of its level's last mip
    NTC_FIELD_UINT sampling;  // NTC_FILTER_*, NTC_WRAP_*, anisotropy
    NTC_FIELD_FLOAT mipBias;  // added to the level of detail
    NTC_FIELD_UINT format;    // NTC_TILES_*
    NTC_FIELD_UINT pool;      // which buffer has the slots: passed to NtcSlotLoad, the engine's
    NTC_FIELD_UINT firstSlot; // slot s has stamp, and slice row, firstSlot + s
    NTC_FIELD_UINT slotsWord; // slot s begins at word slotsWord + s * slotWords of the pool
    NTC_FIELD_UINT slotWords; // images only: slice rows hold their own offsets
    NTC_FIELD_UINT
    firstTailRow; // texture sets: slice row of mip m of the tail: firstTailRow + m - firstTailMip
    NTC_FIELD_UINT textureSet;    // texture sets: number of the constants, for NtcDemandGrad
    NTC_FIELD_UINT weightsOffset; // texture sets: bytes
    NTC_FIELD_UINT channels;      // texture sets: first of four outputs, bits 0 ... 7; bit 8: to linear light
    NTC_FIELD_UINT mipLevels0;    // levels of mips 0 ... 7, 4 bits each; those of the tail do not count
    NTC_FIELD_UINT mipLevels1;    // of mips 8 ... 15
    NTC_FIELD_UINT firstRegion;   // feedback: first word in a frame's map
    NTC_FIELD_UINT regionsXY;     // 16 bits each: regions across, regions down; 0: no feedback
    NTC_FIELD_UINT regionWidth;   // texels of mip 0
    NTC_FIELD_UINT regionHeight;
    NtcTiledLevel levels[NTC_MAX_LEVELS];
};

/// Head of the request queue, 16 bytes. `count` goes on counting where the queue is full: entries are
/// min(count, capacity), and overflow = count - entries were dropped.
struct NtcRequestQueue {
    NTC_FIELD_UINT count;
    NTC_FIELD_UINT overflow;
    NTC_FIELD_UINT capacity;
    NTC_FIELD_UINT padding0;
};

/// A tile that was read and is missing, 8 bytes.
struct NtcTileRequest {
    NTC_FIELD_UINT textureId;
    NTC_FIELD_UINT tile; // number in the texture
};

/// Head of the list of regions whose feedback has changed, 16 bytes; `count` goes on counting where the list
/// is full: `dropped` changes are reported again next time.
struct NtcFeedbackChangesHead {
    NTC_FIELD_UINT count;
    NTC_FIELD_UINT dropped;
    NTC_FIELD_UINT capacity;
    NTC_FIELD_UINT padding0;
};

/// A region whose finest wanted mip has changed, 8 bytes.
struct NtcFeedbackChange {
    NTC_FIELD_UINT region; // word in a frame's map: NtcTiledTexture::firstRegion + number in the texture
    NTC_FIELD_UINT mip;    // 255: none
};

/// Push constants of passes/ResolveFeedback, 16 bytes.
struct NtcResolveFeedbackConstants {
    NTC_FIELD_UINT feedbackWord; // first word of the frame's map
    NTC_FIELD_UINT firstRegion;  // a multiple of 4
    NTC_FIELD_UINT regionCount;
    NTC_FIELD_UINT padding0;
};

/// What a launch is given, 64 bytes (uniform buffer or push constants).
struct NtcStreamingConstants {
    NTC_FIELD_UINT headersWord; // of the page table
    NTC_FIELD_UINT entriesWord;
    NTC_FIELD_UINT slicesWord;
    NTC_FIELD_UINT textureCount; // identifiers from here on do not exist
    NTC_FIELD_UINT queueWord;    // of the launch state
    NTC_FIELD_UINT bitsWord;
    NTC_FIELD_UINT stampsWord;
    NTC_FIELD_UINT round;        // 1 or more: what stamps get
    NTC_FIELD_UINT requestRate;  // a request is made if a random number is at most this; 2^32 - 1: always
    NTC_FIELD_UINT feedbackRate; // likewise for feedback
    NTC_FIELD_UINT feedbackWord; // of the feedback buffer: first word of this frame's map
    NTC_FIELD_UINT frame;        // for random numbers; rounds of one frame may share it
    NTC_FIELD_UINT padding0;
    NTC_FIELD_UINT padding1;
    NTC_FIELD_UINT padding2;
    NTC_FIELD_UINT padding3;
};

#if defined(__cplusplus)
static_assert(sizeof(NtcTiledLevel) == 16);
static_assert(offsetof(NtcTiledLevel, widthFirstMip) == 0);
static_assert(offsetof(NtcTiledLevel, heightLastMip) == 4);
static_assert(offsetof(NtcTiledLevel, tilesXY) == 8);
static_assert(offsetof(NtcTiledLevel, firstTile) == 12);
static_assert(sizeof(NtcTiledTexture) == 352);
static_assert(offsetof(NtcTiledTexture, firstEntry) == 0);
static_assert(offsetof(NtcTiledTexture, tileCount) == 4);
static_assert(offsetof(NtcTiledTexture, levelsMips) == 8);
static_assert(offsetof(NtcTiledTexture, firstTailTile) == 12);
static_assert(offsetof(NtcTiledTexture, width) == 16);
static_assert(offsetof(NtcTiledTexture, height) == 20);
static_assert(offsetof(NtcTiledTexture, tileSize) == 24);
static_assert(offsetof(NtcTiledTexture, sampling) == 28);
static_assert(offsetof(NtcTiledTexture, mipBias) == 32);
static_assert(offsetof(NtcTiledTexture, format) == 36);
static_assert(offsetof(NtcTiledTexture, pool) == 40);
static_assert(offsetof(NtcTiledTexture, firstSlot) == 44);
static_assert(offsetof(NtcTiledTexture, slotsWord) == 48);
static_assert(offsetof(NtcTiledTexture, slotWords) == 52);
static_assert(offsetof(NtcTiledTexture, firstTailRow) == 56);
static_assert(offsetof(NtcTiledTexture, textureSet) == 60);
static_assert(offsetof(NtcTiledTexture, weightsOffset) == 64);
static_assert(offsetof(NtcTiledTexture, channels) == 68);
static_assert(offsetof(NtcTiledTexture, mipLevels0) == 72);
static_assert(offsetof(NtcTiledTexture, mipLevels1) == 76);
static_assert(offsetof(NtcTiledTexture, firstRegion) == 80);
static_assert(offsetof(NtcTiledTexture, regionsXY) == 84);
static_assert(offsetof(NtcTiledTexture, regionWidth) == 88);
static_assert(offsetof(NtcTiledTexture, regionHeight) == 92);
static_assert(offsetof(NtcTiledTexture, levels) == 96);
static_assert(sizeof(NtcRequestQueue) == 16);
static_assert(offsetof(NtcRequestQueue, count) == 0);
static_assert(offsetof(NtcRequestQueue, overflow) == 4);
static_assert(offsetof(NtcRequestQueue, capacity) == 8);
static_assert(offsetof(NtcRequestQueue, padding0) == 12);
static_assert(sizeof(NtcTileRequest) == 8);
static_assert(offsetof(NtcTileRequest, textureId) == 0);
static_assert(offsetof(NtcTileRequest, tile) == 4);
static_assert(sizeof(NtcFeedbackChangesHead) == 16);
static_assert(offsetof(NtcFeedbackChangesHead, count) == 0);
static_assert(offsetof(NtcFeedbackChangesHead, dropped) == 4);
static_assert(offsetof(NtcFeedbackChangesHead, capacity) == 8);
static_assert(offsetof(NtcFeedbackChangesHead, padding0) == 12);
static_assert(sizeof(NtcFeedbackChange) == 8);
static_assert(offsetof(NtcFeedbackChange, region) == 0);
static_assert(offsetof(NtcFeedbackChange, mip) == 4);
static_assert(sizeof(NtcResolveFeedbackConstants) == 16);
static_assert(offsetof(NtcResolveFeedbackConstants, feedbackWord) == 0);
static_assert(offsetof(NtcResolveFeedbackConstants, firstRegion) == 4);
static_assert(offsetof(NtcResolveFeedbackConstants, regionCount) == 8);
static_assert(offsetof(NtcResolveFeedbackConstants, padding0) == 12);
static_assert(sizeof(NtcStreamingConstants) == 64);
static_assert(offsetof(NtcStreamingConstants, headersWord) == 0);
static_assert(offsetof(NtcStreamingConstants, entriesWord) == 4);
static_assert(offsetof(NtcStreamingConstants, slicesWord) == 8);
static_assert(offsetof(NtcStreamingConstants, textureCount) == 12);
static_assert(offsetof(NtcStreamingConstants, queueWord) == 16);
static_assert(offsetof(NtcStreamingConstants, bitsWord) == 20);
static_assert(offsetof(NtcStreamingConstants, stampsWord) == 24);
static_assert(offsetof(NtcStreamingConstants, round) == 28);
static_assert(offsetof(NtcStreamingConstants, requestRate) == 32);
static_assert(offsetof(NtcStreamingConstants, feedbackRate) == 36);
static_assert(offsetof(NtcStreamingConstants, feedbackWord) == 40);
static_assert(offsetof(NtcStreamingConstants, frame) == 44);
static_assert(offsetof(NtcStreamingConstants, padding0) == 48);
static_assert(offsetof(NtcStreamingConstants, padding1) == 52);
static_assert(offsetof(NtcStreamingConstants, padding2) == 56);
static_assert(offsetof(NtcStreamingConstants, padding3) == 60);
} // namespace openntc
#endif

#undef NTC_FIELD_INT
#undef NTC_FIELD_UINT
#undef NTC_FIELD_FLOAT

#endif
