// SPDX-License-Identifier: MIT
// BC1 blocks, and the colours of BC2 and BC3.
//
// A pair of colours is judged by the squared error of the texels against its palette without rounding: of
// four colours (indices 0 ... 3 from one end, times 9) or three (0 ... 2, times 4, BC1 only). Which index is
// nearest says the projection on the line between both, in integers. For the indices that a pair gets, the
// best pair of each channel follows from sums alone: the least-squares line, and round it the pairs of 5 or
// 6 bits. The search goes from starts to such pairs until the level's rounds are spent; each level visits
// what the lower ones visit and more.
#ifndef OPENNTC_BC1_H
#define OPENNTC_BC1_H

#include "openntc/bc/Bc1Axis.h"
#include "openntc/bc/Bc1Solid.h"
#include "openntc/bc/Lanes.h"
#include "openntc/bc/LineFit.h"
#include "openntc/bc/Quality.h"

NTC_LANES_NAMESPACE_BEGIN

struct NtcBc1Block {
    NtcLane words[2];
};

struct NtcBc1Best {
    NtcBc1Pair pair;
    NtcLane error;
};

/// Of one channel the pair of endpoints that fits best, among those whose first one is within 1 of the
/// line's. u, v: squares of the weights that indices give to both ends and their product; ux, vx: with the
/// texels.
NTC_LANES_INLINE void NtcBc1FitChannel(NtcLane uu, NtcLane uv, NtcLane vv, NtcLane ux, NtcLane vx, int steps,
                                       bool isGreen, NtcLane start, NTC_INOUT(NtcLane, a),
                                       NTC_INOUT(NtcLane, b)) {
    int top = isGreen ? 63 : 31;
    NtcLane least = NtcSplat(0x7FFFFFFF);
    NtcLane bestA = a;
    NtcLane bestB = b;
    NtcLane divisor = NtcLaneMax(vv, NtcSplat(1));
    NTC_UNROLL for (int i = -1; i <= 1; i++) {
        NtcLane tryA = NtcLaneClamp(start + i, 0, top);
        NtcLane wideA = NtcBc1Widen(tryA, isGreen);
        NtcLane rest = NtcLaneMax(vx * steps - wideA * uv, NtcSplat(0));
        NtcLane wideB = NtcLaneMin(NtcDividePositive(rest * 2 + divisor, divisor * 2), NtcSplat(255));
        NtcLane tryB = NtcBc1Narrow(wideB, isGreen);
        wideB = NtcBc1Widen(tryB, isGreen);
        NtcLane error = wideA * (wideA * uu + wideB * uv * 2 - ux * (2 * steps)) +
                        wideB * (wideB * vv - vx * (2 * steps));
        NtcMask isBetter = error < least;
        least = NtcSelect(isBetter, error, least);
        bestA = NtcSelect(isBetter, tryA, bestA);
        bestB = NtcSelect(isBetter, tryB, bestB);
    }
    a = bestA;
    b = bestB;
}

/// Judges a pair with steps + 1 colours and says which pair fits its indices best. weights: 0 for texels that
/// do not count; all 1 unless isWeighted.
NTC_LANES_INLINE NtcBc1Pair NtcBc1Visit(NTC_IN_ARRAY(NtcLaneFloat, x, 48),
                                        NTC_IN_ARRAY(NtcLaneFloat, weights, 16), NtcBc1Sums sums,
                                        NtcBc1Pair pair, int steps, bool isWeighted, bool wantsFit,
                                        NTC_INOUT(NtcBc1Best, best)) {
    NtcLane a[3];
    NtcLane d[3];
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        pair.a[c] = NtcLaneClamp(pair.a[c], 0, c == 1 ? 63 : 31);
        pair.b[c] = NtcLaneClamp(pair.b[c], 0, c == 1 ? 63 : 31);
        a[c] = NtcBc1Widen(pair.a[c], c == 1);
        d[c] = NtcBc1Widen(pair.b[c], c == 1) - a[c];
    }
    // Index k is at least j where 2 steps (x - a) d >= (2 j - 1) d d.
    NtcLane lengths = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    NtcLane origin = (a[0] * d[0] + a[1] * d[1] + a[2] * d[2]) * (2 * steps);
    NtcLaneFloat axis0 = NtcLaneToFloat(d[0] * (2 * steps));
    NtcLaneFloat axis1 = NtcLaneToFloat(d[1] * (2 * steps));
    NtcLaneFloat axis2 = NtcLaneToFloat(d[2] * (2 * steps));
    NtcLaneFloat limit1 = NtcLaneToFloat(origin + lengths);
    NtcLaneFloat limit2 = NtcLaneToFloat(origin + lengths * 3);
    NtcLaneFloat limit3 = NtcLaneToFloat(origin + lengths * 5);
    NtcLaneFloat sumK = NtcLaneToFloat(NtcSplat(0));
    NtcLaneFloat sumKK = sumK;
    NtcLaneFloat sumKX0 = sumK;
    NtcLaneFloat sumKX1 = sumK;
    NtcLaneFloat sumKX2 = sumK;
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLaneFloat along = x[t] * axis0 + x[16 + t] * axis1 + x[32 + t] * axis2;
        NtcLane level = NtcCountMask(along >= limit1) + NtcCountMask(along >= limit2);
        if (steps == 3)
            level = level + NtcCountMask(along >= limit3);
        NtcLaneFloat k = NtcLaneToFloat(level);
        NtcLaneFloat weighted = isWeighted ? k * weights[t] : k;
        sumK = sumK + weighted;
        sumKK = sumKK + weighted * k;
        sumKX0 = sumKX0 + weighted * x[t];
        sumKX1 = sumKX1 + weighted * x[16 + t];
        sumKX2 = sumKX2 + weighted * x[32 + t];
    }
    NtcLane k1 = NtcLaneTruncate(sumK);
    NtcLane kk = NtcLaneTruncate(sumKK);
    NtcLane kx[3];
    kx[0] = NtcLaneTruncate(sumKX0);
    kx[1] = NtcLaneTruncate(sumKX1);
    kx[2] = NtcLaneTruncate(sumKX2);
    // The sum of (steps y - k d)^2 with y = x - a.
    NtcLane error = sums.squares * (steps * steps) + lengths * kk;
    NTC_UNROLL for (int c = 0; c < 3; c++) error =
        error - a[c] * (sums.sum[c] * 2 - a[c] * sums.count) * (steps * steps) -
        d[c] * (kx[c] - a[c] * k1) * (2 * steps);
    NtcMask isBetter = error < best.error;
    best.error = NtcSelect(isBetter, error, best.error);
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        best.pair.a[c] = NtcSelect(isBetter, pair.a[c], best.pair.a[c]);
        best.pair.b[c] = NtcSelect(isBetter, pair.b[c], best.pair.b[c]);
    }
    if (wantsFit) {
        NtcLane uv = k1 * steps - kk;
        NtcLane uu = sums.count * (steps * steps) - k1 * steps - uv;
        NTC_UNROLL for (int c = 0; c < 3; c++) {
            NtcLane atZero;
            NtcLane atEnd;
            NtcMask fits = NtcFitLine(sums.count, k1, kk, kx[c], sums.sum[c], steps, 255, atZero, atEnd);
            NtcLane nextA = pair.a[c];
            NtcLane nextB = pair.b[c];
            NtcBc1FitChannel(uu, uv, kk, sums.sum[c] * steps - kx[c], kx[c], steps, c == 1,
                             NtcBc1Narrow(atZero, c == 1), nextA, nextB);
            pair.a[c] = NtcSelect(fits, nextA, pair.a[c]);
            pair.b[c] = NtcSelect(fits, nextB, pair.b[c]);
        }
    }
    return pair;
}

/// Starts: sixteenths by which the extremes move inwards, low end | high end << 4, each less 8.
NTC_TABLE(int, kNtcBc1Insets, 12) = {0xAA, 0x88, 0x48, 0x84, 0xCC, 0x8C, 0xC8, 0x99, 0x66, 0x8E, 0xE8, 0xEE};

NTC_FUNCTION NtcBc1Pair NtcBc1Start(NTC_IN_ARRAY(NtcLane, low, 3), NTC_IN_ARRAY(NtcLane, high, 3),
                                    int start) {
    int inset = kNtcBc1Insets[start];
    int atLow = (inset & 15) - 8;
    int atHigh = (inset >> 4) - 8;
    NtcBc1Pair pair;
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        NtcLane range = high[c] - low[c];
        pair.a[c] = NtcBc1Narrow(NtcLaneClamp(low[c] + ((range * atLow + 8) >> 4), 0, 255), c == 1);
        pair.b[c] = NtcBc1Narrow(NtcLaneClamp(high[c] - ((range * atHigh + 8) >> 4), 0, 255), c == 1);
    }
    return pair;
}

/// Pairs beside the best one: number 0 ... 23 moves one endpoint of a channel, or both, by one.
NTC_FUNCTION NtcBc1Pair NtcBc1Neighbour(NtcBc1Pair pair, int number) {
    int moveBy = number & 7;
    int first = moveBy < 2 ? 1 - 2 * moveBy : (moveBy >= 4 ? 1 - 2 * (moveBy & 1) : 0);
    int second =
        moveBy >= 2 && moveBy < 4 ? 1 - 2 * (moveBy & 1) : (moveBy >= 4 ? (moveBy < 6 ? first : -first) : 0);
    int channel = number >> 3;
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        pair.a[c] = pair.a[c] + (c == channel ? first : 0);
        pair.b[c] = pair.b[c] + (c == channel ? second : 0);
    }
    return pair;
}

NTC_LANES_INLINE NtcBc1Best NtcBc1Choose(NtcMask mask, NtcBc1Best a, NtcBc1Best b) {
    b.error = NtcSelect(mask, a.error, b.error);
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        b.pair.a[c] = NtcSelect(mask, a.pair.a[c], b.pair.a[c]);
        b.pair.b[c] = NtcSelect(mask, a.pair.b[c], b.pair.b[c]);
    }
    return b;
}

/// A pair, and those that it leads to.
NTC_FUNCTION void NtcBc1Visits(NTC_IN_ARRAY(NtcLaneFloat, x, 48), NTC_IN_ARRAY(NtcLaneFloat, weights, 16),
                               NtcBc1Sums sums, NtcBc1Pair pair, int steps, int quality,
                               NTC_INOUT(NtcBc1Best, best)) {
    int rounds = quality == NTC_BC_QUALITY_FAST ? 1 : 3;
    NTC_LOOP for (int round = 0; round < rounds; round++) pair =
        NtcBc1Visit(x, weights, sums, pair, steps, steps == 2, true, best);
    NtcBc1Visit(x, weights, sums, pair, steps, steps == 2, false, best);
}

NTC_FUNCTION void NtcBc1Neighbours(NTC_IN_ARRAY(NtcLaneFloat, x, 48), NTC_IN_ARRAY(NtcLaneFloat, weights, 16),
                                   NtcBc1Sums sums, int steps, NTC_INOUT(NtcBc1Best, best)) {
    NtcBc1Pair center = best.pair;
    NTC_LOOP for (int number = 0; number < 24; number++)
        NtcBc1Visit(x, weights, sums, NtcBc1Neighbour(center, number), steps, steps == 2, false, best);
}

/// The best pair of steps + 1 colours.
NTC_LANES_INLINE NtcBc1Best NtcBc1Search(NTC_IN_ARRAY(NtcLaneFloat, x, 48),
                                         NTC_IN_ARRAY(NtcLaneFloat, weights, 16), NtcBc1Sums sums,
                                         NTC_IN_ARRAY(NtcLane, low, 3), NTC_IN_ARRAY(NtcLane, high, 3),
                                         int steps, int quality) {
    NtcBc1Best best;
    best.error = NtcSplat(0x7FFFFFFF);
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        best.pair.a[c] = NtcSplat(0);
        best.pair.b[c] = NtcSplat(0);
    }
    NTC_LOOP for (int first = 0; first < 3; first++)
        NtcBc1Visits(x, weights, sums, NtcBc1Start(low, high, first), steps, quality, best);
    if (quality == NTC_BC_QUALITY_FAST) {
        // One colour: the nearest that the palette has between its ends.
        NtcMask isSolid = NtcMaskAnd(low[0] == high[0], NtcMaskAnd(low[1] == high[1], low[2] == high[2]));
        if (NtcAnyLane(isSolid)) {
            NtcBc1Best solid = best;
            NtcBc1Visit(x, weights, sums, NtcBc1MeanPair(sums.sum, sums.count, steps), steps, steps == 2,
                        false, solid);
            best = NtcBc1Choose(isSolid, solid, best);
        }
        return best;
    }
    // Smooth blocks need colours between the ends that are near their mean.
    NtcBc1Visits(x, weights, sums, NtcBc1MeanPair(sums.sum, sums.count, steps), steps, quality, best);
    NtcBc1Neighbours(x, weights, sums, steps, best);
    if (quality == NTC_BC_QUALITY_NORMAL)
        return best;
    NTC_LOOP for (int late = 3; late < 12; late++)
        NtcBc1Visits(x, weights, sums, NtcBc1Start(low, high, late), steps, quality, best);
    NTC_LOOP for (int round = 0; round < 5; round++) NtcBc1Neighbours(x, weights, sums, steps, best);
    return best;
}

/// Two words of colours, and indices that `holes` leave at 3. steps of a lane: 3 or 2.
NTC_FUNCTION NtcBc1Block NtcBc1Pack(NTC_IN_ARRAY(NtcLaneFloat, x, 48),
                                    NTC_IN_ARRAY(NtcLaneFloat, weights, 16), NtcBc1Pair pair,
                                    NtcMask hasFour) {
    NtcLane a[3];
    NtcLane d[3];
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        a[c] = NtcBc1Widen(pair.a[c], c == 1);
        d[c] = NtcBc1Widen(pair.b[c], c == 1) - a[c];
    }
    NtcLane steps = NtcSelect(hasFour, NtcSplat(3), NtcSplat(2));
    NtcLane lengths = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    NtcLane origin = (a[0] * d[0] + a[1] * d[1] + a[2] * d[2]) * steps * 2;
    NtcLane first = (pair.a[0] << 11) | (pair.a[1] << 5) | pair.a[2];
    NtcLane second = (pair.b[0] << 11) | (pair.b[1] << 5) | pair.b[2];
    // Four colours have the larger number first, three the smaller one.
    NtcMask isSwapped =
        NtcMaskOr(NtcMaskAnd(hasFour, first < second), NtcMaskAnd(NtcMaskNot(hasFour), first > second));
    NtcMask isEqual = first == second;
    NtcBc1Block block;
    block.words[0] = NtcSelect(isSwapped, second | (first << 16), first | (second << 16));
    block.words[1] = NtcSplat(0);
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane along = (NtcLaneTruncate(x[t]) * d[0] + NtcLaneTruncate(x[16 + t]) * d[1] +
                         NtcLaneTruncate(x[32 + t]) * d[2]) *
                            steps * 2 -
                        origin;
        NtcLane k = NtcCountMask(along >= lengths) + NtcCountMask(along >= lengths * 3) +
                    NtcCountMask(NtcMaskAnd(hasFour, along >= lengths * 5));
        k = NtcSelect(isSwapped, steps - k, k);
        NtcLane index = NtcSelect(k == 0, NtcSplat(0), NtcSelect(k == steps, NtcSplat(1), k + 1));
        index = NtcSelect(isEqual, NtcSplat(0), index);
        index = NtcSelect(NtcLaneTruncate(weights[t]) > 0, index, NtcSplat(3));
        block.words[1] = block.words[1] | (index << (2 * t));
    }
    return block;
}

/// RGB to a block. isBc1: three colours may be used, and texels whose alpha is at most alphaThreshold (-1:
/// none) are transparent; no other texel ever is.
NTC_FUNCTION NtcBc1Block NtcEncodeBc1(NTC_IN_ARRAY(NtcLane, red, 16), NTC_IN_ARRAY(NtcLane, green, 16),
                                      NTC_IN_ARRAY(NtcLane, blue, 16), NTC_IN_ARRAY(NtcLane, alpha, 16),
                                      int alphaThreshold, bool isBc1, int quality) {
    NtcLaneFloat x[48];
    NtcLaneFloat weights[16];
    NtcBc1Sums sums;
    sums.count = NtcSplat(0);
    sums.squares = NtcSplat(0);
    NTC_UNROLL for (int c = 0; c < 3; c++) sums.sum[c] = NtcSplat(0);
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane weight = isBc1 ? NtcCountMask(alpha[t] > alphaThreshold) : NtcSplat(1);
        sums.count = sums.count + weight;
        sums.sum[0] = sums.sum[0] + red[t] * weight;
        sums.sum[1] = sums.sum[1] + green[t] * weight;
        sums.sum[2] = sums.sum[2] + blue[t] * weight;
        sums.squares = sums.squares + (red[t] * red[t] + green[t] * green[t] + blue[t] * blue[t]) * weight;
        x[t] = NtcLaneToFloat(red[t]);
        x[16 + t] = NtcLaneToFloat(green[t]);
        x[32 + t] = NtcLaneToFloat(blue[t]);
        weights[t] = NtcLaneToFloat(weight);
    }
    NtcLane axis[3];
    NtcLane low[3];
    NtcLane high[3];
    NtcBc1Axis(x, weights, sums, axis);
    NtcBc1Extremes(x, weights, axis, low, high);
    NtcBc1Best best = NtcBc1Search(x, weights, sums, low, high, 3, quality);
    NtcMask hasHoles = sums.count < 16;
    NtcMask hasFour = NtcMaskNot(hasHoles);
    // The fast level has three colours for what needs them only: transparent texels, and single colours.
    NtcMask isSolid = NtcMaskAnd(low[0] == high[0], NtcMaskAnd(low[1] == high[1], low[2] == high[2]));
    NtcMask mayBeThree = NtcMaskOr(hasHoles, isSolid);
    if (isBc1 && (quality != NTC_BC_QUALITY_FAST || NtcAnyLane(mayBeThree))) {
        NtcBc1Best three = NtcBc1Search(x, weights, sums, low, high, 2, quality);
        NtcMask isThree = NtcMaskOr(hasHoles, three.error * 9 < best.error * 4);
        if (quality == NTC_BC_QUALITY_FAST)
            isThree = NtcMaskAnd(isThree, mayBeThree);
        best = NtcBc1Choose(isThree, three, best);
        hasFour = NtcMaskNot(isThree);
    }
    return NtcBc1Pack(x, weights, best.pair, hasFour);
}

/// BC2's alpha: four bits a texel, the nearest; 0 and 255 stay exactly that.
struct NtcBc2Alpha {
    NtcLane words[2];
};

NTC_FUNCTION NtcBc2Alpha NtcEncodeBc2Alpha(NTC_IN_ARRAY(NtcLane, alpha, 16)) {
    NtcBc2Alpha alphaWords;
    alphaWords.words[0] = NtcSplat(0);
    alphaWords.words[1] = NtcSplat(0);
    NTC_UNROLL for (int t = 0; t < 8; t++) {
        alphaWords.words[0] = alphaWords.words[0] | (((alpha[t] * 241 + 2048) >> 12) << (4 * t));
        alphaWords.words[1] = alphaWords.words[1] | (((alpha[8 + t] * 241 + 2048) >> 12) << (4 * t));
    }
    return alphaWords;
}

NTC_LANES_NAMESPACE_END

#endif
