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
#define NTC_LAYER_OUTPUTS 208  // rows of all four layers: 64 + 64 + 64 + 16; 160 in generation 3

// What a layer has written, into an array that is indexed by constants only: the rolled loop over rows writes
// y at run-time indices, which keeps y in memory; x can be in registers for the next layer, whose rows all
// read it (FP32 on an H100: 5 times as fast).
#define NTC_COPY_TO_REGISTERS(x, y)                                                                          \
    NTC_UNROLL for (uint copied = 0u; copied < uint(4 * NTC_HIDDEN_WORDS); copied++) x[copied] = y[copied];

NTC_NAMESPACE_BEGIN

/// Words of high-resolution latents per corner, 1 ... 4 (NTC_NETWORK_SMALL ... NTC_NETWORK_XLARGE); of
/// generation 1.
NTC_FUNCTION uint NtcGetHighResWords(int networkVersion) {
    return uint(networkVersion);
}

/// True for the networks of generations 2 and 3, whose inputs are those of InputsMips.h.
NTC_FUNCTION bool NtcReadsLatentMips(int networkVersion) {
    return networkVersion >= NTC_NETWORK_GENERATION_2;
}

/// Words of network inputs. Generation 1: 4 corners, 4 of low-resolution latents, 3 waves, 1 with the level
/// of detail; later ones: 4 for each of two latent mips in the place of the latents.
NTC_FUNCTION uint NtcGetInputWords(int networkVersion) {
    return NtcReadsLatentMips(networkVersion) ? 12u : 4u * NtcGetHighResWords(networkVersion) + 8u;
}

/// Rows of a layer (0 ... 3), 4 to a word: 64, 64, 64 and 16, in generation 3 64, 48, 32 and 16.
NTC_FUNCTION uint NtcGetRowWords(int networkVersion, uint layer) {
    if (networkVersion == NTC_NETWORK_GENERATION_3)
        return 16u - 4u * layer;
    return layer < 3u ? 16u : 4u;
}

/// Rows of all layers before `layer` (0 ... 4).
NTC_FUNCTION uint NtcGetFirstRow(int networkVersion, uint layer) {
    if (networkVersion == NTC_NETWORK_GENERATION_3)
        return 64u * layer - 8u * layer * (layer - 1u);
    return layer < 4u ? 64u * layer : uint(NTC_LAYER_OUTPUTS);
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

/// The constant of the activation in binary32: 1/3, or the 0.333333 of generation 3.
NTC_FUNCTION float NtcGetThird(int networkVersion) {
    return networkVersion == NTC_NETWORK_GENERATION_3 ? 0.333332985639572144f : 0.333333343267440796f;
}

/// Activation in binary32; third: NtcGetThird.
NTC_FUNCTION float NtcApplyActivation(float thirdOfOne, float z) {
    if (NtcIsActivationZero(z))
        return 0.0f;
    if (NtcIsActivationMaximal(z))
        return 3.0f;
    NTC_PRECISE float third = NtcMultiply(z, thirdOfOne);
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

#if NTC_WITH_LATENT_MIPS
/// NtcActivateFloat of generation 3: another constant, and the offset is added after rounding.
NTC_FUNCTION uint NtcActivateFloatThenRound(float value) {
    int ordered = int(asuint(value)) > 0x7F800000 ? -1 : min(int(asuint(value)), 0x40400000);
    float z = asfloat(min(uint(ordered), 0xC0000000u));              // -2 ... 3
    NTC_PRECISE float third = NtcMultiply(z, 0.333332985639572144f); // 0x3EAAAA9F: 0.333333, not 1/3
    NTC_PRECISE float gate = third + 0.5f;
    gate = gate < 0.0f ? 0.0f : (gate > 1.0f ? 1.0f : gate);
    NTC_PRECISE float y = z * NtcKeep(gate);
    return (NtcRoundToByte(NtcMultiply(NtcKeep(y), 80.0f)) + 143u) & 255u; // - 113 in a byte
}
#endif

/// Activation and requantisation of a network and a maths mode: the byte that the next layer reads.
/// Generation 2 has binary16 between its layers whatever the mode.
NTC_FUNCTION uint NtcActivate(int networkVersion, int math, float z) {
#if NTC_WITH_LATENT_MIPS
    if (networkVersion == NTC_NETWORK_GENERATION_3 && math != NTC_MATH_INT8_HALF)
        return NtcActivateFloatThenRound(z);
    if (networkVersion == NTC_NETWORK_GENERATION_2)
        return NtcActivateHalf(z);
#endif
    if (math == NTC_MATH_INT8_HALF)
        return NtcActivateHalf(z);
    return NtcActivateFloat(z);
}

/// An output of the network: rounded to half where that is what lies between the layers. In FP8 it is
/// binary32.
NTC_FUNCTION float NtcFinishOutput(int networkVersion, int math, float z) {
    if (math == NTC_MATH_INT8_HALF || (networkVersion == NTC_NETWORK_GENERATION_2 && math == NTC_MATH_INT8))
        return NtcRoundToHalf(z);
    return z;
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
    uint rowWords; // rows / 4
};

/// The byte offset of a layer's matrix.
NTC_FUNCTION uint NtcGetLayerOffset(NtcLayerOffsets layers, uint layer) {
    if (layer < 2u)
        return uint(layer == 0u ? layers.layer0 : layers.layer1);
    return uint(layer == 2u ? layers.layer2 : layers.layer3);
}

/// Layer `index` of Int8 weights.
NTC_FUNCTION NtcLayer NtcGetLayer(int networkVersion, uint weightsOffset, NtcLayerOffsets layers,
                                  uint index) {
    NtcLayer layer;
    layer.weights = weightsOffset + NtcGetLayerOffset(layers, index);
    layer.scales = weightsOffset + uint(layers.scaleBias) + 4u * NtcGetFirstRow(networkVersion, index);
    layer.biases = layer.scales + 4u * NtcGetFirstRow(networkVersion, 4u);
    layer.inputWords =
        index == 0u ? NtcGetInputWords(networkVersion) : NtcGetRowWords(networkVersion, index - 1u);
    layer.rowWords = NtcGetRowWords(networkVersion, index);
    return layer;
}

/// Layers 1 and 2 where both have one shape (not in generation 3), by an index that is known at run time
/// only.
NTC_FUNCTION NtcLayer NtcGetInnerLayer(int networkVersion, uint weightsOffset, NtcLayerOffsets layers,
                                       uint index) {
    NtcLayer layer = NtcGetLayer(networkVersion, weightsOffset, layers, 1u);
    uint rows = 4u * layer.rowWords * (index - 1u);
    layer.weights = weightsOffset + uint(index == 1u ? layers.layer1 : layers.layer2);
    layer.scales += 4u * rows;
    layer.biases += 4u * rows;
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

/// The rows with activation, packed into words. The row loop stays rolled: unrolled, a driver takes minutes.
NTC_FUNCTION void NtcEvaluateHiddenLayer(int networkVersion, int math, NtcBuffer weights, NtcLayer layer,
                                         NTC_IN_ARRAY(uint, x, NTC_MAX_INPUT_WORDS),
                                         NTC_OUT_ARRAY(uint, y, NTC_MAX_INPUT_WORDS)) {
    NTC_LOOP for (uint word = 0u; word < layer.rowWords; word++) {
        uint packedBytes = 0u;
        NTC_LOOP for (uint i = 0u; i < 4u; i++) {
            float z = NtcEvaluateRow(weights, layer, 4u * word + i, x);
            packedBytes = packedBytes | (NtcActivate(networkVersion, math, z) << (8u * i));
        }
        y[word] = packedBytes;
    }
}

/// The outputs that are read (NTC_OUTPUT_MASK): no activation.
NTC_FUNCTION void NtcEvaluateOutputLayer(int networkVersion, int math, NtcBuffer weights, NtcLayer layer,
                                         NTC_IN_ARRAY(uint, x, NTC_MAX_INPUT_WORDS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    NTC_CLEAR_UNREAD_OUTPUTS(outputs);
    NTC_LOOP for (uint row = NTC_FIRST_OUTPUT; row < NTC_END_OUTPUT; row++) {
        if (NtcIsOutputRead(row))
            outputs[row] = NtcFinishOutput(networkVersion, math, NtcEvaluateRow(weights, layer, row, x));
    }
}

/// The whole network. networkVersion and math are literals at the outermost call, so that compilers fold
/// them. The five offsets are those of the texture-set constants, in bytes, relative to weightsOffset.
NTC_FUNCTION void NtcEvaluateNetwork(int networkVersion, int math, NtcBuffer weights, uint weightsOffset,
                                     NtcLayerOffsets layers, NTC_IN_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS),
                                     NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    uint a[NTC_MAX_INPUT_WORDS];
    uint b[NTC_MAX_INPUT_WORDS];
    NtcEvaluateHiddenLayer(networkVersion, math, weights,
                           NtcGetLayer(networkVersion, weightsOffset, layers, 0u), inputs, a);
    NtcEvaluateHiddenLayer(networkVersion, math, weights,
                           NtcGetLayer(networkVersion, weightsOffset, layers, 1u), a, b);
    NtcEvaluateHiddenLayer(networkVersion, math, weights,
                           NtcGetLayer(networkVersion, weightsOffset, layers, 2u), b, a);
    NtcEvaluateOutputLayer(networkVersion, math, weights,
                           NtcGetLayer(networkVersion, weightsOffset, layers, 3u), a, outputs);
}

NTC_NAMESPACE_END

#endif
