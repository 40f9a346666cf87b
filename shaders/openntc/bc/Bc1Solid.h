// SPDX-License-Identifier: MIT
// Colours of 5, 6 and 5 bits, and the pair of them whose first inner colour is nearest to a given one.
#ifndef OPENNTC_BC1_SOLID_H
#define OPENNTC_BC1_SOLID_H

#include "openntc/bc/Lanes.h"

NTC_LANES_NAMESPACE_BEGIN

/// Two colours as they are stored: 5, 6 and 5 bits of red, green and blue.
struct NtcBc1Pair {
    NtcLane a[3];
    NtcLane b[3];
};

/// 5 bits (green: 6) to 8 by repeating them.
NTC_LANES_INLINE NtcLane NtcBc1Widen(NtcLane x, bool isGreen) {
    if (isGreen)
        return (x << 2) | (x >> 4);
    return (x << 3) | (x >> 2);
}

/// 8 bits to the nearest of 5 (green: 6).
NTC_LANES_INLINE NtcLane NtcBc1Narrow(NtcLane x, bool isGreen) {
    NtcLane product = x * (isGreen ? 63 : 31) + 128;
    return (product + (product >> 8)) >> 8;
}

/// Of one channel the pair whose colour at index 1 of `steps` (2 or 3) is nearest to x / count, by the
/// colour without rounding; of equal ones that with the smallest distance.
NTC_FUNCTION void NtcBc1MeanChannel(NtcLane x, NtcLane count, int steps, bool isGreen, NTC_INOUT(NtcLane, a),
                                    NTC_INOUT(NtcLane, b)) {
    int top = isGreen ? 63 : 31;
    NtcLane least = NtcSplat(0x7FFFFFFF);
    a = NtcSplat(0);
    b = NtcSplat(0);
    NTC_LOOP for (int tryB = 0; tryB <= top; tryB++) {
        // (steps - 1) a + b = steps x / count
        NtcLane wideB = NtcBc1Widen(NtcSplat(tryB), isGreen);
        NtcLane wanted = x * steps - wideB * count;
        NtcLane part = count * (steps - 1);
        NtcLane wideA = NtcDividePositive(NtcLaneMax(wanted * 2 + part, NtcSplat(0)), part * 2);
        NtcLane tryA = NtcBc1Narrow(NtcLaneMin(wideA, NtcSplat(255)), isGreen);
        wideA = NtcBc1Widen(tryA, isGreen);
        NtcLane error = NtcLaneAbs(wanted - wideA * part) * 64 + NtcLaneAbs(tryA - tryB);
        NtcMask isBetter = error < least;
        least = NtcSelect(isBetter, error, least);
        a = NtcSelect(isBetter, tryA, a);
        b = NtcSelect(isBetter, NtcSplat(tryB), b);
    }
}

/// The pair for the mean of `count` colours, whose sums are given.
NTC_FUNCTION NtcBc1Pair NtcBc1MeanPair(NTC_IN_ARRAY(NtcLane, sums, 3), NtcLane count, int steps) {
    NtcBc1Pair pair;
    NtcLane some = NtcLaneMax(count, NtcSplat(1));
    NtcBc1MeanChannel(sums[0], some, steps, false, pair.a[0], pair.b[0]);
    NtcBc1MeanChannel(sums[1], some, steps, true, pair.a[1], pair.b[1]);
    NtcBc1MeanChannel(sums[2], some, steps, false, pair.a[2], pair.b[2]);
    return pair;
}

NTC_LANES_NAMESPACE_END

#endif
