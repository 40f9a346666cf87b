// SPDX-License-Identifier: MIT
// BC7: which index of which texel, given endpoints, and what a decoder makes of it. Shapes: texel t, channel
// c is x[4 t + c]; endpoint of subset s, channel c is [4 s + c].
#ifndef OPENNTC_BC7_INDICES_H
#define OPENNTC_BC7_INDICES_H

#include "openntc/bc/Bc7Tables.h"

NTC_LANES_NAMESPACE_BEGIN

/// The colours between which a decoder interpolates: 0 ... 255.
struct NtcBc7Line {
    NtcLane low[12];
    NtcLane high[12];
};

/// Of the texels of each subset: how many, and the sum of each channel.
struct NtcBc7Moments {
    NtcLane count[3];
    NtcLane sum[12];
};

/// Of the indices of each subset's texels: their sum, that of their squares, that of their products with
/// each channel.
struct NtcBc7Sums {
    NtcLane index[3];
    NtcLane square[3];
    NtcLane product[12];
};

NTC_FUNCTION NtcLane NtcBc7Square(NtcLane x) {
    return x * x;
}

/// steps 2^26 / length, at least ten bits of it exact; the product with a number up to `length` stays below
/// 2^30. steps: 1 ... 15.
NTC_FUNCTION NtcLane NtcBc7Reciprocal(NtcLane steps, NtcLane length) {
    NtcMask isLong = length >= 1024;
    NtcLane quotient =
        NtcDivide(NtcSelect(isLong, steps << 26, steps << 16), NtcLaneMax(length, NtcSplat(1)));
    return NtcSelect(isLong, quotient, quotient << 10);
}

/// weight(i) = (i factor + offset) >> 2 is the table of the specification for 2, 3 and 4 bits.
NTC_FUNCTION int NtcBc7WeightFactor(int steps) {
    return steps == 3 ? 85 : steps == 7 ? 37 : 17;
}
NTC_FUNCTION int NtcBc7WeightOffset(int steps) {
    return steps == 7 ? 0 : 2;
}

/// Chooses the better of the two colours around each texel's projection on its line. subset: two bits a
/// texel. Gives the squared error of each subset, and the sums for the next fit. `subsets`, `first` and
/// `channels` are constants: the channels first ... first + channels - 1 count.
NTC_BC7_INLINE void NtcBc7AssignShape(int subsets, int first, int channels, int steps, NTC_BC7_TEXELS(x),
                                      NtcLane subset, NTC_BC7_IN(NtcBc7Line, segment),
                                      NTC_INOUT(NtcBc7Sums, sums), NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcLane zero = NtcSplat(0);
    NtcLane delta[12];
    NtcLane length[3];
    NtcLane reciprocal[3];
    NTC_BC7_UNROLL for (int s = 0; s < subsets; s++) {
        length[s] = zero;
        NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) {
            delta[4 * s + c] = segment.high[4 * s + c] - segment.low[4 * s + c];
            length[s] = length[s] + NtcBc7Square(delta[4 * s + c]);
        }
        reciprocal[s] = NtcBc7Reciprocal(NtcSplat(steps), length[s]);
        sums.index[s] = zero;
        sums.square[s] = zero;
        error[s] = zero;
        NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) sums.product[4 * s + c] = zero;
    }
    int factor = NtcBc7WeightFactor(steps);
    int offset = NtcBc7WeightOffset(steps);
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcMask isSecond = ((subset >> (2 * t)) & 1) != 0;
        NtcMask isThird = ((subset >> (2 * t + 1)) & 1) != 0;
        NtcLane d[4];
        NtcLane y[4];
        NtcLane span = length[0];
        NtcLane scale = reciprocal[0];
        if (subsets > 1) {
            span = NtcSelect(isSecond, length[1], span);
            scale = NtcSelect(isSecond, reciprocal[1], scale);
        }
        if (subsets > 2) {
            span = NtcSelect(isThird, length[2], span);
            scale = NtcSelect(isThird, reciprocal[2], scale);
        }
        NtcLane along = zero;
        NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) {
            NtcLane low = segment.low[c];
            d[c] = delta[c];
            if (subsets > 1) {
                low = NtcSelect(isSecond, segment.low[4 + c], low);
                d[c] = NtcSelect(isSecond, delta[4 + c], d[c]);
            }
            if (subsets > 2) {
                low = NtcSelect(isThird, segment.low[8 + c], low);
                d[c] = NtcSelect(isThird, delta[8 + c], d[c]);
            }
            y[c] = NtcBc7Channel(x, t, c) - low;
            along = along + y[c] * d[c];
        }
        along = NtcLaneMin(NtcLaneMax(along, zero), span);
        NtcLane below = NtcLaneMin((along * scale) >> 26, NtcSplat(steps - 1));
        NtcLane belowWeight = (below * factor + offset) >> 2;
        NtcLane aboveWeight = (below * factor + (offset + factor)) >> 2;
        NtcLane belowError = zero;
        NtcLane aboveError = zero;
        NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) {
            belowError = belowError + NtcBc7Square(y[c] - ((d[c] * belowWeight + 32) >> 6));
            aboveError = aboveError + NtcBc7Square(y[c] - ((d[c] * aboveWeight + 32) >> 6));
        }
        NtcMask isAbove = aboveError < belowError;
        NtcLane index = NtcSelect(isAbove, below + 1, below);
        NtcLane least = NtcLaneMin(aboveError, belowError);
        error[0] = error[0] + least;
        sums.index[0] = sums.index[0] + index;
        sums.square[0] = sums.square[0] + index * index;
        NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) sums.product[c] =
            sums.product[c] + index * NtcBc7Channel(x, t, c);
        NTC_BC7_UNROLL for (int s = 1; s < subsets; s++) {
            NtcMask isThis = isSecond;
            if (s == 2)
                isThis = isThird;
            NtcLane own = NtcSelect(isThis, index, zero);
            error[s] = error[s] + NtcSelect(isThis, least, zero);
            sums.index[s] = sums.index[s] + own;
            sums.square[s] = sums.square[s] + own * own;
            NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) sums.product[4 * s + c] =
                sums.product[4 * s + c] + own * NtcBc7Channel(x, t, c);
        }
    }
    NTC_BC7_UNROLL for (int s = 1; s < subsets; s++) { // so far the first holds all
        error[0] = error[0] - error[s];
        sums.index[0] = sums.index[0] - sums.index[s];
        sums.square[0] = sums.square[0] - sums.square[s];
        NTC_BC7_UNROLL for (int c = first; c < first + channels; c++) sums.product[c] =
            sums.product[c] - sums.product[4 * s + c];
    }
}

// clang-format off
NTC_BC7_LEAF void NtcBc7AssignAlpha(int steps, NTC_BC7_TEXELS(x), NTC_BC7_IN(NtcBc7Line, segment),
                                    NTC_INOUT(NtcBc7Sums, sums), NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcBc7AssignShape(1, 3, 1, steps, x, NtcSplat(0), segment, sums, error);
}
NTC_BC7_LEAF void NtcBc7AssignColor1(int steps, NTC_BC7_TEXELS(x), NTC_BC7_IN(NtcBc7Line, segment),
                                     NTC_INOUT(NtcBc7Sums, sums), NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcBc7AssignShape(1, 0, 3, steps, x, NtcSplat(0), segment, sums, error);
}
NTC_BC7_LEAF void NtcBc7AssignColor2(int steps, NTC_BC7_TEXELS(x), NtcLane subset,
                                     NTC_BC7_IN(NtcBc7Line, segment), NTC_INOUT(NtcBc7Sums, sums),
                                     NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcBc7AssignShape(2, 0, 3, steps, x, subset, segment, sums, error);
}
NTC_BC7_LEAF void NtcBc7AssignColor3(int steps, NTC_BC7_TEXELS(x), NtcLane subset,
                                     NTC_BC7_IN(NtcBc7Line, segment), NTC_INOUT(NtcBc7Sums, sums),
                                     NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcBc7AssignShape(3, 0, 3, steps, x, subset, segment, sums, error);
}
NTC_BC7_LEAF void NtcBc7AssignBoth1(int steps, NTC_BC7_TEXELS(x), NTC_BC7_IN(NtcBc7Line, segment),
                                    NTC_INOUT(NtcBc7Sums, sums), NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcBc7AssignShape(1, 0, 4, steps, x, NtcSplat(0), segment, sums, error);
}
NTC_BC7_LEAF void NtcBc7AssignBoth2(int steps, NTC_BC7_TEXELS(x), NtcLane subset,
                                    NTC_BC7_IN(NtcBc7Line, segment), NTC_INOUT(NtcBc7Sums, sums),
                                    NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    NtcBc7AssignShape(2, 0, 4, steps, x, subset, segment, sums, error);
}
// clang-format on

/// NtcBc7AssignShape for what the channels and subsets of a mode are.
NTC_FUNCTION void NtcBc7Assign(int subsets, int first, int channels, int steps, NTC_BC7_TEXELS(x),
                               NtcLane subset, NTC_BC7_IN(NtcBc7Line, segment), NTC_INOUT(NtcBc7Sums, sums),
                               NTC_INOUT_ARRAY(NtcLane, error, 3)) {
    if (first == 3)
        NtcBc7AssignAlpha(steps, x, segment, sums, error);
    else if (channels == 4 && subsets == 1)
        NtcBc7AssignBoth1(steps, x, segment, sums, error);
    else if (channels == 4)
        NtcBc7AssignBoth2(steps, x, subset, segment, sums, error);
    else if (subsets == 1)
        NtcBc7AssignColor1(steps, x, segment, sums, error);
    else if (subsets == 2)
        NtcBc7AssignColor2(steps, x, subset, segment, sums, error);
    else
        NtcBc7AssignColor3(steps, x, subset, segment, sums, error);
}

NTC_LANES_NAMESPACE_END

#endif
