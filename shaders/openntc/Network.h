// SPDX-License-Identifier: MIT
// The Int8 network: packed inputs, four fully connected layers, HGELU-clamp activation and requantisation
// (format specification, network 3). Same bits in every language and on every device whose compiler keeps its
// roundings (Portability.h).
#ifndef OPENNTC_NETWORK_H
#define OPENNTC_NETWORK_H

#include "Buffers.h"
#include "Effects.h"
#include "InferenceConstants.h"
#include "Portability.h"
#include "Rounding.h"
#include "Switches.h"

#define NTC_MAX_INPUT_WORDS 24 // 96 inputs, 4 to a word
#define NTC_HIDDEN_WORDS 16    // 64 hidden values
#define NTC_LAYER_OUTPUTS 208  // rows of all four layers: 64 + 64 + 64 + 16

// What a layer has written, into an array that is indexed by constants only: the rolled loop over rows writes
// y at run-time indices, which keeps y in memory; x can be in registers for the next layer, whose rows all
// read it (FP32 on an H100: 5 times as fast).
#define NTC_COPY_TO_REGISTERS(x, y)                                                                          \
    NTC_UNROLL for (uint copied = 0u; copied < uint(4 * NTC_HIDDEN_WORDS); copied++) x[copied] = y[copied];

NTC_NAMESPACE_BEGIN

/// Words of high-resolution latents per corner, 1 ... 4 (NTC_NETWORK_SMALL ... NTC_NETWORK_XLARGE).
NTC_FUNCTION uint NtcGetHighResWords(int networkVersion) {
    return uint(networkVersion);
}

/// Words of network inputs: 4 corners, 4 of low-resolution latents, 3 waves, 1 with the level of detail.
NTC_FUNCTION uint NtcGetInputWords(int networkVersion) {
    return 4u * NtcGetHighResWords(networkVersion) + 8u;
}

// Both activations: y = min(z, 3) clamp(z / 3 + 1/2, 0, 1). Outside (-1.5, 3) the result is constant and
// chosen by the bits of z before any arithmetic, so that infinities have one defined result; NaN is taken as
// -infinity. Requantisation: round(80 y - 113).

NTC_FUNCTION bool NtcIsActivationZero(float z) {
    return asuint(z) >= 0xBFC00000u || NtcIsNan(z); // z <= -1.5
}

NTC_FUNCTION bool NtcIsActivationMaximal(float z) {
    return asuint(z) >= 0x40400000u && asuint(z) <= 0x7F800000u; // z >= 3
}

/// Activation in binary32.
NTC_FUNCTION float NtcApplyActivation(float z) {
    if (NtcIsActivationZero(z))
        return 0.0f;
    if (NtcIsActivationMaximal(z))
        return 3.0f;
    NTC_PRECISE float third = NtcMultiply(z, 0.333333343267440796f); // 0x3EAAAAAB
    NTC_PRECISE float gate = third + 0.5f;
    gate = gate < 0.0f ? 0.0f : (gate > 1.0f ? 1.0f : gate);
    NTC_PRECISE float y = z * NtcKeep(gate);
    return NtcKeep(y);
}

/// Activation in binary16 of a half. Products of halves are exact in binary32, and so are these sums wherever
/// it matters, so rounding the binary32 result to half is the one rounding of half arithmetic.
NTC_FUNCTION float NtcApplyActivationHalf(float z) {
    if (NtcIsActivationZero(z))
        return 0.0f;
    if (NtcIsActivationMaximal(z))
        return 3.0f;
    NTC_PRECISE float third = NtcRoundToHalf(z * 0.333251953125f); // 0x3555
    NTC_PRECISE float gate = NtcRoundToHalf(third + 0.5f);
    gate = gate < 0.0f ? 0.0f : (gate > 1.0f ? 1.0f : gate);
    NTC_PRECISE float y = NtcRoundToHalf(z * gate);
    return y;
}

/// Activation and requantisation in binary32; the byte that the next layer reads. Bounds of z instead of the
/// constant results: at -2 the gate is 0, at 3 it is 1 and 3 z's product, and what lies between is computed.
NTC_FUNCTION uint NtcActivateFloat(float value) {
    // Positive numbers are in the order of their bits, at most 3; behind infinity comes NaN. Negative ones
    // are in the opposite order, at least -2, NaN among them.
    int ordered = int(asuint(value)) > 0x7F800000 ? -1 : min(int(asuint(value)), 0x40400000);
    uint bits = min(uint(ordered), 0xC0000000u);
    float z = asfloat(bits);
    NTC_PRECISE float third = NtcMultiply(z, 0.333333343267440796f); // 0x3EAAAAAB
    NTC_PRECISE float gate = third + 0.5f;
#if defined(__cplusplus)
    gate = gate < 0.0f ? 0.0f : (gate > 1.0f ? 1.0f : gate);
#else
    gate = clamp(gate, 0.0f, 1.0f); // of a number: z is -2 ... 3
#endif
    NTC_PRECISE float y = z * NtcKeep(gate);
    NTC_PRECISE float steps = NtcMultiply(NtcKeep(y), 80.0f);
    NTC_PRECISE float shifted = steps - 113.0f;
    return NtcRoundToByte(shifted);
}

/// The same with binary16 arithmetic.
NTC_FUNCTION uint NtcActivateHalf(float accumulated) {
    float y = NtcApplyActivationHalf(NtcRoundToHalf(accumulated));
    NTC_PRECISE float steps = NtcRoundToHalf(y * 80.0f);
    NTC_PRECISE float shifted = NtcRoundToHalf(steps - 113.0f);
    return NtcRoundToByte(shifted);
}

/// Byte offsets of the layers and of their scales and biases, as the texture-set constants have them.
struct NtcLayerOffsets {
    int layer0;
    int layer1;
    int layer2;
    int layer3;
    int scaleBias;
};

NTC_FUNCTION NtcLayerOffsets NtcMakeLayerOffsets(int layer0, int layer1, int layer2, int layer3,
                                                 int scaleBias) {
    NtcLayerOffsets layers;
    layers.layer0 = layer0;
    layers.layer1 = layer1;
    layers.layer2 = layer2;
    layers.layer3 = layer3;
    layers.scaleBias = scaleBias;
    return layers;
}

/// Where one layer lies in the weight buffer: byte offsets, and its shape.
struct NtcLayer {
    uint weights; // rows of 4 * inputWords signed bytes
    uint scales;  // binary32 per row
    uint biases;  // int32 per row
    uint inputWords;
};

NTC_FUNCTION NtcLayer NtcMakeLayer(uint weightsOffset, uint layerOffset, uint scaleBiasOffset, uint firstRow,
                                   uint inputWords) {
    NtcLayer layer;
    layer.weights = weightsOffset + layerOffset;
    layer.scales = weightsOffset + scaleBiasOffset + 4u * firstRow;
    layer.biases = layer.scales + uint(4 * NTC_LAYER_OUTPUTS);
    layer.inputWords = inputWords;
    return layer;
}

/// One row: (bias + weights . x) * scale, the sum in wrapping 32-bit integers, one rounding in the product.
NTC_FUNCTION float NtcEvaluateRow(NtcBuffer weights, NtcLayer layer, uint row,
                                  NTC_IN_ARRAY(uint, x, NTC_MAX_INPUT_WORDS)) {
    uint address = layer.weights + 4u * layer.inputWords * row;
    uint sum = NtcBufferLoad(weights, layer.biases + 4u * row);
    NTC_UNROLL for (uint i = 0u; i < layer.inputWords; i++) sum +=
        uint(NtcDot4(NtcBufferLoad(weights, address + 4u * i), x[i]));
    NTC_PRECISE float scale = asfloat(NtcBufferLoad(weights, layer.scales + 4u * row));
    NTC_PRECISE float z = NtcMultiply(float(int(sum)), scale);
    return z;
}

/// 64 rows with activation, packed into 16 words. The row loop stays rolled: unrolled, a driver takes
/// minutes.
NTC_FUNCTION void NtcEvaluateHiddenLayer(int math, NtcBuffer weights, NtcLayer layer,
                                         NTC_IN_ARRAY(uint, x, NTC_MAX_INPUT_WORDS),
                                         NTC_OUT_ARRAY(uint, y, NTC_MAX_INPUT_WORDS)) {
    NTC_LOOP for (uint word = 0u; word < uint(NTC_HIDDEN_WORDS); word++) {
        uint packedBytes = 0u;
        NTC_LOOP for (uint i = 0u; i < 4u; i++) {
            float z = NtcEvaluateRow(weights, layer, 4u * word + i, x);
            uint quantized = 0u;
            if (math == NTC_MATH_INT8_HALF)
                quantized = NtcActivateHalf(z);
            else
                quantized = NtcActivateFloat(z);
            packedBytes = packedBytes | (quantized << (8u * i));
        }
        y[word] = packedBytes;
    }
}

/// The outputs that are read (NTC_OUTPUT_MASK): no activation; rounded to half under NTC_MATH_INT8_HALF.
NTC_FUNCTION void NtcEvaluateOutputLayer(int math, NtcBuffer weights, NtcLayer layer,
                                         NTC_IN_ARRAY(uint, x, NTC_MAX_INPUT_WORDS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    NTC_CLEAR_UNREAD_OUTPUTS(outputs);
    NTC_LOOP for (uint row = NTC_FIRST_OUTPUT; row < NTC_END_OUTPUT; row++) {
        if (NtcIsOutputRead(row)) {
            float z = NtcEvaluateRow(weights, layer, row, x);
            if (math == NTC_MATH_INT8_HALF)
                z = NtcRoundToHalf(z);
            outputs[row] = z;
        }
    }
}

/// The whole network. networkVersion and math are literals at the outermost call, so that compilers fold
/// them. The five offsets are those of the texture-set constants, in bytes, relative to weightsOffset.
NTC_FUNCTION void NtcEvaluateNetwork(int networkVersion, int math, NtcBuffer weights, uint weightsOffset,
                                     NtcLayerOffsets layers, NTC_IN_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS),
                                     NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    uint a[NTC_MAX_INPUT_WORDS];
    uint b[NTC_MAX_INPUT_WORDS];
    uint scales = uint(layers.scaleBias);
    uint hidden = uint(NTC_HIDDEN_WORDS);
    NtcEvaluateHiddenLayer(
        math, weights,
        NtcMakeLayer(weightsOffset, uint(layers.layer0), scales, 0u, NtcGetInputWords(networkVersion)),
        inputs, a);
    NtcEvaluateHiddenLayer(math, weights,
                           NtcMakeLayer(weightsOffset, uint(layers.layer1), scales, 64u, hidden), a, b);
    NtcEvaluateHiddenLayer(math, weights,
                           NtcMakeLayer(weightsOffset, uint(layers.layer2), scales, 128u, hidden), b, a);
    NtcEvaluateOutputLayer(
        math, weights, NtcMakeLayer(weightsOffset, uint(layers.layer3), scales, 192u, hidden), a, outputs);
}

NTC_NAMESPACE_END

#endif
