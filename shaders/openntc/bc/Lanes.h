// SPDX-License-Identifier: MIT
// Block encoders are written once for many blocks: one block is one lane. In GLSL and HLSL a lane is a
// thread, and the types below are int, float and bool. In C++ a lane is an element of a vector of NTC_LANES
// ints (1: plain ints), so that the same source is the CPU's encoder for every instruction set.
//
// What makes all of them give the same blocks:
//   - integers, and floats whose value is an integer below 2^24; divisions by NtcDivide
//   - what differs between lanes is chosen by NtcSelect; `if` and loop bounds hang on what all lanes share,
//     or on NtcAnyLane where doing the work for the other lanes too changes nothing
//   - a vector is made of one number by NtcSplat; NtcLane x = 0 does not compile for vectors
//
// In C++ bc/detail/Kernels.h includes this and the encoders once more for each instruction set, in a
// namespace of its own (NTC_LANES_TARGET).
#ifndef OPENNTC_LANES_H
#define OPENNTC_LANES_H

#include "openntc/Portability.h"

#if defined(__cplusplus)
#if !defined(NTC_LANES)
#define NTC_LANES 1
#define NTC_LANES_TARGET lanes1
#endif
#define NTC_LANES_NAMESPACE_BEGIN namespace openntc::shader::NTC_LANES_TARGET {
#define NTC_LANES_NAMESPACE_END }
#define NTC_TABLE(T, name, size) inline constexpr T name[size]
#elif defined(NTC_HLSL)
#define NTC_LANES 1
#define NTC_LANES_NAMESPACE_BEGIN
#define NTC_LANES_NAMESPACE_END
#define NTC_TABLE(T, name, size) static const T name[size]
#else
#define NTC_LANES 1
#define NTC_LANES_NAMESPACE_BEGIN
#define NTC_LANES_NAMESPACE_END
#define NTC_TABLE(T, name, size) const T name[size]
#endif

NTC_LANES_NAMESPACE_BEGIN

#if defined(__cplusplus)
#if NTC_LANES > 1
typedef int NtcLane __attribute__((vector_size(4 * NTC_LANES)));
typedef float NtcLaneFloat __attribute__((vector_size(4 * NTC_LANES)));
typedef NtcLane NtcMask; // -1 where true, else 0

NTC_FUNCTION NtcLane NtcSplat(int x) {
    return NtcLane{} + x;
}
NTC_FUNCTION NtcLaneFloat NtcLaneToFloat(NtcLane x) {
    return __builtin_convertvector(x, NtcLaneFloat);
}
NTC_FUNCTION NtcLane NtcLaneTruncate(NtcLaneFloat x) {
    return __builtin_convertvector(x, NtcLane);
}
NTC_FUNCTION NtcLane NtcLaneBits(NtcLaneFloat x) {
    return __builtin_bit_cast(NtcLane, x);
}
NTC_FUNCTION NtcMask NtcMaskAnd(NtcMask a, NtcMask b) {
    return a & b;
}
NTC_FUNCTION NtcMask NtcMaskOr(NtcMask a, NtcMask b) {
    return a | b;
}
NTC_FUNCTION NtcMask NtcMaskNot(NtcMask a) {
    return ~a;
}
NTC_FUNCTION bool NtcAnyLane(NtcMask mask) {
    int any = 0;
    for (int i = 0; i < NTC_LANES; i++)
        any |= mask[i];
    return any != 0;
}
/// table[index] of every lane.
template <typename T, std::size_t Size>
NTC_FUNCTION NtcLane NtcLookup(const T (&table)[Size], NtcLane index) {
    NtcLane values = {};
    for (int i = 0; i < NTC_LANES; i++)
        values[i] = static_cast<int>(table[index[i]]);
    return values;
}
#else
typedef int NtcLane;
typedef float NtcLaneFloat;
typedef bool NtcMask;

template <typename T, std::size_t Size>
NTC_FUNCTION int NtcLookup(const T (&table)[Size], int index) {
    return static_cast<int>(table[index]);
}
#endif
#else
#define NtcLane int
#define NtcLaneFloat float
#define NtcMask bool
#define NtcLookup(table, index) int((table)[index])
#endif

/// For functions that must vanish into their callers: what they take is constant there, or lives in
/// registers.
#if defined(__cplusplus) && defined(__GNUC__)
#define NTC_LANES_INLINE inline __attribute__((always_inline))
#else
#define NTC_LANES_INLINE NTC_FUNCTION
#endif

#if NTC_LANES == 1
NTC_FUNCTION NtcLane NtcSplat(int x) {
    return x;
}
NTC_FUNCTION NtcLaneFloat NtcLaneToFloat(NtcLane x) {
    return float(x);
}
NTC_FUNCTION NtcLane NtcLaneTruncate(NtcLaneFloat x) {
    return int(x);
}
NTC_FUNCTION NtcLane NtcLaneBits(NtcLaneFloat x) {
    return int(asuint(x));
}
NTC_FUNCTION NtcMask NtcMaskAnd(NtcMask a, NtcMask b) {
    return a && b;
}
NTC_FUNCTION NtcMask NtcMaskOr(NtcMask a, NtcMask b) {
    return a || b;
}
NTC_FUNCTION NtcMask NtcMaskNot(NtcMask a) {
    return !a;
}
NTC_FUNCTION bool NtcAnyLane(NtcMask mask) {
    return mask;
}
#endif

NTC_FUNCTION NtcLane NtcSelect(NtcMask mask, NtcLane a, NtcLane b) {
    return mask ? a : b;
}
/// 1 where true, else 0.
NTC_FUNCTION NtcLane NtcCountMask(NtcMask mask) {
    return NtcSelect(mask, NtcSplat(1), NtcSplat(0));
}
NTC_FUNCTION NtcLane NtcLaneMin(NtcLane a, NtcLane b) {
    return NtcSelect(a < b, a, b);
}
NTC_FUNCTION NtcLane NtcLaneMax(NtcLane a, NtcLane b) {
    return NtcSelect(a > b, a, b);
}
NTC_FUNCTION NtcLane NtcLaneClamp(NtcLane x, int low, int high) {
    return NtcLaneMin(NtcLaneMax(x, NtcSplat(low)), NtcSplat(high));
}
NTC_FUNCTION NtcLane NtcLaneAbs(NtcLane x) {
    return NtcLaneMax(x, -x);
}

/// The integer quotient, rounded towards minus infinity; |numerator| < 2^30, |quotient| < 2^20, denominator
/// 1 ... 2^30. A float division, of whatever rounding a device has, is off by two at most; integers tell by
/// how much.
NTC_FUNCTION NtcLane NtcDivide(NtcLane numerator, NtcLane denominator) {
    NtcLane quotient = NtcLaneTruncate(NtcLaneToFloat(numerator) / NtcLaneToFloat(denominator));
    NTC_UNROLL for (int i = 0; i < 3; i++) {
        NtcLane rest = numerator - quotient * denominator;
        quotient = quotient + NtcSelect(rest < 0, NtcSplat(-1),
                                        NtcSelect(rest >= denominator, NtcSplat(1), NtcSplat(0)));
    }
    return quotient;
}

/// The same for 0 <= numerator < 2^30 and quotients below 2^20, of which a float division is off by one at
/// most.
NTC_FUNCTION NtcLane NtcDividePositive(NtcLane numerator, NtcLane denominator) {
    NtcLane quotient = NtcLaneTruncate(NtcLaneToFloat(numerator) / NtcLaneToFloat(denominator));
    NtcLane rest = numerator - quotient * denominator;
    return quotient +
           NtcSelect(rest < 0, NtcSplat(-1), NtcSelect(rest >= denominator, NtcSplat(1), NtcSplat(0)));
}

/// The index of the highest bit of x > 0: its exponent as a float. Without the bit below the highest one no
/// rounding reaches the next power of two.
NTC_FUNCTION NtcLane NtcHighestBit(NtcLane x) {
    return ((NtcLaneBits(NtcLaneToFloat(x & ~(x >> 1))) >> 23) & 255) - 127;
}

NTC_LANES_NAMESPACE_END

#endif
