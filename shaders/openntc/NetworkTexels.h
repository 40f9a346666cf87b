// SPDX-License-Identifier: MIT
// The Int8 network for NTC_TEXELS_PER_INVOCATION texels at once, with weights fetched as NTC_WEIGHT_FETCH
// says. The arithmetic is that of Network.h. Arrays hold the texels one after another.
#ifndef OPENNTC_NETWORK_TEXELS_H
#define OPENNTC_NETWORK_TEXELS_H

#include "Effects.h"
#include "Network.h"
#include "NetworkOperands.h"
#include "NetworkSubgroup.h"
#include "Portability.h"
#include "Switches.h"

#if NTC_WITH_NETWORK_TEXELS

// Loop over the groups of 4 rows. Unrolled, drivers that compile to the CPU take minutes.
#ifndef NTC_ROW_LOOP
#define NTC_ROW_LOOP NTC_LOOP
#endif

// The inner layers share their code, and inputs of a layer are an array of its own that is indexed by
// constants only. Drivers that compile to the CPU take half as long to compile it; on an H100 it is the
// faster one for several texels of the larger networks (xlarge by a fifth), for one texel and for small ones
// it is slower.
#if NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP || NTC_FLOAT_DOT ||                                               \
    (NTC_TEXELS_PER_INVOCATION > 1 &&                                                                        \
     (NETWORK_VERSION == NTC_NETWORK_LARGE || NETWORK_VERSION == NTC_NETWORK_XLARGE))
#define NTC_WITH_COMPACT_NETWORK 1
#else
#define NTC_WITH_COMPACT_NETWORK 0
#endif

// What a layer needs before its rows are evaluated: a declaration, and an argument.
#if NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP
#define NTC_BEGIN_ROWS(layer, rows) NtcOwnRows ownRows = NtcLoadOwnRows(weights, layer, rows);
#define NTC_ROWS_OF(layer) layer, ownRows
#else
#define NTC_BEGIN_ROWS(layer, rows)
#define NTC_ROWS_OF(layer) layer
#endif

#if NTC_WEIGHT_FETCH != NTC_FETCH_SUBGROUP
/// Rows 4 group ... 4 group + 3 of every texel before activation: z[4 t + r].
NTC_FUNCTION void NtcEvaluateRowsOfTexels(NtcBuffer weights, NtcLayer layer, uint group,
                                          NTC_IN_ARRAY(NTC_OPERAND, x, NTC_TEXELS_INPUT_WORDS),
                                          NTC_OUT_ARRAY(float, z, 4 * NTC_TEXELS_PER_INVOCATION)) {
    uint words = layer.inputWords;
    uint address = layer.weights + 16u * words * group;
    NTC_SUM sums[4 * NTC_TEXELS_PER_INVOCATION];
    NTC_UNROLL for (uint s = 0u; s < uint(4 * NTC_TEXELS_PER_INVOCATION); s++) sums[s] = NTC_SUM(0u);
    uint biases[4];
    uint scales[4];

#if NTC_WEIGHT_FETCH == NTC_FETCH_UNIFORM || NTC_WIDE_WEIGHT_LOADS
    uint4 fourBiases = NtcLoadFourWeightWords(weights, layer.biases + 16u * group);
    uint4 fourScales = NtcLoadFourWeightWords(weights, layer.scales + 16u * group);
    biases[0] = fourBiases.x;
    biases[1] = fourBiases.y;
    biases[2] = fourBiases.z;
    biases[3] = fourBiases.w;
    scales[0] = fourScales.x;
    scales[1] = fourScales.y;
    scales[2] = fourScales.z;
    scales[3] = fourScales.w;
    NTC_UNROLL for (uint i = 0u; i < words; i += 4u) {
        NTC_UNROLL for (uint row = 0u; row < 4u; row++) {
            uint4 four = NtcLoadFourWeightWords(weights, address + 4u * (row * words + i));
            NTC_ADD_PRODUCTS(sums, row, NtcMakeOperand(four.x), x, i)
            NTC_ADD_PRODUCTS(sums, row, NtcMakeOperand(four.y), x, i + 1u)
            NTC_ADD_PRODUCTS(sums, row, NtcMakeOperand(four.z), x, i + 2u)
            NTC_ADD_PRODUCTS(sums, row, NtcMakeOperand(four.w), x, i + 3u)
        }
    }
#else
    NTC_UNROLL for (uint r = 0u; r < 4u; r++) {
        biases[r] = NtcBufferLoad(weights, layer.biases + 16u * group + 4u * r);
        scales[r] = NtcBufferLoad(weights, layer.scales + 16u * group + 4u * r);
    }
    NTC_UNROLL for (uint i = 0u; i < words; i++) {
        NTC_UNROLL for (uint row = 0u; row < 4u; row++) NTC_ADD_PRODUCTS(
            sums, row, NtcMakeOperand(NtcBufferLoad(weights, address + 4u * (row * words + i))), x, i)
    }
#endif

    NTC_UNROLL for (uint texel = 0u; texel < uint(NTC_TEXELS_PER_INVOCATION); texel++) {
        NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
            NTC_PRECISE float scale = asfloat(scales[k]);
            z[4u * texel + k] = NTC_FINISH_ROW(sums, texel, k, biases[k], scale);
        }
    }
}

#endif

/// The rows with activation: y[NTC_MAX_INPUT_WORDS t + word].
NTC_FUNCTION void NtcEvaluateHiddenLayerOfTexels(int networkVersion, int math, NtcBuffer weights,
                                                 NtcLayer layer,
                                                 NTC_IN_ARRAY(NTC_OPERAND, x, NTC_TEXELS_INPUT_WORDS),
                                                 NTC_OUT_ARRAY(uint, y, NTC_TEXELS_INPUT_WORDS)) {
    NTC_BEGIN_ROWS(layer, 4u * layer.rowWords)
    NTC_ROW_LOOP for (uint group = 0u; group < layer.rowWords; group++) {
        float z[4 * NTC_TEXELS_PER_INVOCATION];
        NtcEvaluateRowsOfTexels(weights, NTC_ROWS_OF(layer), group, x, z);
        NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) {
            uint packedBytes = 0u;
            NTC_UNROLL for (uint i = 0u; i < 4u; i++) packedBytes =
                packedBytes | (NtcActivate(networkVersion, math, z[4u * t + i]) << (8u * i));
            y[uint(NTC_MAX_INPUT_WORDS) * t + group] = packedBytes;
        }
    }
}

/// NtcEvaluateNetwork for several texels: inputs[NTC_MAX_INPUT_WORDS t + word], outputs[NTC_MAX_CHANNELS t +
/// channel]. weightsOffset: a multiple of 16 with UNIFORM and with wide loads.
NTC_FUNCTION void NtcEvaluateNetworkOfTexels(int networkVersion, int math, NtcBuffer weights,
                                             uint weightsOffset, NtcLayerOffsets layers,
                                             NTC_IN_ARRAY(uint, inputs, NTC_TEXELS_INPUT_WORDS),
                                             NTC_OUT_ARRAY(float, outputs, NTC_TEXELS_OUTPUTS)) {
    NtcLayer inputLayer = NtcGetLayer(networkVersion, weightsOffset, layers, 0u);
    NtcLayer layer = NtcGetLayer(networkVersion, weightsOffset, layers, 3u);
#if NTC_WITH_COMPACT_NETWORK
    NTC_OPERAND x[NTC_TEXELS_INPUT_WORDS];
    uint y[NTC_TEXELS_INPUT_WORDS];
    NtcMakeOperands(inputs, inputLayer.inputWords, x);
    NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights, inputLayer, x, y);
#if NTC_WITH_EQUAL_LAYERS
    NTC_LOOP for (uint inner = 1u; inner < 3u; inner++) {
        NtcLayer innerLayer = NtcGetInnerLayer(networkVersion, weightsOffset, layers, inner);
        NtcMakeOperands(y, innerLayer.inputWords, x);
        NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights, innerLayer, x, y);
    }
#else
    NtcLayer second = NtcGetLayer(networkVersion, weightsOffset, layers, 1u);
    NtcMakeOperands(y, second.inputWords, x);
    NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights, second, x, y);
    NtcLayer third = NtcGetLayer(networkVersion, weightsOffset, layers, 2u);
    NtcMakeOperands(y, third.inputWords, x);
    NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights, third, x, y);
#endif
    NtcMakeOperands(y, layer.inputWords, x);
#else
    uint x[NTC_TEXELS_INPUT_WORDS];
    uint y[NTC_TEXELS_INPUT_WORDS];
    NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights, inputLayer, inputs, x);
    NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights,
                                   NtcGetLayer(networkVersion, weightsOffset, layers, 1u), x, y);
    NtcEvaluateHiddenLayerOfTexels(networkVersion, math, weights,
                                   NtcGetLayer(networkVersion, weightsOffset, layers, 2u), y, x);
#endif
    NTC_BEGIN_ROWS(layer, 16u)
#if NTC_OUTPUT_MASK != 0xFFFF
    NTC_UNROLL for (uint unread = 0u; unread < uint(NTC_TEXELS_OUTPUTS); unread++) outputs[unread] = 0.0f;
#endif
    NTC_ROW_LOOP for (uint group = NTC_FIRST_OUTPUT / 4u; group < (NTC_END_OUTPUT + 3u) / 4u; group++) {
        float z[4 * NTC_TEXELS_PER_INVOCATION];
        NtcEvaluateRowsOfTexels(weights, NTC_ROWS_OF(layer), group, x, z);
        NTC_UNROLL for (uint texel = 0u; texel < uint(NTC_TEXELS_PER_INVOCATION); texel++) {
            NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
                float value = NtcFinishOutput(networkVersion, math, z[4u * texel + k]);
                uint channel = 4u * group + k;
                bool isRead =
                    channel >= NTC_FIRST_OUTPUT && channel < NTC_END_OUTPUT && NtcIsOutputRead(channel);
                outputs[uint(NTC_MAX_CHANNELS) * texel + channel] = isRead ? value : 0.0f;
            }
        }
    }
}

#endif
#endif
