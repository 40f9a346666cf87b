// SPDX-License-Identifier: MIT
// The Int8 network for NTC_TEXELS_PER_INVOCATION texels at once, with weights fetched as NTC_WEIGHT_FETCH says. The
// arithmetic is that of Network.h. Arrays hold the texels one after another.
#ifndef OPENNTC_NETWORK_TEXELS_H
#define OPENNTC_NETWORK_TEXELS_H

#include "Effects.h"
#include "MathModes.h"
#include "Network.h"
#include "Portability.h"
#include "WeightFetch.h"

#define NTC_TEXELS_INPUT_WORDS (NTC_TEXELS_PER_INVOCATION * NTC_MAX_INPUT_WORDS)
#define NTC_TEXELS_OUTPUTS (NTC_TEXELS_PER_INVOCATION * NTC_MAX_CHANNELS)

#if NTC_WITH_NETWORK_TEXELS

// Loop over the groups of 4 rows. Unrolled, drivers that compile to the CPU take minutes.
#ifndef NTC_ROW_LOOP
#define NTC_ROW_LOOP NTC_LOOP
#endif

#if NTC_FLOAT_DOT
#define NTC_SUM float
#define NTC_OPERAND float
#define NTC_TEXELS_OPERANDS (4 * NTC_TEXELS_INPUT_WORDS)
#else
#define NTC_SUM uint
#define NTC_OPERAND uint
#define NTC_TEXELS_OPERANDS NTC_TEXELS_INPUT_WORDS
#endif

/// Adds weights . operands of every texel to its sum, for word i of row r.
#if NTC_FLOAT_DOT
#define NTC_ADD_PRODUCTS(sums, r, w0, w1, w2, w3, x, i)                                                      \
    NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) {                                 \
        uint first = 4u * (uint(NTC_MAX_INPUT_WORDS) * t + (i));                                             \
        float sum = sums[4u * t + (r)];                                                                      \
        sum = sum + (w0)*x[first];                                                                           \
        sum = sum + (w1)*x[first + 1u];                                                                      \
        sum = sum + (w2)*x[first + 2u];                                                                      \
        sum = sum + (w3)*x[first + 3u];                                                                      \
        sums[4u * t + (r)] = sum;                                                                            \
    }
#define NTC_ADD_WORD(sums, r, word, x, i)                                                                    \
    {                                                                                                        \
        uint packed_ = word;                                                                                 \
        float v0 = float(NtcSignedByte(packed_, 0u));                                                        \
        float v1 = float(NtcSignedByte(packed_, 1u));                                                        \
        float v2 = float(NtcSignedByte(packed_, 2u));                                                        \
        float v3 = float(NtcSignedByte(packed_, 3u));                                                        \
        NTC_ADD_PRODUCTS(sums, r, v0, v1, v2, v3, x, i)                                                      \
    }
#else
#define NTC_ADD_WORD(sums, r, word, x, i)                                                                    \
    {                                                                                                        \
        uint packed_ = word;                                                                                 \
        NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) sums[4u * t + (r)] +=         \
            uint(NtcDot4(packed_, x[uint(NTC_MAX_INPUT_WORDS) * t + (i)]));                                  \
    }
#endif

/// Rows 4 group ... 4 group + 3 of every texel before activation: z[4 t + r].
NTC_FUNCTION void NtcEvaluateRowsOfTexels(NtcBuffer weights, NtcLayer layer, uint group,
                                          NTC_IN_ARRAY(NTC_OPERAND, x, NTC_TEXELS_OPERANDS),
                                          NTC_OUT_ARRAY(float, z, 4 * NTC_TEXELS_PER_INVOCATION)) {
    uint words = layer.inputWords;
    uint address = layer.weights + 16u * words * group;
    NTC_SUM sums[4 * NTC_TEXELS_PER_INVOCATION];
    NTC_UNROLL for (uint s = 0u; s < uint(4 * NTC_TEXELS_PER_INVOCATION); s++) sums[s] = NTC_SUM(0u);
    uint biases[4];
    uint scales[4];

#if NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP
    // The four rows are contiguous: lane l of 8 loads word l of every 8.
    uint lane = gl_SubgroupInvocationID & 7u;
    uint ownBias = NtcBufferLoad(weights, layer.biases + 16u * group + 4u * (lane & 3u));
    uint ownScale = NtcBufferLoad(weights, layer.scales + 16u * group + 4u * (lane & 3u));
#if NTC_FLOAT_DOT
    float own0[NTC_MAX_INPUT_WORDS / 2];
    float own1[NTC_MAX_INPUT_WORDS / 2];
    float own2[NTC_MAX_INPUT_WORDS / 2];
    float own3[NTC_MAX_INPUT_WORDS / 2];
    NTC_UNROLL for (uint c = 0u; c < words / 2u; c++) {
        uint word = NtcBufferLoad(weights, address + 32u * c + 4u * lane);
        own0[c] = float(NtcSignedByte(word, 0u));
        own1[c] = float(NtcSignedByte(word, 1u));
        own2[c] = float(NtcSignedByte(word, 2u));
        own3[c] = float(NtcSignedByte(word, 3u));
    }
#else
    uint own[NTC_MAX_INPUT_WORDS / 2];
    NTC_UNROLL for (uint c = 0u; c < words / 2u; c++) own[c] =
        NtcBufferLoad(weights, address + 32u * c + 4u * lane);
#endif
    NTC_UNROLL for (uint r = 0u; r < 4u; r++) {
        biases[r] = subgroupShuffle(ownBias, r);
        scales[r] = subgroupShuffle(ownScale, r);
    }
    NTC_UNROLL for (uint i = 0u; i < words; i++) {
        NTC_UNROLL for (uint row = 0u; row < 4u; row++) {
            uint n = row * words + i;
#if NTC_FLOAT_DOT
            float w0 = subgroupShuffle(own0[n >> 3], n & 7u);
            float w1 = subgroupShuffle(own1[n >> 3], n & 7u);
            float w2 = subgroupShuffle(own2[n >> 3], n & 7u);
            float w3 = subgroupShuffle(own3[n >> 3], n & 7u);
            NTC_ADD_PRODUCTS(sums, row, w0, w1, w2, w3, x, i)
#else
            NTC_ADD_WORD(sums, row, subgroupShuffle(own[n >> 3], n & 7u), x, i)
#endif
        }
    }
#elif NTC_WEIGHT_FETCH == NTC_FETCH_UNIFORM || NTC_WIDE_WEIGHT_LOADS
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
            NTC_ADD_WORD(sums, row, four.x, x, i)
            NTC_ADD_WORD(sums, row, four.y, x, i + 1u)
            NTC_ADD_WORD(sums, row, four.z, x, i + 2u)
            NTC_ADD_WORD(sums, row, four.w, x, i + 3u)
        }
    }
#else
    NTC_UNROLL for (uint r = 0u; r < 4u; r++) {
        biases[r] = NtcBufferLoad(weights, layer.biases + 16u * group + 4u * r);
        scales[r] = NtcBufferLoad(weights, layer.scales + 16u * group + 4u * r);
    }
    NTC_UNROLL for (uint i = 0u; i < words; i++) {
        NTC_UNROLL for (uint row = 0u; row < 4u; row++)
            NTC_ADD_WORD(sums, row, NtcBufferLoad(weights, address + 4u * (row * words + i)), x, i)
    }
#endif

    NTC_UNROLL for (uint texel = 0u; texel < uint(NTC_TEXELS_PER_INVOCATION); texel++) {
        NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
            NTC_PRECISE float scale = asfloat(scales[k]);
            z[4u * texel + k] = NtcMultiply(float(int(biases[k] + uint(int(sums[4u * texel + k])))), scale);
        }
    }
}

/// 64 rows with activation, as operands of the next layer.
NTC_FUNCTION void NtcEvaluateHiddenLayerOfTexels(int math, NtcBuffer weights, NtcLayer layer,
                                                 NTC_IN_ARRAY(NTC_OPERAND, x, NTC_TEXELS_OPERANDS),
                                                 NTC_OUT_ARRAY(NTC_OPERAND, y, NTC_TEXELS_OPERANDS)) {
    NTC_ROW_LOOP for (uint group = 0u; group < uint(NTC_HIDDEN_WORDS); group++) {
        float z[4 * NTC_TEXELS_PER_INVOCATION];
        NtcEvaluateRowsOfTexels(weights, layer, group, x, z);
        NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) {
            uint packed = 0u;
            NTC_UNROLL for (uint i = 0u; i < 4u; i++) {
                uint quantized = 0u;
                if (math == NTC_MATH_INT8_HALF)
                    quantized = NtcActivateHalf(z[4u * t + i]);
                else
                    quantized = NtcActivateFloat(z[4u * t + i]);
#if NTC_FLOAT_DOT
                y[4u * (uint(NTC_MAX_INPUT_WORDS) * t + group) + i] = float(NtcSignedByte(quantized, 0u));
#endif
                packed = packed | (quantized << (8u * i));
            }
#if !NTC_FLOAT_DOT
            y[uint(NTC_MAX_INPUT_WORDS) * t + group] = packed;
#endif
        }
    }
}

/// NtcEvaluateNetwork for several texels: inputs[NTC_MAX_INPUT_WORDS t + word], outputs[NTC_MAX_CHANNELS t + channel].
/// weightsOffset: a multiple of 16 with UNIFORM and with wide loads.
NTC_FUNCTION void NtcEvaluateNetworkOfTexels(int networkVersion, int math, NtcBuffer weights,
                                             uint weightsOffset, int layerOffset0, int layerOffset1,
                                             int layerOffset2, int layerOffset3, int scaleBiasOffset,
                                             NTC_IN_ARRAY(uint, inputs, NTC_TEXELS_INPUT_WORDS),
                                             NTC_OUT_ARRAY(float, outputs, NTC_TEXELS_OUTPUTS)) {
    NTC_OPERAND a[NTC_TEXELS_OPERANDS];
    NTC_OPERAND b[NTC_TEXELS_OPERANDS];
    uint scales = uint(scaleBiasOffset);
    uint hidden = uint(NTC_HIDDEN_WORDS);
    uint inputWords = NtcGetInputWords(networkVersion);
    NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) {
        NTC_UNROLL for (uint i = 0u; i < inputWords; i++) {
            uint word = uint(NTC_MAX_INPUT_WORDS) * t + i;
#if NTC_FLOAT_DOT
            NTC_UNROLL for (uint k = 0u; k < 4u; k++) b[4u * word + k] =
                float(NtcSignedByte(inputs[word], k));
#else
            b[word] = inputs[word];
#endif
        }
    }
    NtcEvaluateHiddenLayerOfTexels(
        math, weights, NtcMakeLayer(weightsOffset, uint(layerOffset0), scales, 0u, inputWords), b, a);
    NtcEvaluateHiddenLayerOfTexels(
        math, weights, NtcMakeLayer(weightsOffset, uint(layerOffset1), scales, 64u, hidden), a, b);
    NtcEvaluateHiddenLayerOfTexels(
        math, weights, NtcMakeLayer(weightsOffset, uint(layerOffset2), scales, 128u, hidden), b, a);
    NtcLayer layer = NtcMakeLayer(weightsOffset, uint(layerOffset3), scales, 192u, hidden);
#if NTC_OUTPUT_MASK != 0xFFFF
    NTC_UNROLL for (uint unread = 0u; unread < uint(NTC_TEXELS_OUTPUTS); unread++) outputs[unread] = 0.0f;
#endif
    NTC_ROW_LOOP for (uint group = NTC_FIRST_OUTPUT / 4u; group < (NTC_END_OUTPUT + 3u) / 4u; group++) {
        float z[4 * NTC_TEXELS_PER_INVOCATION];
        NtcEvaluateRowsOfTexels(weights, layer, group, a, z);
        NTC_UNROLL for (uint texel = 0u; texel < uint(NTC_TEXELS_PER_INVOCATION); texel++) {
            NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
                float value = z[4u * texel + k];
                if (math == NTC_MATH_INT8_HALF)
                    value = NtcRoundToHalf(value);
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
