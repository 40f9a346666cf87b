// SPDX-License-Identifier: MIT
// The maths modes: values of the NTC_MATH macro and of the `math` parameters.
//
//   mode        weights   what is computed
//   INT8        Int8      integer layers, binary32 between them: the exact contract
//   INT8_HALF   Int8      integer layers, binary16 between them and for the outputs
//   FP8         FP8       E4M3 inputs and weights, summed in binary32, binary16 between the layers; last
//                         layer Int8
//   FP16        Int8      no quantiser but the weights': latents, waves and activations in binary16
//   FP32        Int8      the same in binary32: the accuracy reference
//   COOPVEC_INT8, COOPVEC_FP8   INT8 and FP8 with cooperative vectors, GLSL only: see InferenceCoopVec.h
//
// Every mode gives the same bits in every language and on every device: operations are rounded once and in a
// defined order, binary16 by bit operations. Weights: the buffer and constants that MakeInferenceData makes
// for GenericInt8 or GenericFP8.
#ifndef OPENNTC_MATH_MODES_H
#define OPENNTC_MATH_MODES_H

#define NTC_MATH_INT8 1
#define NTC_MATH_INT8_HALF 2
#define NTC_MATH_FP8 3
#define NTC_MATH_FP16 4
#define NTC_MATH_FP32 5
#define NTC_MATH_COOPVEC_INT8 6
#define NTC_MATH_COOPVEC_FP8 7

#ifndef NTC_MATH
#define NTC_MATH NTC_MATH_INT8
#endif
#if NTC_MATH < NTC_MATH_INT8 || NTC_MATH > NTC_MATH_COOPVEC_FP8
#error NTC_MATH must be NTC_MATH_INT8, _INT8_HALF, _FP8, _FP16, _FP32, _COOPVEC_INT8 or _COOPVEC_FP8
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

#endif
