// SPDX-License-Identifier: MIT
// Dot products of the Int8 network for NTC_TEXELS_PER_INVOCATION texels at once, by integers or
// (NTC_FLOAT_DOT) in binary32.
#ifndef OPENNTC_NETWORK_OPERANDS_H
#define OPENNTC_NETWORK_OPERANDS_H

#include "Network.h"
#include "Portability.h"
#include "Switches.h"

#define NTC_TEXELS_INPUT_WORDS (NTC_TEXELS_PER_INVOCATION * NTC_MAX_INPUT_WORDS)
#define NTC_TEXELS_OUTPUTS (NTC_TEXELS_PER_INVOCATION * NTC_MAX_CHANNELS)

#if NTC_WITH_NETWORK_TEXELS

// What a word of inputs is for the dot product, and the sum.
#if NTC_FLOAT_DOT
#define NTC_SUM float
#define NTC_OPERAND float4
#else
#define NTC_SUM uint
#define NTC_OPERAND uint
#endif

NTC_FUNCTION NTC_OPERAND NtcMakeOperand(uint word) {
#if NTC_FLOAT_DOT
    return float4(float(NtcSignedByte(word, 0u)), float(NtcSignedByte(word, 1u)),
                  float(NtcSignedByte(word, 2u)), float(NtcSignedByte(word, 3u)));
#else
    return word;
#endif
}

/// Dot product of two operands; exact, so that the order of its additions does not matter.
NTC_FUNCTION NTC_SUM NtcMultiplyOperands(NTC_OPERAND a, NTC_OPERAND b) {
#if NTC_FLOAT_DOT
    return dot(a, b);
#else
    return uint(NtcDot4(a, b));
#endif
}

/// Adds weights . inputs of every texel to its sum, for word i of row r.
#define NTC_ADD_PRODUCTS(sums, r, operand, x, i)                                                             \
    {                                                                                                        \
        NTC_OPERAND weights_ = operand;                                                                      \
        NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) sums[4u * t + (r)] +=         \
            NtcMultiplyOperands(weights_, x[uint(NTC_MAX_INPUT_WORDS) * t + (i)]);                           \
    }

/// Words of every texel as operands.
NTC_FUNCTION void NtcMakeOperands(NTC_IN_ARRAY(uint, inputs, NTC_TEXELS_INPUT_WORDS), uint words,
                                  NTC_OUT_ARRAY(NTC_OPERAND, x, NTC_TEXELS_INPUT_WORDS)) {
    NTC_UNROLL for (uint t = 0u; t < uint(NTC_TEXELS_PER_INVOCATION); t++) {
        NTC_UNROLL for (uint i = 0u; i < words; i++) {
            uint word = uint(NTC_MAX_INPUT_WORDS) * t + i;
            x[word] = NtcMakeOperand(inputs[word]);
        }
    }
}

/// Row r of texel t before activation, from its sum of products.
#define NTC_FINISH_ROW(sums, t, r, bias, scale)                                                              \
    NtcMultiply(float(int((bias) + uint(int(sums[4u * (t) + (r)])))), scale)

#endif
#endif
