// SPDX-License-Identifier: MIT
// How shaders read the network's weights: values of NTC_WEIGHT_FETCH, and texels per invocation. Same bits in
// every form.
//
//   NTC_WEIGHT_FETCH
//     NTC_FETCH_DIRECT    loads from the weights' storage buffer; works everywhere
//     NTC_FETCH_UNIFORM   the weights are a uniform buffer at the same binding (GLSL, default bindings):
//                         9472 to 17024 bytes; weightsOffset is 0
//     NTC_FETCH_SUBGROUP  8 lanes load 8 different words and pass them round with subgroupShuffle (GLSL).
//                         Only where all lanes of a subgroup are active and decode the same texture set,
//                         which the host promises by NTC_SUBGROUP_DECODES_ONE_SET; subgroups of at least 8
//                         lanes
//   NTC_TEXELS_PER_INVOCATION   1 ... 8: texels that NtcSampleTextureSetTexels decodes with one pass over the
//                               weights
//   NTC_FLOAT_DOT               1: dot products in binary32, which is exact here (|sum| < 2^24) and faster
//                               where integer multiplication is slow (lavapipe)
//   NTC_WIDE_WEIGHT_LOADS       1: 16 bytes a load with NTC_FETCH_DIRECT and NTC_FETCH_SUBGROUP;
//                               weightsOffset is then a multiple of 16
//
// Defaults by device, as PermutationKey.h chooses them. GPUs with integer dot products (measured on an H100,
// docs/benchmarks): DIRECT with NTC_WIDE_WEIGHT_LOADS where weights are aligned, 2 texels in passes that
// decode blocks (1 for INT8_HALF), 1 in material shaders. Drivers that compile to the CPU (measured on
// lavapipe, docs/shaders.md): SUBGROUP with NTC_FLOAT_DOT, with NTC_WIDE_WEIGHT_LOADS where weights are
// aligned, and 2 texels, 1 in material shaders: 5 to 8 times as fast as scalar DIRECT. Scalar DIRECT where
// subgroups may be incomplete: wide loads are faster there too, but their machine code takes twice as long to
// generate. Other devices: scalar DIRECT.
//
// The forms other than DIRECT with one texel are for the maths modes INT8 and INT8_HALF.
//
// Numbers only: C++ includes this file too. Defaults and what follows from them are in Switches.h.
#ifndef OPENNTC_WEIGHT_FETCH_H
#define OPENNTC_WEIGHT_FETCH_H

#define NTC_FETCH_DIRECT 1
#define NTC_FETCH_UNIFORM 2
#define NTC_FETCH_SUBGROUP 3

#endif
