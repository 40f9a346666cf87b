// SPDX-License-Identifier: MIT
// BC7: the direction in which the texels of a subset spread most, the indices to start from, and how far
// texels lie from such lines for every partition.
#ifndef OPENNTC_BC7_AXES_H
#define OPENNTC_BC7_AXES_H

#include "openntc/bc/Bc7Indices.h"

NTC_LANES_NAMESPACE_BEGIN

/// Count n, sums and sums of products of a set of texels: products in the order RR GG BB AA RG RB RA GB GA
/// BA.
struct NtcBc7Spread {
    NtcLane sum[4];
    NtcLane product[10];
};

/// n times the covariances' sums, scaled to a trace below 2^12.
struct NtcBc7Matrix {
    NtcLane m[10];
    NtcLane trace;
    NtcLane shift; ///< trace << shift is what it was
};

NTC_BC7_INLINE NtcBc7Matrix NtcBc7MakeMatrix(int channels, NTC_BC7_IN(NtcBc7Spread, spread), NtcLane count) {
    NtcBc7Matrix covariance;
    covariance.m[0] = spread.product[0] * count - NtcBc7Square(spread.sum[0]);
    covariance.m[1] = spread.product[1] * count - NtcBc7Square(spread.sum[1]);
    covariance.m[2] = spread.product[2] * count - NtcBc7Square(spread.sum[2]);
    covariance.m[4] = spread.product[4] * count - spread.sum[0] * spread.sum[1];
    covariance.m[5] = spread.product[5] * count - spread.sum[0] * spread.sum[2];
    covariance.m[7] = spread.product[7] * count - spread.sum[1] * spread.sum[2];
    covariance.trace = covariance.m[0] + covariance.m[1] + covariance.m[2];
    if (channels == 4) {
        covariance.m[3] = spread.product[3] * count - NtcBc7Square(spread.sum[3]);
        covariance.m[6] = spread.product[6] * count - spread.sum[0] * spread.sum[3];
        covariance.m[8] = spread.product[8] * count - spread.sum[1] * spread.sum[3];
        covariance.m[9] = spread.product[9] * count - spread.sum[2] * spread.sum[3];
        covariance.trace = covariance.trace + covariance.m[3];
    }
    covariance.shift = NtcLaneMax(NtcHighestBit(NtcLaneMax(covariance.trace, NtcSplat(1))) - 11, NtcSplat(0));
    covariance.trace = covariance.trace >> covariance.shift;
    NTC_BC7_UNROLL for (int i = 0; i < 10; i++) {
        if (channels == 4 || (i != 3 && i != 6 && i < 8))
            covariance.m[i] = covariance.m[i] >> covariance.shift;
    }
    return covariance;
}

/// y = M x.
NTC_BC7_INLINE void NtcBc7Transform(int channels, NTC_BC7_IN(NtcBc7Matrix, covariance),
                                    NTC_IN_ARRAY(NtcLane, x, 4), NTC_INOUT_ARRAY(NtcLane, y, 4)) {
    y[0] = covariance.m[0] * x[0] + covariance.m[4] * x[1] + covariance.m[5] * x[2];
    y[1] = covariance.m[4] * x[0] + covariance.m[1] * x[1] + covariance.m[7] * x[2];
    y[2] = covariance.m[5] * x[0] + covariance.m[7] * x[1] + covariance.m[2] * x[2];
    y[3] = NtcSplat(0);
    if (channels == 4) {
        y[0] = y[0] + covariance.m[6] * x[3];
        y[1] = y[1] + covariance.m[8] * x[3];
        y[2] = y[2] + covariance.m[9] * x[3];
        y[3] =
            covariance.m[6] * x[0] + covariance.m[8] * x[1] + covariance.m[9] * x[2] + covariance.m[3] * x[3];
    }
}

/// Scales to components below 2^7.
NTC_BC7_INLINE void NtcBc7Normalize(int channels, NTC_INOUT_ARRAY(NtcLane, x, 4)) {
    NtcLane largest = NtcSplat(1);
    NTC_BC7_UNROLL for (int c = 0; c < channels; c++) largest = NtcLaneMax(largest, NtcLaneAbs(x[c]));
    NtcLane shift = NtcLaneMax(NtcHighestBit(largest) - 6, NtcSplat(0));
    NTC_BC7_UNROLL for (int c = 0; c < channels; c++) x[c] = x[c] >> shift;
}

/// The direction of most spread: the matrix's column of the channel that spreads most, and `turns` steps of
/// the power method.
NTC_BC7_INLINE void NtcBc7FindAxis(int channels, int turns, NTC_BC7_IN(NtcBc7Matrix, covariance),
                                   NTC_INOUT_ARRAY(NtcLane, axis, 4)) {
    NtcLane most = covariance.m[0];
    axis[0] = covariance.m[0];
    axis[1] = covariance.m[4];
    axis[2] = covariance.m[5];
    axis[3] = NtcSplat(0);
    if (channels == 4)
        axis[3] = covariance.m[6];
    NtcMask isMore = covariance.m[1] > most;
    most = NtcSelect(isMore, covariance.m[1], most);
    axis[0] = NtcSelect(isMore, covariance.m[4], axis[0]);
    axis[1] = NtcSelect(isMore, covariance.m[1], axis[1]);
    axis[2] = NtcSelect(isMore, covariance.m[7], axis[2]);
    if (channels == 4)
        axis[3] = NtcSelect(isMore, covariance.m[8], axis[3]);
    isMore = covariance.m[2] > most;
    most = NtcSelect(isMore, covariance.m[2], most);
    axis[0] = NtcSelect(isMore, covariance.m[5], axis[0]);
    axis[1] = NtcSelect(isMore, covariance.m[7], axis[1]);
    axis[2] = NtcSelect(isMore, covariance.m[2], axis[2]);
    if (channels == 4) {
        axis[3] = NtcSelect(isMore, covariance.m[9], axis[3]);
        isMore = covariance.m[3] > most;
        axis[0] = NtcSelect(isMore, covariance.m[6], axis[0]);
        axis[1] = NtcSelect(isMore, covariance.m[8], axis[1]);
        axis[2] = NtcSelect(isMore, covariance.m[9], axis[2]);
        axis[3] = NtcSelect(isMore, covariance.m[3], axis[3]);
    }
    NtcBc7Normalize(channels, axis);
    NTC_BC7_UNROLL for (int i = 0; i < turns; i++) {
        NtcLane next[4];
        NtcBc7Transform(channels, covariance, axis, next);
        NtcBc7Normalize(channels, next);
        NTC_BC7_UNROLL for (int c = 0; c < 4; c++) axis[c] = next[c];
    }
}

/// The largest eigenvalue, from below, at the matrix's scale: the spread along the axis.
NTC_BC7_INLINE NtcLane NtcBc7SpreadAlong(int channels, NTC_BC7_IN(NtcBc7Matrix, covariance),
                                         NTC_IN_ARRAY(NtcLane, axis, 4)) {
    NtcLane image[4];
    NtcBc7Transform(channels, covariance, axis, image);
    NtcLane numerator = axis[0] * image[0] + axis[1] * image[1] + axis[2] * image[2];
    NtcLane length = NtcBc7Square(axis[0]) + NtcBc7Square(axis[1]) + NtcBc7Square(axis[2]);
    if (channels == 4) {
        numerator = numerator + axis[3] * image[3];
        length = length + NtcBc7Square(axis[3]);
    }
    return NtcDivide(numerator, NtcLaneMax(length, NtcSplat(1)));
}

/// How many texels each subset has, and their sums.
NTC_BC7_LEAF void NtcBc7Gather(int subsets, NTC_BC7_TEXELS(x), NtcLane subset,
                               NTC_INOUT(NtcBc7Moments, moments)) {
    NtcLane zero = NtcSplat(0);
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        moments.count[s] = zero;
        NTC_LOOP for (int c = 0; c < 4; c++) moments.sum[4 * s + c] = zero;
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask isOwn = ((subset >> (2 * t)) & 3) == s;
            moments.count[s] = moments.count[s] + NtcSelect(isOwn, NtcSplat(1), zero);
            NTC_BC7_UNROLL for (int c = 0; c < 4; c++) moments.sum[4 * s + c] =
                moments.sum[4 * s + c] + NtcSelect(isOwn, NtcBc7Channel(x, t, c), zero);
        }
    }
}

/// Indices to start from, as sums: texels along the axis of their subset, from its first to its last one,
/// spread over indices low ... high. Channels 0 ... channels - 1; `channels` is a constant.
NTC_BC7_INLINE void NtcBc7StartShape(int channels, int subsets, int low, int high, NTC_BC7_TEXELS(x),
                                     NtcLane subset, NTC_BC7_IN(NtcBc7Moments, moments),
                                     NTC_INOUT(NtcBc7Sums, sums)) {
    NtcLane zero = NtcSplat(0);
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        NtcBc7Spread spread;
        NTC_BC7_UNROLL for (int i = 0; i < 10; i++) spread.product[i] = zero;
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask isOwn = ((subset >> (2 * t)) & 3) == s;
            NtcLane r = NtcSelect(isOwn, NtcBc7Channel(x, t, 0), zero);
            NtcLane g = NtcSelect(isOwn, NtcBc7Channel(x, t, 1), zero);
            NtcLane b = NtcSelect(isOwn, NtcBc7Channel(x, t, 2), zero);
            spread.product[0] = spread.product[0] + r * r;
            spread.product[1] = spread.product[1] + g * g;
            spread.product[2] = spread.product[2] + b * b;
            spread.product[4] = spread.product[4] + r * g;
            spread.product[5] = spread.product[5] + r * b;
            spread.product[7] = spread.product[7] + g * b;
            if (channels == 4) {
                NtcLane a = NtcSelect(isOwn, NtcBc7Channel(x, t, 3), zero);
                spread.product[3] = spread.product[3] + a * a;
                spread.product[6] = spread.product[6] + r * a;
                spread.product[8] = spread.product[8] + g * a;
                spread.product[9] = spread.product[9] + b * a;
            }
        }
        NTC_BC7_UNROLL for (int c = 0; c < 4; c++) spread.sum[c] = moments.sum[4 * s + c];
        NtcBc7Matrix covariance = NtcBc7MakeMatrix(channels, spread, moments.count[s]);
        NtcLane axis[4];
        NtcBc7FindAxis(channels, 3, covariance, axis);
        NtcLane along[16];
        NtcLane least = NtcSplat(1 << 20);
        NtcLane most = NtcSplat(-(1 << 20));
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask isOwn = ((subset >> (2 * t)) & 3) == s;
            NtcLane at = axis[0] * NtcBc7Channel(x, t, 0) + axis[1] * NtcBc7Channel(x, t, 1) +
                         axis[2] * NtcBc7Channel(x, t, 2);
            if (channels == 4)
                at = at + axis[3] * NtcBc7Channel(x, t, 3);
            along[t] = at;
            least = NtcSelect(isOwn, NtcLaneMin(at, least), least);
            most = NtcSelect(isOwn, NtcLaneMax(at, most), most);
        }
        NtcLane scale = NtcBc7Reciprocal(NtcSplat(high - low), NtcLaneMax(most - least, NtcSplat(0)));
        sums.index[s] = zero;
        sums.square[s] = zero;
        NTC_BC7_UNROLL for (int c = 0; c < channels; c++) sums.product[4 * s + c] = zero;
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask isOwn = ((subset >> (2 * t)) & 3) == s;
            // Of other subsets the position may lie anywhere: not multiplied.
            NtcLane at = NtcSelect(isOwn, along[t] - least, zero);
            NtcLane index = NtcSelect(isOwn, (((at * scale) + (1 << 25)) >> 26) + low, zero);
            sums.index[s] = sums.index[s] + index;
            sums.square[s] = sums.square[s] + index * index;
            NTC_BC7_UNROLL for (int c = 0; c < channels; c++) sums.product[4 * s + c] =
                sums.product[4 * s + c] + index * NtcBc7Channel(x, t, c);
        }
    }
}

NTC_BC7_LEAF void NtcBc7StartColor(int subsets, int low, int high, NTC_BC7_TEXELS(x), NtcLane subset,
                                   NTC_BC7_IN(NtcBc7Moments, moments), NTC_INOUT(NtcBc7Sums, sums)) {
    NtcBc7StartShape(3, subsets, low, high, x, subset, moments, sums);
}
NTC_BC7_LEAF void NtcBc7StartBoth(int subsets, int low, int high, NTC_BC7_TEXELS(x), NtcLane subset,
                                  NTC_BC7_IN(NtcBc7Moments, moments), NTC_INOUT(NtcBc7Sums, sums)) {
    NtcBc7StartShape(4, subsets, low, high, x, subset, moments, sums);
}

/// The same for alpha alone: from its least to its largest value.
NTC_BC7_LEAF void NtcBc7StartAlpha(int low, int high, NTC_BC7_TEXELS(x), NTC_INOUT(NtcBc7Sums, sums)) {
    NtcLane least = NtcBc7Channel(x, 0, 3);
    NtcLane most = NtcBc7Channel(x, 0, 3);
    NTC_LOOP for (int t = 1; t < 16; t++) {
        least = NtcLaneMin(least, NtcBc7Channel(x, t, 3));
        most = NtcLaneMax(most, NtcBc7Channel(x, t, 3));
    }
    NtcLane scale = NtcBc7Reciprocal(NtcSplat(high - low), most - least);
    sums.index[0] = NtcSplat(0);
    sums.square[0] = NtcSplat(0);
    sums.product[3] = NtcSplat(0);
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcLane index = ((((NtcBc7Channel(x, t, 3) - least) * scale) + (1 << 25)) >> 26) + low;
        sums.index[0] = sums.index[0] + index;
        sums.square[0] = sums.square[0] + index * index;
        sums.product[3] = sums.product[3] + index * NtcBc7Channel(x, t, 3);
    }
}

NTC_LANES_NAMESPACE_END

#endif
