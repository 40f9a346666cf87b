// SPDX-License-Identifier: MIT
// BC6H: lines through the texels of a subset, before anything is quantised.
#ifndef OPENNTC_BC6_FIT_H
#define OPENNTC_BC6_FIT_H

#include "openntc/bc/Bc6Block.h"
#include "openntc/bc/Lanes.h"

NTC_LANES_NAMESPACE_BEGIN

/// Second moments around the mean, times the square of the number of texels: xx xy xz yy yz zz.
/// 0 ... 2^30 in the frame.
struct NtcBc6Moments {
    NtcLane v[6];
};

/// The direction along which the texels lie, of components up to 1023; from the moments by power iteration.
/// scaled: the moments, shifted by an even amount so that the largest is below 1024.
NTC_FUNCTION void NtcBc6Axis(NtcBc6Moments moments, int steps, NTC_OUT_ARRAY(NtcLane, axis, 3),
                             NTC_OUT(NtcBc6Moments, scaled)) {
    NtcLane largest = NtcLaneMax(NtcLaneMax(moments.v[0], moments.v[3]), moments.v[5]);
    NtcLane shift = NtcHighestBit(NtcLaneMax(largest, NtcSplat(1))) - 9;
    NtcLane down = NtcLaneMax(shift, NtcSplat(0));
    NtcLane up = NtcLaneMax(-shift, NtcSplat(0));
    NTC_UNROLL for (int i = 0; i < 6; i++) {
        scaled.v[i] = (moments.v[i] << up) >> down;
    }
    // The row of the largest diagonal element is not at right angles to the axis.
    NtcMask first = NtcMaskAnd(scaled.v[0] >= scaled.v[3], scaled.v[0] >= scaled.v[5]);
    NtcMask middle = scaled.v[3] >= scaled.v[5];
    axis[0] = NtcSelect(first, scaled.v[0], NtcSelect(middle, scaled.v[1], scaled.v[2]));
    axis[1] = NtcSelect(first, scaled.v[1], NtcSelect(middle, scaled.v[3], scaled.v[4]));
    axis[2] = NtcSelect(first, scaled.v[2], NtcSelect(middle, scaled.v[4], scaled.v[5]));
    NTC_LOOP for (int step = 0; step < steps; step++) {
        NtcLane x = axis[0] * scaled.v[0] + axis[1] * scaled.v[1] + axis[2] * scaled.v[2];
        NtcLane y = axis[0] * scaled.v[1] + axis[1] * scaled.v[3] + axis[2] * scaled.v[4];
        NtcLane z = axis[0] * scaled.v[2] + axis[1] * scaled.v[4] + axis[2] * scaled.v[5];
        NtcLane size = NtcLaneMax(NtcLaneMax(NtcLaneAbs(x), NtcLaneAbs(y)), NtcLaneAbs(z));
        NtcLane by = NtcLaneMax(NtcHighestBit(NtcLaneMax(size, NtcSplat(1))) - 9, NtcSplat(0));
        axis[0] = x >> by;
        axis[1] = y >> by;
        axis[2] = z >> by;
    }
}

/// Moments of the texels of which bit `mask` is set. x: 3 texel + channel, in the frame.
NTC_FUNCTION NtcBc6Moments NtcBc6MomentsOf(NTC_IN_ARRAY(NtcLane, x, 48), NtcLane mask) {
    NtcLane count = NtcSplat(0);
    NtcLane sum[3];
    NtcBc6Moments moments;
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        sum[c] = NtcSplat(0);
    }
    NTC_UNROLL for (int i = 0; i < 6; i++) {
        moments.v[i] = NtcSplat(0);
    }
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcLane bit = (mask >> t) & 1;
        NtcLane r = x[3 * t] & -bit;
        NtcLane g = x[3 * t + 1] & -bit;
        NtcLane b = x[3 * t + 2] & -bit;
        count = count + bit;
        sum[0] = sum[0] + r;
        sum[1] = sum[1] + g;
        sum[2] = sum[2] + b;
        moments.v[0] = moments.v[0] + r * r;
        moments.v[1] = moments.v[1] + r * g;
        moments.v[2] = moments.v[2] + r * b;
        moments.v[3] = moments.v[3] + g * g;
        moments.v[4] = moments.v[4] + g * b;
        moments.v[5] = moments.v[5] + b * b;
    }
    moments.v[0] = moments.v[0] * count - sum[0] * sum[0];
    moments.v[1] = moments.v[1] * count - sum[0] * sum[1];
    moments.v[2] = moments.v[2] * count - sum[0] * sum[2];
    moments.v[3] = moments.v[3] * count - sum[1] * sum[1];
    moments.v[4] = moments.v[4] * count - sum[1] * sum[2];
    moments.v[5] = moments.v[5] * count - sum[2] * sum[2];
    return moments;
}

/// First weights (0 ... 64) of all texels: their places along the axes of their subsets.
NTC_FUNCTION void NtcBc6FirstWeights(NTC_IN_ARRAY(NtcLane, x, 48), int subsets, NtcLane masks,
                                     NTC_OUT_ARRAY(NtcLane, weights, 16)) {
    int last = subsets == 2 ? 7 : 15;
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        NtcLane mask = s == 0 ? ~masks : masks;
        NtcLane axis[3];
        NtcBc6Moments scaled;
        NtcBc6Axis(NtcBc6MomentsOf(x, mask), 4, axis, scaled);
        NtcLane places[16];
        NtcLane low = NtcSplat(0x3FFFFFFF);
        NtcLane high = NtcSplat(-0x3FFFFFFF);
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask inside = ((mask >> t) & 1) != 0;
            places[t] = x[3 * t] * axis[0] + x[3 * t + 1] * axis[1] + x[3 * t + 2] * axis[2];
            low = NtcSelect(inside, NtcLaneMin(low, places[t]), low);
            high = NtcSelect(inside, NtcLaneMax(high, places[t]), high);
        }
        // (place - low) last / (high - low) to nearest; 2^26 stands for 1.
        NtcLane step = NtcDivide(NtcSplat(last << 26), NtcLaneMax(high - low, NtcSplat(1024)));
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask inside = ((mask >> t) & 1) != 0;
            NtcLane place = NtcSelect(inside, places[t] - low, NtcSplat(0));
            NtcLane weight = NtcBc6Weight((place * step + (1 << 25)) >> 26, subsets);
            weights[t] = s == 0 ? weight : NtcSelect(inside, weight, weights[t]);
        }
    }
}

/// The decoder's 16-bit value that yields x.
NTC_FUNCTION NtcLane NtcBc6LeaveFrame(NtcLane x, NtcLane center, NtcBc6Frame frame, bool isSigned) {
    NtcLane sixteenths = (center << 4) + (((x << 4) << frame.down) >> frame.up);
    // The decoder takes 31/64 (signed 31/32) and drops the fraction: aim at a half more.
    // v / 31 = v / 32 + v / 32^2 + ...
    NtcLane size = NtcLaneMin(NtcLaneAbs(sixteenths) + 8, NtcSplat(31744 << 4));
    NtcLane v = size << (isSigned ? 7 : 8);
    v = ((v >> 5) + (v >> 10) + (v >> 15) + (v >> 20) + 32) >> 6;
    v = NtcLaneMin(v, NtcSplat(isSigned ? 0x7FFF : 0xFFFF));
    NtcLane negative = isSigned ? -v : NtcSplat(0);
    return NtcSelect(sixteenths < 0, negative, v);
}

/// Endpoints (16-bit values) of least squared error for given weights, one line for each subset; turned so
/// that the texels of which an index bit is not stored are nearer to the first endpoint.
NTC_FUNCTION void NtcBc6FitLines(NTC_IN_ARRAY(NtcLane, x, 48), NtcBc6Frame frame, int subsets, bool isSigned,
                                 NtcLane masks, NTC_IN_ARRAY(NtcLane, weights, 16),
                                 NTC_OUT_ARRAY(NtcLane, u, 12)) {
    NTC_UNROLL for (int i = 6; i < 12; i++) {
        u[i] = NtcSplat(0);
    }
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        NtcLane mask = s == 0 ? ~masks : masks;
        NtcLane count = NtcSplat(0);
        NtcLane sumW = NtcSplat(0);
        NtcLane sumWW = NtcSplat(0);
        NtcLane sumX[3];
        NtcLane sumWX[3];
        NTC_UNROLL for (int c = 0; c < 3; c++) {
            sumX[c] = NtcSplat(0);
            sumWX[c] = NtcSplat(0);
        }
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcLane bit = (mask >> t) & 1;
            NtcLane weight = weights[t] & -bit;
            count = count + bit;
            sumW = sumW + weight;
            sumWW = sumWW + weight * weight;
            NTC_UNROLL for (int c = 0; c < 3; c++) {
                sumX[c] = sumX[c] + (x[3 * t + c] & -bit);
                sumWX[c] = sumWX[c] + x[3 * t + c] * weight;
            }
        }
        NtcLane variance = sumWW * count - sumW * sumW;
        NtcLane divisor = NtcLaneMax(variance, NtcSplat(1));
        NtcLane anchor = masks >> 16;
        NtcLane anchorWeight = weights[0];
        if (s == 1)
            anchorWeight =
                NtcSelect(anchor == 2, weights[2], NtcSelect(anchor == 8, weights[8], weights[15]));
        NtcMask turn = anchorWeight > 32;
        NTC_LOOP for (int c = 0; c < 3; c++) {
            NtcLane covariance = sumWX[c] * count - sumW * sumX[c]; // below 2^24
            NtcLane slope = NtcDivide(covariance * 64, divisor);    // over the whole line
            slope = NtcLaneClamp(NtcSelect(variance == 0, NtcSplat(0), slope), -8192, 8192);
            NtcLane first = NtcDivide(sumX[c] * 64 - slope * sumW, NtcLaneMax(count * 64, NtcSplat(1)));
            NtcLane a = NtcBc6LeaveFrame(NtcLaneClamp(first, -8192, 8192), frame.center[c], frame, isSigned);
            NtcLane b =
                NtcBc6LeaveFrame(NtcLaneClamp(first + slope, -8192, 8192), frame.center[c], frame, isSigned);
            u[6 * s + c] = NtcSelect(turn, b, a);
            u[6 * s + 3 + c] = NtcSelect(turn, a, b);
        }
    }
}

NTC_LANES_NAMESPACE_END

#endif
