// SPDX-License-Identifier: MIT
// Least squares over indices, for blocks whose texels lie between two endpoints.
#ifndef OPENNTC_BC_LINE_FIT_H
#define OPENNTC_BC_LINE_FIT_H

#include "openntc/bc/Lanes.h"

NTC_LANES_NAMESPACE_BEGIN

/// The line that fits `count` <= 16 numbers x of 0 ... 255 at indices k of 0 ... 7 best: its values at index
/// 0 and at index `steps`, rounded and clamped to 0 ... limit. From the sums of k, k k, k x and x. False
/// where all indices are equal.
NTC_LANES_INLINE NtcMask NtcFitLine(NtcLane count, NtcLane sumK, NtcLane sumKK, NtcLane sumKX, NtcLane sumX,
                                    int steps, int limit, NTC_OUT(NtcLane, atZero), NTC_OUT(NtcLane, atEnd)) {
    NtcLane det = count * sumKK - sumK * sumK;
    NtcLane slope = count * sumKX - sumK * sumX;
    NtcLane base = sumX * det - slope * sumK;
    NtcLane unit = NtcLaneMax(count * det, NtcSplat(1));
    NtcLane zero = NtcLaneMax(base * 2 + unit, NtcSplat(0));
    NtcLane end = NtcLaneMax((base + count * slope * steps) * 2 + unit, NtcSplat(0));
    atZero = NtcLaneMin(NtcDividePositive(zero, unit * 2), NtcSplat(limit));
    atEnd = NtcLaneMin(NtcDividePositive(end, unit * 2), NtcSplat(limit));
    return det > 0;
}

NTC_LANES_NAMESPACE_END

#endif
