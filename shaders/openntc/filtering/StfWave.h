// SPDX-License-Identifier: MIT
// Operations between the lanes of a wave, one spelling for all languages. GLSL needs
// GL_KHR_shader_subgroup_basic, _ballot, _arithmetic and _shuffle (Vulkan 1.1; in fragment shaders
// subgroupSupportedStages says whether), HLSL shader model 6.0. Waves have up to 128 lanes. In C++ a wave has
// one lane; all of these macros defined before, the same in all of a program, emulate larger ones.
//   NtcWaveLane()            this lane's number
//   NtcWaveSize()            how many numbers there are
//   NtcWaveBallot(bool)      uint4: a bit for every active lane where it is true
//   NtcWaveMin, NtcWaveMax(int), NtcWaveOr(uint)   over active lanes
//   NtcWaveRead(x, lane)     x of another active lane; lanes may ask for different ones
#ifndef OPENNTC_STF_WAVE_H
#define OPENNTC_STF_WAVE_H

#include "StfMultiTap.h"
#include "openntc/Portability.h"

#if defined(__cplusplus)
#if !defined(NtcWaveLane)
#define NtcWaveLane() 0u
#define NtcWaveSize() 1u
#define NtcWaveBallot(x) uint4((x) ? 1u : 0u, 0u, 0u, 0u)
#define NtcWaveMin(x) (x)
#define NtcWaveMax(x) (x)
#define NtcWaveOr(x) (x)
#define NtcWaveRead(x, lane) NtcReadOnlyLane(x, lane)
namespace openntc::shader {
template <typename T>
inline T NtcReadOnlyLane(T value, uint) {
    return value;
}
} // namespace openntc::shader
#endif
#define NtcStfCountBits(x) uint(std::popcount(uint(x)))
#elif defined(NTC_HLSL)
#define NtcWaveLane() WaveGetLaneIndex()
#define NtcWaveSize() WaveGetLaneCount()
#define NtcWaveBallot(x) WaveActiveBallot(x)
#define NtcWaveMin(x) WaveActiveMin(x)
#define NtcWaveMax(x) WaveActiveMax(x)
#define NtcWaveOr(x) WaveActiveBitOr(x)
#define NtcWaveRead(x, lane) WaveReadLaneAt(x, lane)
#define NtcStfCountBits(x) countbits(x)
#else
#extension GL_KHR_shader_subgroup_basic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_shuffle : require
#define NtcWaveLane() gl_SubgroupInvocationID
#define NtcWaveSize() gl_SubgroupSize
#define NtcWaveBallot(x) subgroupBallot(x)
#define NtcWaveMin(x) subgroupMin(x)
#define NtcWaveMax(x) subgroupMax(x)
#define NtcWaveOr(x) subgroupOr(x)
#define NtcWaveRead(x, lane) subgroupShuffle(x, lane)
#define NtcStfCountBits(x) uint(bitCount(x))
#endif

NTC_NAMESPACE_BEGIN

// Values of another lane; whoever has a type of his own adds one.
NTC_FUNCTION float NtcStfReadLane(float value, uint lane) {
    return NtcWaveRead(value, lane);
}
NTC_FUNCTION float2 NtcStfReadLane(float2 value, uint lane) {
    return NtcWaveRead(value, lane);
}
NTC_FUNCTION float4 NtcStfReadLane(float4 value, uint lane) {
    return NtcWaveRead(value, lane);
}
NTC_FUNCTION NtcStfTexel NtcStfReadLane(NtcStfTexel value, uint lane) {
    NtcStfTexel other;
    other.channels0 = NtcStfReadLane(value.channels0, lane);
    other.channels4 = NtcStfReadLane(value.channels4, lane);
    other.channels8 = NtcStfReadLane(value.channels8, lane);
    other.channels12 = NtcStfReadLane(value.channels12, lane);
    return other;
}

// 128 bits, a lane or a cell of a box each.

NTC_FUNCTION uint NtcStfGetWord(uint4 bits, uint word) {
    return word == 0u ? bits.x : (word == 1u ? bits.y : (word == 2u ? bits.z : bits.w));
}

NTC_FUNCTION uint NtcStfCountAll(uint4 bits) {
    return NtcStfCountBits(bits.x) + NtcStfCountBits(bits.y) + NtcStfCountBits(bits.z) +
           NtcStfCountBits(bits.w);
}

/// How many bits below bit `index`, 0 ... 127, are set.
NTC_FUNCTION uint NtcStfCountBelow(uint4 bits, uint index) {
    uint word = index >> 5;
    uint count = NtcStfCountBits(NtcStfGetWord(bits, word) & ((1u << (index & 31u)) - 1u));
    count += word > 0u ? NtcStfCountBits(bits.x) : 0u;
    count += word > 1u ? NtcStfCountBits(bits.y) : 0u;
    count += word > 2u ? NtcStfCountBits(bits.z) : 0u;
    return count;
}

/// The place of set bit number `rank`, counted from 0; rank must be below their number.
NTC_FUNCTION uint NtcStfFindBit(uint4 bits, uint rank) {
    uint left = rank;
    uint word = 0u;
    for (uint i = 0u; i < 3u; i++) {
        uint count = NtcStfCountBits(NtcStfGetWord(bits, i));
        if (word == i && left >= count) {
            left -= count;
            word = i + 1u;
        }
    }
    uint rest = NtcStfGetWord(bits, word);
    uint place = 32u * word;
    for (uint span = 16u; span > 0u; span >>= 1) {
        uint low = NtcStfCountBits(rest & ((1u << span) - 1u));
        if (left >= low) {
            left -= low;
            place += span;
            rest >>= span;
        }
    }
    return place;
}

NTC_FUNCTION bool NtcStfHasBit(uint4 bits, uint index) {
    return ((NtcStfGetWord(bits, index >> 5) >> (index & 31u)) & 1u) != 0u;
}

/// Bit `index` alone.
NTC_FUNCTION uint4 NtcStfMakeBit(uint index) {
    uint bit = 1u << (index & 31u);
    uint word = index >> 5;
    return uint4(word == 0u ? bit : 0u, word == 1u ? bit : 0u, word == 2u ? bit : 0u, word == 3u ? bit : 0u);
}

NTC_NAMESPACE_END

#endif
