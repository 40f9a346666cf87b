// SPDX-License-Identifier: MIT
// Sizes of the network that is trained, and where its weights are. NTC_TRAIN_GENERATION: 1 (default) or 3, of
// files; NTC_TRAIN_INPUTS: inputs of the first layer, 64 or 96, in generation 3 32 or 64.
#ifndef OPENNTC_TRAIN_SHAPE_H
#define OPENNTC_TRAIN_SHAPE_H

#ifndef NTC_TRAIN_GENERATION
#define NTC_TRAIN_GENERATION 1
#endif
#if NTC_TRAIN_GENERATION == 3
#define NTC_TRAIN_TAPER 16 // outputs that each layer has less
#else
#define NTC_TRAIN_TAPER 0
#endif
// Outputs of a layer, in whole tiles of 16.
#define NTC_TRAIN_OUTPUT_TILES(layer) ((layer) == 3 ? 1 : 4 - (NTC_TRAIN_TAPER / 16) * (layer))
#define NTC_TRAIN_OUTPUTS(layer) (16u * uint(NTC_TRAIN_OUTPUT_TILES(layer)))
// Inputs of the first layer that are not padding, in whole tiles of 16.
#if NTC_TRAIN_GENERATION == 3 && NTC_TRAIN_INPUTS == 64
#define NTC_TRAIN_USED 48
#else
#define NTC_TRAIN_USED NTC_TRAIN_INPUTS
#endif

const uint kLayer1 = 64u * uint(NTC_TRAIN_INPUTS); // first weight of a layer
const uint kLayer2 = kLayer1 + 64u * NTC_TRAIN_OUTPUTS(1);
const uint kLayer3 = kLayer2 + NTC_TRAIN_OUTPUTS(1) * NTC_TRAIN_OUTPUTS(2);
const uint kWeights = kLayer3 + NTC_TRAIN_OUTPUTS(2) * 16u;

#endif
