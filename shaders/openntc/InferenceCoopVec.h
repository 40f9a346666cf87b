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
// In C++ this compiles for tests only, with cooperative vectors that are arrays (NTC_COOPVEC_EMULATED).
#ifndef OPENNTC_INFERENCE_COOPVEC_H
#define OPENNTC_INFERENCE_COOPVEC_H

#include "Effects.h"
#include "InputsReal.h"
#include "Network.h"
#include "Portability.h"
#include "Switches.h"

#if defined(NTC_HLSL) || (defined(__cplusplus) && !defined(NTC_COOPVEC_EMULATED))
#error NTC_MATH: NTC_MATH_COOPVEC_INT8 and NTC_MATH_COOPVEC_FP8 exist in GLSL only
#endif
#ifndef NETWORK_VERSION
#error NETWORK_VERSION is not defined
#endif

#if !defined(__cplusplus)
#extension GL_NV_cooperative_vector : require
#extension GL_KHR_memory_scope_semantics : require
#extension GL_EXT_shader_explicit_arithmetic_types : require
#endif

#ifndef NTC_COOPVEC_WEIGHTS
#define NTC_COOPVEC_WEIGHTS ntcWeights.words
#endif
#ifndef NTC_COOPVEC_EXPLICIT
#define NTC_COOPVEC_EXPLICIT 0
#endif
#ifndef NTC_COOPVEC_LAYOUT
#define NTC_COOPVEC_LAYOUT gl_CooperativeVectorMatrixLayoutInferencingOptimalNV
#endif

// Inputs of the network in words of four, units of layers 1 and 2 (64 of layer 0, 16 outputs), and the first
// rows of layers 2 and 3 among those of all.
#if NETWORK_VERSION <= NTC_NETWORK_XLARGE
#define NTC_COOPVEC_INPUT_WORDS (4 * NETWORK_VERSION + 8)
#else
#define NTC_COOPVEC_INPUT_WORDS 12
#endif
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
#define NTC_COOPVEC_UNITS_1 48
#define NTC_COOPVEC_UNITS_2 32
#else
#define NTC_COOPVEC_UNITS_1 64
#define NTC_COOPVEC_UNITS_2 64
#endif
#define NTC_COOPVEC_FIRST_ROW_2 uint(64 + NTC_COOPVEC_UNITS_1)
#define NTC_COOPVEC_FIRST_ROW_3 (NTC_COOPVEC_FIRST_ROW_2 + uint(NTC_COOPVEC_UNITS_2))

/// result = matrix (signed bytes) * x + bias (int32).
#define NTC_COOPVEC_MULTIPLY_INT8(result, x, interpretation, matrix, bias, rows, columns)                    \
    coopVecMatMulAddNV(result, x, interpretation, NTC_COOPVEC_WEIGHTS, matrix, gl_ComponentTypeSignedInt8NV, \
                       NTC_COOPVEC_WEIGHTS, bias, gl_ComponentTypeSignedInt32NV, rows, columns,              \
                       NTC_COOPVEC_LAYOUT, false, columns)

// NAME(sums of so many halves): activation in binary16.
#define NTC_COOPVEC_ACTIVATE_HALF(NAME, units)                                                               \
    NTC_FUNCTION coopvecNV<float16_t, units> NAME(coopvecNV<float16_t, units> sums) {                        \
        NTC_PRECISE coopvecNV<float16_t, units> z =                                                          \
            min(max(sums, coopvecNV<float16_t, units>(float16_t(-1.5f))),                                    \
                coopvecNV<float16_t, units>(float16_t(3.0f)));                                               \
        NTC_PRECISE coopvecNV<float16_t, units> third =                                                      \
            z * coopvecNV<float16_t, units>(float16_t(0.333251953125f));                                     \
        NTC_PRECISE coopvecNV<float16_t, units> gate = third + coopvecNV<float16_t, units>(float16_t(0.5f)); \
        gate = clamp(gate, coopvecNV<float16_t, units>(float16_t(0.0f)),                                     \
                     coopvecNV<float16_t, units>(float16_t(1.0f)));                                          \
        NTC_PRECISE coopvecNV<float16_t, units> y = z * gate;                                                \
        return y;                                                                                            \
    }

// NAME(activations): what the multiplication rounds to bytes, exact in binary32.
#define NTC_COOPVEC_QUANTIZE_HALF(NAME, units)                                                               \
    NTC_FUNCTION coopvecNV<float, units> NAME(coopvecNV<float16_t, units> activations) {                     \
        NTC_PRECISE coopvecNV<float16_t, units> steps =                                                      \
            activations * coopvecNV<float16_t, units>(float16_t(80.0f));                                     \
        NTC_PRECISE coopvecNV<float16_t, units> shifted =                                                    \
            steps - coopvecNV<float16_t, units>(float16_t(113.0f));                                          \
        return coopvecNV<float, units>(shifted);                                                             \
    }

NTC_NAMESPACE_BEGIN

#if NTC_MATH == NTC_MATH_COOPVEC_INT8
#if NTC_COOPVEC_EXPLICIT
// NAME(sums, scales): bytes of the next layer's input.
#define NTC_COOPVEC_ACTIVATE(NAME, units)                                                                    \
    NTC_FUNCTION coopvecNV<uint32_t, (units / 4)> NAME(coopvecNV<int32_t, units> sums, uint scalesOffset) {  \
        coopvecNV<float, units> scales;                                                                      \
        coopVecLoadNV(scales, NTC_COOPVEC_WEIGHTS, scalesOffset);                                            \
        coopvecNV<uint32_t, (units / 4)> bytes;                                                              \
        NTC_UNROLL for (int i = 0; i < units / 4; i++) {                                                     \
            uint packedBytes = 0u;                                                                           \
            NTC_UNROLL for (int k = 0; k < 4; k++) packedBytes |=                                            \
                NtcActivate(NETWORK_VERSION, NTC_MATH_INT8,                                                  \
                            NtcMultiply(float(sums[4 * i + k]), scales[4 * i + k]))                          \
                << uint(8 * k);                                                                              \
            bytes[i] = packedBytes;                                                                          \
        }                                                                                                    \
        return bytes;                                                                                        \
    }
#define NTC_COOPVEC_NEXT_TYPE gl_ComponentTypeSignedInt8PackedNV
#else
// NAME(sums, scales): activation and the steps of requantisation but the last rounding (NTC_COOPVEC_FINISH).
#define NTC_COOPVEC_ACTIVATE(NAME, units)                                                                    \
    NTC_FUNCTION coopvecNV<float, units> NAME(coopvecNV<int32_t, units> sums, uint scalesOffset) {           \
        coopvecNV<float, units> scales;                                                                      \
        coopVecLoadNV(scales, NTC_COOPVEC_WEIGHTS, scalesOffset);                                            \
        NTC_PRECISE coopvecNV<float, units> z = coopvecNV<float, units>(sums) * scales;                      \
        z = min(max(z, coopvecNV<float, units>(-1.5f)), coopvecNV<float, units>(3.0f));                      \
        NTC_COOPVEC_FINISH(units)                                                                            \
    }
#define NTC_COOPVEC_NEXT_TYPE gl_ComponentTypeSignedInt8NV
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_2
// Binary16 between the layers.
NTC_COOPVEC_ACTIVATE_HALF(NtcActivateHalfCoopVec, 64)
NTC_COOPVEC_QUANTIZE_HALF(NtcQuantizeHalfCoopVec, 64)
#define NTC_COOPVEC_FINISH(units)                                                                            \
    return NtcQuantizeHalfCoopVec(NtcActivateHalfCoopVec(coopvecNV<float16_t, units>(z)));
#else
#define NTC_COOPVEC_FINISH(units)                                                                            \
    NTC_PRECISE coopvecNV<float, units> third = z * coopvecNV<float, units>(NTC_COOPVEC_THIRD);              \
    NTC_PRECISE coopvecNV<float, units> gate = third + coopvecNV<float, units>(0.5f);                        \
    gate = clamp(gate, coopvecNV<float, units>(0.0f), coopvecNV<float, units>(1.0f));                        \
    NTC_PRECISE coopvecNV<float, units> y = z * gate;                                                        \
    NTC_PRECISE coopvecNV<float, units> steps = y * coopvecNV<float, units>(80.0f);                          \
    NTC_COOPVEC_SHIFT(units)                                                                                 \
    return shifted;
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
// Rounded before 113 is taken away: the spacing of floats at 1.5 * 2^23 is 1.
#define NTC_COOPVEC_THIRD 0.333332985639572144f // 0x3EAAAA9F
#define NTC_COOPVEC_SHIFT(units)                                                                             \
    NTC_PRECISE coopvecNV<float, units> integers = steps + coopvecNV<float, units>(12582912.0f);             \
    NTC_PRECISE coopvecNV<float, units> shifted = integers - coopvecNV<float, units>(12583025.0f);
#else
#define NTC_COOPVEC_THIRD 0.333333343267440796f // 0x3EAAAAAB
#define NTC_COOPVEC_SHIFT(units)                                                                             \
    NTC_PRECISE coopvecNV<float, units> shifted = steps - coopvecNV<float, units>(113.0f);
#endif
#endif
#endif

NTC_COOPVEC_ACTIVATE(NtcActivateFirstCoopVec, 64)
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
NTC_COOPVEC_ACTIVATE(NtcActivateSecondCoopVec, NTC_COOPVEC_UNITS_1)
NTC_COOPVEC_ACTIVATE(NtcActivateThirdCoopVec, NTC_COOPVEC_UNITS_2)
#else
#define NtcActivateSecondCoopVec NtcActivateFirstCoopVec
#define NtcActivateThirdCoopVec NtcActivateFirstCoopVec
#endif

// As NtcFinishOutput.
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_2
#define NTC_COOPVEC_FINISH_OUTPUT(z) NtcRoundToHalf(z)
#else
#define NTC_COOPVEC_FINISH_OUTPUT(z) (z)
#endif

/// The Int8 network; scales and biases are where NtcEvaluateNetwork has them.
NTC_FUNCTION void NtcEvaluateInt8CoopVec(uint weightsOffset, NtcLayerOffsets layers,
                                         NTC_IN_ARRAY(uint, inputs, NTC_MAX_INPUT_WORDS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    uint scales = weightsOffset + uint(layers.scaleBias);
    uint biases = scales + 4u * (NTC_COOPVEC_FIRST_ROW_3 + 16u);
    coopvecNV<uint32_t, NTC_COOPVEC_INPUT_WORDS> x;
    NTC_UNROLL for (int i = 0; i < NTC_COOPVEC_INPUT_WORDS; i++) x[i] = inputs[i];
    coopvecNV<int32_t, 64> first;
    NTC_COOPVEC_MULTIPLY_INT8(first, x, gl_ComponentTypeSignedInt8PackedNV,
                              weightsOffset + uint(layers.layer0), biases, 64, 4 * NTC_COOPVEC_INPUT_WORDS);
    coopvecNV<int32_t, NTC_COOPVEC_UNITS_1> second;
    NTC_COOPVEC_MULTIPLY_INT8(second, NtcActivateFirstCoopVec(first, scales), NTC_COOPVEC_NEXT_TYPE,
                              weightsOffset + uint(layers.layer1), biases + 256u, NTC_COOPVEC_UNITS_1, 64);
    coopvecNV<int32_t, NTC_COOPVEC_UNITS_2> third;
    NTC_COOPVEC_MULTIPLY_INT8(third, NtcActivateSecondCoopVec(second, scales + 256u), NTC_COOPVEC_NEXT_TYPE,
                              weightsOffset + uint(layers.layer2), biases + 4u * NTC_COOPVEC_FIRST_ROW_2,
                              NTC_COOPVEC_UNITS_2, NTC_COOPVEC_UNITS_1);
    coopvecNV<int32_t, 16> last;
    NTC_COOPVEC_MULTIPLY_INT8(last, NtcActivateThirdCoopVec(third, scales + 4u * NTC_COOPVEC_FIRST_ROW_2),
                              NTC_COOPVEC_NEXT_TYPE, weightsOffset + uint(layers.layer3),
                              biases + 4u * NTC_COOPVEC_FIRST_ROW_3, 16, NTC_COOPVEC_UNITS_2);
    coopvecNV<float, 16> lastScales;
    coopVecLoadNV(lastScales, NTC_COOPVEC_WEIGHTS, scales + 4u * NTC_COOPVEC_FIRST_ROW_3);
    coopvecNV<float, 16> results = coopvecNV<float, 16>(last) * lastScales;
    NTC_UNROLL for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) outputs[c] =
        ((uint(NTC_OUTPUT_MASK) >> c) & 1u) != 0u ? NTC_COOPVEC_FINISH_OUTPUT(results[c]) : 0.0f;
}
#endif

#if NTC_MATH == NTC_MATH_COOPVEC_FP8
#define NTC_COOPVEC_MULTIPLY_E4M3(result, x, matrix, bias, rows, columns)                                    \
    coopVecMatMulAddNV(result, x, gl_ComponentTypeFloatE4M3NV, NTC_COOPVEC_WEIGHTS, matrix,                  \
                       gl_ComponentTypeFloatE4M3NV, NTC_COOPVEC_WEIGHTS, bias, gl_ComponentTypeFloat16NV,    \
                       rows, columns, NTC_COOPVEC_LAYOUT, false, columns)

NTC_COOPVEC_ACTIVATE_HALF(NtcActivateFirstCoopVec, 64)
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
NTC_COOPVEC_ACTIVATE_HALF(NtcActivateSecondCoopVec, NTC_COOPVEC_UNITS_1)
NTC_COOPVEC_ACTIVATE_HALF(NtcActivateThirdCoopVec, NTC_COOPVEC_UNITS_2)
#else
#define NtcActivateSecondCoopVec NtcActivateFirstCoopVec
#define NtcActivateThirdCoopVec NtcActivateFirstCoopVec
#endif
NTC_COOPVEC_QUANTIZE_HALF(NtcQuantizeHalfCoopVec, NTC_COOPVEC_UNITS_2)

/// The FP8 network; inputs are E4M3 numbers. Biases and scales are where NtcEvaluateE4M3Network has them.
NTC_FUNCTION void NtcEvaluateE4M3CoopVec(uint weightsOffset, NtcLayerOffsets layers,
                                         NTC_IN_ARRAY(float, inputs, NTC_MAX_INPUTS),
                                         NTC_OUT_ARRAY(float, outputs, NTC_MAX_CHANNELS)) {
    uint biases = weightsOffset + uint(layers.scaleBias);
    uint scales = biases + 2u * NTC_COOPVEC_FIRST_ROW_3;
    coopvecNV<float16_t, (4 * NTC_COOPVEC_INPUT_WORDS)> x;
    NTC_UNROLL for (int i = 0; i < 4 * NTC_COOPVEC_INPUT_WORDS; i++) x[i] = float16_t(inputs[i]);
    coopvecNV<float16_t, 64> first;
    NTC_COOPVEC_MULTIPLY_E4M3(first, x, weightsOffset + uint(layers.layer0), biases, 64,
                              4 * NTC_COOPVEC_INPUT_WORDS);
    coopvecNV<float16_t, NTC_COOPVEC_UNITS_1> second;
    NTC_COOPVEC_MULTIPLY_E4M3(second, NtcActivateFirstCoopVec(first), weightsOffset + uint(layers.layer1),
                              biases + 128u, NTC_COOPVEC_UNITS_1, 64);
    coopvecNV<float16_t, NTC_COOPVEC_UNITS_2> third;
    NTC_COOPVEC_MULTIPLY_E4M3(third, NtcActivateSecondCoopVec(second), weightsOffset + uint(layers.layer2),
                              biases + 2u * NTC_COOPVEC_FIRST_ROW_2, NTC_COOPVEC_UNITS_2,
                              NTC_COOPVEC_UNITS_1);
    coopvecNV<int32_t, 16> last;
    NTC_COOPVEC_MULTIPLY_INT8(last, NtcQuantizeHalfCoopVec(NtcActivateThirdCoopVec(third)),
                              gl_ComponentTypeSignedInt8NV, weightsOffset + uint(layers.layer3),
                              scales + uint(4 * NTC_MAX_CHANNELS), 16, NTC_COOPVEC_UNITS_2);
    coopvecNV<float, 16> lastScales;
    coopVecLoadNV(lastScales, NTC_COOPVEC_WEIGHTS, scales);
    coopvecNV<float, 16> results = coopvecNV<float, 16>(last) * lastScales;
    NTC_UNROLL for (uint c = 0u; c < uint(NTC_MAX_CHANNELS); c++) outputs[c] =
        ((uint(NTC_OUTPUT_MASK) >> c) & 1u) != 0u ? results[c] : 0.0f;
}
#endif

NTC_NAMESPACE_END

#endif
