// SPDX-License-Identifier: MIT
// The effects of a decoder, one switch each: what a scene does not call for is left out of the shader.
//
// A switch is a macro defined before the first include; without any, a shader does everything, and every
// output that it computes has the same bits whatever the other switches say. From C++ the host's SceneNeeds
// lead to the switches (permutation/PermutationKey.h). What a shader was promised and does not find in the
// constants makes sampling return false, never a wrong texel.
//
//   NTC_OUTPUT_MASK    bit c: output c is read. Other outputs are not evaluated and are 0. 0x1 ... 0xFFFF.
//   NTC_LINEARISE      NTC_LINEARISE_RUNTIME   on request, by the colour spaces in the constants
//                      NTC_LINEARISE_NONE      no code for it; a request returns false
//                      NTC_LINEARISE_CHANNELS  on request, code for exactly the channels that
//                                              NTC_CHANNEL_COLOR_SPACES says are sRGB or HLG (2 bits per
//                                              channel, as in the constants; false if the constants differ in
//                                              an output that is read)
//   NTC_SINGLE_MIP     1: mip 0, and latent image 0, only. Other mips return false. The constants may then be
//                      the 160 bytes of NtcSingleMipConstants, in push constants for example.
//   NTC_LATENT_SLICES  0: latent images are whole, so there is no slice to subtract. A sliced one returns
//                      false.
//   NTC_CLAMP_TEXELS   0: the caller promises texels inside the mip. Texels outside decode to something,
//                      safely.
//
// Of shaders that read tiles (streaming/); others do not look at them:
//
//   NTC_TILE_FALLBACK  0: a missing tile is not there; no walk to coarser mips. resident says the same, the
//                      mip sampled instead is -1 and the colour 0.
//   NTC_TILE_REQUESTS  0: missing tiles are not requested
//   NTC_TILE_STAMPS    0: slots that are read are not stamped: a loader goes by when tiles came. With
//                      neither requests nor stamps there is no buffer of launch state.
//   NTC_TILE_FEEDBACK  0: NtcRecordFeedback, NtcRecordLod and NtcRecordTexel do nothing; there is no buffer
//                      of feedback
//   NTC_TILE_RATES     0: requests and feedback at rate 1, whatever the launch says
//
// They are switches of shaders. The C++ build of this source decodes everything; there would be several
// definitions of one inline function otherwise.
#ifndef OPENNTC_EFFECTS_H
#define OPENNTC_EFFECTS_H

#include "EffectTable.h"

#ifndef NTC_OUTPUT_MASK
#define NTC_OUTPUT_MASK 0xFFFF
#endif
#ifndef NTC_LINEARISE
#define NTC_LINEARISE NTC_LINEARISE_RUNTIME
#endif
#ifndef NTC_CHANNEL_COLOR_SPACES
#if NTC_LINEARISE == NTC_LINEARISE_CHANNELS
#error NTC_CHANNEL_COLOR_SPACES is not defined: NTC_LINEARISE_CHANNELS needs it
#endif
#define NTC_CHANNEL_COLOR_SPACES 0
#endif
#ifndef NTC_SINGLE_MIP
#define NTC_SINGLE_MIP 0
#endif
#ifndef NTC_LATENT_SLICES
#define NTC_LATENT_SLICES 1
#endif
#ifndef NTC_CLAMP_TEXELS
#define NTC_CLAMP_TEXELS 1
#endif
#ifndef NTC_TILE_FALLBACK
#define NTC_TILE_FALLBACK 1
#endif
#ifndef NTC_TILE_REQUESTS
#define NTC_TILE_REQUESTS 1
#endif
#ifndef NTC_TILE_STAMPS
#define NTC_TILE_STAMPS 1
#endif
#ifndef NTC_TILE_FEEDBACK
#define NTC_TILE_FEEDBACK 1
#endif
#ifndef NTC_TILE_RATES
#define NTC_TILE_RATES 1
#endif

#if NTC_OUTPUT_MASK < 1 || NTC_OUTPUT_MASK > 0xFFFF
#error NTC_OUTPUT_MASK must be 0x1 ... 0xFFFF: bit c for every output c that is read
#endif
#if NTC_LINEARISE != NTC_LINEARISE_NONE && NTC_LINEARISE != NTC_LINEARISE_RUNTIME &&                         \
    NTC_LINEARISE != NTC_LINEARISE_CHANNELS
#error NTC_LINEARISE must be NTC_LINEARISE_NONE, NTC_LINEARISE_RUNTIME or NTC_LINEARISE_CHANNELS
#endif
#if NTC_SINGLE_MIP != 0 && NTC_SINGLE_MIP != 1
#error NTC_SINGLE_MIP must be 0 or 1
#endif
#if NTC_LATENT_SLICES != 0 && NTC_LATENT_SLICES != 1
#error NTC_LATENT_SLICES must be 0 or 1
#endif
#if NTC_CLAMP_TEXELS != 0 && NTC_CLAMP_TEXELS != 1
#error NTC_CLAMP_TEXELS must be 0 or 1
#endif
#if NTC_TILE_FALLBACK != 0 && NTC_TILE_FALLBACK != 1
#error NTC_TILE_FALLBACK must be 0 or 1
#endif
#if NTC_TILE_REQUESTS != 0 && NTC_TILE_REQUESTS != 1
#error NTC_TILE_REQUESTS must be 0 or 1
#endif
#if NTC_TILE_STAMPS != 0 && NTC_TILE_STAMPS != 1
#error NTC_TILE_STAMPS must be 0 or 1
#endif
#if NTC_TILE_FEEDBACK != 0 && NTC_TILE_FEEDBACK != 1
#error NTC_TILE_FEEDBACK must be 0 or 1
#endif
#if NTC_TILE_RATES != 0 && NTC_TILE_RATES != 1
#error NTC_TILE_RATES must be 0 or 1
#endif
#if defined(__cplusplus) && (NTC_OUTPUT_MASK != 0xFFFF || NTC_LINEARISE != NTC_LINEARISE_RUNTIME ||          \
                             NTC_SINGLE_MIP != 0 || NTC_LATENT_SLICES != 1 || NTC_CLAMP_TEXELS != 1)
#error NTC_OUTPUT_MASK, NTC_LINEARISE, NTC_SINGLE_MIP, NTC_LATENT_SLICES and NTC_CLAMP_TEXELS are switches of shaders, not of C++
#endif
#if defined(__cplusplus) &&                                                                                  \
    !(NTC_TILE_FALLBACK && NTC_TILE_REQUESTS && NTC_TILE_STAMPS && NTC_TILE_FEEDBACK && NTC_TILE_RATES)
#error NTC_TILE_FALLBACK, NTC_TILE_REQUESTS, NTC_TILE_STAMPS, NTC_TILE_FEEDBACK and NTC_TILE_RATES are switches of shaders, not of C++
#endif

#include "Portability.h"

// Outputs that are read lie in NTC_FIRST_OUTPUT ... NTC_END_OUTPUT - 1, so that a loop over them stays rolled
// and short.
#if NTC_OUTPUT_MASK & 0x1
#define NTC_FIRST_OUTPUT 0u
#elif NTC_OUTPUT_MASK & 0x2
#define NTC_FIRST_OUTPUT 1u
#elif NTC_OUTPUT_MASK & 0x4
#define NTC_FIRST_OUTPUT 2u
#elif NTC_OUTPUT_MASK & 0x8
#define NTC_FIRST_OUTPUT 3u
#elif NTC_OUTPUT_MASK & 0x10
#define NTC_FIRST_OUTPUT 4u
#elif NTC_OUTPUT_MASK & 0x20
#define NTC_FIRST_OUTPUT 5u
#elif NTC_OUTPUT_MASK & 0x40
#define NTC_FIRST_OUTPUT 6u
#elif NTC_OUTPUT_MASK & 0x80
#define NTC_FIRST_OUTPUT 7u
#elif NTC_OUTPUT_MASK & 0x100
#define NTC_FIRST_OUTPUT 8u
#elif NTC_OUTPUT_MASK & 0x200
#define NTC_FIRST_OUTPUT 9u
#elif NTC_OUTPUT_MASK & 0x400
#define NTC_FIRST_OUTPUT 10u
#elif NTC_OUTPUT_MASK & 0x800
#define NTC_FIRST_OUTPUT 11u
#elif NTC_OUTPUT_MASK & 0x1000
#define NTC_FIRST_OUTPUT 12u
#elif NTC_OUTPUT_MASK & 0x2000
#define NTC_FIRST_OUTPUT 13u
#elif NTC_OUTPUT_MASK & 0x4000
#define NTC_FIRST_OUTPUT 14u
#else
#define NTC_FIRST_OUTPUT 15u
#endif
#if NTC_OUTPUT_MASK < 0x2
#define NTC_END_OUTPUT 1u
#elif NTC_OUTPUT_MASK < 0x4
#define NTC_END_OUTPUT 2u
#elif NTC_OUTPUT_MASK < 0x8
#define NTC_END_OUTPUT 3u
#elif NTC_OUTPUT_MASK < 0x10
#define NTC_END_OUTPUT 4u
#elif NTC_OUTPUT_MASK < 0x20
#define NTC_END_OUTPUT 5u
#elif NTC_OUTPUT_MASK < 0x40
#define NTC_END_OUTPUT 6u
#elif NTC_OUTPUT_MASK < 0x80
#define NTC_END_OUTPUT 7u
#elif NTC_OUTPUT_MASK < 0x100
#define NTC_END_OUTPUT 8u
#elif NTC_OUTPUT_MASK < 0x200
#define NTC_END_OUTPUT 9u
#elif NTC_OUTPUT_MASK < 0x400
#define NTC_END_OUTPUT 10u
#elif NTC_OUTPUT_MASK < 0x800
#define NTC_END_OUTPUT 11u
#elif NTC_OUTPUT_MASK < 0x1000
#define NTC_END_OUTPUT 12u
#elif NTC_OUTPUT_MASK < 0x2000
#define NTC_END_OUTPUT 13u
#elif NTC_OUTPUT_MASK < 0x4000
#define NTC_END_OUTPUT 14u
#elif NTC_OUTPUT_MASK < 0x8000
#define NTC_END_OUTPUT 15u
#else
#define NTC_END_OUTPUT 16u
#endif

// bool: is output `c` (uint) of that range read? Of a mask without gaps, all are, and the test costs no
// instruction.
#if ((NTC_OUTPUT_MASK + (NTC_OUTPUT_MASK & (0x10000 - NTC_OUTPUT_MASK))) & NTC_OUTPUT_MASK) == 0
#define NtcIsOutputRead(c) true
#else
#define NtcIsOutputRead(c) (((uint(NTC_OUTPUT_MASK) >> (c)) & 1u) != 0u)
#endif

// Before the output layer: what nobody reads is 0.
#if NTC_OUTPUT_MASK != 0xFFFF
#define NTC_CLEAR_UNREAD_OUTPUTS(outputs)                                                                    \
    NTC_LOOP for (uint unread = 0u; unread < 16u; unread++) outputs[unread] = 0.0f
#else
#define NTC_CLEAR_UNREAD_OUTPUTS(outputs)
#endif

// uint: channels whose colour space is sRGB (1) or HLG (2), in bit 2c. In code:
// FXC's #if knows neither ~ nor shifts.
#define NTC_SRGB_BITS (uint(NTC_CHANNEL_COLOR_SPACES) & ~(uint(NTC_CHANNEL_COLOR_SPACES) >> 1) & 0x55555555u)
#define NTC_HLG_BITS (~uint(NTC_CHANNEL_COLOR_SPACES) & (uint(NTC_CHANNEL_COLOR_SPACES) >> 1) & 0x55555555u)

NTC_NAMESPACE_BEGIN

#if NTC_LINEARISE == NTC_LINEARISE_CHANNELS
/// Bits 2c and 2c + 1 of every output c that is read.
NTC_FUNCTION uint NtcGetReadColorSpaceBits() {
    uint bits = uint(NTC_OUTPUT_MASK);
    bits = (bits | (bits << 8)) & 0x00FF00FFu;
    bits = (bits | (bits << 4)) & 0x0F0F0F0Fu;
    bits = (bits | (bits << 2)) & 0x33333333u;
    bits = (bits | (bits << 1)) & 0x55555555u;
    return bits | (bits << 1);
}
#endif

// bool: does the shader have code for what is asked of it and for what the constants say about outputs that
// are read?
#if NTC_LINEARISE == NTC_LINEARISE_NONE
#define NtcCanLinearise(convertToLinear, channelColorSpaces) (!(convertToLinear))
#elif NTC_LINEARISE == NTC_LINEARISE_CHANNELS
#define NtcCanLinearise(convertToLinear, channelColorSpaces)                                                 \
    (!(convertToLinear) ||                                                                                   \
     (((channelColorSpaces) ^ uint(NTC_CHANNEL_COLOR_SPACES)) & NtcGetReadColorSpaceBits()) == 0u)
#else
#define NtcCanLinearise(convertToLinear, channelColorSpaces) true
#endif

#if !defined(__cplusplus)
/// The value that an effect (NTC_EFFECT_*) has in this shader.
NTC_FUNCTION uint NtcGetEffect(uint effect) {
    uint values[NTC_EFFECT_COUNT];
    uint count = 0u;
#define NTC_STORE_EFFECT(name, macro, fallback, rule)                                                        \
    values[count] = uint(macro);                                                                             \
    count += 1u;
    NTC_EFFECT_TABLE(NTC_STORE_EFFECT)
#undef NTC_STORE_EFFECT
    return effect < count ? values[effect] : 0u;
}
#endif

NTC_NAMESPACE_END

#endif
