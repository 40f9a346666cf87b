// SPDX-License-Identifier: MIT
// Maths mode FP8: the FP8 network (format specification, network 5) without FP8 hardware.
//
// Layers 0 to 2: E4M3 inputs and weights. s = bias (binary16, widened); for every input in order s = f32(s +
// w x), whose products are exact in binary32; z = f16(s). Activation in binary16; what layers 0 and 1 pass on
// is rounded to E4M3, what layer 2 passes on is quantised as in the Int8 network, half epilogue. Layer 3:
// signed bytes, int32 bias, binary32 scale; outputs in binary32. Hardware adds up in an order and precision
// of its own, so its results lie in an interval around these.
#ifndef OPENNTC_NETWORK_FP8_H
#define OPENNTC_NETWORK_FP8_H

#include "InputsReal.h"
#include "Network.h"
#include "Portability.h"
#include "Switches.h"

#if NTC_WITH_FP8
NTC_NAMESPACE_BEGIN

/// Byte `index` (0 is the lowest) of a word as an E4M3 number, exact. The format rejects NaN weights; here
/// 0x7F and 0xFF would be +-480.
NTC_FUNCTION float NtcWidenE4M3(uint word, uint index) {
    uint code = word >> (8u * index);
    uint magnitude = code & 0x7Fu;
    float value = asfloat((magnitude << 20) + 0x3C000000u);
    if (magnitude < 8u)
        value = float(magnitude) * 0.001953125f; // subnormals: multiples of 2^-9
    return asfloat(asuint(value) | ((code & 0x80u) << 24));
}

/// Bits of a binary16 number to float, exact; not for infinities and NaN.
NTC_FUNCTION float NtcWidenHalf(uint code) {
    uint magnitude = code & 0x7FFFu;
    float value = asfloat((magnitude << 13) + 0x38000000u);
    if (magnitude < 0x400u)
        value = float(magnitude) * 5.9604644775390625e-8f; // subnormals: multiples of 2^-24
    return asfloat(asuint(value) | ((code & 0x8000u) << 16));
}

/// One row of layers 0 to 2, rounded to half. layer.biases: binary16, two to a word.
NTC_FUNCTION float NtcEvaluateE4M3Row(NtcBuffer weights, NtcLayer layer, uint row,
                                      NTC_IN_ARRAY(float, x, NTC_MAX_INPUTS)) {
    uint address = layer.weights + 4u * layer.inputWords * row;
    NTC_PRECISE float sum =
        NtcWidenHalf(NtcBufferLoad(weights, layer.biases + 4u * (row >> 1)) >> (16u * (row & 1u)));
    NTC_UNROLL for (uint i = 0u; i < layer.inputWords; i++) {
        uint word = NtcBufferLoad(weights, address + 4u * i);
        sum = NtcKeep(sum) + NtcMultiply(NtcWidenE4M3(word, 0u), x[4u * i]);
        sum = NtcKeep(sum) + NtcMultiply(NtcWidenE4M3(word, 1u), x[4u * i + 1u]);
        sum = NtcKeep(sum) + NtcMultiply(NtcWidenE4M3(word, 2u), x[4u * i + 2u]);
        sum = NtcKeep(sum) + NtcMultiply(NtcWidenE4M3(word, 3u), x[4u * i + 3u]);
    }
    return NtcRoundToHalf(sum);
}

/// Layer `index` of FP8 weights: layers 0 to 2 have binary16 biases and no scales; layer 3 has its scales
/// behind those, and int32 biases.
NTC_FUNCTION NtcLayer NtcGetE4M3Layer(int networkVersion, uint weightsOffset, NtcLayerOffsets layers,
                                      uint index) {
    NtcLayer layer = NtcGetLayer(networkVersion, weightsOffset, layers, index);
    uint start = weightsOffset + uint(layers.scaleBias) + 2u * NtcGetFirstRow(networkVersion, index);
    layer.scales = start;
    layer.biases = index < 3u ? start : start + uint(4 * NTC_MAX_CHANNELS);
    return layer;
}

/// The rows with activation, as inputs of the next layer. The row loop stays rolled.
NTC_FUNCTION void NtcEvaluateHiddenE4M3Layer(NtcBuffer weights, NtcLayer layer,
                                             NTC_IN_ARRAY(float, x, NTC_MAX_INPUTS),
                                             NTC_OUT_ARRAY(float, y, NTC_MAX_INPUTS)) {
    NTC_LOOP for (uint row = 0u; row < 4u * layer.rowWords; row++) y[row] =
        NtcRoundToE4M3(NtcApplyActivationHalf(NtcEvaluateE4M3Row(weights, layer, row, x)));
}

/// The network; inputs are E4M3 numbers in floats. The offsets are those of the texture-set constants for FP8
/// weights.
NTC_FUNCTION void NtcEvaluateE4M3Network(int networkVersion, NtcBuffer weights, uint weightsOffset,
                                         NtcLayerOffsets layers, NTC_IN_ARRAY(float, inputs, NTC_MAX_INPUTS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    float a[NTC_MAX_INPUTS];
    float b[NTC_MAX_INPUTS];
    NtcEvaluateHiddenE4M3Layer(weights, NtcGetE4M3Layer(networkVersion, weightsOffset, layers, 0u), inputs,
                               a);
    NtcEvaluateHiddenE4M3Layer(weights, NtcGetE4M3Layer(networkVersion, weightsOffset, layers, 1u), a, b);
    NtcLayer layer = NtcGetE4M3Layer(networkVersion, weightsOffset, layers, 2u);
    uint packedBytes[NTC_MAX_INPUT_WORDS];
    NTC_LOOP for (uint word = 0u; word < layer.rowWords; word++) {
        uint bytes = 0u;
        NTC_LOOP for (uint i = 0u; i < 4u; i++) bytes =
            bytes | (NtcActivateHalf(NtcEvaluateE4M3Row(weights, layer, 4u * word + i, b)) << (8u * i));
        packedBytes[word] = bytes;
    }
    NtcEvaluateOutputLayer(networkVersion, NTC_MATH_FP8, weights,
                           NtcGetE4M3Layer(networkVersion, weightsOffset, layers, 3u), packedBytes, outputs);
}

NTC_NAMESPACE_END
#endif

#endif
