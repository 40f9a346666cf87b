// SPDX-License-Identifier: MIT
// Matrices, shared memory and lanes of NetworkCoopMat.h, which includes it and says what the switches mean.
#ifndef OPENNTC_NETWORK_COOP_MAT_TYPES_H
#define OPENNTC_NETWORK_COOP_MAT_TYPES_H

#include "Network.h"

#if defined(__cplusplus) || defined(NTC_HLSL)
#error NetworkCoopMat.h is GLSL only
#endif
#ifndef NETWORK_VERSION
#error NETWORK_VERSION is not defined
#endif
#if !NTC_WITH_COOPMAT
#error NTC_MATH: NetworkCoopMat.h needs NTC_MATH_COOPMAT_INT8 or NTC_MATH_COOPMAT_INT8_HALF
#endif
#ifndef NTC_COOPMAT_LANES
#define NTC_COOPMAT_LANES 0
#endif
#if NTC_WITH_EQUAL_LAYERS
#ifndef NTC_COOPMAT_ROLLED
#define NTC_COOPMAT_ROLLED NTC_COOPMAT_LANES
#endif
#elif !defined(NTC_COOPMAT_ROLLED)
#define NTC_COOPMAT_ROLLED 0
#elif NTC_COOPMAT_ROLLED
#error NTC_COOPMAT_ROLLED must be 0 for NTC_NETWORK_GENERATION_3, whose inner layers have two shapes
#endif
#ifndef NTC_COOPMAT_EMULATED
#define NTC_COOPMAT_EMULATED 0
#endif
#if NTC_COOPMAT_EMULATED
#define NTC_COOPMAT_SUBGROUPS 1
#endif

// Operands of the first layer, 32 inputs each (48 are two, with weights of 0 behind the last), and vectors of
// 16 bytes in a row of its weights and of inputs: one more than needed, so that rows begin in different
// banks. Rows of all layers, the first ones of layers 2 and 3, and operands of layer 3.
#if NETWORK_VERSION == NTC_NETWORK_LARGE || NETWORK_VERSION == NTC_NETWORK_XLARGE
#define NTC_COOPMAT_CHUNKS 3
#define NTC_COOPMAT_STRIDE 7u
#else
#define NTC_COOPMAT_CHUNKS 2
#define NTC_COOPMAT_STRIDE 5u
#endif
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
#define NTC_COOPMAT_ROWS 160u
#define NTC_COOPMAT_FIRST_ROW_2 112u
#define NTC_COOPMAT_FIRST_ROW_3 144u
#define NTC_COOPMAT_LAST_CHUNKS 1u
#else
#define NTC_COOPMAT_ROWS 208u
#define NTC_COOPMAT_FIRST_ROW_2 128u
#define NTC_COOPMAT_FIRST_ROW_3 192u
#define NTC_COOPMAT_LAST_CHUNKS 2u
#endif

// Generation 2 has binary16 between its layers in both modes.
#if NTC_MATH == NTC_MATH_COOPMAT_INT8_HALF || NETWORK_VERSION == NTC_NETWORK_GENERATION_2
#define NTC_COOPMAT_HALF 1
#else
#define NTC_COOPMAT_HALF 0
#endif

#ifndef NTC_COOPMAT_SUBGROUPS // what was fastest on an H100 and stays below 48 KiB; portable: below 32 KiB
#if !NTC_COOPMAT_LANES
#define NTC_COOPMAT_SUBGROUPS (NTC_COOPMAT_CHUNKS == 2 ? 8 : 6)
#elif NETWORK_VERSION == NTC_NETWORK_GENERATION_3
#define NTC_COOPMAT_SUBGROUPS 24
#elif NTC_COOPMAT_CHUNKS == 2
#define NTC_COOPMAT_SUBGROUPS 20
#else
#define NTC_COOPMAT_SUBGROUPS 12
#endif
#endif

#extension GL_EXT_control_flow_attributes : require
// Matrices are indexed by constants only. Arrays need not be: all unrolled they keep a compiler busy for
// minutes, and with every loop rolled an invocation passes the 65535 turns that lavapipe lets its loops have.
#if NTC_COOPMAT_EMULATED
#define NTC_COOPMAT_UNROLL [[dont_unroll]]
#else
#define NTC_COOPMAT_UNROLL [[unroll]]
#extension GL_EXT_shader_explicit_arithmetic_types : require
#extension GL_KHR_memory_scope_semantics : require
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_cooperative_matrix : require
#endif

// Vectors of all weights: 64 rows of the first layer, five vectors a row of the others.
#define NTC_COOPMAT_ROW_VECTOR(row) (64u * NTC_COOPMAT_STRIDE + 5u * ((row)-64u))
#define NTC_COOPMAT_WEIGHT_VECTORS NTC_COOPMAT_ROW_VECTOR(NTC_COOPMAT_ROWS)

shared uvec4 sNtcWeights[NTC_COOPMAT_WEIGHT_VECTORS];
// 16 rows a subgroup: inputs of a layer, and between its operands sums and outputs, five vectors a row.
shared uvec4 sNtcStage[uint(NTC_COOPMAT_SUBGROUPS) * 16u * NTC_COOPMAT_STRIDE];
uint gNtcStage; // where the subgroup's begin
#if NTC_COOPMAT_LANES
shared vec4 sNtcBiases[NTC_COOPMAT_ROWS / 4u]; // of 16 units, 4 for each group of lanes
shared vec4 sNtcScales[NTC_COOPMAT_ROWS / 4u];
uvec4 gNtcLane;    // the lane's two rows of a tile, its group, and 0x00FF00FF
uvec4 gNtcColumns; // of its elements 0-3 and 4-7
#else
shared int sNtcBiases[NTC_COOPMAT_ROWS];
shared float sNtcScales[NTC_COOPMAT_ROWS];
#endif

#if NTC_COOPMAT_EMULATED
uint NtcGetLane() {
    return gl_LocalInvocationIndex;
}
uint NtcGetSubgroup() {
    return 0u;
}
void NtcSyncLanes() {
    barrier();
}
shared uint sNtcLaneWords[32];
/// The word of another lane; all lanes take part.
uint NtcReadLane(uint word, uint lane) {
    barrier();
    sNtcLaneWords[gl_LocalInvocationIndex] = word;
    barrier();
    return sNtcLaneWords[lane];
}

// Elements of a lane: two rows, four columns. They are those of the lanes' form, or any.
uvec2 NtcGetEmulatedRows() {
#if NTC_COOPMAT_LANES
    return gNtcLane.xy;
#else
    return uvec2(NtcGetLane() >> 2, 8u + (NtcGetLane() >> 2));
#endif
}
uint NtcGetEmulatedColumn(uint i) {
#if NTC_COOPMAT_LANES
    return gNtcColumns[i];
#else
    return 4u * (NtcGetLane() & 3u) + i;
#endif
}

struct NtcMatA {
    uvec4 rows[4]; // two vectors of each row
};
struct NtcMatB {
    uint at;
    uint stride;
};
#define NtcMatC int[8]

int[8] NtcStartMatC(int x) {
    return int[8](x, x, x, x, x, x, x, x);
}

NtcMatA NtcLoadEmulatedA(uint at, uint stride) {
    uvec2 rows = NtcGetEmulatedRows();
    NtcMatA a;
    NTC_COOPMAT_UNROLL for (uint k = 0u; k < 4u; k++) a.rows[k] =
        sNtcStage[at + rows[k >> 1] * stride + (k & 1u)];
    return a;
}

int[8] NtcMultiplyEmulated(NtcMatA a, NtcMatB b, int[8] c) {
    NTC_COOPMAT_UNROLL for (uint i = 0u; i < 8u; i++) {
        uint column = NtcGetEmulatedColumn(i & 3u);
        [[unroll]] for (uint v = 0u; v < 2u; v++) {
            uvec4 x = a.rows[2u * (i >> 2) + v];
            uvec4 w = sNtcWeights[b.at + column * b.stride + v];
            [[unroll]] for (uint k = 0u; k < 4u; k++) c[i] += NtcDot4Emulated(x[k], w[k]);
        }
    }
    return c;
}

#if !NTC_COOPMAT_LANES
void NtcStoreEmulated(int[8] c, uint at) {
    uvec2 rows = NtcGetEmulatedRows();
    NTC_COOPMAT_UNROLL for (uint i = 0u; i < 8u; i++)
        sNtcStage[at + 5u * rows[i >> 2] + (NtcGetEmulatedColumn(i & 3u) >> 2)]
                 [NtcGetEmulatedColumn(i & 3u) & 3u] = uint(c[i]);
}
#endif

#define NTC_COOPMAT_LOAD_A(a, at, stride) a = NtcLoadEmulatedA(at, stride)
#define NTC_COOPMAT_LOAD_B(b, at, stride) b = NtcMatB(at, stride)
#define NTC_COOPMAT_MULTIPLY(a, b, c) NtcMultiplyEmulated(a, b, c)
#define NTC_COOPMAT_STORE(c, at) NtcStoreEmulated(c, at)
#else
uint NtcGetLane() {
    return gl_SubgroupInvocationID;
}
uint NtcGetSubgroup() {
    return gl_SubgroupID;
}
void NtcSyncLanes() {
    controlBarrier(gl_ScopeSubgroup, gl_ScopeSubgroup, gl_StorageSemanticsShared, gl_SemanticsAcquireRelease);
}
uint NtcReadLane(uint word, uint lane) {
    return subgroupShuffle(word, lane);
}
#define NtcMatA coopmat<int8_t, gl_ScopeSubgroup, 16, 32, gl_MatrixUseA>
#define NtcMatB coopmat<int8_t, gl_ScopeSubgroup, 32, 16, gl_MatrixUseB>
#define NtcMatC coopmat<int, gl_ScopeSubgroup, 16, 16, gl_MatrixUseAccumulator>
#define NtcStartMatC(x) NtcMatC(x)
#define NTC_COOPMAT_LOAD_A(a, at, stride)                                                                    \
    coopMatLoad(a, sNtcStage, at, stride, gl_CooperativeMatrixLayoutRowMajor)
#define NTC_COOPMAT_LOAD_B(b, at, stride)                                                                    \
    coopMatLoad(b, sNtcWeights, at, stride, gl_CooperativeMatrixLayoutColumnMajor)
#define NTC_COOPMAT_MULTIPLY(a, b, c) coopMatMulAdd(a, b, c)
#define NTC_COOPMAT_STORE(c, at) coopMatStore(c, sNtcStage, at, 5u, gl_CooperativeMatrixLayoutRowMajor)
#endif

/// Weights and what else is shared; all invocations of the workgroup, once.
void NtcLoadCoopMatWeights() {
    uint lanes = 32u * uint(NTC_COOPMAT_SUBGROUPS);
    uint first = gl_LocalInvocationIndex;
    uint tail = NTC_COOPMAT_WEIGHT_VECTORS;
    for (uint i = first; i < NTC_COOPMAT_WEIGHT_VECTORS; i += lanes)
        sNtcWeights[i] = NTC_COOPMAT_WEIGHTS[i];
    gNtcStage = NtcGetSubgroup() * 16u * NTC_COOPMAT_STRIDE;
#if NTC_COOPMAT_LANES
    for (uint i = first; i < NTC_COOPMAT_ROWS / 4u; i += lanes) {
        sNtcScales[i] = uintBitsToFloat(NTC_COOPMAT_WEIGHTS[tail + i]);
        sNtcBiases[i] = uintBitsToFloat(NTC_COOPMAT_WEIGHTS[tail + NTC_COOPMAT_ROWS / 4u + i]);
    }
    gNtcLane = NTC_COOPMAT_WEIGHTS[tail + NTC_COOPMAT_ROWS / 2u + NtcGetLane()];
    gNtcColumns = NTC_COOPMAT_WEIGHTS[tail + NTC_COOPMAT_ROWS / 2u + 32u + gNtcLane.z];
#else
    for (uint i = first; i < NTC_COOPMAT_ROWS; i += lanes) {
        sNtcScales[i] = uintBitsToFloat(NTC_COOPMAT_WEIGHTS[tail + (i >> 2)][i & 3u]);
        sNtcBiases[i] = int(NTC_COOPMAT_WEIGHTS[tail + NTC_COOPMAT_ROWS / 4u + (i >> 2)][i & 3u]);
    }
#endif
    barrier();
}

#endif
