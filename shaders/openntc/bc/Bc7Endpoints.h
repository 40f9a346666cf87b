// SPDX-License-Identifier: MIT
// BC7: endpoints that fit given indices best, on the lattice of a mode's endpoints and p-bits.
//
// With indices i of 0 ... N the squared error of one channel is a quadratic form around the optimum e of
// the two endpoints, (A d0^2 + 2 B d0 d1 + C d1^2) / N^2 with A = sum (N-i)^2, B = sum i (N-i), C = sum i^2:
// endpoints are not independent, and what rounding the first one loses the second one can make good.
#ifndef OPENNTC_BC7_ENDPOINTS_H
#define OPENNTC_BC7_ENDPOINTS_H

#include "openntc/bc/Bc7Indices.h"

NTC_LANES_NAMESPACE_BEGIN

/// Endpoints as a block stores them, p-bit lowest: eight bits a channel, R lowest; endpoint e of subset s is
/// [2 s + e].
struct NtcBc7Ends {
    NtcLane ends[6];
};

/// How a mode stores the channels of a line.
struct NtcBc7Lattice {
    int bits;  // with the p-bit
    int pbits; // NTC_BC7_PBITS_*
};

/// x of `bits` bits, 5 ... 8, to eight by repeating its high bits.
NTC_BC7_INLINE NtcLane NtcBc7Expand(NtcLane x, int bits) {
    return (x << (8 - bits)) | (x >> (2 * bits - 8));
}

/// x to 64ths of the lattice's units, from 64ths of 8-bit units; |x| < 2^16.
NTC_BC7_INLINE NtcLane NtcBc7ToLattice(NtcLane x, int bits) {
    int factor = (((1 << bits) - 1) * 16384 + 127) / 255;
    return (x * factor) >> 14;
}

/// The least-squares optimum of one subset's channel.
struct NtcBc7Optimum {
    NtcLane low;  // 64ths
    NtcLane high; // 64ths
};

/// What the channels of one subset share: A, B and C, and B / C in 256ths.
struct NtcBc7Form {
    NtcLane a;
    NtcLane b;
    NtcLane c;
    NtcLane slope;
};

NTC_BC7_INLINE NtcBc7Form NtcBc7MakeForm(int steps, NtcLane count, NtcLane index, NtcLane square) {
    NtcBc7Form form;
    NtcMask isFlat = count * square == index * index; // all indices alike: no line through them
    form.a = NtcSelect(isFlat, count * ((2 * steps * steps + 5) / 6),
                       count * (steps * steps) - index * (2 * steps) + square);
    form.b = NtcSelect(isFlat, count * ((steps * steps + 5) / 6), index * steps - square);
    form.c = NtcSelect(isFlat, form.a, square);
    form.slope = NtcBc7Divide(form.b << 8, NtcLaneMax(form.c, NtcSplat(1)));
    int shift = steps == 15 ? 4 : steps == 7 ? 2 : 0; // the form's sum is at most 225 then
    form.a = form.a >> shift;
    form.b = form.b >> shift;
    form.c = form.c >> shift;
    return form;
}

/// e0 = (Sx Sii - Si Six) / D, e1 = e0 + N (n Six - Si Sx) / D, D = n Sii - Si^2; without a line the mean.
NTC_BC7_INLINE NtcBc7Optimum NtcBc7Solve(int steps, NtcLane count, NtcLane sum, NtcLane index, NtcLane square,
                                         NtcLane product) {
    NtcLane determinant = count * square - index * index;
    NtcMask isFlat = determinant == 0;
    NtcLane lowPart = NtcSelect(isFlat, sum, sum * square - index * product);
    NtcLane highPart = NtcSelect(isFlat, sum, lowPart + (count * product - index * sum) * steps);
    NtcLane divisor = NtcLaneMax(NtcSelect(isFlat, count, determinant), NtcSplat(1));
    NtcBc7Optimum optimum;
    optimum.low = NtcLaneClamp(NtcBc7Divide(lowPart << 6, divisor), -32768, 49152);
    optimum.high = NtcLaneClamp(NtcBc7Divide(highPart << 6, divisor), -32768, 49152);
    return optimum;
}

/// Eighths of the distance of an 8-bit value from an optimum in 64ths, at most 64 units.
NTC_BC7_INLINE NtcLane NtcBc7Distance(NtcLane value, NtcLane optimum) {
    return NtcLaneClamp(((value << 6) - optimum) >> 3, -511, 511);
}

/// Rounds the optimum of one channel: for both p-bits of either end the best pair of lattice points, for
/// two candidates of the low end each with the high end that fits it. [k]: p-bit of low is k & 1, of high
/// k >> 1; without p-bits only [0].
NTC_BC7_INLINE void NtcBc7RoundChannel(NTC_BC7_IN(NtcBc7Form, form), NTC_BC7_IN(NtcBc7Optimum, optimum),
                                       int bits, int pbits, NTC_INOUT_ARRAY(NtcLane, lows, 4),
                                       NTC_INOUT_ARRAY(NtcLane, highs, 4),
                                       NTC_INOUT_ARRAY(NtcLane, costs, 4)) {
    int variants = pbits == NTC_BC7_PBITS_NONE ? 1 : 2;
    int unit = pbits == NTC_BC7_PBITS_NONE ? 0 : 1; // a lattice point is q << unit | p
    int largest = (1 << (bits - unit)) - 1;
    NtcLane lowTarget = NtcBc7ToLattice(optimum.low, bits);
    NTC_BC7_UNROLL for (int p = 0; p < variants; p++) {
        NtcLane floored = (lowTarget - 64 * p) >> (6 + unit);
        NTC_BC7_UNROLL for (int side = 0; side < 2; side++) {
            NtcLane low = (NtcLaneClamp(floored + side, 0, largest) << unit) | p;
            NtcLane lowValue = NtcBc7Expand(low, bits);
            NtcLane lowOff = (lowValue << 6) - optimum.low;
            NtcLane wanted = NtcLaneClamp(optimum.high - ((lowOff * form.slope) >> 8), -32768, 49152);
            NtcLane highTarget = NtcBc7ToLattice(wanted, bits);
            NtcLane lowDistance = NtcBc7Distance(lowValue, optimum.low);
            NtcLane lowCost = form.a * NtcBc7Square(lowDistance);
            NtcLane cross = form.b * lowDistance * 2;
            NTC_BC7_UNROLL for (int r = 0; r < variants; r++) {
                int k = p + 2 * r;
                if (pbits != NTC_BC7_PBITS_SHARED || p == r) {
                    NtcLane high =
                        (NtcLaneClamp((highTarget - 64 * r + (32 << unit)) >> (6 + unit), 0, largest)
                         << unit) |
                        r;
                    NtcLane highDistance = NtcBc7Distance(NtcBc7Expand(high, bits), optimum.high);
                    NtcLane cost = lowCost + (cross + form.c * highDistance) * highDistance;
                    NtcMask isBetter = cost < costs[k];
                    if (side == 0)
                        isBetter = NtcSplat(0) == 0;
                    costs[k] = NtcSelect(isBetter, cost, costs[k]);
                    lows[k] = NtcSelect(isBetter, low, lows[k]);
                    highs[k] = NtcSelect(isBetter, high, highs[k]);
                }
            }
        }
    }
}

/// The best endpoints of every subset for given sums. forced: the p-bit that every endpoint must have, or
/// -1. `rank`: 0 the best combination of p-bits, 1 ... 3 the next ones.
NTC_BC7_INLINE void NtcBc7FitShape(int pbits, int subsets, int first, int channels, int steps, int bits,
                                   int rank, NtcLane forced, NTC_BC7_IN(NtcBc7Moments, moments),
                                   NTC_BC7_IN(NtcBc7Sums, sums), NTC_INOUT(NtcBc7Ends, ends)) {
    int variants = pbits == NTC_BC7_PBITS_NONE ? 1 : 4;
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        NtcBc7Form form = NtcBc7MakeForm(steps, moments.count[s], sums.index[s], sums.square[s]);
        NtcLane total[4];
        NtcLane lowWord[4];
        NtcLane highWord[4];
        NTC_BC7_UNROLL for (int k = 0; k < variants; k++) {
            // A combination that is forbidden costs more than any other: those stay below 2^28.
            NtcMask isForbidden = NtcMaskAnd(forced >= 0, NtcMaskOr(forced != (k & 1), forced != (k >> 1)));
            if (pbits == NTC_BC7_PBITS_SHARED && (k == 1 || k == 2))
                isForbidden = NtcSplat(0) == 0;
            total[k] = NtcSelect(isForbidden, NtcSplat(1 << 30), NtcSplat(0));
            lowWord[k] = NtcSplat(0);
            highWord[k] = NtcSplat(0);
        }
        NTC_LOOP for (int c = first; c < first + channels; c++) {
            NtcBc7Optimum optimum = NtcBc7Solve(steps, moments.count[s], moments.sum[4 * s + c],
                                                sums.index[s], sums.square[s], sums.product[4 * s + c]);
            NtcLane lows[4];
            NtcLane highs[4];
            NtcLane costs[4];
            NTC_BC7_UNROLL for (int k = 0; k < 4; k++) {
                lows[k] = NtcSplat(0);
                highs[k] = NtcSplat(0);
                costs[k] = NtcSplat(0);
            }
            NtcBc7RoundChannel(form, optimum, bits, pbits, lows, highs, costs);
            NTC_BC7_UNROLL for (int k = 0; k < variants; k++) {
                total[k] = total[k] + costs[k];
                lowWord[k] = lowWord[k] | (lows[k] << (8 * c));
                highWord[k] = highWord[k] | (highs[k] << (8 * c));
            }
        }
        NTC_LOOP for (int turn = 0; turn <= rank; turn++) {
            NtcLane least = total[0];
            NtcLane which = NtcSplat(0);
            ends.ends[2 * s] = lowWord[0];
            ends.ends[2 * s + 1] = highWord[0];
            NTC_BC7_UNROLL for (int k = 1; k < variants; k++) {
                NtcMask isBetter = total[k] < least;
                least = NtcSelect(isBetter, total[k], least);
                which = NtcSelect(isBetter, NtcSplat(k), which);
                ends.ends[2 * s] = NtcSelect(isBetter, lowWord[k], ends.ends[2 * s]);
                ends.ends[2 * s + 1] = NtcSelect(isBetter, highWord[k], ends.ends[2 * s + 1]);
            }
            NTC_BC7_UNROLL for (int k = 0; k < variants; k++) total[k] =
                total[k] + NtcSelect(which == k, NtcSplat(1 << 28), NtcSplat(0));
        }
    }
}

NTC_BC7_LEAF void NtcBc7FitPlain(int subsets, int first, int channels, int steps, int bits,
                                 NTC_BC7_IN(NtcBc7Moments, moments), NTC_BC7_IN(NtcBc7Sums, sums),
                                 NTC_INOUT(NtcBc7Ends, ends)) {
    NtcBc7FitShape(NTC_BC7_PBITS_NONE, subsets, first, channels, steps, bits, 0, NtcSplat(-1), moments, sums,
                   ends);
}
NTC_BC7_LEAF void NtcBc7FitEach(int subsets, int channels, int steps, int bits, int rank, NtcLane forced,
                                NTC_BC7_IN(NtcBc7Moments, moments), NTC_BC7_IN(NtcBc7Sums, sums),
                                NTC_INOUT(NtcBc7Ends, ends)) {
    NtcBc7FitShape(NTC_BC7_PBITS_EACH, subsets, 0, channels, steps, bits, rank, forced, moments, sums, ends);
}
NTC_BC7_LEAF void NtcBc7FitShared(int subsets, int steps, int bits, int rank,
                                  NTC_BC7_IN(NtcBc7Moments, moments), NTC_BC7_IN(NtcBc7Sums, sums),
                                  NTC_INOUT(NtcBc7Ends, ends)) {
    NtcBc7FitShape(NTC_BC7_PBITS_SHARED, subsets, 0, 3, steps, bits, rank, NtcSplat(-1), moments, sums, ends);
}

/// NtcBc7FitShape for what the p-bits of a mode are.
NTC_FUNCTION void NtcBc7Fit(int subsets, int first, int channels, int steps, int bits, int pbits, int rank,
                            NtcLane forced, NTC_BC7_IN(NtcBc7Moments, moments), NTC_BC7_IN(NtcBc7Sums, sums),
                            NTC_INOUT(NtcBc7Ends, ends)) {
    if (pbits == NTC_BC7_PBITS_NONE)
        NtcBc7FitPlain(subsets, first, channels, steps, bits, moments, sums, ends);
    else if (pbits == NTC_BC7_PBITS_EACH)
        NtcBc7FitEach(subsets, channels, steps, bits, rank, forced, moments, sums, ends);
    else
        NtcBc7FitShared(subsets, steps, bits, rank, moments, sums, ends);
}

/// The colours of stored endpoints, channels first ... first + channels - 1.
NTC_FUNCTION void NtcBc7MakeLine(int subsets, int first, int channels, int bits, NTC_BC7_IN(NtcBc7Ends, ends),
                                 NTC_INOUT(NtcBc7Line, segment)) {
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        NTC_LOOP for (int c = first; c < first + channels; c++) {
            segment.low[4 * s + c] = NtcBc7Expand((ends.ends[2 * s] >> (8 * c)) & 255, bits);
            segment.high[4 * s + c] = NtcBc7Expand((ends.ends[2 * s + 1] >> (8 * c)) & 255, bits);
        }
    }
}

NTC_LANES_NAMESPACE_END

#endif
