// SPDX-License-Identifier: MIT
// BC7: which partitions are worth a try. For every partition the squared distance of texels from a line
// through each subset, from sums alone, plus what indices of so many steps lose along the lines.
#ifndef OPENNTC_BC7_ESTIMATE_H
#define OPENNTC_BC7_ESTIMATE_H

#include "openntc/bc/Bc7Axes.h"

#define NTC_BC7_KEPT 2   // the most partitions of a mode that are kept
#define NTC_BC7_USUAL 32 // of two subsets: the first ones, among which is most of what blocks need

NTC_LANES_NAMESPACE_BEGIN

/// The best partitions of each mode, mode m from [NTC_BC7_KEPT m] on: score << 6 | partition. Of three
/// subsets best first; of two the best of the usual ones, which is what lower levels try, then the best of
/// the others.
struct NtcBc7Ranking {
    NtcLane keys[8 * NTC_BC7_KEPT];
};

NTC_FUNCTION void NtcBc7ClearRanking(NTC_INOUT(NtcBc7Ranking, ranking)) {
    NTC_LOOP for (int i = 0; i < 8 * NTC_BC7_KEPT; i++) ranking.keys[i] = NtcSplat(0x7FFFFFFF);
}

/// The best of one mode.
struct NtcBc7ModeRanking {
    NtcLane keys[NTC_BC7_KEPT];
};

NTC_BC7_INLINE NtcBc7ModeRanking NtcBc7StartRanking() {
    NtcBc7ModeRanking ranking;
    NTC_BC7_UNROLL for (int i = 0; i < NTC_BC7_KEPT; i++) ranking.keys[i] = NtcSplat(0x7FFFFFFF);
    return ranking;
}

/// Ranks a partition, behind the first one that is kept unless `mayLead`.
NTC_BC7_INLINE void NtcBc7Rank(NtcLane score, int pattern, bool mayLead,
                               NTC_INOUT(NtcBc7ModeRanking, ranking)) {
    NtcLane key = (score << 6) | pattern;
    NTC_BC7_UNROLL for (int i = 0; i < NTC_BC7_KEPT; i++) {
        if (i > 0 || mayLead) {
            NtcLane least = NtcLaneMin(ranking.keys[i], key);
            key = NtcLaneMax(ranking.keys[i], key);
            ranking.keys[i] = least;
        }
    }
}

/// `mode` is a constant.
NTC_BC7_INLINE void NtcBc7KeepRanking(int mode, NTC_BC7_IN(NtcBc7ModeRanking, own),
                                      NTC_INOUT(NtcBc7Ranking, ranking)) {
    NTC_BC7_UNROLL for (int i = 0; i < NTC_BC7_KEPT; i++) ranking.keys[NTC_BC7_KEPT * mode + i] = own.keys[i];
}

// With the device's dot product of four signed bytes sums over texels are made of four texels at once.
// (A test defines NTC_BC7_PLANES in C++.)
#ifndef NTC_BC7_PLANES
#if !defined(__cplusplus) && (defined(NTC_DOT4_SPIRV) || defined(NTC_DOT4_SM64))
#define NTC_BC7_PLANES 1
#else
#define NTC_BC7_PLANES 0
#endif
#endif

/// What sums over texels are made of: sums and products of each texel, 4 + 10 a texel, in the order of
/// NtcBc7Spread. In shaders the texels, in registers: arrays that are indexed at run time are memory there,
/// and that memory was half of the time of the fast level. As planes: channel c of texels 4 q ... 4 q + 3,
/// less 128, at [4 c + q]; spreads are of what is less 128 then, which no covariance tells.
struct NtcBc7Terms {
#if NTC_BC7_PLANES
    uint planes[16];
#elif defined(__cplusplus)
    NtcLane terms[224];
#else
    uint texels[16];
#endif
};

#if NTC_BC7_PLANES
// Four texels are added at once.
#elif defined(__cplusplus)
/// Adds a texel's terms to a spread; `channels` is a constant.
NTC_BC7_INLINE void NtcBc7AddTerms(int channels, const NtcBc7Terms& terms, int t, NtcBc7Spread& spread) {
    NTC_BC7_UNROLL for (int c = 0; c < 4; c++) {
        if (c < channels)
            spread.sum[c] = spread.sum[c] + terms.terms[14 * t + c];
    }
    NTC_BC7_UNROLL for (int p = 0; p < 10; p++) {
        if (channels == 4 || (p != 3 && p != 6 && p < 8))
            spread.product[p] = spread.product[p] + terms.terms[14 * t + 4 + p];
    }
}
#else
/// Adds a texel (0: nothing) to a spread; `channels` is a constant.
void NtcBc7AddTerms(int channels, uint texel, NTC_INOUT(NtcBc7Spread, spread)) {
    int r = int(texel & 255u);
    int g = int((texel >> 8) & 255u);
    int b = int((texel >> 16) & 255u);
    spread.sum[0] += r;
    spread.sum[1] += g;
    spread.sum[2] += b;
    spread.product[0] += r * r;
    spread.product[1] += g * g;
    spread.product[2] += b * b;
    spread.product[4] += r * g;
    spread.product[5] += r * b;
    spread.product[7] += g * b;
    if (channels == 4) {
        int a = int(texel >> 24);
        spread.sum[3] += a;
        spread.product[3] += a * a;
        spread.product[6] += r * a;
        spread.product[8] += g * a;
        spread.product[9] += b * a;
    }
}
#endif

NTC_BC7_INLINE void NtcBc7ClearSpread(NTC_INOUT(NtcBc7Spread, spread)) {
    NTC_BC7_UNROLL for (int c = 0; c < 4; c++) spread.sum[c] = NtcSplat(0);
    NTC_BC7_UNROLL for (int p = 0; p < 10; p++) spread.product[p] = NtcSplat(0);
}

/// The spread of the texels of a mask.
NTC_BC7_INLINE void NtcBc7Collect(int channels, NTC_BC7_IN(NtcBc7Terms, terms), uint mask,
                                  NTC_INOUT(NtcBc7Spread, spread)) {
    NtcBc7Spread part; // of its own: what is passed in may be memory
    NtcBc7ClearSpread(part);
#if NTC_BC7_PLANES
    NTC_UNROLL for (int q = 0; q < 4; q++) {
        // Four bits of the mask to four bytes of 0 or 255.
        uint own = ((((mask >> uint(4 * q)) & 15u) * 0x00204081u) & 0x01010101u) * 255u;
        uint r = terms.planes[q];
        uint g = terms.planes[4 + q];
        uint b = terms.planes[8 + q];
        part.sum[0] += NtcDot4(r & own, 0x01010101u);
        part.sum[1] += NtcDot4(g & own, 0x01010101u);
        part.sum[2] += NtcDot4(b & own, 0x01010101u);
        part.product[0] += NtcDot4(r & own, r);
        part.product[1] += NtcDot4(g & own, g);
        part.product[2] += NtcDot4(b & own, b);
        part.product[4] += NtcDot4(r & own, g);
        part.product[5] += NtcDot4(r & own, b);
        part.product[7] += NtcDot4(g & own, b);
        if (channels == 4) {
            uint a = terms.planes[12 + q];
            part.sum[3] += NtcDot4(a & own, 0x01010101u);
            part.product[3] += NtcDot4(a & own, a);
            part.product[6] += NtcDot4(r & own, a);
            part.product[8] += NtcDot4(g & own, a);
            part.product[9] += NtcDot4(b & own, a);
        }
    }
#elif defined(__cplusplus)
    while (mask != 0u) {
        NtcBc7AddTerms(channels, terms, NtcLowestBit(mask), part);
        mask &= mask - 1u;
    }
#else
    NTC_UNROLL for (int t = 0; t < 16; t++)
        NtcBc7AddTerms(channels, (mask & (1u << uint(t))) != 0u ? terms.texels[t] : 0u, part);
#endif
    spread = part;
}

NTC_BC7_LEAF void NtcBc7MakeTerms(NTC_BC7_TEXELS(x), NTC_INOUT(NtcBc7Terms, terms),
                                  NTC_INOUT(NtcBc7Spread, whole)) {
#if NTC_BC7_PLANES
    NTC_UNROLL for (int c = 0; c < 4; c++) {
        NTC_UNROLL for (int q = 0; q < 4; q++) {
            uint plane = 0u;
            NTC_UNROLL for (int i = 0; i < 4; i++) plane =
                plane | (uint(NtcBc7Channel(x, 4 * q + i, c)) << uint(8 * i));
            terms.planes[4 * c + q] = plane ^ 0x80808080u;
        }
    }
    NtcBc7Collect(4, terms, 0xFFFFu, whole);
#else
    NtcBc7ClearSpread(whole);
#if defined(__cplusplus)
    for (int t = 0; t < 16; t++) {
        NtcLane r = x[4 * t];
        NtcLane g = x[4 * t + 1];
        NtcLane b = x[4 * t + 2];
        NtcLane a = x[4 * t + 3];
        const NtcLane own[14] = {r,     g,     b,     a,     r * r, g * g, b * b,
                                 a * a, r * g, r * b, r * a, g * b, g * a, b * a};
        for (int i = 0; i < 14; i++)
            terms.terms[14 * t + i] = own[i];
        NtcBc7AddTerms(4, terms, t, whole);
    }
#else
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        terms.texels[t] = x[t];
        NtcBc7AddTerms(4, x[t], whole);
    }
#endif
#endif
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
    int share = int(4096.5f / float(count)); // 4096 / count, of whatever rounding
    fine = fine + (((off + (along >> 6)) * share) >> 10);
    coarse = coarse + (((off + (along >> 3)) * share) >> 10);
}

NTC_FUNCTION int NtcBc7CountBits(uint mask) {
    uint pairs = mask - ((mask >> 1) & 0x5555u);
    uint fours = (pairs & 0x3333u) + ((pairs >> 2) & 0x3333u);
    uint bytes = (fours + (fours >> 4)) & 0x0F0Fu;
    return int((bytes + (bytes >> 8)) & 31u);
}

/// Ranks the first `tried` partitions of two subsets, for a mode with indices of 3 bits (fine) and one of 2
/// bits (coarse).
NTC_BC7_INLINE void NtcBc7Estimate2Shape(int channels, int tried, NTC_BC7_IN(NtcBc7Terms, terms),
                                         NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7ModeRanking, fine),
                                         NTC_INOUT(NtcBc7ModeRanking, coarse)) {
    NtcBc7ModeRanking ownFine = NtcBc7StartRanking();
    NtcBc7ModeRanking ownCoarse = NtcBc7StartRanking();
    NtcLane shift = NtcBc7EstimateShift(channels, whole);
    NTC_LOOP for (int pattern = 0; pattern < tried; pattern++) {
        uint mask = NtcBc7GetPartition2(pattern);
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
        NtcBc7Rank(fineScore, pattern, pattern < NTC_BC7_USUAL, ownFine);
        NtcBc7Rank(coarseScore, pattern, pattern < NTC_BC7_USUAL, ownCoarse);
    }
    fine = ownFine;
    coarse = ownCoarse;
}

/// For modes 1 and 3.
NTC_BC7_LEAF void NtcBc7Estimate2Color(int tried, NTC_BC7_IN(NtcBc7Terms, terms),
                                       NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcBc7ModeRanking fine;
    NtcBc7ModeRanking coarse;
    NtcBc7Estimate2Shape(3, tried, terms, whole, fine, coarse);
    NtcBc7KeepRanking(1, fine, ranking);
    NtcBc7KeepRanking(3, coarse, ranking);
}
/// For mode 7.
NTC_BC7_LEAF void NtcBc7Estimate2Both(int tried, NTC_BC7_IN(NtcBc7Terms, terms),
                                      NTC_BC7_IN(NtcBc7Spread, whole), NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcBc7ModeRanking unread;
    NtcBc7ModeRanking coarse;
    NtcBc7Estimate2Shape(4, tried, terms, whole, unread, coarse);
    NtcBc7KeepRanking(7, coarse, ranking);
}

/// The texels of a subset, of a partition with two bits a texel.
NTC_FUNCTION uint NtcBc7SubsetMask(uint pattern, int subset) {
    uint bits = (subset == 1 ? pattern : pattern >> 1) & 0x55555555u;
    bits = (bits | (bits >> 1)) & 0x33333333u;
    bits = (bits | (bits >> 2)) & 0x0F0F0F0Fu;
    bits = (bits | (bits >> 4)) & 0x00FF00FFu;
    return (bits | (bits >> 8)) & 0xFFFFu;
}

/// Ranks the partitions of three subsets: the first sixteen for mode 0 (fine), `tried` for mode 2 (coarse).
NTC_BC7_LEAF void NtcBc7Estimate3(int tried, NTC_BC7_IN(NtcBc7Terms, terms), NTC_BC7_IN(NtcBc7Spread, whole),
                                  NTC_INOUT(NtcBc7Ranking, ranking)) {
    NtcBc7ModeRanking fine = NtcBc7StartRanking();
    NtcBc7ModeRanking coarse = NtcBc7StartRanking();
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
            NtcBc7Rank(fineScore, pattern, true, fine);
        NtcBc7Rank(coarseScore, pattern, true, coarse);
    }
    NtcBc7KeepRanking(0, fine, ranking);
    NtcBc7KeepRanking(2, coarse, ranking);
}

/// The rotation that leaves least to the other channels: spread of each channel off what the rest follows.
NTC_BC7_LEAF NtcLane NtcBc7EstimateRotation(NTC_BC7_IN(NtcBc7Spread, whole)) {
    NtcLane bestScore = NtcSplat(0x7FFFFFFF);
    NtcLane best = NtcSplat(0);
    NTC_LOOP for (int r = 0; r < 4; r++) {
        NtcBc7Spread spread = whole;
        NtcLane left;
        int out0 = r == 0 ? 3 : r - 1; // the channel that gets indices of its own
        NTC_BC7_UNROLL for (int i = 0; i < 10; i++) {
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
