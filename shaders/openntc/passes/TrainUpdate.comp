// SPDX-License-Identifier: MIT
// Compute pass: a step of the optimiser (Adam) from what TrainTexels left. The first NTC_TRAIN_COLUMNS
// workgroups add the workgroups' sums in their order, step eight rows of the network each and make its
// working weights; the others step the latents of a tile of the batch each. A latent that several tiles
// read is stepped by the one that takes its gradient first; which one that is changes nothing.
//
// Set 0, storage buffers: 0 - 3, 5 - 10 as TrainTexels, 11 and 12 first and second moments of latents, 13
// the network: weights, first and second moments in tiles of 16 inputs x 16 outputs, then biases and their
// moments (NTC_TRAIN_ROWS each), 14 squared errors, 16 numbers a slot. Push constants: NtcTrainStep;
// dispatch NTC_TRAIN_COLUMNS workgroups, and the batch's tiles more if latents are trained.
// NTC_TRAIN_INPUTS and NTC_TRAIN_GENERATION: encode/TrainShape.h.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "openntc/encode/TrainConstants.h"
#include "openntc/encode/TrainShape.h"

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
layout(set = 0, binding = 5, std430) readonly buffer Batch {
    uint tiles[];
} gBatch;
layout(set = 0, binding = 6, std430) writeonly buffer Weights {
    uint words[];
} gWeights;
layout(set = 0, binding = 7, std430) buffer Rows {
    float values[];
} gRows;
layout(set = 0, binding = 8, std430) buffer Latents {
    float values[];
} gLatents;
layout(set = 0, binding = 9, std430) buffer LatentGradients {
    int values[];
} gLatentGradients;
layout(set = 0, binding = 10, std430) readonly buffer Partials {
    float values[];
} gPartials;
layout(set = 0, binding = 11, std430) buffer FirstMoments {
    float values[];
} gFirst;
layout(set = 0, binding = 12, std430) buffer SecondMoments {
    float values[];
} gSecond;
layout(set = 0, binding = 13, std430) buffer Network {
    float values[];
} gNetwork;
layout(set = 0, binding = 14, std430) writeonly buffer Losses {
    float values[];
} gLosses;
layout(push_constant) uniform TrainPush {
    NtcTrainStep gStep;
};

const uint kPartial = kWeights + uint(NTC_TRAIN_TAIL);
const float kBeta1 = 0.9, kEpsilon = 1e-15;

struct AdamNumbers {
    float value;
    float first;
    float second;
};

/// Numbers without gradient keep their moments.
void stepAdam(inout AdamNumbers n, float gradient, float rate, float correction, float beta2, vec2 range) {
    if (gradient == 0.0)
        return;
    n.first += (1.0 - kBeta1) * (gradient - n.first);
    n.second += (1.0 - beta2) * (gradient * gradient - n.second);
    float updated = n.value - rate * n.first / (sqrt(n.second * correction) + kEpsilon);
    n.value = isnan(updated) ? 0.0 : clamp(updated, range.x, range.y);
}

const uint kAtOnce = 16u; // loads under way

/// Of the workgroups, in their order.
float sumPartials(uint at) {
    float sum = 0.0;
    uint group = 0u;
    for (; group + kAtOnce <= gStep.groups; group += kAtOnce) {
        float values[kAtOnce];
        [[unroll]] for (uint i = 0u; i < kAtOnce; i++)
            values[i] = gPartials.values[at + (group + i) * kPartial];
        [[unroll]] for (uint i = 0u; i < kAtOnce; i++) sum += values[i];
    }
    for (; group < gStep.groups; group++) sum += gPartials.values[at + group * kPartial];
    return sum;
}

shared float sLargest[NTC_TRAIN_GROUP];

/// Eight rows of a layer: lane = row + 8 * pair of inputs.
struct NetworkRows {
    uint base;    // first weight of the layer
    uint inputs;  // of the layer
    uint outputs; // of the layer
    uint output_; // the lane's
    uint row;     // of all layers
    float unit;   // an integer input times this is real
};

uint getWeightIndex(NetworkRows r, uint input_) {
    return r.base + ((input_ >> 4) * (r.outputs >> 4) + (r.output_ >> 4)) * 256u + (input_ & 15u) * 16u +
           (r.output_ & 15u);
}

/// Working weights' tiles have the inputs of an output beside each other.
uint getWorkingPlace(NetworkRows r, uint input_) {
    return r.base + ((input_ >> 4) * (r.outputs >> 4) + (r.output_ >> 4)) * 256u + (r.output_ & 15u) * 16u +
           (input_ & 15u);
}

const vec2 kRange = vec2(-1000.0, 1000.0);

float stepWeight(uint at, float scale) {
    AdamNumbers n = AdamNumbers(gNetwork.values[at], gNetwork.values[kWeights + at],
                                gNetwork.values[2u * kWeights + at]);
    if ((gStep.flags & NTC_TRAIN_NETWORK) != 0u) {
        stepAdam(n, sumPartials(at) * scale, gStep.networkRate, gStep.networkSecond, gStep.networkBeta2,
                 kRange);
        gNetwork.values[at] = n.value;
        gNetwork.values[kWeights + at] = n.first;
        gNetwork.values[2u * kWeights + at] = n.second;
    }
    return n.value;
}

float stepBias(uint row) {
    uint at = 3u * kWeights + row, rows = uint(NTC_TRAIN_ROWS);
    AdamNumbers n =
        AdamNumbers(gNetwork.values[at], gNetwork.values[at + rows], gNetwork.values[at + 2u * rows]);
    if ((gStep.flags & NTC_TRAIN_NETWORK) != 0u) {
        stepAdam(n, sumPartials(kWeights + row), gStep.networkRate, gStep.networkSecond, gStep.networkBeta2,
                 kRange);
        gNetwork.values[at] = n.value;
        gNetwork.values[at + rows] = n.first;
        gNetwork.values[at + 2u * rows] = n.second;
    }
    return n.value;
}

/// Integers -127 ... 127 for the row's largest weight.
float quantise(float weight, float inverse) {
    float scaled = weight * inverse;
    return trunc(clamp(scaled + (scaled < 0.0 ? -0.5 : 0.5), -127.0, 127.0));
}

void stepRows(uint column) {
    uint lane = gl_LocalInvocationIndex, layer = column >> 3;
    NetworkRows r;
    r.inputs = layer == 0u ? uint(NTC_TRAIN_USED) : NTC_TRAIN_OUTPUTS(int(layer) - 1);
    r.outputs = NTC_TRAIN_OUTPUTS(int(layer));
    r.base = layer == 0u ? 0u : layer == 1u ? kLayer1 : layer == 2u ? kLayer2 : kLayer3;
    r.unit = layer == 0u ? 1.0 / 127.5 : 0.0125;
    r.output_ = 8u * (column & 7u) + (lane & 7u);
    r.row = 64u * layer + r.output_;
    if (8u * (column & 7u) >= r.outputs)
        return;

    // The sums are of gradients times the row's largest weight.
    const uint rows = uint(NTC_TRAIN_ROWS), largestAt = 2u * rows + r.row;
    float scale = r.unit / gRows.values[largestAt];
    const uint passes = (uint(NTC_TRAIN_INPUTS) + 63u) / 64u;
    vec2 weights[passes];
    float largest = 0.0;
    [[unroll]] for (uint i = 0u; i < passes; i++) {
        uint input_ = 2u * (lane >> 3) + 64u * i;
        weights[i] = vec2(0.0);
        if (input_ < r.inputs)
            weights[i] = vec2(stepWeight(getWeightIndex(r, input_), scale),
                              stepWeight(getWeightIndex(r, input_ + 1u), scale));
        largest = max(largest, max(abs(weights[i].x), abs(weights[i].y)));
    }
    sLargest[lane] = largest;
    barrier();
    largest = 1e-12;
    for (uint i = lane & 7u; i < uint(NTC_TRAIN_GROUP); i += 8u) largest = max(largest, sLargest[i]);
    if (layer == 3u)
        largest = max(largest, gConstants.smallestScale[r.output_] * 127.5 / r.unit);
    [[unroll]] for (uint i = 0u; i < passes; i++) {
        uint input_ = 2u * (lane >> 3) + 64u * i;
        vec2 q = vec2(quantise(weights[i].x, 127.5 / largest), quantise(weights[i].y, 127.5 / largest));
        if (input_ < r.inputs)
            gWeights.words[getWorkingPlace(r, input_) >> 1] = packHalf2x16(q);
    }
    if (lane < 8u) {
        float real = largest * (1.0 / 127.5) * r.unit;
        // Sums stay below 2^24, so that binary32 holds them exactly.
        float bias = clamp(stepBias(r.row) / real, -8388608.0, 8388608.0);
#if NTC_TRAIN_GENERATION == 3
        gRows.values[r.row] = real;
#else
        gRows.values[r.row] = layer < 3u ? real * 80.0 : real;
#endif
        gRows.values[rows + r.row] = (bias < 0.0 ? -1.0 : 1.0) * floor(abs(bias) + 0.5);
        gRows.values[largestAt] = largest;
    } else if (lane < 16u && layer == 3u) {
        gLosses.values[16u * gStep.lossSlot + r.output_] = sumPartials(kWeights + rows + r.output_);
    }
}

/// Pixels of a grid that texels of a tile read.
struct TileLatents {
    ivec2 first;
    uvec2 size;
};

#if NTC_TRAIN_GENERATION == 3
/// Before they wrap around: `first` may be -1, and the last may be the grid's size.
TileLatents placeTile(NtcTrainGrid grid, uvec2 first, uvec2 last) {
    uvec2 begin = uvec2(gTaps.taps[grid.tapsX + first.x].y, gTaps.taps[grid.tapsY + first.y].y) >> 16;
    uvec2 end = uvec2(gTaps.taps[grid.tapsX + last.x].y, gTaps.taps[grid.tapsY + last.y].y) >> 16;
    return TileLatents(ivec2(begin) - 1, end - begin + 2u);
}
uint wrapLatent(int at, uint count) {
    return at < 0 ? count - 1u : uint(at) == count ? 0u : uint(at);
}
#else
TileLatents placeTile(NtcTrainGrid grid, uvec2 first, uvec2 last) {
    uvec2 begin = uvec2(gTaps.taps[grid.tapsX + first.x].x, gTaps.taps[grid.tapsY + first.y].x) & 0xFFFFu;
    uvec2 end = uvec2(gTaps.taps[grid.tapsX + last.x].x, gTaps.taps[grid.tapsY + last.y].x) >> 16;
    return TileLatents(ivec2(begin), end - begin + 1u);
}
uint wrapLatent(int at, uint) {
    return uint(at);
}
#endif

void stepLatents(NtcTrainGrid grid, uint features, NtcTrainQuantiser quantiser, uvec2 first, uvec2 last) {
    TileLatents place = placeTile(grid, first, last);
    uvec2 size = place.size;
    for (uint i = gl_LocalInvocationIndex; i < size.x * size.y * features; i += uint(NTC_TRAIN_GROUP)) {
        uint rest = i / size.x;
        uint x = wrapLatent(place.first.x + int(i % size.x), grid.width);
        uint y = wrapLatent(place.first.y + int(rest % size.y), grid.height);
        uint at = grid.base + rest / size.y * grid.plane + y * grid.width + x;
        int gradient = atomicExchange(gLatentGradients.values[at], 0);
        if (gradient == 0)
            continue;
        AdamNumbers n = AdamNumbers(gLatents.values[at], gFirst.values[at], gSecond.values[at]);
        stepAdam(n, float(gradient), gStep.latentRate, gStep.latentSecond, gStep.latentBeta2,
                 vec2(quantiser.minimum, quantiser.maximum));
        gLatents.values[at] = n.value;
        gFirst.values[at] = n.first;
        gSecond.values[at] = n.second;
    }
}

void main() {
    if (gl_WorkGroupID.x < NTC_TRAIN_COLUMNS) {
        stepRows(gl_WorkGroupID.x);
        return;
    }
    uvec2 record = gTiles.records[gBatch.tiles[gStep.firstTile + gl_WorkGroupID.x - NTC_TRAIN_COLUMNS]];
    uvec2 first = uvec2(record.y & 0xFFFFu, record.y >> 16);
    uvec2 last = min(first + uvec2(15u, 7u),
                     uvec2(gMips.mips[record.x].width, gMips.mips[record.x].height) - 1u);
    stepLatents(gMips.mips[record.x].high, uint(gConstants.highFeatures), gConstants.high, first, last);
    stepLatents(gMips.mips[record.x].low, uint(gConstants.lowFeatures), gConstants.low, first, last);
}
