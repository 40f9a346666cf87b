// SPDX-License-Identifier: MIT
// Compute pass: forward and backward pass of a batch of texels, for the encoder. It gives each workgroup's
// sums of the gradients of weights and biases and of squared errors (to Partials), and the gradients of
// latents as whole numbers. TrainUpdate makes a step of them.
//
// The forward pass computes the decoder's integers, which are exact in binary16: inputs, activations 0 ...
// 240 and weights -127 ... 127, and sums below 2^24 in binary32. Gradients of a layer's sums are kept in
// binary16, times the row's largest weight, so that one matrix of integers serves both ways.
//
// Set 0, storage buffers: 0 NtcTrainConstants, 1 NtcTrainMip, 2 taps (two pixels, bits of the second one's
// weight), 3 tiles (mip, x | y << 16), 4 references (16 bits, [tile][channel][128], of all tiles or with
// NTC_TRAIN_STREAMED of those that a submission visits, in its order), 5 list of tiles, 6 weights (binary16,
// tiles of 16 inputs x 16 outputs, in each [output][input]: matrices are loaded from rows without gaps), 7
// rows (scales, biases, largest weights: three times NTC_TRAIN_ROWS), 8 latents, 9 their gradients, 10
// Partials. Push constants: NtcTrainStep; dispatch NtcTrainStep::groups workgroups. NTC_TRAIN_INPUTS and
// NTC_TRAIN_GENERATION: encode/TrainShape.h. Taps of generation 3, where latents wrap around: two pixels,
// then the second one's weight in 1/256 and, << 16, 1 more than what the first one was before. NTC_MATH=8: on
// cooperative matrices (binary16, 16 x 16 x 16, subgroups of 32 lanes that are full; Vulkan 1.3).
//
// NTC_TRAIN_TRIES=1: only forward, over NtcTrainStep::tiles tiles from NtcTrainStep::firstTile on, with
// rounded latents of which a class of pixels may be moved (NTC_TRAIN_MOVE): losses of texels, [tile][128],
// to 17, without a move to 16. TrainMoves decides.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/encode/TrainConstants.h"
#ifndef NTC_TRAIN_TRIES
#define NTC_TRAIN_TRIES 0
#endif

layout(local_size_x = NTC_TRAIN_GROUP) in;

layout(set = 0, binding = 0, std430) readonly buffer Constants {
    NtcTrainConstants gConstants;
};
layout(set = 0, binding = 1, std430) readonly buffer Mips {
    NtcTrainMip mips[];
} gMips;
layout(set = 0, binding = 2, std430) readonly buffer Taps {
    uvec2 taps[];
} gTaps;
layout(set = 0, binding = 3, std430) readonly buffer Tiles {
    uvec2 records[];
} gTiles;
layout(set = 0, binding = 4, std430) readonly buffer References {
    uint words[];
} gReferences;
#if !NTC_TRAIN_TRIES
layout(set = 0, binding = 5, std430) readonly buffer Batch {
    uint tiles[];
} gBatch;
#endif
layout(set = 0, binding = 6, std430) readonly buffer Weights {
    uvec4 vectors[];
} gWeights;
layout(set = 0, binding = 7, std430) readonly buffer Rows {
    float values[];
} gRows;
layout(set = 0, binding = 8, std430) readonly buffer Latents {
    float values[];
} gLatents;
#if NTC_TRAIN_TRIES
layout(set = 0, binding = 16, std430) writeonly buffer Kept {
    float values[];
} gKept;
layout(set = 0, binding = 17, std430) writeonly buffer Tried {
    float values[];
} gTried;
#else
layout(set = 0, binding = 9, std430) buffer LatentGradients {
    int values[];
} gLatentGradients;
layout(set = 0, binding = 10, std430) writeonly buffer Partials {
    float values[];
} gPartials;
#endif
layout(push_constant) uniform TrainPush {
    NtcTrainStep gStep;
};

#include "openntc/encode/TrainShape.h"
#include "openntc/encode/TrainMatrices.h"
#include "openntc/encode/TrainLatents.h"
#if NTC_TRAIN_GENERATION == 3
#include "openntc/encode/TrainBlends.h"
#else
#include "openntc/encode/TrainCorners.h"
#endif
#include "openntc/encode/TrainLoss.h"

#if !NTC_TRAIN_TRIES
// A lane has two neighbouring outputs of four texels of a layer, and two outputs of one texel of the last.
vec2 gSlopes[3][4];
vec2 gBiasSums[3];
vec2 gLastBiasSums, gSquares;
// Gradients of weights in tiles of 16 x 16, layer after layer: a subgroup has every eighth of all.
const uint kTiles1 = uint(NTC_TRAIN_USED) / 4u; // first tile of a layer
const uint kTiles2 = kTiles1 + 4u * uint(NTC_TRAIN_OUTPUT_TILES(1));
const uint kTiles3 = kTiles2 + uint(NTC_TRAIN_OUTPUT_TILES(1) * NTC_TRAIN_OUTPUT_TILES(2));
const uint kTiles = kTiles3 + uint(NTC_TRAIN_OUTPUT_TILES(2));
const uint kPaddingTiles = (kLayer1 - 64u * uint(NTC_TRAIN_USED)) / 256u; // of the first layer, not trained
const uint kSlots = (kTiles + 7u) / 8u;                                   // of a subgroup
NtcMatC gGradients[kSlots];
#endif

uint NtcLaneOutput() {
    return 2u * (gl_LocalInvocationIndex & 31u);
}
uint NtcLaneTexel(uint k) {
    return (gl_LocalInvocationIndex >> 5) + 8u * k;
}

/// 4, or 0 of a lane whose outputs a narrower layer lacks.
uint NtcLaneTexels(uint layer) {
#if NTC_TRAIN_TAPER > 0
    if (NtcLaneOutput() >= NTC_TRAIN_OUTPUTS(int(layer)))
        return 0u;
#endif
    return 4u;
}

/// First vector of a tile of weights, [output][input], of a layer whose first weight is `weights`.
uint NtcWeightTile(uint weights, uint inputTile, uint outputTiles, uint outputTile) {
    return weights / 8u + 32u * (inputTile * outputTiles + outputTile);
}

/// Sums of a layer of `inputs`: 16 texels x 16 outputs a subgroup.
void NtcMultiply(uint layer, uint inputs, uint weights, uint outputTiles) {
    uint subgroup = NtcTrainSubgroup(), m = subgroup >> 2, n = subgroup & 3u;
    if (outputTiles == 4u || n < outputTiles) {
        NtcMatC c = NTC_MAT_ZERO;
        [[unroll]] for (uint k = 0u; k < inputs / 16u; k++)
            NTC_MAT_FORWARD(c, NtcTrainRows(layer) + 16u * m * NtcTrainStride(layer) + 2u * k,
                            NtcTrainStride(layer), NtcWeightTile(weights, k, outputTiles, n))
        NTC_MAT_STORE_SUMS(c, 16u * m * NTC_TRAIN_SUMS + 16u * n);
    }
    barrier();
}

#if !NTC_TRAIN_TRIES
/// Gradients of a layer's inputs, columns from 16 * firstTile: 16 texels x 16 inputs a subgroup.
void NtcMultiplyBack(uint outputs, uint inputs, uint weights, uint firstTile) {
    uint subgroup = NtcTrainSubgroup(), m = subgroup >> 2, n = subgroup & 3u;
    if (firstTile + n < inputs / 16u) {
        NtcMatC c = NTC_MAT_ZERO;
        [[unroll]] for (uint k = 0u; k < outputs / 16u; k++)
            NTC_MAT_BACKWARD(c, NtcTrainRows(4u) + 16u * m * NTC_TRAIN_NARROW + 2u * k, NTC_TRAIN_NARROW,
                             NtcWeightTile(weights, firstTile + n, outputs / 16u, k))
        NTC_MAT_STORE_SUMS(c, 16u * m * NTC_TRAIN_SUMS + 16u * n);
    }
    barrier();
}

/// Adds to the gradients of a layer's weights, tiles [first, end).
#define NTC_TRAIN_ADD(layer, first, end, outputTiles)                                                        \
    [[unroll]] for (uint slot = (first) / 8u; slot < ((end) + 7u) / 8u; slot++) {                            \
        uint tile = 8u * slot + subgroup;                                                                    \
        bool isWhole = 8u * slot >= (first) && 8u * slot + 8u <= (end);                                      \
        if (isWhole || (tile >= (first) && tile < (end))) {                                                  \
            uint input_ = (tile - (first)) / (outputTiles), output_ = (tile - (first)) % (outputTiles);      \
            [[unroll]] for (uint k = 0u; k < 2u; k++)                                                        \
                NTC_MAT_GRADIENT(gGradients[slot],                                                           \
                                 NtcTrainRows(layer) + 16u * k * NtcTrainStride(layer) + 2u * input_,        \
                                 NtcTrainStride(layer),                                                      \
                                 NtcTrainRows(4u) + 16u * k * NTC_TRAIN_NARROW + 2u * output_,               \
                                 NTC_TRAIN_NARROW)                                                           \
        }                                                                                                    \
    }

/// Clamped to what binary16 holds.
uint NtcPackGradients(vec2 gradients) {
    return packHalf2x16(clamp(gradients, vec2(-65504.0), vec2(65504.0)));
}
#endif

#if NTC_TRAIN_GENERATION == 3
/// The activation in steps of the hidden quantiser, and what its derivative comes from: of real units, and
/// rounded before the decoder's offset is added.
vec2 NtcActivatePair(vec2 z, out vec2 open) {
    precise vec2 third = z * uintBitsToFloat(0x3EAAAA9Fu); // 0.333333
    precise vec2 raised = third + 0.5;
    open = raised;
    precise vec2 y = min(z, 3.0) * clamp(open, 0.0, 1.0);
    y *= 80.0;
    return roundEven(y);
}
#else
/// The activation in steps of the hidden quantiser, and what its derivative comes from.
vec2 NtcActivatePair(vec2 u, out vec2 open) {
    precise vec2 third = u * (1.0 / 240.0);
    precise vec2 raised = third + 0.5;
    open = raised;
    precise vec2 y = min(u, 240.0) * clamp(open, 0.0, 1.0);
    y += 0.5;
    return floor(y);
}
#endif

/// The activation of a layer's sums, and its derivative.
void NtcActivate(uint layer) {
    uint o = NtcLaneOutput(), row = 64u * layer + o, texels = NtcLaneTexels(layer);
    vec2 scale = vec2(gRows.values[row], gRows.values[row + 1u]);
    vec2 bias = vec2(gRows.values[NTC_TRAIN_ROWS + row], gRows.values[NTC_TRAIN_ROWS + row + 1u]);
    [[unroll]] for (uint k = 0u; k < 4u; k++) {
        if (k >= texels)
            break;
        uint t = NtcLaneTexel(k), at = t * NTC_TRAIN_SUMS + o;
        precise vec2 u = (vec2(sSums[at], sSums[at + 1u]) + bias) * scale;
        vec2 open;
        vec2 activated = NtcActivatePair(u, open);
        at = 4u * (NtcTrainRows(layer + 1u) + t * NTC_TRAIN_NARROW) + (o >> 1);
        sHalves[at >> 2][at & 3u] = packHalf2x16(activated);
#if !NTC_TRAIN_TRIES
        vec2 upper = vec2(lessThanEqual(open, vec2(1.5)));
        vec2 slope = mix(2.0 * open - 0.5, upper, greaterThanEqual(open, vec2(1.0)));
        gSlopes[layer][k] = mix(vec2(0.0), slope, greaterThan(open, vec2(0.0)));
#endif
    }
    barrier();
}

/// Sums of the last layer, of a strip's texels.
void NtcEvaluateStrip(uvec2 record, uint strip) {
    NtcGatherInputs(record, strip);
    barrier();
    NtcMultiply(0u, uint(NTC_TRAIN_USED), 0u, 4u);
    NtcActivate(0u);
    NtcMultiply(1u, 64u, kLayer1, uint(NTC_TRAIN_OUTPUT_TILES(1)));
    NtcActivate(1u);
    NtcMultiply(2u, NTC_TRAIN_OUTPUTS(1), kLayer2, uint(NTC_TRAIN_OUTPUT_TILES(2)));
    NtcActivate(2u);
    NtcMultiply(3u, NTC_TRAIN_OUTPUTS(2), kLayer3, 1u);
}

#if NTC_TRAIN_TRIES
/// Losses of a strip's texels, to what is kept or what is tried.
void NtcTryStrip(uint index, uint strip) {
    uint tile = gStep.firstTile + index;
    uvec2 record = gTiles.records[tile];
    NtcTrainTargets targets = NtcReadTargets(NtcPlaceReference(tile, index), strip, record);
    NtcEvaluateStrip(record, strip);
    float loss = NtcMeasureLoss(targets);
    barrier();
    sSums[gl_LocalInvocationIndex] = loss;
    barrier();
    if (gl_LocalInvocationIndex < 32u) {
        float sum = 0.0;
        [[unroll]] for (uint i = 0u; i < 8u; i++) sum += sSums[8u * gl_LocalInvocationIndex + i];
        uint at = uint(NTC_TRAIN_TILE_TEXELS) * tile + 32u * strip + gl_LocalInvocationIndex;
        if ((gStep.flags & NTC_TRAIN_MOVE) != 0u)
            gTried.values[at] = sum;
        else
            gKept.values[at] = sum;
    }
}

void main() {
    [[dont_unroll]] for (uint i = 0u; i < gStep.strips; i++) {
        uint at = gl_WorkGroupID.x * gStep.strips + i;
        uint tile = at / uint(NTC_TRAIN_STRIPS_OF_TILE), strip = at % uint(NTC_TRAIN_STRIPS_OF_TILE);
        if (tile < gStep.tiles)
            NtcTryStrip(tile, strip);
        barrier();
    }
}
#else
/// From gradients of a layer's activations, which are in sSums, to those of its sums.
void NtcActivateBack(uint layer) {
    uint o = NtcLaneOutput(), row = 2u * NTC_TRAIN_ROWS + 64u * layer + o, texels = NtcLaneTexels(layer);
    vec2 largest = vec2(gRows.values[row], gRows.values[row + 1u]);
    [[unroll]] for (uint k = 0u; k < 4u; k++) {
        if (k >= texels)
            break;
        uint t = NtcLaneTexel(k), at = t * NTC_TRAIN_SUMS + o;
        vec2 z = vec2(sSums[at], sSums[at + 1u]) * gSlopes[layer][k] * (1.0 / 127.5);
        gBiasSums[layer] += z;
        at = 4u * (NtcTrainRows(4u) + t * NTC_TRAIN_NARROW) + (o >> 1);
        sHalves[at >> 2][at & 3u] = NtcPackGradients(z * largest);
    }
    barrier();
}

void NtcTrainStrip(uint reference, uvec2 record, uint strip) {
    NtcTrainTargets targets = NtcReadTargets(reference, strip, record);
    NtcEvaluateStrip(record, strip);
    NtcTrainErrors errors = NtcMeasureErrors(targets);
    gLastBiasSums += errors.gradients;
    gSquares += errors.squares;
    uint o = NtcErrorOutput(), row = 2u * NTC_TRAIN_ROWS + 192u + o;
    uint at = 4u * (NtcTrainRows(4u) + NtcErrorTexel() * NTC_TRAIN_NARROW) + (o >> 1);
    sHalves[at >> 2][at & 3u] =
        NtcPackGradients(errors.gradients * vec2(gRows.values[row], gRows.values[row + 1u]));
    barrier();

    uint subgroup = NtcTrainSubgroup();
    NTC_TRAIN_ADD(3u, kTiles3, kTiles, 1u)
    NtcMultiplyBack(16u, NTC_TRAIN_OUTPUTS(2), kLayer3, 0u);
    NtcActivateBack(2u);
    NTC_TRAIN_ADD(2u, kTiles2, kTiles3, uint(NTC_TRAIN_OUTPUT_TILES(2)))
    NtcMultiplyBack(NTC_TRAIN_OUTPUTS(2), NTC_TRAIN_OUTPUTS(1), kLayer2, 0u);
    NtcActivateBack(1u);
    NTC_TRAIN_ADD(1u, kTiles1, kTiles2, uint(NTC_TRAIN_OUTPUT_TILES(1)))
    NtcMultiplyBack(NTC_TRAIN_OUTPUTS(1), 64u, kLayer1, 0u);
    NtcActivateBack(0u);
    NTC_TRAIN_ADD(0u, 0u, kTiles1, 4u)
    if ((gStep.flags & NTC_TRAIN_LATENTS) == 0u)
        return;
#if NTC_TRAIN_GENERATION == 3
    NtcMultiplyBack(64u, 32u, 0u, 0u); // latents have the first 32 inputs at most
    NtcScatterGradients(record, strip);
#else
    NtcMultiplyBack(64u, uint(NTC_TRAIN_INPUTS), 0u, 0u);
    NtcScatterGradients(record, strip, 0u);
#if NTC_TRAIN_INPUTS > 64
    if (4 * gConstants.highFeatures + gConstants.lowFeatures > 64) {
        barrier();
        NtcMultiplyBack(64u, uint(NTC_TRAIN_INPUTS), 0u, 4u);
        NtcScatterGradients(record, strip, 64u);
    }
#endif
#endif
}

/// Sums over the lanes that have the same outputs, in their order: `lanes` lanes lie `stride` apart.
vec2 NtcSumLanes(vec2 mine, uint stride, uint lanes) {
    barrier();
    sSums[2u * gl_LocalInvocationIndex] = mine.x;
    sSums[2u * gl_LocalInvocationIndex + 1u] = mine.y;
    barrier();
    vec2 sum = vec2(0.0);
    if (gl_LocalInvocationIndex < stride) {
        [[dont_unroll]] for (uint lane = 0u; lane < lanes; lane++) {
            uint at = 2u * (gl_LocalInvocationIndex + lane * stride);
            sum += vec2(sSums[at], sSums[at + 1u]);
        }
    }
    return sum;
}

void NtcWritePair(uint at, vec2 pair) {
    gPartials.values[at] = pair.x;
    gPartials.values[at + 1u] = pair.y;
}

void NtcWriteSums() {
    uint subgroup = NtcTrainSubgroup(), at = gl_WorkGroupID.x * (kWeights + uint(NTC_TRAIN_TAIL));
    [[unroll]] for (uint slot = 0u; slot < kSlots; slot++) {
        uint tile = 8u * slot + subgroup;
        uint place = tile < kTiles1 ? tile : tile + kPaddingTiles;
        if (8u * slot + 8u <= kTiles || tile < kTiles)
            NTC_MAT_STORE_PARTIAL(gGradients[slot], at + 256u * place);
    }
    at += kWeights;
    [[unroll]] for (uint layer = 0u; layer < 3u; layer++) {
        vec2 sum = NtcSumLanes(gBiasSums[layer], 32u, 8u);
        if (gl_LocalInvocationIndex < 32u)
            NtcWritePair(at + 64u * layer + NtcLaneOutput(), sum);
    }
    vec2 bias = NtcSumLanes(gLastBiasSums, 8u, 32u);
    vec2 squares = NtcSumLanes(gSquares, 8u, 32u);
    if (gl_LocalInvocationIndex < 8u) {
        NtcWritePair(at + 192u + NtcErrorOutput(), bias);
        NtcWritePair(at + NTC_TRAIN_ROWS + NtcErrorOutput(), squares);
    }
}

void main() {
    [[unroll]] for (uint slot = 0u; slot < kSlots; slot++) gGradients[slot] = NTC_MAT_ZERO;
    [[unroll]] for (uint layer = 0u; layer < 3u; layer++) gBiasSums[layer] = vec2(0.0);
    gLastBiasSums = vec2(0.0);
    gSquares = vec2(0.0);
    [[dont_unroll]] for (uint i = 0u; i < gStep.strips; i++) {
        uint at = gl_WorkGroupID.x * gStep.strips + i;
        uint index = gStep.firstTile + at / uint(NTC_TRAIN_STRIPS_OF_TILE), tile = gBatch.tiles[index];
        uint strip = at % uint(NTC_TRAIN_STRIPS_OF_TILE);
        uvec2 record = gTiles.records[tile];
        if ((record.y >> 16) + 2u * strip < uint(gMips.mips[record.x].height))
            NtcTrainStrip(NtcPlaceReference(tile, index), record, strip);
        barrier();
    }
    NtcWriteSums();
}
#endif
