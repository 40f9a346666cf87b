// SPDX-License-Identifier: MIT
// BC4 blocks, and the channels of BC3's alpha and BC5.
//
// A pair of endpoints is judged by the squared error of the sixteen texels against its palette without
// rounding, times 49 (eight values, steps of a seventh) or 25 (six values, steps of a fifth): integers. The
// search visits pairs; from each it may go on to the pair that fits the indices best by least squares. What
// starts it: the texels' extremes, moved inwards; and palettes that cover the texels' range with 6, 5, 4, 3
// of the seven steps, whose finer phases are what smooth blocks need. Then pairs beside the best one.
// Each quality visits what the lower ones visit and more, so that it is never worse.
#ifndef OPENNTC_BC4_H
#define OPENNTC_BC4_H

#include "openntc/bc/Lanes.h"
#include "openntc/bc/LineFit.h"
#include "openntc/bc/Quality.h"

NTC_LANES_NAMESPACE_BEGIN

/// The two words of a block: endpoints in bytes 0 and 1, then sixteen indices of three bits.
struct NtcBc4Block {
    NtcLane words[2];
};

/// A pair of endpoints: first > second has eight values.
struct NtcBc4Pair {
    NtcLane first;
    NtcLane second;
};

struct NtcBc4Best {
    NtcBc4Pair pair;
    NtcLane error;
};

/// Sums over a block, and what a pair may be. Numbers are 0 ... limit.
struct NtcBc4Sums {
    NtcLane low;
    NtcLane high;
    NtcLane sum;
    NtcLane squares;
    NtcLane leastFirst; // of eight values
    NtcLane mostSecond;
    int limit;
};

/// Which of `steps` + 1 values from `low` in steps of (high - low) / steps is nearest to x; between two the
/// higher one. scale: steps / (high - low); offset: 1/2 + 1/4 / (high - low) - low scale. The true quotient
/// is a quarter of a smallest step off all integers, far more than what floats may be wrong by.
NTC_LANES_INLINE NtcLane NtcBc4Level(NtcLaneFloat x, NtcLaneFloat scale, NtcLaneFloat offset, int steps) {
    return NtcLaneClamp(NtcLaneTruncate(x * scale + offset), 0, steps);
}

/// Judges first > second with eight values, and says which pair fits its indices better, or the same one.
NTC_LANES_INLINE NtcBc4Pair NtcBc4Visit8(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, NtcBc4Pair pair,
                                         bool wantsFit, NTC_INOUT(NtcBc4Best, best)) {
    pair.first = NtcLaneMax(NtcLaneMin(pair.first, NtcSplat(sums.limit)), sums.leastFirst);
    pair.second = NtcLaneMin(NtcLaneMax(pair.second, NtcSplat(0)), sums.mostSecond);
    NtcMask isValid = pair.first > pair.second;
    NtcLane range = NtcLaneMax(pair.first - pair.second, NtcSplat(1));
    NtcLaneFloat reciprocal = 1.0f / NtcLaneToFloat(range);
    NtcLaneFloat scale = reciprocal * 7.0f;
    NtcLaneFloat offset = reciprocal * 0.25f + 0.5f - NtcLaneToFloat(pair.second) * scale;
    NtcLaneFloat sumK = NtcLaneToFloat(NtcSplat(0));
    NtcLaneFloat sumKK = sumK;
    NtcLaneFloat sumKX = sumK;
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLaneFloat k = NtcLaneToFloat(NtcBc4Level(x[t], scale, offset, 7));
        sumK = sumK + k;
        sumKK = sumKK + k * k;
        sumKX = sumKX + k * x[t];
    }
    // The sum of (7 y - k range)^2 with y = x - second.
    NtcLane k1 = NtcLaneTruncate(sumK);
    NtcLane kk = NtcLaneTruncate(sumKK);
    NtcLane kx = NtcLaneTruncate(sumKX);
    NtcLane yy = sums.squares - pair.second * (sums.sum * 2 - pair.second * 16);
    NtcLane error = yy * 49 + range * (range * kk - (kx - pair.second * k1) * 14);
    NtcMask isBetter = NtcMaskAnd(isValid, error < best.error);
    best.error = NtcSelect(isBetter, error, best.error);
    best.pair.first = NtcSelect(isBetter, pair.first, best.pair.first);
    best.pair.second = NtcSelect(isBetter, pair.second, best.pair.second);
    NtcBc4Pair next = pair;
    if (wantsFit) {
        NtcLane first;
        NtcLane second;
        NtcMask fits = NtcFitLine(NtcSplat(16), k1, kk, kx, sums.sum, 7, sums.limit, second, first);
        fits = NtcMaskAnd(fits, first > second);
        next.first = NtcSelect(fits, first, pair.first);
        next.second = NtcSelect(fits, second, pair.second);
    }
    return next;
}

/// Judges first <= second with six values, 0 and the limit.
NTC_LANES_INLINE NtcBc4Pair NtcBc4Visit6(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, NtcBc4Pair pair,
                                         bool wantsFit, NTC_INOUT(NtcBc4Best, best)) {
    pair.first = NtcLaneClamp(pair.first, 0, sums.limit);
    pair.second = NtcLaneClamp(pair.second, 0, sums.limit);
    NtcMask isValid = pair.first <= pair.second;
    NtcLane range = NtcLaneMax(pair.second - pair.first, NtcSplat(1));
    NtcLaneFloat rangeFloat = NtcLaneToFloat(range);
    NtcLaneFloat reciprocal = 1.0f / rangeFloat;
    NtcLaneFloat scale = reciprocal * 5.0f;
    NtcLaneFloat firstFloat = NtcLaneToFloat(pair.first);
    NtcLaneFloat offset = reciprocal * 0.25f + 0.5f - firstFloat * scale;
    NtcMask isEqual = pair.first == pair.second; // range is 1 then, and level 0 the only one
    NtcLane count = NtcSplat(0);
    NtcLane sumX = count;
    NtcLane sumK = count;
    NtcLane sumKK = count;
    NtcLane sumKX = count;
    NtcLane error = count;
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane number = NtcLaneTruncate(x[t]);
        NtcLane k = NtcSelect(isEqual, NtcSplat(0), NtcBc4Level(x[t], scale, offset, 5));
        NtcLane rest = NtcLaneAbs((number - pair.first) * 5 - k * range);
        NtcLane extreme = NtcLaneMin(number, sums.limit - number) * 5;
        NtcMask isInside = rest <= extreme;
        NtcLane least = NtcLaneMin(rest, extreme);
        error = error + least * least;
        if (wantsFit) {
            NtcLane inside = NtcSelect(isInside, k, NtcSplat(0));
            count = count + NtcSelect(isInside, NtcSplat(1), NtcSplat(0));
            sumX = sumX + NtcSelect(isInside, number, NtcSplat(0));
            sumK = sumK + inside;
            sumKK = sumKK + inside * k;
            sumKX = sumKX + inside * number;
        }
    }
    NtcMask isBetter = NtcMaskAnd(isValid, error < best.error);
    best.error = NtcSelect(isBetter, error, best.error);
    best.pair.first = NtcSelect(isBetter, pair.first, best.pair.first);
    best.pair.second = NtcSelect(isBetter, pair.second, best.pair.second);
    NtcBc4Pair next = pair;
    if (wantsFit) {
        NtcLane first;
        NtcLane second;
        NtcMask fits = NtcFitLine(count, sumK, sumKK, sumKX, sumX, 5, sums.limit, first, second);
        fits = NtcMaskAnd(fits, first <= second);
        next.first = NtcSelect(fits, first, pair.first);
        next.second = NtcSelect(fits, second, pair.second);
    }
    return next;
}

/// Starts by number: the extremes moved inwards by sixteenths (high | low << 4), or ranges of fewer steps.
NTC_TABLE(int, kNtcBc4Insets, 5) = {0x00, 0x22, 0x11, 0x02, 0x20};

NTC_FUNCTION NtcBc4Pair NtcBc4Start(NtcBc4Sums sums, int start, int insets) {
    NtcLane range = sums.high - sums.low;
    NtcBc4Pair pair;
    if (start < insets) {
        int inset = kNtcBc4Insets[start];
        pair.first = sums.high - ((range * (inset & 15)) >> 4);
        pair.second = sums.low + ((range * (inset >> 4)) >> 4);
    } else {
        int steps = 6 - (start - insets); // of seven
        int below = (7 - steps) / 2;      // steps below the lowest texel
        NtcLane wide = NtcLaneMax(NtcDividePositive(range * 7 + (steps - 1), NtcSplat(steps)), NtcSplat(7));
        NtcLane second = NtcLaneMax(sums.low - NtcDividePositive(wide * below, NtcSplat(7)), NtcSplat(0));
        pair.second = NtcLaneMax(NtcLaneMin(second, sums.limit - wide), NtcSplat(0));
        pair.first = pair.second + wide;
    }
    pair.first = NtcLaneMin(pair.first, NtcSplat(sums.limit));
    NtcMask isEmpty = pair.first <= pair.second;
    NtcMask isTop = pair.second >= sums.limit;
    pair.first = NtcSelect(NtcMaskAnd(isEmpty, NtcMaskNot(isTop)), pair.second + 1, pair.first);
    pair.second = NtcSelect(NtcMaskAnd(isEmpty, isTop), pair.first - 1, pair.second);
    return pair;
}

/// The best pair's palette moved by whole steps: other roundings.
NTC_FUNCTION void NtcBc4Shifts(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, int reach,
                               NTC_INOUT(NtcBc4Best, best)) {
    NtcBc4Pair center = best.pair;
    NTC_LOOP for (int s = -reach; s <= reach; s++) {
        NtcLane moveBy = NtcDivide((center.first - center.second) * (2 * s) + 7, NtcSplat(14));
        NtcBc4Pair pair;
        pair.first = center.first + moveBy;
        pair.second = center.second + moveBy;
        if (s != 0)
            NtcBc4Visit8(x, sums, pair, false, best);
    }
}

/// Pairs beside the best one.
NTC_FUNCTION void NtcBc4Neighbours(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, int reach,
                                   NTC_INOUT(NtcBc4Best, best)) {
    NtcBc4Pair center = best.pair;
    NTC_LOOP for (int i = -reach; i <= reach; i++) {
        NTC_LOOP for (int j = -reach; j <= reach; j++) {
            NtcBc4Pair pair;
            pair.first = center.first + i;
            pair.second = center.second + j;
            if (i != 0 || j != 0)
                NtcBc4Visit8(x, sums, pair, false, best);
        }
    }
}

NTC_FUNCTION void NtcBc4Search8(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, int quality,
                                NTC_INOUT(NtcBc4Best, best)) {
    // A start of the fast level is one of all levels.
    int starts = quality == NTC_BC_QUALITY_FAST ? 4 : 9;
    int fits = quality == NTC_BC_QUALITY_FAST ? 1 : 2;
    NTC_LOOP for (int start = 0; start < starts; start++) {
        int insets = quality == NTC_BC_QUALITY_FAST ? 2 : 5;
        NtcBc4Pair pair = NtcBc4Start(sums, start, insets);
        NTC_LOOP for (int fit = 0; fit < fits; fit++) pair = NtcBc4Visit8(x, sums, pair, true, best);
        NtcBc4Visit8(x, sums, pair, false, best);
    }
    if (quality == NTC_BC_QUALITY_FAST)
        return;
    NtcBc4Shifts(x, sums, 2, best);
    NtcBc4Neighbours(x, sums, 1, best);
    if (quality == NTC_BC_QUALITY_NORMAL)
        return;
    NtcBc4Shifts(x, sums, 3, best);
    NTC_LOOP for (int round = 0; round < 4; round++) NtcBc4Neighbours(x, sums, round == 3 ? 3 : 1, best);
}

/// Six values round the texels that are further from the ends than `below` and `above`.
NTC_FUNCTION NtcBc4Pair NtcBc4Inside(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, int below,
                                     int above) {
    NtcBc4Pair pair;
    pair.first = NtcSplat(sums.limit);
    pair.second = NtcSplat(0);
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane number = NtcLaneTruncate(x[t]);
        NtcMask isInside = NtcMaskAnd(number > below, number < sums.limit - above);
        pair.first = NtcSelect(isInside, NtcLaneMin(pair.first, number), pair.first);
        pair.second = NtcSelect(isInside, NtcLaneMax(pair.second, number), pair.second);
    }
    NtcMask isNone = pair.first > pair.second;
    pair.first = NtcSelect(isNone, sums.low, pair.first);
    pair.second = NtcSelect(isNone, sums.high, pair.second);
    return pair;
}

NTC_FUNCTION void NtcBc4Search6(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Sums sums, int quality,
                                NTC_INOUT(NtcBc4Best, best)) {
    // Texels near the ends may be left to 0 and the limit, more and more of them.
    int starts = quality == NTC_BC_QUALITY_NORMAL ? 1 : 5;
    NTC_LOOP for (int i = 0; i < starts; i++) {
        NTC_LOOP for (int j = 0; j < starts; j++) {
            NtcBc4Pair pair = NtcBc4Inside(x, sums, 14 * i, 14 * j);
            NTC_LOOP for (int fit = 0; fit < 2; fit++) pair = NtcBc4Visit6(x, sums, pair, true, best);
            NtcBc4Visit6(x, sums, pair, false, best);
        }
    }
    int rounds = quality == NTC_BC_QUALITY_NORMAL ? 0 : 4;
    NTC_LOOP for (int round = 0; round < rounds; round++) {
        NtcBc4Pair center = best.pair;
        NTC_LOOP for (int n = 0; n < 9; n++) {
            NtcBc4Pair pair;
            pair.first = center.first + (n / 3 - 1);
            pair.second = center.second + (n % 3 - 1);
            if (n != 4)
                NtcBc4Visit6(x, sums, pair, false, best);
        }
    }
}

/// The indices of the better of both.
NTC_FUNCTION NtcBc4Block NtcBc4Pack(NTC_IN_ARRAY(NtcLaneFloat, x, 16), NtcBc4Pair pair, int limit, int bias) {
    NtcMask hasEight = pair.first > pair.second;
    NtcMask isEqual = pair.first == pair.second;
    NtcLane low = NtcLaneMin(pair.first, pair.second);
    NtcLane range = NtcLaneMax(NtcLaneAbs(pair.first - pair.second), NtcSplat(1));
    NtcLane steps = NtcSelect(hasEight, NtcSplat(7), NtcSplat(5));
    NtcLaneFloat reciprocal = 1.0f / NtcLaneToFloat(range);
    NtcLaneFloat scale = reciprocal * NtcLaneToFloat(steps);
    NtcLaneFloat offset = reciprocal * 0.25f + 0.5f - NtcLaneToFloat(low) * scale;
    NtcBc4Block block;
    block.words[0] = ((pair.first - bias) & 255) | (((pair.second - bias) & 255) << 8);
    block.words[1] = NtcSplat(0);
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane k = NtcLaneMin(NtcBc4Level(x[t], scale, offset, 7), steps);
        k = NtcSelect(isEqual, NtcSplat(0), k);
        // From the first endpoint: 0, 2, 3 ..., 1.
        NtcLane fromFirst = NtcSelect(hasEight, 7 - k, k);
        NtcLane index = NtcSelect(fromFirst == 0, NtcSplat(0), fromFirst + 1);
        index = NtcSelect(NtcMaskAnd(fromFirst == steps, NtcMaskNot(isEqual)), NtcSplat(1), index);
        NtcLane number = NtcLaneTruncate(x[t]);
        NtcLane rest = NtcLaneAbs((number - low) * 5 - k * range);
        NtcMask isInside = NtcMaskOr(hasEight, rest <= NtcLaneMin(number, limit - number) * 5);
        NtcLane extreme = NtcSelect(number * 2 > limit, NtcSplat(7), NtcSplat(6));
        index = NtcSelect(isInside, index, extreme);
        int bit = 16 + 3 * t;
        if (bit < 32)
            block.words[0] = block.words[0] | (index << bit);
        if (bit >= 32)
            block.words[1] = block.words[1] | (index << (bit - 32));
        if (bit == 31)
            block.words[1] = block.words[1] | (index >> 1);
    }
    return block;
}

/// One channel to a block. Unsigned (limit 255, bias 0): numbers 0 ... 255; signed (limit 254, bias 127):
/// -127 ... 127. keepsExtremes: numbers at the ends stay exactly what they are, as alpha must.
NTC_FUNCTION NtcBc4Block NtcEncodeBc4(NTC_IN_ARRAY(NtcLane, numbers, 16), int limit, int bias,
                                      bool keepsExtremes, int quality) {
    NtcLaneFloat x[16];
    NtcBc4Sums sums;
    sums.low = NtcSplat(limit);
    sums.high = NtcSplat(0);
    sums.sum = NtcSplat(0);
    sums.squares = NtcSplat(0);
    sums.limit = limit;
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane number = numbers[t] + bias;
        sums.low = NtcLaneMin(sums.low, number);
        sums.high = NtcLaneMax(sums.high, number);
        sums.sum = sums.sum + number;
        sums.squares = sums.squares + number * number;
        x[t] = NtcLaneToFloat(number);
    }
    sums.leastFirst = NtcSplat(0);
    sums.mostSecond = NtcSplat(limit);
    if (keepsExtremes) {
        sums.leastFirst = NtcSelect(sums.high == limit, NtcSplat(limit), NtcSplat(0));
        sums.mostSecond = NtcSelect(sums.low == 0, NtcSplat(0), NtcSplat(limit));
    }
    NtcBc4Best best8;
    best8.pair.first = NtcSplat(limit);
    best8.pair.second = NtcSplat(0);
    best8.error = NtcSplat(0x7FFFFFFF);
    NtcBc4Search8(x, sums, quality, best8);
    NtcBc4Pair pair = best8.pair;
    if (quality != NTC_BC_QUALITY_FAST) {
        NtcBc4Best best6;
        best6.pair.first = NtcSplat(0);
        best6.pair.second = NtcSplat(limit);
        best6.error = NtcSplat(0x01FFFFFF);
        NtcBc4Search6(x, sums, quality, best6);
        // No block's best error is above 16 (7 limit / 14)^2.
        NtcMask isSix = best6.error * 49 < best8.error * 25;
        pair.first = NtcSelect(isSix, best6.pair.first, pair.first);
        pair.second = NtcSelect(isSix, best6.pair.second, pair.second);
    }
    return NtcBc4Pack(x, pair, limit, bias);
}

NTC_LANES_NAMESPACE_END

#endif
