// SPDX-License-Identifier: MIT
// Rows of the Int8 network with NTC_FETCH_SUBGROUP: 8 lanes load different weights and pass them round. Made
// for drivers that compile to the CPU, where a load is a loop over the lanes and takes as long as dozens of
// products: loads are few and, with NTC_WIDE_WEIGHT_LOADS, of 16 bytes.
#ifndef OPENNTC_NETWORK_SUBGROUP_H
#define OPENNTC_NETWORK_SUBGROUP_H

#include "Network.h"
#include "NetworkOperands.h"
#include "Portability.h"
#include "Switches.h"

#if NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP

/// Of a layer's biases and scales, those that this lane has loaded.
struct NtcOwnRows {
    uint4 biases0; // rows 4 lane ... 4 lane + 3
    uint4 scales0;
    uint4 biases1; // rows 32 + 4 lane ... if there are more than 32
    uint4 scales1;
};

NTC_FUNCTION NtcOwnRows NtcLoadOwnRows(NtcBuffer weights, NtcLayer layer, uint rows) {
    uint lane = gl_SubgroupInvocationID & 7u;
    uint at = 16u * min(lane, rows / 4u - 1u); // not beyond the last row
    NtcOwnRows own;
    own.biases0 = NtcLoadFourWeightWords(weights, layer.biases + at);
    own.scales0 = NtcLoadFourWeightWords(weights, layer.scales + at);
    own.biases1 = own.biases0;
    own.scales1 = own.scales0;
    if (rows > 32u) {
        at = 16u * (8u + min(lane, rows / 4u - 9u));
        own.biases1 = NtcLoadFourWeightWords(weights, layer.biases + at);
        own.scales1 = NtcLoadFourWeightWords(weights, layer.scales + at);
    }
    return own;
}

/// Rows 4 group ... 4 group + 3 of every texel before activation: z[4 t + r].
NTC_FUNCTION void NtcEvaluateRowsOfTexels(NtcBuffer weights, NtcLayer layer, NtcOwnRows ownRows, uint group,
                                          NTC_IN_ARRAY(NTC_OPERAND, x, NTC_TEXELS_INPUT_WORDS),
                                          NTC_OUT_ARRAY(float, z, 4 * NTC_TEXELS_PER_INVOCATION)) {
    uint words = layer.inputWords;
    uint address = layer.weights + 16u * words * group;
    uint lane = gl_SubgroupInvocationID & 7u;
    NTC_SUM sums[4 * NTC_TEXELS_PER_INVOCATION];
    NTC_UNROLL for (uint s = 0u; s < uint(4 * NTC_TEXELS_PER_INVOCATION); s++) sums[s] = NTC_SUM(0u);
    // The four rows are contiguous: lane l loads words 4 l ... 4 l + 3 of every 32. What is loaded is used up
    // before the next load, so that it stays in registers.
    NTC_UNROLL for (uint load = 0u; load < (words + 7u) / 8u; load++) {
        uint4 four = NtcLoadFourWeightWords(weights, address + 16u * min(8u * load + lane, words - 1u));
        NTC_OPERAND own[4]; // unpacked before they are passed round: once in 8 lanes
        own[0] = NtcMakeOperand(four.x);
        own[1] = NtcMakeOperand(four.y);
        own[2] = NtcMakeOperand(four.z);
        own[3] = NtcMakeOperand(four.w);
        NTC_UNROLL for (uint k = 0u; k < 32u; k++) {
            uint n = 32u * load + k;
            if (n < 4u * words)
                NTC_ADD_PRODUCTS(sums, n / words, subgroupShuffle(own[k & 3u], k >> 2), x, n % words)
        }
    }
    bool isFirstHalf = group < 8u;
    uint4 ownBiases = isFirstHalf ? ownRows.biases0 : ownRows.biases1;
    uint4 ownScales = isFirstHalf ? ownRows.scales0 : ownRows.scales1;
    NTC_UNROLL for (uint r = 0u; r < 4u; r++) {
        uint bias = subgroupShuffle(ownBiases[r], group & 7u);
        NTC_PRECISE float scale = asfloat(subgroupShuffle(ownScales[r], group & 7u));
        NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) z[4u * t + r] =
            NTC_FINISH_ROW(sums, t, r, bias, scale);
    }
}

#endif
#endif
