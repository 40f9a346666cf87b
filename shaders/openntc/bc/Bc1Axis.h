// SPDX-License-Identifier: MIT
// The direction in which a block's colours differ most, in integers, and the texels at its ends.
#ifndef OPENNTC_BC1_AXIS_H
#define OPENNTC_BC1_AXIS_H

#include "openntc/bc/Lanes.h"

NTC_LANES_NAMESPACE_BEGIN

/// Over the texels that count.
struct NtcBc1Sums {
    NtcLane count;
    NtcLane sum[3];
    NtcLane squares;
};

/// The direction in which the texels differ most, by powers of their covariance; numbers up to 1024.
NTC_FUNCTION void NtcBc1Axis(NTC_IN_ARRAY(NtcLaneFloat, x, 48), NTC_IN_ARRAY(NtcLaneFloat, weights, 16),
                             NtcBc1Sums sums, NTC_OUT_ARRAY(NtcLane, axis, 3)) {
    NtcLaneFloat products[6];
    NTC_UNROLL for (int i = 0; i < 6; i++) products[i] = NtcLaneToFloat(NtcSplat(0));
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLaneFloat r = x[t] * weights[t];
        NtcLaneFloat g = x[16 + t] * weights[t];
        products[0] = products[0] + r * x[t];
        products[1] = products[1] + r * x[16 + t];
        products[2] = products[2] + r * x[32 + t];
        products[3] = products[3] + g * x[16 + t];
        products[4] = products[4] + g * x[32 + t];
        products[5] = products[5] + x[32 + t] * weights[t] * x[32 + t];
    }
    NtcLane cov[6];
    cov[0] = NtcLaneTruncate(products[0]) * sums.count - sums.sum[0] * sums.sum[0];
    cov[1] = NtcLaneTruncate(products[1]) * sums.count - sums.sum[0] * sums.sum[1];
    cov[2] = NtcLaneTruncate(products[2]) * sums.count - sums.sum[0] * sums.sum[2];
    cov[3] = NtcLaneTruncate(products[3]) * sums.count - sums.sum[1] * sums.sum[1];
    cov[4] = NtcLaneTruncate(products[4]) * sums.count - sums.sum[1] * sums.sum[2];
    cov[5] = NtcLaneTruncate(products[5]) * sums.count - sums.sum[2] * sums.sum[2];
    // To 13 bits; the largest number is on the diagonal.
    NtcLane largest = NtcLaneMax(NtcLaneMax(cov[0], cov[3]), NtcLaneMax(cov[5], NtcSplat(1)));
    NtcLane shift = NtcLaneMax(NtcHighestBit(largest) - 12, NtcSplat(0));
    NTC_UNROLL for (int i = 0; i < 6; i++) cov[i] = cov[i] >> shift;
    // From the row of the largest variance.
    NtcMask isGreen = NtcMaskAnd(cov[3] >= cov[0], cov[3] >= cov[5]);
    NtcMask isBlue = NtcMaskAnd(NtcMaskNot(isGreen), cov[5] > cov[0]);
    NtcLane r = NtcSelect(isGreen, cov[1], NtcSelect(isBlue, cov[2], cov[0]));
    NtcLane g = NtcSelect(isGreen, cov[3], NtcSelect(isBlue, cov[4], cov[1]));
    NtcLane b = NtcSelect(isGreen, cov[4], NtcSelect(isBlue, cov[5], cov[2]));
    NTC_LOOP for (int i = 0; i < 5; i++) {
        NtcLane size =
            NtcLaneMax(NtcLaneMax(NtcLaneAbs(r), NtcLaneAbs(g)), NtcLaneMax(NtcLaneAbs(b), NtcSplat(1)));
        NtcLane down = NtcLaneMax(NtcHighestBit(size) - 10, NtcSplat(0));
        r = r >> down;
        g = g >> down;
        b = b >> down;
        if (i < 4) {
            NtcLane nextR = cov[0] * r + cov[1] * g + cov[2] * b;
            NtcLane nextG = cov[1] * r + cov[3] * g + cov[4] * b;
            b = cov[2] * r + cov[4] * g + cov[5] * b;
            r = nextR;
            g = nextG;
        }
    }
    axis[0] = r;
    axis[1] = g;
    axis[2] = b;
}

/// The texels that are furthest along an axis, on both sides.
NTC_FUNCTION void NtcBc1Extremes(NTC_IN_ARRAY(NtcLaneFloat, x, 48), NTC_IN_ARRAY(NtcLaneFloat, weights, 16),
                                 NTC_IN_ARRAY(NtcLane, axis, 3), NTC_OUT_ARRAY(NtcLane, low, 3),
                                 NTC_OUT_ARRAY(NtcLane, high, 3)) {
    NtcLaneFloat r = NtcLaneToFloat(axis[0]);
    NtcLaneFloat g = NtcLaneToFloat(axis[1]);
    NtcLaneFloat b = NtcLaneToFloat(axis[2]);
    NtcLane least = NtcSplat(0x7FFFFFFF);
    NtcLane most = NtcSplat(-0x7FFFFFFF);
    NTC_UNROLL for (int c = 0; c < 3; c++) {
        low[c] = NtcSplat(0);
        high[c] = NtcSplat(0);
    }
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane along = NtcLaneTruncate(x[t] * r + x[16 + t] * g + x[32 + t] * b);
        NtcMask counts = NtcLaneTruncate(weights[t]) > 0;
        NtcMask isLow = NtcMaskAnd(counts, along < least);
        NtcMask isHigh = NtcMaskAnd(counts, along > most);
        least = NtcSelect(isLow, along, least);
        most = NtcSelect(isHigh, along, most);
        NTC_UNROLL for (int c = 0; c < 3; c++) {
            low[c] = NtcSelect(isLow, NtcLaneTruncate(x[16 * c + t]), low[c]);
            high[c] = NtcSelect(isHigh, NtcLaneTruncate(x[16 * c + t]), high[c]);
        }
    }
}

NTC_LANES_NAMESPACE_END

#endif
