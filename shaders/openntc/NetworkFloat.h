// SPDX-License-Identifier: MIT
// Maths modes FP32 and FP16: the Int8 network in floating point, on inputs and activations that are not
// quantised.
//
// Row o of the Int8 network is z = S (B + sum_i q_i X_i) with the scale S, the int32 bias B and the signed
// bytes q. Its X are integers because of its quantisers; without them
//   layer 0       X_i = 127.5 x_i                                 x: the real inputs (InputsReal.h)
//   other layers  X_i = 80 y_i - 113                              y = min(z, 3) clamp(z / 3 + 1/2, 0, 1)
// and taking the offset -113 out of the sum, in integers and therefore exactly (format specification, network
// 10):
//   layer 0       z = S (B + sum_i q_i X_i)
//   other layers  z = S (B' + sum_i q_i 80 y_i),  B' = B - 113 sum_i q_i  (wrapping int32, as all of the
//                                                                         format's sums)
//
// FP32. s = 0; for every input in order: s = f32(s + f32(q X)); z = f32(f32(s + f32(B')) S). Activation:
// third = f32(z c), c = f32(1/3); gate = clamp(f32(third + 1/2), 0, 1); y = f32(z gate); next input f32(80
// y).
//
// FP16. Sums of q X would overflow, so inputs are X / 128 and y itself; |sum| < 64 * 127 * 3. Every operation
// is rounded to half: inputs go in blocks of 16, with a lane for each of the four bytes of a word. In a
// block, lane += q x over the words in order; then block = (lane0 + lane1) + (lane2 + lane3); then s +=
// block. The scale is a binary32 number, as halves would lose small ones: z = f16(f16(s k) + f16(f32(B') S))
// with k = f32(128 S) or f32(80 S). Activation as in the half epilogue of the Int8 network. Half arithmetic
// is emulated in binary32 (for +, - and * rounding the binary32 result again gives the correctly rounded
// half); NTC_NATIVE_FLOAT16 uses the device's, which gives the same finite numbers where it rounds to nearest
// even and keeps subnormals. GLSL then needs shaderFloat16; HLSL a compiler with 16-bit types.
//
// In generation 3 c is 0.333333 (NtcGetThird).
// Where z <= -1.5 or NaN, y = 0, and where z >= 3, y = 3, chosen by comparison as in the Int8 network.
#ifndef OPENNTC_NETWORK_FLOAT_H
#define OPENNTC_NETWORK_FLOAT_H

#include "Effects.h"
#include "InputsReal.h"
#include "Network.h"
#include "Portability.h"
#include "Switches.h"

#if defined(NTC_NATIVE_FLOAT16) && !defined(__cplusplus) && NTC_WITH_FP16
#if !defined(NTC_HLSL)
#extension GL_EXT_shader_explicit_arithmetic_types_float16 : require
#endif
#define NtcHalf float16_t
#define NtcToHalf(x) float16_t(x)
#else
#define NtcHalf float
#define NtcToHalf(x) (x)
#endif

NTC_NAMESPACE_BEGIN

#if NTC_WITH_FP32
/// One row in binary32. `offset` is 113 in the layers behind an activation, else 0.
NTC_FUNCTION float NtcEvaluateRealRow(NtcBuffer weights, NtcLayer layer, uint offset, uint row,
                                      NTC_IN_ARRAY(float, x, NTC_MAX_INPUTS)) {
    uint address = layer.weights + 4u * layer.inputWords * row;
    NTC_PRECISE float sum = 0.0f;
    int weightSum = 0;
    NTC_UNROLL for (uint i = 0u; i < layer.inputWords; i++) {
        uint word = NtcBufferLoad(weights, address + 4u * i);
        weightSum += NtcDot4(word, 0x01010101u);
        sum = NtcKeep(sum) + NtcMultiply(float(NtcSignedByte(word, 0u)), x[4u * i]);
        sum = NtcKeep(sum) + NtcMultiply(float(NtcSignedByte(word, 1u)), x[4u * i + 1u]);
        sum = NtcKeep(sum) + NtcMultiply(float(NtcSignedByte(word, 2u)), x[4u * i + 2u]);
        sum = NtcKeep(sum) + NtcMultiply(float(NtcSignedByte(word, 3u)), x[4u * i + 3u]);
    }
    uint bias = NtcBufferLoad(weights, layer.biases + 4u * row) - offset * uint(weightSum);
    sum = NtcKeep(sum) + float(int(bias));
    NTC_PRECISE float scale = asfloat(NtcBufferLoad(weights, layer.scales + 4u * row));
    return NtcMultiply(NtcKeep(sum), scale);
}
#endif

#if NTC_WITH_FP16
#if defined(NTC_NATIVE_FLOAT16) && !defined(__cplusplus)
#define NtcRoundSum(x) (x)
#else
/// Rounds to the nearest half, ties to even, where |x| < 65520; -0 becomes 0. Adding 3/2 of the power of two
/// whose floats are as far apart as halves are at x (2^-24 or more) does the rounding; taking it away again
/// is exact.
NTC_FUNCTION float NtcRoundSum(float x) {
    uint exponent = asuint(x) & 0x7F800000u;
    exponent = exponent < 0x38800000u ? 0x38800000u : exponent;
    NTC_PRECISE float shift = asfloat(exponent + 0x06C00000u);
    NTC_PRECISE float raised = NtcKeep(x) + shift;
    NTC_PRECISE float rounded = NtcKeep(raised) - shift;
    return rounded;
}
#endif

// Sums and products of a row: below 65520 and, as they start from +0, without a -0 that would matter.
NTC_FUNCTION NtcHalf NtcAddHalf(NtcHalf a, NtcHalf b) {
    NTC_PRECISE NtcHalf sum = a + b;
    return NtcRoundSum(sum);
}

NTC_FUNCTION NtcHalf NtcMultiplyHalf(NtcHalf a, NtcHalf b) {
    NTC_PRECISE NtcHalf product = a * b;
    return NtcRoundSum(product);
}

/// One row in binary16. `offset` is 113 in the layers behind an activation, else 0; `unit` is 80 there, else
/// 128.
NTC_FUNCTION float NtcEvaluateHalfRow(NtcBuffer weights, NtcLayer layer, uint offset, float unit, uint row,
                                      NTC_IN_ARRAY(NtcHalf, x, NTC_MAX_INPUTS)) {
    uint address = layer.weights + 4u * layer.inputWords * row;
    NtcHalf sum = NtcToHalf(0.0f);
    int weightSum = 0;
    NTC_UNROLL for (uint block = 0u; block < layer.inputWords; block += 4u) {
        NtcHalf lane0 = NtcToHalf(0.0f);
        NtcHalf lane1 = NtcToHalf(0.0f);
        NtcHalf lane2 = NtcToHalf(0.0f);
        NtcHalf lane3 = NtcToHalf(0.0f);
        // Constant bounds: Mesa does not unroll a loop from `block`, and then neither the outer one (four
        // times slower).
        NTC_UNROLL for (uint j = 0u; j < 4u; j++) {
            uint i = block + j;
            uint word = NtcBufferLoad(weights, address + 4u * i);
            weightSum += NtcDot4(word, 0x01010101u);
            NtcHalf weight0 = NtcToHalf(float(NtcSignedByte(word, 0u)));
            NtcHalf weight1 = NtcToHalf(float(NtcSignedByte(word, 1u)));
            NtcHalf weight2 = NtcToHalf(float(NtcSignedByte(word, 2u)));
            NtcHalf weight3 = NtcToHalf(float(NtcSignedByte(word, 3u)));
            lane0 = NtcAddHalf(lane0, NtcMultiplyHalf(weight0, x[4u * i]));
            lane1 = NtcAddHalf(lane1, NtcMultiplyHalf(weight1, x[4u * i + 1u]));
            lane2 = NtcAddHalf(lane2, NtcMultiplyHalf(weight2, x[4u * i + 2u]));
            lane3 = NtcAddHalf(lane3, NtcMultiplyHalf(weight3, x[4u * i + 3u]));
        }
        sum = NtcAddHalf(sum, NtcAddHalf(NtcAddHalf(lane0, lane1), NtcAddHalf(lane2, lane3)));
    }
    uint bias = NtcBufferLoad(weights, layer.biases + 4u * row) - offset * uint(weightSum);
    NTC_PRECISE float scale = asfloat(NtcBufferLoad(weights, layer.scales + 4u * row));
    float product = NtcRoundToHalf(NtcMultiply(float(sum), NtcMultiply(scale, unit)));
    float shift = NtcRoundToHalf(NtcMultiply(float(int(bias)), scale));
    NTC_PRECISE float z = product + shift;
    return NtcRoundToHalf(z);
}
#endif

#if NTC_WITH_FP32
/// The rows with activation, as inputs of the next layer. The row loop stays rolled.
NTC_FUNCTION void NtcEvaluateHiddenRealLayer(float third, NtcBuffer weights, NtcLayer layer, uint offset,
                                             NTC_IN_ARRAY(float, x, NTC_MAX_INPUTS),
                                             NTC_OUT_ARRAY(float, y, NTC_MAX_INPUTS)) {
    NTC_LOOP for (uint row = 0u; row < 4u * layer.rowWords; row++) y[row] =
        NtcMultiply(NtcApplyActivation(third, NtcEvaluateRealRow(weights, layer, offset, row, x)), 80.0f);
}

/// The network in binary32; arguments as those of NtcEvaluateNetwork.
NTC_FUNCTION void NtcEvaluateRealNetwork(int networkVersion, NtcBuffer weights, uint weightsOffset,
                                         NtcLayerOffsets layers, NTC_IN_ARRAY(float, inputs, NTC_MAX_INPUTS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    float x[NTC_MAX_INPUTS];
    float y[NTC_MAX_INPUTS];
    float third = NtcGetThird(networkVersion);
    NtcEvaluateHiddenRealLayer(third, weights, NtcGetLayer(networkVersion, weightsOffset, layers, 0u), 0u,
                               inputs, y);
#if NTC_WITH_EQUAL_LAYERS
    NTC_LOOP for (uint inner = 1u; inner < 3u; inner++) {
        NTC_COPY_TO_REGISTERS(x, y)
        NtcEvaluateHiddenRealLayer(
            third, weights, NtcGetInnerLayer(networkVersion, weightsOffset, layers, inner), 113u, x, y);
    }
#else
    NTC_COPY_TO_REGISTERS(x, y)
    NtcEvaluateHiddenRealLayer(third, weights, NtcGetLayer(networkVersion, weightsOffset, layers, 1u), 113u,
                               x, y);
    NTC_COPY_TO_REGISTERS(x, y)
    NtcEvaluateHiddenRealLayer(third, weights, NtcGetLayer(networkVersion, weightsOffset, layers, 2u), 113u,
                               x, y);
#endif
    NTC_COPY_TO_REGISTERS(x, y)
    NtcLayer last = NtcGetLayer(networkVersion, weightsOffset, layers, 3u);
    NTC_CLEAR_UNREAD_OUTPUTS(outputs);
    NTC_LOOP for (uint row = NTC_FIRST_OUTPUT; row < NTC_END_OUTPUT; row++) {
        if (NtcIsOutputRead(row))
            outputs[row] = NtcEvaluateRealRow(weights, last, 113u, row, x);
    }
}
#endif

#if NTC_WITH_FP16
/// The rows with activation, as inputs of the next layer. The row loop stays rolled.
NTC_FUNCTION void NtcEvaluateHiddenHalfLayer(NtcBuffer weights, NtcLayer layer, uint offset, float unit,
                                             NTC_IN_ARRAY(NtcHalf, x, NTC_MAX_INPUTS),
                                             NTC_OUT_ARRAY(NtcHalf, y, NTC_MAX_INPUTS)) {
    NTC_LOOP for (uint row = 0u; row < 4u * layer.rowWords; row++) y[row] =
        NtcToHalf(NtcApplyActivationHalf(NtcEvaluateHalfRow(weights, layer, offset, unit, row, x)));
}

/// The network in binary16; arguments as those of NtcEvaluateNetwork, inputs as halves kept in floats.
NTC_FUNCTION void NtcEvaluateHalfNetwork(int networkVersion, NtcBuffer weights, uint weightsOffset,
                                         NtcLayerOffsets layers, NTC_IN_ARRAY(float, inputs, NTC_MAX_INPUTS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    NtcHalf x[NTC_MAX_INPUTS];
    NtcHalf y[NTC_MAX_INPUTS];
    uint inputWords = NtcGetInputWords(networkVersion);
    NTC_UNROLL for (uint i = 0u; i < 4u * inputWords; i++) x[i] = NtcToHalf(inputs[i]);
    NtcEvaluateHiddenHalfLayer(weights, NtcGetLayer(networkVersion, weightsOffset, layers, 0u), 0u, 128.0f, x,
                               y);
#if NTC_WITH_EQUAL_LAYERS
    NTC_LOOP for (uint inner = 1u; inner < 3u; inner++) {
        NTC_COPY_TO_REGISTERS(x, y)
        NtcEvaluateHiddenHalfLayer(weights, NtcGetInnerLayer(networkVersion, weightsOffset, layers, inner),
                                   113u, 80.0f, x, y);
    }
#else
    NTC_COPY_TO_REGISTERS(x, y)
    NtcEvaluateHiddenHalfLayer(weights, NtcGetLayer(networkVersion, weightsOffset, layers, 1u), 113u, 80.0f,
                               x, y);
    NTC_COPY_TO_REGISTERS(x, y)
    NtcEvaluateHiddenHalfLayer(weights, NtcGetLayer(networkVersion, weightsOffset, layers, 2u), 113u, 80.0f,
                               x, y);
#endif
    NTC_COPY_TO_REGISTERS(x, y)
    NtcLayer last = NtcGetLayer(networkVersion, weightsOffset, layers, 3u);
    NTC_CLEAR_UNREAD_OUTPUTS(outputs);
    NTC_LOOP for (uint row = NTC_FIRST_OUTPUT; row < NTC_END_OUTPUT; row++) {
        if (NtcIsOutputRead(row))
            outputs[row] = NtcEvaluateHalfRow(weights, last, 113u, 80.0f, row, x);
    }
}
#endif

NTC_NAMESPACE_END

#endif
