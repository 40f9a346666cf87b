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
//   COOPMAT_INT8, COOPMAT_INT8_HALF   INT8 and INT8_HALF with cooperative matrices, their bits; GLSL only,
//                         for passes that decode whole blocks of texels: see NetworkCoopMat.h
//
// Every emulated mode (the first five) gives the same bits in every language and on every device whose
// compiler keeps what the source says: operations are rounded once and in a defined order, binary16 by bit
// operations. glslang, DXC and FXC keep it by `precise`. Slang's SPIR-V, GLSL ES, WGSL and Metal have no
// such promise: there the roundings hold with NTC_OPAQUE_ZERO (Portability.h), and texels are wrong without.
// Subnormal numbers may be flushed to zero. Weights: the buffer and constants that MakeInferenceData makes
// for GenericInt8 or GenericFP8.
//
// Numbers only: C++ includes this file too. The default and what follows from it is in Switches.h.
#ifndef OPENNTC_MATH_MODES_H
#define OPENNTC_MATH_MODES_H

#define NTC_MATH_INT8 1
#define NTC_MATH_INT8_HALF 2
#define NTC_MATH_FP8 3
#define NTC_MATH_FP16 4
#define NTC_MATH_FP32 5
#define NTC_MATH_COOPVEC_INT8 6
#define NTC_MATH_COOPVEC_FP8 7
#define NTC_MATH_COOPMAT_INT8 8
#define NTC_MATH_COOPMAT_INT8_HALF 9

#endif
