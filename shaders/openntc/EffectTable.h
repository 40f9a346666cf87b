// SPDX-License-Identifier: MIT
// The one table of a decoder's effects, for shaders (Effects.h, which says what they do) and for C++
// (permutation/PermutationDefines.h). No language's own header is included here.
#ifndef OPENNTC_EFFECT_TABLE_H
#define OPENNTC_EFFECT_TABLE_H

#define NTC_LINEARISE_NONE 0
#define NTC_LINEARISE_RUNTIME 1
#define NTC_LINEARISE_CHANNELS 2

// X(name, macro, value when not defined, rule): the one list of effects. Values are 32 bits. The rule says
// which compiled values serve a wanted one with the same texels (EffectRule in C++; shaders do not look at
// it):
//   Superset     every wanted bit is compiled
//   AtLeast      the compiled value is the wanted one or larger
//   AtMost       the compiled value is the wanted one or smaller
//   Linearise    RUNTIME serves everything; CHANNELS serves itself and NONE, which requests nothing
//   ColorSpaces  the same channels with the same colour spaces, where both say CHANNELS
#define NTC_EFFECT_TABLE(X)                                                                                  \
    X(OutputMask, NTC_OUTPUT_MASK, 0xFFFF, Superset)                                                         \
    X(Linearise, NTC_LINEARISE, 1, Linearise)                                                                \
    X(ChannelColorSpaces, NTC_CHANNEL_COLOR_SPACES, 0, ColorSpaces)                                          \
    X(SingleMip, NTC_SINGLE_MIP, 0, AtMost)                                                                  \
    X(LatentSlices, NTC_LATENT_SLICES, 1, AtLeast)                                                           \
    X(ClampTexels, NTC_CLAMP_TEXELS, 1, AtLeast)                                                             \
    X(TileFallback, NTC_TILE_FALLBACK, 1, AtLeast)                                                           \
    X(TileRequests, NTC_TILE_REQUESTS, 1, AtLeast)                                                           \
    X(TileStamps, NTC_TILE_STAMPS, 1, AtLeast)                                                               \
    X(TileFeedback, NTC_TILE_FEEDBACK, 1, AtLeast)                                                           \
    X(TileRates, NTC_TILE_RATES, 1, AtLeast)

#define NTC_EFFECT_OUTPUT_MASK 0
#define NTC_EFFECT_LINEARISE 1
#define NTC_EFFECT_CHANNEL_COLOR_SPACES 2
#define NTC_EFFECT_SINGLE_MIP 3
#define NTC_EFFECT_LATENT_SLICES 4
#define NTC_EFFECT_CLAMP_TEXELS 5
#define NTC_EFFECT_TILE_FALLBACK 6
#define NTC_EFFECT_TILE_REQUESTS 7
#define NTC_EFFECT_TILE_STAMPS 8
#define NTC_EFFECT_TILE_FEEDBACK 9
#define NTC_EFFECT_TILE_RATES 10
#define NTC_EFFECT_COUNT 11

#endif
