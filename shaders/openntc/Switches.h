// SPDX-License-Identifier: MIT
// The switches NTC_MATH (MathModes.h) and of fetching (WeightFetch.h, LatentFetch.h): defaults, checks, and
// what gets compiled. The switches of effects are in Effects.h.
#ifndef OPENNTC_SWITCHES_H
#define OPENNTC_SWITCHES_H

#include "InferenceConstants.h"
#include "LatentFetch.h"
#include "MathModes.h"
#include "Portability.h"
#include "WeightFetch.h"

#ifndef NTC_MATH
#define NTC_MATH NTC_MATH_INT8
#endif
#if NTC_MATH < NTC_MATH_INT8 || NTC_MATH > NTC_MATH_COOPMAT_INT8_HALF
#error NTC_MATH must be NTC_MATH_INT8, _INT8_HALF, _FP8, _FP16, _FP32, _COOPVEC_INT8, _COOPVEC_FP8, _COOPMAT_INT8 or _COOPMAT_INT8_HALF
#endif

// Matrices are a matter of whole subgroups: there is no NtcSampleTextureSet in these modes.
#if NTC_MATH == NTC_MATH_COOPMAT_INT8 || NTC_MATH == NTC_MATH_COOPMAT_INT8_HALF
#define NTC_WITH_COOPMAT 1
#if defined(__cplusplus) || defined(NTC_HLSL)
#error NTC_MATH: NTC_MATH_COOPMAT_INT8 and NTC_MATH_COOPMAT_INT8_HALF exist in GLSL only
#elif !defined(NTC_DECODES_BLOCKS)
#error NTC_MATH: NTC_MATH_COOPMAT_INT8 and NTC_MATH_COOPMAT_INT8_HALF are for compute passes that decode blocks of texels with NetworkCoopMat.h and define NTC_DECODES_BLOCKS
#endif
#else
#define NTC_WITH_COOPMAT 0
#endif

// Where latents come from: two grids of one latent image (generation 1), or two latent mips (generations 2
// and 3). In C++ both are compiled, in a shader what its network needs.
#if defined(__cplusplus) || !defined(NETWORK_VERSION)
#define NTC_WITH_LATENT_GRIDS 1
#elif NETWORK_VERSION <= NTC_NETWORK_XLARGE
#define NTC_WITH_LATENT_GRIDS 1
#else
#define NTC_WITH_LATENT_GRIDS 0
#endif
#if defined(__cplusplus) || !NTC_WITH_LATENT_GRIDS
#define NTC_WITH_LATENT_MIPS 1
#else
#define NTC_WITH_LATENT_MIPS 0
#endif

#ifndef NTC_LATENT_FETCH
#define NTC_LATENT_FETCH NTC_LATENTS_BUFFER
#endif
#if NTC_LATENT_FETCH != NTC_LATENTS_BUFFER && NTC_LATENT_FETCH != NTC_LATENTS_TEXTURE
#error NTC_LATENT_FETCH must be NTC_LATENTS_BUFFER or NTC_LATENTS_TEXTURE
#endif
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE && NTC_WITH_LATENT_GRIDS
#error NTC_LATENT_FETCH: NTC_LATENTS_TEXTURE is for shaders of the networks of generations 2 and 3
#endif

// Layers 1 and 2 have one shape, so that drivers need to compile their code once only.
#if !defined(__cplusplus) && defined(NETWORK_VERSION)
#if NETWORK_VERSION != NTC_NETWORK_GENERATION_3
#define NTC_WITH_EQUAL_LAYERS 1
#endif
#endif
#ifndef NTC_WITH_EQUAL_LAYERS
#define NTC_WITH_EQUAL_LAYERS 0
#endif

// What gets compiled: in C++ everything, in a shader what its mode needs.
#if defined(__cplusplus) || NTC_MATH == NTC_MATH_INT8 || NTC_MATH == NTC_MATH_INT8_HALF ||                   \
    NTC_MATH == NTC_MATH_COOPVEC_INT8
#define NTC_WITH_INT8_INPUTS 1
#else
#define NTC_WITH_INT8_INPUTS 0
#endif
#if defined(__cplusplus) || NTC_MATH == NTC_MATH_FP8
#define NTC_WITH_FP8 1
#else
#define NTC_WITH_FP8 0
#endif
#if defined(__cplusplus) || NTC_MATH == NTC_MATH_FP16
#define NTC_WITH_FP16 1
#else
#define NTC_WITH_FP16 0
#endif
#if defined(__cplusplus) || NTC_MATH == NTC_MATH_FP32
#define NTC_WITH_FP32 1
#else
#define NTC_WITH_FP32 0
#endif

#if NTC_MATH == NTC_MATH_COOPVEC_INT8 || NTC_MATH == NTC_MATH_COOPVEC_FP8
#define NTC_WITH_COOPVEC 1
#else
#define NTC_WITH_COOPVEC 0
#endif

#if NTC_WITH_FP8 || NTC_WITH_FP16 || NTC_WITH_FP32 || NTC_MATH == NTC_MATH_COOPVEC_FP8
#define NTC_WITH_REAL_INPUTS 1
#else
#define NTC_WITH_REAL_INPUTS 0
#endif

#ifndef NTC_WEIGHT_FETCH
#define NTC_WEIGHT_FETCH NTC_FETCH_DIRECT
#endif
#ifndef NTC_TEXELS_PER_INVOCATION
#define NTC_TEXELS_PER_INVOCATION 1
#endif
#ifndef NTC_FLOAT_DOT
#define NTC_FLOAT_DOT 0
#endif
#ifndef NTC_WIDE_WEIGHT_LOADS
#define NTC_WIDE_WEIGHT_LOADS 0
#endif

#if NTC_WEIGHT_FETCH < NTC_FETCH_DIRECT || NTC_WEIGHT_FETCH > NTC_FETCH_SUBGROUP
#error NTC_WEIGHT_FETCH must be NTC_FETCH_DIRECT, NTC_FETCH_UNIFORM or NTC_FETCH_SUBGROUP
#endif
#if NTC_TEXELS_PER_INVOCATION < 1 || NTC_TEXELS_PER_INVOCATION > 8
#error NTC_TEXELS_PER_INVOCATION must be 1 to 8
#endif
#if NTC_WEIGHT_FETCH != NTC_FETCH_DIRECT && (defined(__cplusplus) || defined(NTC_HLSL))
#error NTC_WEIGHT_FETCH must be NTC_FETCH_DIRECT in C++ and HLSL
#endif
#if NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP && !defined(NTC_SUBGROUP_DECODES_ONE_SET)
#error NTC_WEIGHT_FETCH: NTC_FETCH_SUBGROUP needs NTC_SUBGROUP_DECODES_ONE_SET: all lanes are active and decode the same texture set
#endif
#if NTC_WEIGHT_FETCH == NTC_FETCH_UNIFORM && defined(NtcBufferLoad)
#error NTC_WEIGHT_FETCH: NTC_FETCH_UNIFORM works with the default bindings only: NtcBufferLoad must not be defined
#endif

// The network of NetworkTexels.h in the place of Network.h's.
#if !defined(__cplusplus) && (NTC_WEIGHT_FETCH != NTC_FETCH_DIRECT || NTC_TEXELS_PER_INVOCATION > 1 ||       \
                              NTC_FLOAT_DOT != 0 || NTC_WIDE_WEIGHT_LOADS != 0)
#define NTC_WITH_NETWORK_TEXELS 1
#else
#define NTC_WITH_NETWORK_TEXELS 0
#endif

#if NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#endif

#endif
