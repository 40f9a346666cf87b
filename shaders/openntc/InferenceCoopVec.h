// SPDX-License-Identifier: MIT
// The networks with cooperative vectors (GLSL, GL_NV_cooperative_vector, Vulkan 1.3): maths modes
// COOPVEC_INT8 and COOPVEC_FP8. Matrices must have been converted to the device's inferencing-optimal layout
// (include/openntc/inference/CooperativeVectors.h); their order and the offsets in the constants are those
// that the conversion returns. weightsOffset: a multiple of 64.
//
// NTC_COOPVEC_WEIGHTS: the weights as an array of uint in a storage buffer; the default bindings' one unless
// defined. NTC_COOPVEC_EXPLICIT: 1 packs the activations to bytes in the shader, with the arithmetic of
// NTC_MATH_INT8; otherwise the multiplication converts them, rounding to nearest even and saturating, which
// gives the same bits and is faster.
#ifndef OPENNTC_INFERENCE_COOPVEC_H
#define OPENNTC_INFERENCE_COOPVEC_H

#include "Effects.h"
#include "InputsReal.h"
#include "Network.h"
#include "Portability.h"
#include "Switches.h"

#if defined(__cplusplus) || defined(NTC_HLSL)
#error NTC_MATH: NTC_MATH_COOPVEC_INT8 and NTC_MATH_COOPVEC_FP8 exist in GLSL only
#endif
#ifndef NETWORK_VERSION
#error NETWORK_VERSION is not defined
#endif

#extension GL_NV_cooperative_vector : require
#extension GL_KHR_memory_scope_semantics : require
#extension GL_EXT_shader_explicit_arithmetic_types : require

#ifndef NTC_COOPVEC_WEIGHTS
#define NTC_COOPVEC_WEIGHTS ntcWeights.words
#endif
#ifndef NTC_COOPVEC_EXPLICIT
#define NTC_COOPVEC_EXPLICIT 0
#endif
#ifndef NTC_COOPVEC_LAYOUT
#define NTC_COOPVEC_LAYOUT gl_CooperativeVectorMatrixLayoutInferencingOptimalNV
#endif

const int kNtcCoopVecInputWords = 4 * NETWORK_VERSION + 8;
const int kNtcCoopVecInputs = 4 * kNtcCoopVecInputWords;

/// result = matrix (signed bytes) * x + bias (int32).
#define NTC_COOPVEC_MULTIPLY_INT8(result, x, interpretation, matrix, bias, rows, columns)                    \
    coopVecMatMulAddNV(result, x, interpretation, NTC_COOPVEC_WEIGHTS, matrix, gl_ComponentTypeSignedInt8NV, \
                       NTC_COOPVEC_WEIGHTS, bias, gl_ComponentTypeSignedInt32NV, rows, columns,              \
                       NTC_COOPVEC_LAYOUT, false, columns)

/// Activation and the steps of requantisation but the last rounding.
coopvecNV<float, 64> NtcActivateCoopVec(coopvecNV<int32_t, 64> sums, uint scalesOffset) {
    coopvecNV<float, 64> scales;
    coopVecLoadNV(scales, NTC_COOPVEC_WEIGHTS, scalesOffset);
    precise coopvecNV<float, 64> z = coopvecNV<float, 64>(sums) * scales;
    z = min(max(z, coopvecNV<float, 64>(-1.5)), coopvecNV<float, 64>(3.0));
    precise coopvecNV<float, 64> third = z * coopvecNV<float, 64>(0.333333343267440796); // 0x3EAAAAAB
    precise coopvecNV<float, 64> gate = third + coopvecNV<float, 64>(0.5);
    gate = clamp(gate, coopvecNV<float, 64>(0.0), coopvecNV<float, 64>(1.0));
    precise coopvecNV<float, 64> y = z * gate;
    precise coopvecNV<float, 64> steps = y * coopvecNV<float, 64>(80.0);
    precise coopvecNV<float, 64> shifted = steps - coopvecNV<float, 64>(113.0);
    return shifted;
}

#if NTC_COOPVEC_EXPLICIT
/// Bytes of the next layer's input.
coopvecNV<uint32_t, 16> NtcPackCoopVec(coopvecNV<int32_t, 64> sums, uint scalesOffset) {
    coopvecNV<float, 64> scales;
    coopVecLoadNV(scales, NTC_COOPVEC_WEIGHTS, scalesOffset);
    coopvecNV<uint32_t, 16> bytes;
    [[unroll]] for (int i = 0; i < 16; i++) {
        uint packedBytes = 0u;
        [[unroll]] for (int k = 0; k < 4; k++) packedBytes |=
            NtcActivateFloat(NtcMultiply(float(sums[4 * i + k]), scales[4 * i + k])) << uint(8 * k);
        bytes[i] = packedBytes;
    }
    return bytes;
}
#define NTC_COOPVEC_NEXT(sums, scalesOffset) NtcPackCoopVec(sums, scalesOffset)
#define NTC_COOPVEC_NEXT_TYPE gl_ComponentTypeSignedInt8PackedNV
#else
#define NTC_COOPVEC_NEXT(sums, scalesOffset) NtcActivateCoopVec(sums, scalesOffset)
#define NTC_COOPVEC_NEXT_TYPE gl_ComponentTypeSignedInt8NV
#endif

#if NTC_MATH == NTC_MATH_COOPVEC_INT8
/// The Int8 network; scales and biases are where NtcEvaluateNetwork has them.
void NtcEvaluateInt8CoopVec(uint weightsOffset, NtcLayerOffsets layers, in uint inputs[NTC_MAX_INPUT_WORDS],
                            out float outputs[NTC_MAX_CHANNELS]) {
    uint scales = weightsOffset + uint(layers.scaleBias);
    uint biases = scales + uint(4 * NTC_LAYER_OUTPUTS);
    coopvecNV<uint32_t, kNtcCoopVecInputWords> x;
    [[unroll]] for (int i = 0; i < kNtcCoopVecInputWords; i++) x[i] = inputs[i];
    coopvecNV<int32_t, 64> sums;
    NTC_COOPVEC_MULTIPLY_INT8(sums, x, gl_ComponentTypeSignedInt8PackedNV,
                              weightsOffset + uint(layers.layer0), biases, 64, kNtcCoopVecInputs);
    NTC_COOPVEC_MULTIPLY_INT8(sums, NTC_COOPVEC_NEXT(sums, scales), NTC_COOPVEC_NEXT_TYPE,
                              weightsOffset + uint(layers.layer1), biases + 256u, 64, 64);
    NTC_COOPVEC_MULTIPLY_INT8(sums, NTC_COOPVEC_NEXT(sums, scales + 256u), NTC_COOPVEC_NEXT_TYPE,
                              weightsOffset + uint(layers.layer2), biases + 512u, 64, 64);
    coopvecNV<int32_t, 16> last;
    NTC_COOPVEC_MULTIPLY_INT8(last, NTC_COOPVEC_NEXT(sums, scales + 512u), NTC_COOPVEC_NEXT_TYPE,
                              weightsOffset + uint(layers.layer3), biases + 768u, 16, 64);
    coopvecNV<float, 16> lastScales;
    coopVecLoadNV(lastScales, NTC_COOPVEC_WEIGHTS, scales + 768u);
    coopvecNV<float, 16> results = coopvecNV<float, 16>(last) * lastScales;
    [[unroll]] for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) outputs[c] =
        ((uint(NTC_OUTPUT_MASK) >> c) & 1u) != 0u ? results[c] : 0.0;
}
#endif

#if NTC_MATH == NTC_MATH_COOPVEC_FP8
#define NTC_COOPVEC_MULTIPLY_E4M3(result, x, matrix, bias, columns)                                          \
    coopVecMatMulAddNV(result, x, gl_ComponentTypeFloatE4M3NV, NTC_COOPVEC_WEIGHTS, matrix,                  \
                       gl_ComponentTypeFloatE4M3NV, NTC_COOPVEC_WEIGHTS, bias, gl_ComponentTypeFloat16NV,    \
                       64, columns, NTC_COOPVEC_LAYOUT, false, columns)

/// Activation in binary16.
coopvecNV<float16_t, 64> NtcActivateHalfCoopVec(coopvecNV<float16_t, 64> sums) {
    precise coopvecNV<float16_t, 64> z =
        min(max(sums, coopvecNV<float16_t, 64>(float16_t(-1.5))), coopvecNV<float16_t, 64>(float16_t(3.0)));
    precise coopvecNV<float16_t, 64> third = z * coopvecNV<float16_t, 64>(float16_t(0.333251953125));
    precise coopvecNV<float16_t, 64> gate = third + coopvecNV<float16_t, 64>(float16_t(0.5));
    gate = clamp(gate, coopvecNV<float16_t, 64>(float16_t(0.0)), coopvecNV<float16_t, 64>(float16_t(1.0)));
    precise coopvecNV<float16_t, 64> y = z * gate;
    return y;
}

/// The FP8 network; inputs are E4M3 numbers. Biases and scales are where NtcEvaluateE4M3Network has them.
void NtcEvaluateE4M3CoopVec(uint weightsOffset, NtcLayerOffsets layers, in float inputs[NTC_MAX_INPUTS],
                            out float outputs[NTC_MAX_CHANNELS]) {
    uint biases = weightsOffset + uint(layers.scaleBias);
    coopvecNV<float16_t, kNtcCoopVecInputs> x;
    [[unroll]] for (int i = 0; i < kNtcCoopVecInputs; i++) x[i] = float16_t(inputs[i]);
    coopvecNV<float16_t, 64> sums;
    NTC_COOPVEC_MULTIPLY_E4M3(sums, x, weightsOffset + uint(layers.layer0), biases, kNtcCoopVecInputs);
    NTC_COOPVEC_MULTIPLY_E4M3(sums, NtcActivateHalfCoopVec(sums), weightsOffset + uint(layers.layer1),
                              biases + 128u, 64);
    NTC_COOPVEC_MULTIPLY_E4M3(sums, NtcActivateHalfCoopVec(sums), weightsOffset + uint(layers.layer2),
                              biases + 256u, 64);
    precise coopvecNV<float16_t, 64> steps =
        NtcActivateHalfCoopVec(sums) * coopvecNV<float16_t, 64>(float16_t(80.0));
    precise coopvecNV<float16_t, 64> shifted = steps - coopvecNV<float16_t, 64>(float16_t(113.0));
    coopvecNV<float, 64> widened = coopvecNV<float, 64>(shifted);
    coopvecNV<int32_t, 16> last;
    NTC_COOPVEC_MULTIPLY_INT8(last, widened, gl_ComponentTypeSignedInt8NV,
                              weightsOffset + uint(layers.layer3), biases + 448u, 16, 64);
    coopvecNV<float, 16> lastScales;
    coopVecLoadNV(lastScales, NTC_COOPVEC_WEIGHTS, biases + 384u);
    coopvecNV<float, 16> results = coopvecNV<float, 16>(last) * lastScales;
    [[unroll]] for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) outputs[c] =
        ((uint(NTC_OUTPUT_MASK) >> c) & 1u) != 0u ? results[c] : 0.0;
}
#endif

#endif
