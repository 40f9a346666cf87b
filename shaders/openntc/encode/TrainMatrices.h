// SPDX-License-Identifier: MIT
// Matrix products of TrainTexels, 16 x 16 x 16 with binary16 operands and binary32 sums: cooperative
// matrices (NTC_MATH, for compilers and devices that have them, subgroups of 32 lanes), or plain arithmetic
// of 32 lanes that are a subgroup in name only. Operands are in shared memory or in the buffer of weights,
// sixteen bytes in a vector.
#ifndef OPENNTC_TRAIN_MATRICES_H
#define OPENNTC_TRAIN_MATRICES_H

#extension GL_EXT_control_flow_attributes : require

#if defined(NTC_MATH) && NTC_MATH == 8 // which says which compiler it needs
#define NTC_TRAIN_COOPMAT 1
#else
#define NTC_TRAIN_COOPMAT 0
#endif

// Vectors of a row; those of cooperative matrices begin in different banks.
#if NTC_TRAIN_COOPMAT
#define NTC_TRAIN_PAD 1u
#else
#define NTC_TRAIN_PAD 0u
#endif
#define NTC_TRAIN_WIDE (uint(NTC_TRAIN_USED) / 8u + NTC_TRAIN_PAD) // inputs of the first layer
#define NTC_TRAIN_NARROW (8u + NTC_TRAIN_PAD)                      // of the others
#define NTC_TRAIN_SUMS 68u                                         // numbers of a row of sums

// Inputs of the four layers, then gradients of the sums of one layer: a row a texel.
shared uvec4 sHalves[32u * (NTC_TRAIN_WIDE + 4u * NTC_TRAIN_NARROW)];
shared float sSums[32u * NTC_TRAIN_SUMS];

/// First vector of the inputs of layer 0 ... 3, and with 4 of the gradients.
uint NtcTrainRows(uint layer) {
    return layer == 0u ? 0u : 32u * (NTC_TRAIN_WIDE + (layer - 1u) * NTC_TRAIN_NARROW);
}
uint NtcTrainStride(uint layer) {
    return layer == 0u ? NTC_TRAIN_WIDE : NTC_TRAIN_NARROW;
}

#if NTC_TRAIN_COOPMAT
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_KHR_memory_scope_semantics : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_cooperative_matrix : require

#define NtcMatA coopmat<float16_t, gl_ScopeSubgroup, 16, 16, gl_MatrixUseA>
#define NtcMatB coopmat<float16_t, gl_ScopeSubgroup, 16, 16, gl_MatrixUseB>
#define NtcMatC coopmat<float, gl_ScopeSubgroup, 16, 16, gl_MatrixUseAccumulator>
#define NTC_MAT_ZERO NtcMatC(0.0)

uint NtcTrainSubgroup() {
    return gl_SubgroupID;
}
// c += left * right; the names are of buffers, first vectors, strides and layouts.
#define NTC_MAT_ADD(c, left, leftAt, leftStride, leftLayout, right, rightAt, rightStride, rightLayout)       \
    {                                                                                                        \
        NtcMatA a;                                                                                           \
        NtcMatB b;                                                                                           \
        coopMatLoad(a, left, leftAt, leftStride, gl_CooperativeMatrixLayout##leftLayout);                    \
        coopMatLoad(b, right, rightAt, rightStride, gl_CooperativeMatrixLayout##rightLayout);                \
        c = coopMatMulAdd(a, b, c);                                                                          \
    }
// Of a tile of weights, sixteen rows without gaps: c[m][n] += sum of rows[m][k] * weights[n][k]
#define NTC_MAT_FORWARD(c, rows, rowStride, weights)                                                         \
    NTC_MAT_ADD(c, sHalves, rows, rowStride, RowMajor, gWeights.vectors, weights, 2u, ColumnMajor)
// c[m][n] += sum of rows[m][k] * weights[k][n]
#define NTC_MAT_BACKWARD(c, rows, rowStride, weights)                                                        \
    NTC_MAT_ADD(c, sHalves, rows, rowStride, RowMajor, gWeights.vectors, weights, 2u, RowMajor)
// c[m][n] += sum of inputs[k][m] * gradients[k][n]
#define NTC_MAT_GRADIENT(c, inputs, inputStride, gradients, gradientStride)                                  \
    NTC_MAT_ADD(c, sHalves, inputs, inputStride, ColumnMajor, sHalves, gradients, gradientStride, RowMajor)
#define NTC_MAT_STORE_SUMS(c, at)                                                                            \
    coopMatStore(c, sSums, at, NTC_TRAIN_SUMS, gl_CooperativeMatrixLayoutRowMajor)
#define NTC_MAT_STORE_PARTIAL(c, at)                                                                         \
    coopMatStore(c, gPartials.values, at, 16u, gl_CooperativeMatrixLayoutRowMajor)
#else
// A lane has rows 2r and 2r + 1 and columns 4q ... 4q + 3 of a product.
struct NtcMatC {
    vec4 first;
    vec4 second;
};
#define NTC_MAT_ZERO NtcMatC(vec4(0.0), vec4(0.0))

uint NtcTrainSubgroup() {
    return gl_LocalInvocationIndex >> 5;
}
uint NtcMatRow() {
    return 2u * ((gl_LocalInvocationIndex & 31u) >> 2);
}
uint NtcMatColumn() {
    return 4u * (gl_LocalInvocationIndex & 3u);
}
// Two halves; `at`: words.
vec2 NtcSharedHalves(uint at) {
    return unpackHalf2x16(sHalves[at >> 2][at & 3u]);
}
vec2 NtcWeightHalves(uint at) {
    return unpackHalf2x16(gWeights.vectors[at >> 2][at & 3u]);
}

void NtcMatForward(inout NtcMatC c, uint rows, uint rowStride, uint weights) {
    uint row = 4u * (rows + NtcMatRow() * rowStride), weight = 4u * (weights + NtcMatColumn() * 2u);
    [[dont_unroll]] for (uint k = 0u; k < 8u; k++) {
        vec2 a = NtcSharedHalves(row + k), b = NtcSharedHalves(row + 4u * rowStride + k);
        [[unroll]] for (uint n = 0u; n < 4u; n++) {
            vec2 w = NtcWeightHalves(weight + 8u * n + k);
            c.first[n] += dot(a, w);
            c.second[n] += dot(b, w);
        }
    }
}
void NtcMatBackward(inout NtcMatC c, uint rows, uint rowStride, uint weights) {
    uint row = 4u * (rows + NtcMatRow() * rowStride), weight = 4u * weights + NtcMatColumn() / 2u;
    [[dont_unroll]] for (uint k = 0u; k < 8u; k++) {
        vec2 a = NtcSharedHalves(row + k), b = NtcSharedHalves(row + 4u * rowStride + k);
        uint at = weight + 16u * k;
        vec4 even = vec4(NtcWeightHalves(at), NtcWeightHalves(at + 1u));
        at += 8u;
        vec4 odd = vec4(NtcWeightHalves(at), NtcWeightHalves(at + 1u));
        c.first += a.x * even + a.y * odd;
        c.second += b.x * even + b.y * odd;
    }
}
void NtcMatGradient(inout NtcMatC c, uint inputs, uint inputStride, uint gradients, uint gradientStride) {
    uint input_ = 4u * inputs + NtcMatRow() / 2u, gradient = 4u * gradients + NtcMatColumn() / 2u;
    [[dont_unroll]] for (uint k = 0u; k < 16u; k++) {
        vec2 x = NtcSharedHalves(input_ + 4u * k * inputStride);
        uint at = gradient + 4u * k * gradientStride;
        vec4 z = vec4(NtcSharedHalves(at), NtcSharedHalves(at + 1u));
        c.first += x.x * z;
        c.second += x.y * z;
    }
}
void NtcMatStoreSums(NtcMatC c, uint at) {
    at += NtcMatRow() * NTC_TRAIN_SUMS + NtcMatColumn();
    [[unroll]] for (uint n = 0u; n < 4u; n++) {
        sSums[at + n] = c.first[n];
        sSums[at + NTC_TRAIN_SUMS + n] = c.second[n];
    }
}
#if !NTC_TRAIN_TRIES
void NtcMatStorePartial(NtcMatC c, uint at) {
    at += NtcMatRow() * 16u + NtcMatColumn();
    [[unroll]] for (uint n = 0u; n < 4u; n++) {
        gPartials.values[at + n] = c.first[n];
        gPartials.values[at + 16u + n] = c.second[n];
    }
}
#endif
#define NTC_MAT_FORWARD(c, rows, rowStride, weights) NtcMatForward(c, rows, rowStride, weights);
#define NTC_MAT_BACKWARD(c, rows, rowStride, weights) NtcMatBackward(c, rows, rowStride, weights);
#define NTC_MAT_GRADIENT(c, inputs, inputStride, gradients, gradientStride)                                  \
    NtcMatGradient(c, inputs, inputStride, gradients, gradientStride);
#define NTC_MAT_STORE_SUMS(c, at) NtcMatStoreSums(c, at)
#define NTC_MAT_STORE_PARTIAL(c, at) NtcMatStorePartial(c, at)
#endif

#endif
