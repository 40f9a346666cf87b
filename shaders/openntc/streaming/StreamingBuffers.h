// SPDX-License-Identifier: MIT
// Where shaders find page table and launch state (StreamingConstants.h says what is in them), and the context
// that streaming functions take first.
//
//   NtcPageTableLoad(context, word)          a word of the page table
//   NtcLaunchStateLoad(context, word)        a word of the launch state; may be stale
//   NtcLaunchStateStore(context, word, value)
//   NtcLaunchStateOr(context, word, bits), NtcLaunchStateAdd(context, word, value)
//                                            atomic, relaxed; return what was there before
//
// GLSL and HLSL: two buffers are declared here, in descriptor set NTC_STREAMING_SET (1 unless defined) at
// NTC_PAGE_TABLE_BINDING (0) and NTC_LAUNCH_STATE_BINDING (1); Feedback.h and Demand.h declare theirs at 2
// and 3 to 5. Registers of HLSL are NTC_PAGE_TABLE_REGISTER (t16) and NTC_LAUNCH_STATE_REGISTER (u16). C++:
// NtcStreamingMemory; words outside read 0 and take nothing. An engine replaces this by defining the macros
// of either buffer before the first include: NtcPageTableLoad, or NtcLaunchStateLoad and the three beside it.
// Fragment shaders need fragmentStoresAndAtomics. What a scene does not call for is left out by the switches
// NTC_TILE_... of openntc/Effects.h, buffers included.
#ifndef OPENNTC_STREAMING_BUFFERS_H
#define OPENNTC_STREAMING_BUFFERS_H

#include "StreamingConstants.h"
#include "TileMaths.h"
#include "openntc/Effects.h"
#include "openntc/Portability.h"

#ifndef NTC_STREAMING_SET
#define NTC_STREAMING_SET 1
#endif
#ifndef NTC_PAGE_TABLE_BINDING
#define NTC_PAGE_TABLE_BINDING 0
#endif
#ifndef NTC_LAUNCH_STATE_BINDING
#define NTC_LAUNCH_STATE_BINDING 1
#endif
#ifndef NTC_PAGE_TABLE_REGISTER
#define NTC_PAGE_TABLE_REGISTER t16
#endif
#ifndef NTC_LAUNCH_STATE_REGISTER
#define NTC_LAUNCH_STATE_REGISTER u16
#endif

NTC_NAMESPACE_BEGIN

#if defined(__cplusplus)
/// Words that shaders written in C++ read and write.
struct NtcStreamingWords {
    uint* words = nullptr;
    std::size_t count = 0;
};

inline uint NtcLoadStreamingWord(const NtcStreamingWords& buffer, uint word) {
    if (word >= buffer.count)
        return 0u;
#if defined(__GNUC__) || defined(__clang__)
    return __atomic_load_n(buffer.words + word, __ATOMIC_RELAXED);
#else
    return buffer.words[word];
#endif
}

inline void NtcStoreStreamingWord(const NtcStreamingWords& buffer, uint word, uint value) {
    if (word >= buffer.count)
        return;
#if defined(__GNUC__) || defined(__clang__)
    __atomic_store_n(buffer.words + word, value, __ATOMIC_RELAXED);
#else
    buffer.words[word] = value;
#endif
}

/// Atomic with GCC and Clang; elsewhere for one thread.
inline uint NtcOrStreamingWord(const NtcStreamingWords& buffer, uint word, uint bits) {
    if (word >= buffer.count)
        return 0u;
#if defined(__GNUC__) || defined(__clang__)
    return __atomic_fetch_or(buffer.words + word, bits, __ATOMIC_RELAXED);
#else
    const uint before = buffer.words[word];
    buffer.words[word] |= bits;
    return before;
#endif
}

inline uint NtcAddStreamingWord(const NtcStreamingWords& buffer, uint word, uint value) {
    if (word >= buffer.count)
        return 0u;
#if defined(__GNUC__) || defined(__clang__)
    return __atomic_fetch_add(buffer.words + word, value, __ATOMIC_RELAXED);
#else
    const uint before = buffer.words[word];
    buffer.words[word] += value;
    return before;
#endif
}

/// The buffers that GLSL and HLSL have as globals.
struct NtcStreamingMemory {
    NtcStreamingWords pageTable; ///< only read
    NtcStreamingWords launchState;
    NtcStreamingWords feedback;
    NtcStreamingWords residency;              ///< only read: bytes, see NtcResidencyClamp
    const NtcStreamingWords* pools = nullptr; ///< only read: texels of ordinary images, by their pool
    std::size_t poolCount = 0;
    const void* textureSets = nullptr; ///< NtcDemandSets (Demand.h)
};
#endif

/// What streaming functions know of the launch and of the thread.
struct NtcStreamingContext {
    NtcStreamingConstants launch;
    uint seed; // of the thread, or of its quad
#if defined(__cplusplus)
    const NtcStreamingMemory* memory;
#endif
};

#if defined(__cplusplus)
inline NtcStreamingContext NtcMakeStreamingContext(const NtcStreamingConstants& launch, uint seed,
                                                   const NtcStreamingMemory& memory) {
    return {launch, seed, &memory};
}
#else
/// `seed`: NtcGetQuadSeed in fragment shaders, NtcGetThreadSeed elsewhere. It decides which threads request
/// and record at rates below 1.
NTC_FUNCTION NtcStreamingContext NtcMakeStreamingContext(NtcStreamingConstants launch, uint seed) {
    NtcStreamingContext context;
    context.launch = launch;
    context.seed = seed;
    return context;
}
#endif

/// One seed for the four pixels of a quad, so that they decide as one and nothing diverges.
NTC_FUNCTION uint NtcGetQuadSeed(int2 pixel) {
    return NtcHash(uint(pixel.x >> 1), uint(pixel.y >> 1));
}

NTC_FUNCTION uint NtcGetThreadSeed(uint index) {
    return NtcHash(index, 0x5EEDu);
}

/// True with the probability that `rate`, a threshold of NtcStreamingConstants, stands for: the same for all
/// calls with one seed, frame and purpose.
#if NTC_TILE_RATES
NTC_FUNCTION bool NtcPasses(NtcStreamingContext context, uint rate, uint purpose) {
    return rate == 0xFFFFFFFFu || NtcHash(context.seed, context.launch.frame * 2u + purpose) <= rate;
}
#else
#define NtcPasses(context, rate, purpose) true
#endif

#if !defined(NtcPageTableLoad)
#if defined(__cplusplus)
#define NtcPageTableLoad(context, word) NtcLoadStreamingWord((context).memory->pageTable, word)
#elif defined(NTC_HLSL)
[[vk::binding(NTC_PAGE_TABLE_BINDING, NTC_STREAMING_SET)]] ByteAddressBuffer ntcPageTable
    : register(NTC_PAGE_TABLE_REGISTER);
#define NtcPageTableLoad(context, word) ntcPageTable.Load(4u * (word))
#else
layout(set = NTC_STREAMING_SET, binding = NTC_PAGE_TABLE_BINDING, std430) readonly buffer NtcPageTableBlock {
    uint words[];
}
ntcPageTable;
#define NtcPageTableLoad(context, word) ntcPageTable.words[word]
#endif
#endif

#if !defined(NtcLaunchStateLoad) && (NTC_TILE_REQUESTS || NTC_TILE_STAMPS)
#if defined(__cplusplus)
#define NtcLaunchStateLoad(context, word) NtcLoadStreamingWord((context).memory->launchState, word)
#define NtcLaunchStateStore(context, word, value)                                                            \
    NtcStoreStreamingWord((context).memory->launchState, word, value)
#define NtcLaunchStateOr(context, word, bits) NtcOrStreamingWord((context).memory->launchState, word, bits)
#define NtcLaunchStateAdd(context, word, value)                                                              \
    NtcAddStreamingWord((context).memory->launchState, word, value)
#elif defined(NTC_HLSL)
[[vk::binding(NTC_LAUNCH_STATE_BINDING, NTC_STREAMING_SET)]] RWByteAddressBuffer ntcLaunchState
    : register(NTC_LAUNCH_STATE_REGISTER);
uint NtcOrLaunchState(uint word, uint bits) {
    uint before;
    ntcLaunchState.InterlockedOr(4u * word, bits, before);
    return before;
}
uint NtcAddLaunchState(uint word, uint value) {
    uint before;
    ntcLaunchState.InterlockedAdd(4u * word, value, before);
    return before;
}
#define NtcLaunchStateLoad(context, word) ntcLaunchState.Load(4u * (word))
#define NtcLaunchStateStore(context, word, value) ntcLaunchState.Store(4u * (word), value)
#define NtcLaunchStateOr(context, word, bits) NtcOrLaunchState(word, bits)
#define NtcLaunchStateAdd(context, word, value) NtcAddLaunchState(word, value)
#else
layout(set = NTC_STREAMING_SET, binding = NTC_LAUNCH_STATE_BINDING, std430) buffer NtcLaunchStateBlock {
    uint words[];
}
ntcLaunchState;
#define NtcLaunchStateLoad(context, word) ntcLaunchState.words[word]
#define NtcLaunchStateStore(context, word, value) ntcLaunchState.words[word] = value
#define NtcLaunchStateOr(context, word, bits) atomicOr(ntcLaunchState.words[word], bits)
#define NtcLaunchStateAdd(context, word, value) atomicAdd(ntcLaunchState.words[word], value)
#endif
#endif

/// What functions need of a texture's header, loaded by them; what a shader does not use is not read.
struct NtcTextureHeader {
    uint format; // NTC_TILES_NONE: no such texture
    int levels;
    int mips;
    int firstTailMip;
    uint firstEntry;
    uint tileCount;
    uint firstTailTile;
    uint width;
    uint height;
    uint tileWidth;
    uint tileHeight;
    uint sampling;
    float mipBias;
    uint firstSlot;
    uint word; // of the header in the page table
};

// Words of NtcTiledTexture.
#define NTC_HEADER_WORDS 88u
#define NTC_HEADER_POOL 10u
#define NTC_HEADER_SLOTS_WORD 12u
#define NTC_HEADER_SLOT_WORDS 13u
#define NTC_HEADER_FIRST_TAIL_ROW 14u
#define NTC_HEADER_TEXTURE_SET 15u
#define NTC_HEADER_WEIGHTS_OFFSET 16u
#define NTC_HEADER_CHANNELS 17u
#define NTC_HEADER_MIP_LEVELS 18u
#define NTC_HEADER_FIRST_REGION 20u
#define NTC_HEADER_REGIONS_XY 21u
#define NTC_HEADER_REGION_WIDTH 22u
#define NTC_HEADER_REGION_HEIGHT 23u
#define NTC_HEADER_LEVELS 24u

NTC_FUNCTION NtcTextureHeader NtcLoadTextureHeader(NtcStreamingContext context, uint textureId) {
    NtcTextureHeader header;
    header.word = context.launch.headersWord + textureId * NTC_HEADER_WORDS;
    header.format = uint(NTC_TILES_NONE);
    header.levels = 0;
    header.mips = 0;
    header.firstTailMip = 0;
    header.firstEntry = 0u;
    header.tileCount = 0u;
    header.firstTailTile = 0u;
    header.width = 1u;
    header.height = 1u;
    header.tileWidth = 1u;
    header.tileHeight = 1u;
    header.sampling = 0u;
    header.mipBias = 0.0f;
    header.firstSlot = 0u;
    if (textureId < context.launch.textureCount)
        header.format = NtcPageTableLoad(context, header.word + 9u);
    if (header.format != uint(NTC_TILES_NONE)) {
        header.firstEntry = NtcPageTableLoad(context, header.word);
        header.tileCount = NtcPageTableLoad(context, header.word + 1u);
        uint levelsMips = NtcPageTableLoad(context, header.word + 2u);
        header.levels = int(levelsMips & 255u);
        header.mips = int((levelsMips >> 8) & 255u);
        header.firstTailMip = int((levelsMips >> 16) & 255u);
        header.firstTailTile = NtcPageTableLoad(context, header.word + 3u);
        header.width = NtcPageTableLoad(context, header.word + 4u);
        header.height = NtcPageTableLoad(context, header.word + 5u);
        uint tileSize = NtcPageTableLoad(context, header.word + 6u);
        header.tileWidth = tileSize & 0xFFFFu;
        header.tileHeight = tileSize >> 16;
        header.sampling = NtcPageTableLoad(context, header.word + 7u);
        header.mipBias = asfloat(NtcPageTableLoad(context, header.word + 8u));
        header.firstSlot = NtcPageTableLoad(context, header.word + 11u);
    }
    return header;
}

NTC_NAMESPACE_END

#if defined(__cplusplus)
static_assert(sizeof(openntc::NtcTiledTexture) == 4 * NTC_HEADER_WORDS);
static_assert(offsetof(openntc::NtcTiledTexture, format) == 4 * 9);
static_assert(offsetof(openntc::NtcTiledTexture, firstSlot) == 4 * 11);
static_assert(offsetof(openntc::NtcTiledTexture, pool) == 4 * NTC_HEADER_POOL);
static_assert(offsetof(openntc::NtcTiledTexture, slotsWord) == 4 * NTC_HEADER_SLOTS_WORD);
static_assert(offsetof(openntc::NtcTiledTexture, slotWords) == 4 * NTC_HEADER_SLOT_WORDS);
static_assert(offsetof(openntc::NtcTiledTexture, firstTailRow) == 4 * NTC_HEADER_FIRST_TAIL_ROW);
static_assert(offsetof(openntc::NtcTiledTexture, textureSet) == 4 * NTC_HEADER_TEXTURE_SET);
static_assert(offsetof(openntc::NtcTiledTexture, weightsOffset) == 4 * NTC_HEADER_WEIGHTS_OFFSET);
static_assert(offsetof(openntc::NtcTiledTexture, channels) == 4 * NTC_HEADER_CHANNELS);
static_assert(offsetof(openntc::NtcTiledTexture, mipLevels0) == 4 * NTC_HEADER_MIP_LEVELS);
static_assert(offsetof(openntc::NtcTiledTexture, firstRegion) == 4 * NTC_HEADER_FIRST_REGION);
static_assert(offsetof(openntc::NtcTiledTexture, regionsXY) == 4 * NTC_HEADER_REGIONS_XY);
static_assert(offsetof(openntc::NtcTiledTexture, regionWidth) == 4 * NTC_HEADER_REGION_WIDTH);
static_assert(offsetof(openntc::NtcTiledTexture, regionHeight) == 4 * NTC_HEADER_REGION_HEIGHT);
static_assert(offsetof(openntc::NtcTiledTexture, levels) == 4 * NTC_HEADER_LEVELS);
#endif

#endif
