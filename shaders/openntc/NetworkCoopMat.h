// SPDX-License-Identifier: MIT
// The Int8 network for whole subgroups on cooperative matrices (GLSL, GL_KHR_cooperative_matrix with signed
// bytes, 16 x 16 x 32, at subgroup scope; 32 lanes): for compute passes that decode blocks of texels. A lane
// has a texel. NTC_MATH_COOPMAT_INT8 has the bits of NTC_MATH_INT8, NTC_MATH_COOPMAT_INT8_HALF those of
// NTC_MATH_INT8_HALF, for the networks of every generation.
//
// Texels are the rows of operand A and the units of a layer the columns of operand B, so that weights are
// loaded as they are stored. Two tiles of 16 texels are evaluated by each set of weights that is loaded.
//
//   NTC_COOPMAT_LANES      1: a lane turns its own elements of the accumulator into bytes. That orders the
//                          hidden units by the device's layout, which the host finds with
//                          passes/ProbeCoopMat.comp and orders the next layer's weights by. 0: for any
//                          device, sums go through shared memory.
//   NTC_COOPMAT_SUBGROUPS  of a workgroup: local_size_x is 32 times that. Weights are in shared memory once a
//                          workgroup, so that many are good, as far as shared memory goes (45 KiB for 20 of
//                          a network with up to 64 inputs). Not defined: by lanes 20 of a network with up to
//                          64 inputs (24 of generation 3, whose weights are fewer) and 12 of the others, else
//                          8 and 6, which fit into 32 KiB.
//   NTC_COOPMAT_ROLLED     1: the inner layers share their code; not defined: as NTC_COOPMAT_LANES, but 0 in
//                          generation 3, whose inner layers differ
//   NTC_COOPMAT_EMULATED   1: no extension, matrices are arrays, the lanes of a workgroup of 32 are the
//                          subgroup; for tests of everything else
//
// The weights are those of inference/CooperativeMatrices.h, for the same form, in NTC_COOPMAT_WEIGHTS: an
// array of uvec4 in a storage buffer. Call NtcLoadCoopMatWeights once at the beginning, then
// NtcEvaluateNetworkCoopMat any number of times, always by all invocations of the workgroup or the subgroup.
#ifndef OPENNTC_NETWORK_COOP_MAT_H
#define OPENNTC_NETWORK_COOP_MAT_H

#include "Network.h"
#include "NetworkCoopMatTypes.h"

#if NTC_COOPMAT_HALF && !NTC_COOPMAT_EMULATED
/// Activation and requantisation of two values in binary16; the bytes are bits 0-7 and 16-23. The lower bound
/// keeps infinity times 0 away.
uint NtcActivatePair(vec2 accumulated) {
    f16vec2 z = max(min(f16vec2(accumulated), f16vec2(3.0hf)), f16vec2(-2.0hf));
    precise f16vec2 third = z * f16vec2(0.333251953125hf); // 0x3555
    precise f16vec2 gate = third + f16vec2(0.5hf);
    gate = clamp(gate, f16vec2(0.0hf), f16vec2(1.0hf));
    precise f16vec2 y = z * gate;
    precise f16vec2 steps = y * f16vec2(80.0hf);
    precise f16vec2 shifted = steps - f16vec2(113.0hf);
    precise f16vec2 rounded = shifted + f16vec2(1536.0hf); // the spacing of halves is 1 there
    return packFloat2x16(rounded);
}
#elif NTC_COOPMAT_HALF
uint NtcActivatePair(vec2 accumulated) {
    return NtcActivateHalf(accumulated.x) | (NtcActivateHalf(accumulated.y) << 16);
}
#else
/// The same in binary32; without the branches of NtcApplyActivation, as the host has seen to it that no sum
/// overflows. The byte is bits 0-7. Generation 3 takes 113 away after rounding: here it adds 16, which leaves
/// ties between the same numbers and makes all positive, and NtcActivatePair the rest, of two at once.
uint NtcActivateBounded(float z) {
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
    precise float third = z * uintBitsToFloat(0x3EAAAA9Fu); // 0.333333
#else
    precise float third = z * uintBitsToFloat(0x3EAAAAABu);
#endif
    precise float gate = third + 0.5;
    gate = clamp(gate, 0.0, 1.0);
    precise float y = min(z, 3.0) * gate;
    precise float steps = y * 80.0;
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
    precise float rounded = steps + 12582928.0;
#else
    precise float shifted = steps - 113.0;
    precise float rounded = shifted + 12582912.0;
#endif
    return floatBitsToUint(rounded);
}
uint NtcActivatePair(vec2 accumulated) {
    uint units = (NtcActivateBounded(accumulated.x) & 0xFFFFu) | (NtcActivateBounded(accumulated.y) << 16);
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
    units += 0x007F007Fu; // 1 ... 256 + 127: -113 - 16 of a byte, and nothing is carried into the other half
#endif
    return units;
}
#endif

#if NTC_COOPMAT_LANES
/// A lane's number in units of 1 from the accumulator, which began at 0x4B400000: as a float it is
/// 1.5 * 2^23 + sum, and bias - 1.5 * 2^23 is exact. The host has checked that |sum + bias| < 2^22.
float NtcScaleSum(int accumulated, float bias, float scale) {
    precise float sum = intBitsToFloat(accumulated) + bias;
    precise float z = sum * scale;
    return z;
}

/// Bytes of four units of a texel, in the order 0, 2, 1, 3.
uint NtcPackUnits(int c0, int c1, int c2, int c3, vec4 bias, vec4 scale) {
    uint low = NtcActivatePair(vec2(NtcScaleSum(c0, bias.x, scale.x), NtcScaleSum(c1, bias.y, scale.y)));
    uint high = NtcActivatePair(vec2(NtcScaleSum(c2, bias.z, scale.z), NtcScaleSum(c3, bias.w, scale.w)));
    uint mask = gNtcLane.w; // no literal: compilers make one operation of three inputs of it
    return (low & mask) | ((high << 8) & ~mask);
}
#endif

/// Operands of a tile from its 16 rows in shared memory.
#define NTC_COOPMAT_LOAD_ROWS(a, t, chunks, stage, stride)                                                   \
    {                                                                                                        \
        NtcSyncLanes();                                                                                      \
        NTC_COOPMAT_UNROLL for (uint k = 0u; k < chunks; k++)                                                \
            NTC_COOPMAT_LOAD_A(a[t][k], (stage) + 2u * k, stride);                                           \
        NtcSyncLanes();                                                                                      \
    }

/// A hidden layer of `chunks` times 32 inputs and `tiles` (2 ... 4) times 16 units, whose weights begin at
/// `at` with `stride` vectors a row, and whose first row is row0 of all. PUT: what stores the bytes of so
/// many tiles by lanes. The next layer has two operands of 32 inputs, behind two tiles one.
#define NTC_COOPMAT_HIDDEN(NAME, chunks, stride, tiles, PUT)                                                 \
    void NAME(uint at, uint row0, inout NtcMatA a[2][NTC_COOPMAT_CHUNKS], uint stage) {                      \
        NTC_COOPMAT_BEGIN_HIDDEN                                                                             \
        NTC_COOPMAT_UNROLL for (uint n = 0u; n < tiles; n++) {                                               \
            NtcMatB b[chunks];                                                                               \
            NTC_COOPMAT_UNROLL for (uint k = 0u; k < chunks; k++)                                            \
                NTC_COOPMAT_LOAD_B(b[k], at + 16u * n * stride + 2u * k, stride);                            \
            NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {                                              \
                NtcMatC c = NTC_COOPMAT_START;                                                               \
                NTC_COOPMAT_UNROLL for (uint k = 0u; k < chunks; k++) c =                                    \
                    NTC_COOPMAT_MULTIPLY(a[t][k], b[k], c);                                                  \
                NTC_COOPMAT_END_UNITS(c, t, n)                                                               \
            }                                                                                                \
        }                                                                                                    \
        NTC_COOPMAT_END_HIDDEN(tiles, PUT)                                                                   \
    }

#if NTC_COOPMAT_LANES
#define NTC_COOPMAT_START NtcStartMatC(0x4B400000)
#define NTC_COOPMAT_BEGIN_HIDDEN uvec4 words[2][2];
#define NTC_COOPMAT_END_UNITS(c, t, n)                                                                       \
    {                                                                                                        \
        vec4 bias = sNtcBiases[row0 / 4u + 4u * n + gNtcLane.z];                                             \
        vec4 scale = sNtcScales[row0 / 4u + 4u * n + gNtcLane.z];                                            \
        words[t][0][n] = NtcPackUnits(c[0], c[1], c[2], c[3], bias, scale);                                  \
        words[t][1][n] = NtcPackUnits(c[4], c[5], c[6], c[7], bias, scale);                                  \
    }
// A texel's bytes are those of a group of lanes one after the other, four of each tile. Of three tiles there
// are 16 too, of two 8.
#define NTC_COOPMAT_PUT_FOUR(row, words) sNtcStage[stage + row * 5u + gNtcLane.z] = words;
#define NTC_COOPMAT_PUT_THREE(row, words) sNtcStage[stage + row * 5u + gNtcLane.z] = uvec4(words.xyz, 0u);
#define NTC_COOPMAT_PUT_TWO(row, words)                                                                      \
    {                                                                                                        \
        uint half_ = stage + row * 5u + (gNtcLane.z >> 1);                                                   \
        if ((gNtcLane.z & 1u) == 0u)                                                                         \
            sNtcStage[half_].xy = words.xy;                                                                  \
        else                                                                                                 \
            sNtcStage[half_].zw = words.xy;                                                                  \
    }
#define NTC_COOPMAT_END_HIDDEN(tiles, PUT)                                                                   \
    NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {                                                      \
        PUT(gNtcLane.x, words[t][0])                                                                         \
        PUT(gNtcLane.y, words[t][1])                                                                         \
        NTC_COOPMAT_LOAD_ROWS(a, t, (tiles + 1u) / 2u, stage, 5u)                                            \
    }
#else
#define NTC_COOPMAT_START NtcStartMatC(0)
#define NTC_COOPMAT_BEGIN_HIDDEN uvec2 words[2][4];
// Sums go to shared memory; a lane takes 8 units of a texel.
#define NTC_COOPMAT_END_UNITS(c, t, n)                                                                       \
    {                                                                                                        \
        NTC_COOPMAT_STORE(c, gNtcStage);                                                                     \
        NtcSyncLanes();                                                                                      \
        words[t][n] = uvec2(NtcFinishUnits(row0 + 16u * n, 0u), NtcFinishUnits(row0 + 16u * n, 4u));         \
        NtcSyncLanes();                                                                                      \
    }
// Units in order. Behind three tiles lies what lay there before, which the next layer's weights of 0 take.
#define NTC_COOPMAT_END_HIDDEN(tiles, PUT)                                                                   \
    NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {                                                      \
        uint lane = NtcGetLane();                                                                            \
        NTC_COOPMAT_UNROLL for (uint n = 0u; n < tiles; n++) {                                               \
            uint at_ = stage + (lane & 15u) * 5u + n;                                                        \
            if (lane < 16u)                                                                                  \
                sNtcStage[at_].xy = words[t][n];                                                             \
            else                                                                                             \
                sNtcStage[at_].zw = words[t][n];                                                             \
        }                                                                                                    \
        NTC_COOPMAT_LOAD_ROWS(a, t, (tiles + 1u) / 2u, stage, 5u)                                            \
    }

/// Row `row` of all from its sum of products.
float NtcFinishStoredSum(uint sum, uint row) {
    return NtcMultiply(float(int(sum + uint(sNtcBiases[row]))), sNtcScales[row]);
}

/// The sum of a texel's unit `unit` of 16, whose row is `row` of all.
float NtcFinishSumOf(uint texel, uint unit, uint row) {
    return NtcFinishStoredSum(sNtcStage[gNtcStage + texel * 5u + (unit >> 2)][unit & 3u], row);
}

/// A sum of the lane's texel: unit `unit` of 16, whose row is `row` of all.
float NtcFinishSum(uint unit, uint row) {
    return NtcFinishSumOf(NtcGetLane() & 15u, unit, row);
}

/// Bytes of units `first` ... `first` + 3 of the lane's 8.
uint NtcFinishUnits(uint row0, uint first) {
    uint unit = 8u * (NtcGetLane() >> 4) + first;
    uint packedBytes = 0u;
    NTC_COOPMAT_UNROLL for (uint i = 0u; i < 4u; i++) {
        float z = NtcFinishSum(unit + i, row0 + unit + i);
        packedBytes |=
            NtcActivate(NETWORK_VERSION, NTC_COOPMAT_HALF != 0 ? NTC_MATH_INT8_HALF : NTC_MATH_INT8, z)
            << (8u * i);
    }
    return packedBytes;
}
#endif

NTC_COOPMAT_HIDDEN(NtcEvaluateFirstCoopMat, uint(NTC_COOPMAT_CHUNKS), NTC_COOPMAT_STRIDE, 4u,
                   NTC_COOPMAT_PUT_FOUR)
#if NTC_WITH_EQUAL_LAYERS
NTC_COOPMAT_HIDDEN(NtcEvaluateInnerCoopMat, 2u, 5u, 4u, NTC_COOPMAT_PUT_FOUR)
#define NtcEvaluateSecondCoopMat NtcEvaluateInnerCoopMat
#define NtcEvaluateThirdCoopMat NtcEvaluateInnerCoopMat
#else
NTC_COOPMAT_HIDDEN(NtcEvaluateSecondCoopMat, 2u, 5u, 3u, NTC_COOPMAT_PUT_THREE)
NTC_COOPMAT_HIDDEN(NtcEvaluateThirdCoopMat, 2u, 5u, 2u, NTC_COOPMAT_PUT_TWO)
#endif

#if NTC_COOPMAT_ROLLED
#define NTC_COOPMAT_INNER_LAYERS(a)                                                                          \
    [[dont_unroll]] for (uint inner = 1u; inner < 3u; inner++) {                                             \
        NtcEvaluateInnerCoopMat(64u * NTC_COOPMAT_STRIDE + 320u * (inner - 1u), 64u * inner, a, gNtcStage);  \
    }
#else
#define NTC_COOPMAT_INNER_LAYERS(a)                                                                          \
    NtcEvaluateSecondCoopMat(NTC_COOPMAT_ROW_VECTOR(64u), 64u, a, gNtcStage);                                \
    NtcEvaluateThirdCoopMat(NTC_COOPMAT_ROW_VECTOR(NTC_COOPMAT_FIRST_ROW_2), NTC_COOPMAT_FIRST_ROW_2, a,     \
                            gNtcStage);
#endif

/// Operands `a` of the output layer from the inputs of the lane's texel; all lanes of the subgroup. No
/// function: matrices that one returns have been kept in memory (an H100's driver, 1.4 times the time).
#define NTC_COOPMAT_EVALUATE_HIDDEN(a, inputs)                                                               \
    NtcMatA a[2][NTC_COOPMAT_CHUNKS];                                                                        \
    NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {                                                      \
        if ((NtcGetLane() >> 4) == t) {                                                                      \
            NTC_COOPMAT_UNROLL for (uint i = 0u; i < 2u * uint(NTC_COOPMAT_CHUNKS); i++) {                   \
                uvec4 words = uvec4(0u);                                                                     \
                if (4u * i < NtcGetInputWords(NETWORK_VERSION)) /* a multiple of 4 */                        \
                    words = uvec4(inputs[4u * i], inputs[4u * i + 1u], inputs[4u * i + 2u],                  \
                                  inputs[4u * i + 3u]);                                                      \
                sNtcStage[gNtcStage + (NtcGetLane() & 15u) * NTC_COOPMAT_STRIDE + i] = words;                \
            }                                                                                                \
        }                                                                                                    \
        NTC_COOPMAT_LOAD_ROWS(a, t, uint(NTC_COOPMAT_CHUNKS), gNtcStage, NTC_COOPMAT_STRIDE)                 \
    }                                                                                                        \
    NtcEvaluateFirstCoopMat(0u, 0u, a, gNtcStage);                                                           \
    NTC_COOPMAT_INNER_LAYERS(a)

#define NTC_COOPMAT_LOAD_OUTPUT_WEIGHTS(b)                                                                   \
    NtcMatB b[NTC_COOPMAT_LAST_CHUNKS];                                                                      \
    NTC_COOPMAT_UNROLL for (uint k = 0u; k < NTC_COOPMAT_LAST_CHUNKS; k++)                                   \
        NTC_COOPMAT_LOAD_B(b[k], NTC_COOPMAT_ROW_VECTOR(NTC_COOPMAT_FIRST_ROW_3) + 2u * k, 5u)
#define NTC_COOPMAT_MULTIPLY_OUTPUTS(c, t)                                                                   \
    NtcMatC c = NTC_COOPMAT_START;                                                                           \
    NTC_COOPMAT_UNROLL for (uint k = 0u; k < NTC_COOPMAT_LAST_CHUNKS; k++) c =                               \
        NTC_COOPMAT_MULTIPLY(a[t][k], b[k], c)

#if NTC_COOPMAT_LANES
/// Outputs 4 gNtcLane.z ... + 3 of the lane's two rows of a tile: the host has ordered the rows of the output
/// layer so.
#define NTC_COOPMAT_FINISH_QUADS(first, second, c)                                                           \
    vec4 first;                                                                                              \
    vec4 second;                                                                                             \
    {                                                                                                        \
        vec4 bias = sNtcBiases[NTC_COOPMAT_FIRST_ROW_3 / 4u + gNtcLane.z];                                   \
        vec4 scale = sNtcScales[NTC_COOPMAT_FIRST_ROW_3 / 4u + gNtcLane.z];                                  \
        NTC_COOPMAT_UNROLL for (uint i = 0u; i < 4u; i++) {                                                  \
            first[i] = NtcScaleSum(c[i], bias[i], scale[i]);                                                 \
            second[i] = NtcScaleSum(c[i + 4u], bias[i], scale[i]);                                           \
        }                                                                                                    \
    }
#endif

/// The outputs of the lane's texel from its inputs; all lanes of the subgroup.
void NtcEvaluateNetworkCoopMat(in uint inputs[NTC_MAX_INPUT_WORDS], out float outputs[NTC_MAX_CHANNELS]) {
    NTC_COOPMAT_EVALUATE_HIDDEN(a, inputs)
    uint lane = NtcGetLane();
    NTC_COOPMAT_LOAD_OUTPUT_WEIGHTS(b);
    NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {
        NTC_COOPMAT_MULTIPLY_OUTPUTS(c, t);
#if NTC_COOPMAT_LANES
        NTC_COOPMAT_FINISH_QUADS(first, second, c)
        sNtcStage[gNtcStage + gNtcLane.x * 5u + gNtcLane.z] = floatBitsToUint(first);
        sNtcStage[gNtcStage + gNtcLane.y * 5u + gNtcLane.z] = floatBitsToUint(second);
        NtcSyncLanes();
        if ((lane >> 4) == t) {
            NTC_COOPMAT_UNROLL for (uint v = 0u; v < 4u; v++) {
                vec4 four = uintBitsToFloat(sNtcStage[gNtcStage + (lane & 15u) * 5u + v]);
                NTC_COOPMAT_UNROLL for (uint k = 0u; k < 4u; k++) outputs[4u * v + k] = four[k];
            }
        }
#else
        NTC_COOPMAT_STORE(c, gNtcStage);
        NtcSyncLanes();
        if ((lane >> 4) == t) {
            NTC_COOPMAT_UNROLL for (uint o = 0u; o < 16u; o++) outputs[o] =
                NtcFinishSum(o, NTC_COOPMAT_FIRST_ROW_3 + o);
        }
#endif
        NtcSyncLanes();
    }
#if NTC_COOPMAT_HALF
    NTC_COOPMAT_UNROLL for (uint o = 0u; o < 16u; o++) outputs[o] = NtcRoundToHalf(outputs[o]);
#endif
}

#if defined(NTC_COOPMAT_TILE)
/// Outputs first ... first + 3 (a multiple of 4) of the texel of this number of the tile at hand, in
/// NTC_COOPMAT_TILE.
vec4 NtcGetTileOutputs(uint texel, uint first) {
    uvec4 stored = sNtcStage[gNtcStage + texel * 5u + (first >> 2)];
    vec4 values;
    NTC_COOPMAT_UNROLL for (uint k = 0u; k < 4u; k++) {
#if NTC_COOPMAT_LANES
        values[k] = uintBitsToFloat(stored[k]);
#else
        values[k] = NtcFinishStoredSum(stored[k], NTC_COOPMAT_FIRST_ROW_3 + first + k);
#endif
        if (NTC_COOPMAT_HALF != 0)
            values[k] = NtcRoundToHalf(values[k]);
    }
    return values;
}

/// Output `channel` (0 ... 15, any) of it.
float NtcGetTileOutput(uint texel, uint channel) {
#if NTC_COOPMAT_LANES
    float value = uintBitsToFloat(sNtcStage[gNtcStage + texel * 5u + (channel >> 2)][channel & 3u]);
#else
    float value = NtcFinishSumOf(texel, channel, NTC_COOPMAT_FIRST_ROW_3 + channel);
#endif
    return NTC_COOPMAT_HALF != 0 ? NtcRoundToHalf(value) : value;
}

/// The same for passes whose lanes read outputs by number: calls NTC_COOPMAT_TILE(tile), a function that is
/// defined before this file is included, for both tiles of 16 texels (0: those of lanes 0 ... 15), with all
/// lanes. There NtcGetTileOutput(s) give any output; nothing of them is held in registers.
void NtcVisitNetworkCoopMat(in uint inputs[NTC_MAX_INPUT_WORDS]) {
    NTC_COOPMAT_EVALUATE_HIDDEN(a, inputs)
    NTC_COOPMAT_LOAD_OUTPUT_WEIGHTS(b);
    NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {
        NTC_COOPMAT_MULTIPLY_OUTPUTS(c, t);
#if NTC_COOPMAT_LANES
        NTC_COOPMAT_FINISH_QUADS(first, second, c)
        sNtcStage[gNtcStage + gNtcLane.x * 5u + gNtcLane.z] = floatBitsToUint(first);
        sNtcStage[gNtcStage + gNtcLane.y * 5u + gNtcLane.z] = floatBitsToUint(second);
#else
        NTC_COOPMAT_STORE(c, gNtcStage);
#endif
        NtcSyncLanes();
        NTC_COOPMAT_TILE(t);
        NtcSyncLanes();
    }
}
#endif

#if defined(NTC_COOPMAT_WRITE)
/// The same for passes that write outputs as they come: calls NTC_COOPMAT_WRITE(texel, first, vec4), a
/// function that is defined before this file is included, with outputs first ... first + 3 (a multiple of 4)
/// of texel 0 ... 31 of the subgroup (that of the lane of this number). Not rounded to binary16 where
/// NTC_COOPMAT_HALF is 1: the writer does that.
void NtcWriteNetworkCoopMat(in uint inputs[NTC_MAX_INPUT_WORDS]) {
#if NTC_COOPMAT_LANES
    NTC_COOPMAT_EVALUATE_HIDDEN(a, inputs)
    NTC_COOPMAT_LOAD_OUTPUT_WEIGHTS(b);
    NTC_COOPMAT_UNROLL for (uint t = 0u; t < 2u; t++) {
        NTC_COOPMAT_MULTIPLY_OUTPUTS(c, t);
        NTC_COOPMAT_FINISH_QUADS(first, second, c)
        NTC_COOPMAT_WRITE(16u * t + gNtcLane.x, 4u * gNtcLane.z, first);
        NTC_COOPMAT_WRITE(16u * t + gNtcLane.y, 4u * gNtcLane.z, second);
    }
#else
    float outputs[NTC_MAX_CHANNELS];
    NtcEvaluateNetworkCoopMat(inputs, outputs);
    NTC_COOPMAT_UNROLL for (uint v = 0u; v < 4u; v++) NTC_COOPMAT_WRITE(
        NtcGetLane(), 4u * v,
        vec4(outputs[4u * v], outputs[4u * v + 1u], outputs[4u * v + 2u], outputs[4u * v + 3u]));
#endif
}
#endif

#endif
