// SPDX-License-Identifier: MIT
// BC7: which partitions are worth a try. For every partition the squared distance of texels from a line
// through each subset, from sums alone, plus what indices of so many steps lose along the lines.
#ifndef OPENNTC_BC7_ESTIMATE_H
#define OPENNTC_BC7_ESTIMATE_H

#include "openntc/bc/Bc7Axes.h"

#define NTC_BC7_KEPT 2 // the most partitions of a mode that are kept

NTC_LANES_NAMESPACE_BEGIN

/// The best partitions of each mode, mode m from [NTC_BC7_KEPT m] on, best first: score << 6 | partition.
struct NtcBc7Ranking {
    NtcLane keys[8 * NTC_BC7_KEPT];
};

NTC_FUNCTION void NtcBc7ClearRanking(NTC_INOUT(NtcBc7Ranking, ranking)) {
    NTC_LOOP for (int i = 0; i < 8 * NTC_BC7_KEPT; i++) ranking.keys[i] = NtcSplat(0x7FFFFFFF);
}

NTC_FUNCTION void NtcBc7Rank(int mode, int kept, NtcLane score, int pattern,
                             NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcLane key = (score << 6) | pattern;
    NTC_LOOP for (int i = NTC_BC7_KEPT * mode; i < NTC_BC7_KEPT * mode + kept; i++) {
        NtcLane least = NtcLaneMin(ranking.keys[i], key);
        key = NtcLaneMax(ranking.keys[i], key);
        ranking.keys[i] = least;
    }
}

/// Sums and products of each texel: 4 + 10 a texel, in the order of NtcBc7Spread.
struct NtcBc7Terms {
    NtcLane terms[224];
};

NTC_BC7_LEAF void NtcBc7MakeTerms(NTC_IN_ARRAY(NtcLane, x, 64), NTC_INOUT(NtcBc7Terms, terms),
                                  NTC_INOUT(NtcBc7Spread, whole)) {
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcLane r = x[4 * t];
        NtcLane g = x[4 * t + 1];
        NtcLane b = x[4 * t + 2];
        NtcLane a = x[4 * t + 3];
        terms.terms[14 * t] = r;
        terms.terms[14 * t + 1] = g;
        terms.terms[14 * t + 2] = b;
        terms.terms[14 * t + 3] = a;
        terms.terms[14 * t + 4] = r * r;
        terms.terms[14 * t + 5] = g * g;
        terms.terms[14 * t + 6] = b * b;
        terms.terms[14 * t + 7] = a * a;
        terms.terms[14 * t + 8] = r * g;
        terms.terms[14 * t + 9] = r * b;
        terms.terms[14 * t + 10] = r * a;
        terms.terms[14 * t + 11] = g * b;
        terms.terms[14 * t + 12] = g * a;
        terms.terms[14 * t + 13] = b * a;
    }
    NTC_LOOP for (int c = 0; c < 4; c++) {
        NtcLane total = NtcSplat(0);
        NTC_LOOP for (int t = 0; t < 16; t++) total = total + terms.terms[14 * t + c];
        whole.sum[c] = total;
    }
    NTC_LOOP for (int p = 0; p < 10; p++) {
        NtcLane total = NtcSplat(0);
        NTC_LOOP for (int t = 0; t < 16; t++) total = total + terms.terms[14 * t + 4 + p];
        whole.product[p] = total;
    }
}

/// The spread of the texels of a mask.
NTC_BC7_INLINE void NtcBc7Collect(int channels, NTC_BC7_IN(NtcBc7Terms, terms), uint mask,
                                  NTC_INOUT(NtcBc7Spread, spread)) {
    NtcLane zero = NtcSplat(0);
    NtcLane sum0 = zero;
    NtcLane sum1 = zero;
    NtcLane sum2 = zero;
    NtcLane sum3 = zero;
    NtcLane rr = zero;
    NtcLane gg = zero;
    NtcLane bb = zero;
    NtcLane aa = zero;
    NtcLane rg = zero;
    NtcLane rb = zero;
    NtcLane ra = zero;
    NtcLane gb = zero;
    NtcLane ga = zero;
    NtcLane ba = zero;
    NTC_LOOP while (mask != 0u) {
        int at = 14 * NtcLowestBit(mask);
        mask &= mask - 1u;
        sum0 = sum0 + terms.terms[at];
        sum1 = sum1 + terms.terms[at + 1];
        sum2 = sum2 + terms.terms[at + 2];
        rr = rr + terms.terms[at + 4];
        gg = gg + terms.terms[at + 5];
        bb = bb + terms.terms[at + 6];
        rg = rg + terms.terms[at + 8];
        rb = rb + terms.terms[at + 9];
        gb = gb + terms.terms[at + 11];
        if (channels == 4) {
            sum3 = sum3 + terms.terms[at + 3];
            aa = aa + terms.terms[at + 7];
            ra = ra + terms.terms[at + 10];
            ga = ga + terms.terms[at + 12];
            ba = ba + terms.terms[at + 13];
        }
    }
    spread.sum[0] = sum0;
    spread.sum[1] = sum1;
    spread.sum[2] = sum2;
    spread.sum[3] = sum3;
    spread.product[0] = rr;
    spread.product[1] = gg;
    spread.product[2] = bb;
    spread.product[3] = aa;
    spread.product[4] = rg;
    spread.product[5] = rb;
    spread.product[6] = ra;
    spread.product[7] = gb;
    spread.product[8] = ga;
    spread.product[9] = ba;
}

NTC_BC7_INLINE void NtcBc7Subtract(NTC_INOUT(NtcBc7Spread, minuend), NTC_BC7_IN(NtcBc7Spread, what)) {
    NTC_BC7_UNROLL for (int c = 0; c < 4; c++) minuend.sum[c] = minuend.sum[c] - what.sum[c];
    NTC_BC7_UNROLL for (int i = 0; i < 10; i++) minuend.product[i] = minuend.product[i] - what.product[i];
}

/// A right shift for n times the covariances' sums of any subset that leaves traces below 2^15.
NTC_FUNCTION NtcLane NtcBc7EstimateShift(int channels, NTC_BC7_IN(NtcBc7Spread, whole)) {
    NtcLane trace = NtcSplat(1);
    NTC_BC7_UNROLL for (int c = 0; c < channels; c++) trace =
        trace + whole.product[c] * 16 - NtcBc7Square(whole.sum[c]);
    return NtcLaneMax(NtcHighestBit(trace) - 14, NtcSplat(0));
}

/// The squared error, right by `shift`, that a subset of `count` texels is expected to have with indices of
/// 7 steps (fine) and of 3 steps (coarse), added. Off the line: of eigenvalues a >= b >= c about b + c, and
/// (ab + ac + bc) / (a + b + c), which needs no eigenvalue, is close to that where b + c is small. Along it,
/// where texels are spread evenly over `steps` steps: 1 / steps^2 of the rest.
NTC_BC7_INLINE void NtcBc7Expect(int channels, NTC_BC7_IN(NtcBc7Spread, spread), int count, NtcLane shift,
                                 NTC_INOUT(NtcLane, fine), NTC_INOUT(NtcLane, coarse)) {
    NtcLane rr = (spread.product[0] * count - NtcBc7Square(spread.sum[0])) >> shift;
    NtcLane gg = (spread.product[1] * count - NtcBc7Square(spread.sum[1])) >> shift;
    NtcLane bb = (spread.product[2] * count - NtcBc7Square(spread.sum[2])) >> shift;
    NtcLane rg = (spread.product[4] * count - spread.sum[0] * spread.sum[1]) >> shift;
    NtcLane rb = (spread.product[5] * count - spread.sum[0] * spread.sum[2]) >> shift;
    NtcLane gb = (spread.product[7] * count - spread.sum[1] * spread.sum[2]) >> shift;
    NtcLane trace = rr + gg + bb;
    NtcLane minors = (rr * gg - rg * rg) + (rr * bb - rb * rb) + (gg * bb - gb * gb);
    if (channels == 4) {
        NtcLane aa = (spread.product[3] * count - NtcBc7Square(spread.sum[3])) >> shift;
        NtcLane ra = (spread.product[6] * count - spread.sum[0] * spread.sum[3]) >> shift;
        NtcLane ga = (spread.product[8] * count - spread.sum[1] * spread.sum[3]) >> shift;
        NtcLane ba = (spread.product[9] * count - spread.sum[2] * spread.sum[3]) >> shift;
        minors = minors + (trace * aa - ra * ra) - (ga * ga + ba * ba);
        trace = trace + aa;
    }
    NtcLane off = NtcBc7Divide(NtcLaneMax(minors, NtcSplat(0)), NtcLaneMax(trace, NtcSplat(1)));
    NtcLane along = trace - off;
    int share = 4096 / count;
    fine = fine + (((off + (along >> 6)) * share) >> 10);
    coarse = coarse + (((off + (along >> 3)) * share) >> 10);
}

NTC_FUNCTION int NtcBc7CountBits(uint mask) {
    uint pairs = mask - ((mask >> 1) & 0x5555u);
    uint fours = (pairs & 0x3333u) + ((pairs >> 2) & 0x3333u);
    uint bytes = (fours + (fours >> 4)) & 0x0F0Fu;
    return int((bytes + (bytes >> 8)) & 31u);
}

/// Ranks the partitions of two subsets, for a mode with indices of 3 bits (fine) and one of 2 bits (coarse);
/// as many as are kept of each.
NTC_BC7_INLINE void NtcBc7Estimate2Shape(int channels, int fineMode, int keptFine, int coarseMode,
                                         int keptCoarse, NTC_BC7_IN(NtcBc7Terms, terms),
                                         NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcLane shift = NtcBc7EstimateShift(channels, whole);
    NTC_LOOP for (int pattern = 0; pattern < 64; pattern++) {
        uint mask = kNtcBc7Partitions2[pattern];
        int count = NtcBc7CountBits(mask);
        if (count > 8) { // the smaller subset is summed up
            mask = mask ^ 0xFFFFu;
            count = 16 - count;
        }
        NtcBc7Spread part;
        NtcBc7Collect(channels, terms, mask, part);
        NtcBc7Spread rest = whole;
        NtcBc7Subtract(rest, part);
        NtcLane fineScore = NtcSplat(0);
        NtcLane coarseScore = NtcSplat(0);
        NtcBc7Expect(channels, part, count, shift, fineScore, coarseScore);
        NtcBc7Expect(channels, rest, 16 - count, shift, fineScore, coarseScore);
        NtcBc7Rank(fineMode, keptFine, fineScore, pattern, ranking);
        NtcBc7Rank(coarseMode, keptCoarse, coarseScore, pattern, ranking);
    }
}

NTC_BC7_LEAF void NtcBc7Estimate2Color(int kept1, int kept3, NTC_BC7_IN(NtcBc7Terms, terms),
                                       NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcBc7Estimate2Shape(3, 1, kept1, 3, kept3, terms, whole, ranking);
}
NTC_BC7_LEAF void NtcBc7Estimate2Both(int kept7, NTC_BC7_IN(NtcBc7Terms, terms),
                                      NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcBc7Estimate2Shape(4, 6, 0, 7, kept7, terms, whole, ranking);
}

/// The texels of a subset, of a partition with two bits a texel.
NTC_FUNCTION uint NtcBc7SubsetMask(uint pattern, int subset) {
    uint bits = (subset == 1 ? pattern : pattern >> 1) & 0x55555555u;
    bits = (bits | (bits >> 1)) & 0x33333333u;
    bits = (bits | (bits >> 2)) & 0x0F0F0F0Fu;
    bits = (bits | (bits >> 4)) & 0x00FF00FFu;
    return (bits | (bits >> 8)) & 0xFFFFu;
}

/// Ranks the partitions of three subsets: the first sixteen for mode 0 (fine), all for mode 2 (coarse).
NTC_BC7_LEAF void NtcBc7Estimate3(int kept0, int kept2, NTC_BC7_IN(NtcBc7Terms, terms),
                                  NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7Ranking, ranking)) {
    int tried = kept2 > 0 ? 64 : 16;
    NtcLane shift = NtcBc7EstimateShift(3, whole);
    NTC_LOOP for (int pattern = 0; pattern < tried; pattern++) {
        NtcBc7Spread rest = whole;
        NtcLane fineScore = NtcSplat(0);
        NtcLane coarseScore = NtcSplat(0);
        int left = 16;
        NTC_LOOP for (int s = 1; s <= 3; s++) { // the third turn is what the others leave
            NtcBc7Spread part = rest;
            int count = left;
            if (s < 3) {
                uint mask = NtcBc7SubsetMask(kNtcBc7Partitions3[pattern], s);
                count = NtcBc7CountBits(mask);
                NtcBc7Collect(3, terms, mask, part);
                NtcBc7Subtract(rest, part);
                left -= count;
            }
            NtcBc7Expect(3, part, count, shift, fineScore, coarseScore);
        }
        if (pattern < 16)
            NtcBc7Rank(0, kept0, fineScore, pattern, ranking);
        NtcBc7Rank(2, kept2, coarseScore, pattern, ranking);
    }
}

/// The rotation that leaves least to the other channels: spread of each channel off what the rest follows.
NTC_BC7_LEAF NtcLane NtcBc7EstimateRotation(NTC_BC7_IN(NtcBc7Spread, whole)) {
    NtcLane bestScore = NtcSplat(0x7FFFFFFF);
    NtcLane best = NtcSplat(0);
    NTC_LOOP for (int r = 0; r < 4; r++) {
        NtcBc7Spread spread = whole;
        NtcLane left;
        int out0 = r == 0 ? 3 : r - 1; // the channel that gets indices of its own
        NTC_LOOP for (int i = 0; i < 10; i++) {
            bool isOut = i == out0 || (i == 4 && (out0 == 0 || out0 == 1)) ||
                         (i == 5 && (out0 == 0 || out0 == 2)) || (i == 6 && (out0 == 0 || out0 == 3)) ||
                         (i == 7 && (out0 == 1 || out0 == 2)) || (i == 8 && (out0 == 1 || out0 == 3)) ||
                         (i == 9 && (out0 == 2 || out0 == 3));
            if (isOut)
                spread.product[i] = NtcSplat(0);
        }
        NtcLane own = whole.product[out0] * 16 - NtcBc7Square(whole.sum[out0]);
        spread.sum[out0] = NtcSplat(0);
        NtcBc7Matrix covariance = NtcBc7MakeMatrix(4, spread, NtcSplat(16));
        NtcLane axis[4];
        NtcBc7FindAxis(4, 1, covariance, axis);
        // Off the line, and a ninth of what is along it and of the own channel's: 3 steps each.
        NtcLane off = ((covariance.trace << 3) - ((NtcBc7SpreadAlong(4, covariance, axis) * 910) >> 7))
                      << covariance.shift;
        left = (off >> 3) + (own >> 8) * 28;
        NtcMask isBetter = left < bestScore;
        bestScore = NtcSelect(isBetter, left, bestScore);
        best = NtcSelect(isBetter, NtcSplat(r), best);
    }
    return best;
}

NTC_LANES_NAMESPACE_END

#endif
