// SPDX-License-Identifier: MIT
// BC7: one mode on many blocks, a partition and a rotation of its own in each. All levels measure by the
// squared error of R, G, B and A of what a decoder sees, and each tries all that the level below it tries.
#ifndef OPENNTC_BC7_MODES_H
#define OPENNTC_BC7_MODES_H

#include "openntc/bc/Bc7Endpoints.h"
#include "openntc/bc/Bc7Estimate.h"

NTC_LANES_NAMESPACE_BEGIN

/// How much is searched.
struct NtcBc7Effort {
    int partitions[8]; // by mode: how many are tried, best estimates first
    int patterns;      // of two subsets: how many are looked at
    int rounds;        // of fitting endpoints and choosing indices
    int ranks;         // combinations of p-bits that are tried
    int starts;        // sets of indices to start from
    int rotations;     // 1: the one that is expected to be best; 4: all
};

NTC_FUNCTION NtcBc7Effort NtcBc7GetEffort(int quality) {
    NtcBc7Effort effort;
    bool isFast = quality == NTC_BC_QUALITY_FAST;
    bool isBest = quality == NTC_BC_QUALITY_BEST;
    NTC_LOOP for (int mode = 0; mode < 8; mode++) {
        bool isOfThree = mode == 0 || mode == 2;
        effort.partitions[mode] = mode == 6 ? 1 : isBest ? NTC_BC7_KEPT : isFast && isOfThree ? 0 : 1;
    }
    effort.patterns = isBest ? 64 : NTC_BC7_USUAL;
    effort.rounds = isBest ? 2 : 1;
    effort.ranks = isBest ? 2 : 1;
    effort.starts = isFast ? 1 : isBest ? 6 : 3;
    effort.rotations = isFast ? 1 : 4;
    return effort;
}

/// One way to code a block.
struct NtcBc7Coding {
    NtcLane error;
    NtcLane choice; // NtcBc7Hint
    NtcBc7Ends ends;
};

/// Keeps a coding of the lanes of `isOwn` where it is better.
NTC_FUNCTION void NtcBc7Keep(NtcMask isOwn, NtcLane error, NtcLane choice, NTC_BC7_IN(NtcBc7Ends, ends),
                             NTC_INOUT(NtcBc7Coding, best)) {
    NtcMask isBetter = NtcMaskAnd(isOwn, error < best.error);
    best.error = NtcSelect(isBetter, error, best.error);
    best.choice = NtcSelect(isBetter, choice, best.choice);
    NTC_LOOP for (int i = 0; i < 6; i++) best.ends.ends[i] =
        NtcSelect(isBetter, ends.ends[i], best.ends.ends[i]);
}

/// What of a mode is the same for every partition.
struct NtcBc7Shape {
    int subsets;
    int first;
    int channels;
    int steps;
    int bits;
    int pbits;
};

NTC_FUNCTION NtcBc7Shape NtcBc7MakeShape(int mode) {
    NtcBc7Shape shape;
    shape.subsets = kNtcBc7Subsets[mode];
    shape.first = 0;
    shape.channels = mode > 5 ? 4 : 3;
    shape.steps = (1 << kNtcBc7IndexBits[mode]) - 1;
    shape.bits = kNtcBc7ColorBits[mode];
    shape.pbits = kNtcBc7PBits[mode];
    return shape;
}

/// Fits and assigns in turns from `sums` on; of every subset the best endpoints and their error stay.
NTC_BC7_LEAF void NtcBc7Refine(NTC_BC7_IN(NtcBc7Shape, shape), int rounds, int ranks, NtcLane forced,
                               NTC_BC7_TEXELS(x), NtcLane subset, NTC_BC7_IN(NtcBc7Moments, moments),
                               NTC_BC7_IN(NtcBc7Sums, start), NTC_INOUT(NtcBc7Ends, best),
                               NTC_INOUT_ARRAY(NtcLane, leastError, 3)) {
    NtcBc7Sums sums = start;
    NTC_LOOP for (int turn = 0; turn < rounds; turn++) {
        NtcBc7Sums startSums = sums;
        int tries = shape.pbits == NTC_BC7_PBITS_NONE     ? 1
                    : shape.pbits == NTC_BC7_PBITS_SHARED ? (ranks < 2 ? ranks : 2)
                                                          : ranks;
        NTC_LOOP for (int rank = 0; rank < tries; rank++) {
            NtcBc7Ends ends;
            NtcBc7Line segment;
            NtcBc7Sums next = sums;
            NtcLane error[3];
            NtcBc7Fit(shape.subsets, shape.first, shape.channels, shape.steps, shape.bits, shape.pbits, rank,
                      forced, moments, startSums, ends);
            NtcBc7MakeLine(shape.subsets, shape.first, shape.channels, shape.bits, ends, segment);
            NtcBc7Assign(shape.subsets, shape.first, shape.channels, shape.steps, x, subset, segment, next,
                         error);
            NTC_LOOP for (int s = 0; s < shape.subsets; s++) {
                NtcMask isBetter = error[s] < leastError[s];
                leastError[s] = NtcSelect(isBetter, error[s], leastError[s]);
                best.ends[2 * s] = NtcSelect(isBetter, ends.ends[2 * s], best.ends[2 * s]);
                best.ends[2 * s + 1] = NtcSelect(isBetter, ends.ends[2 * s + 1], best.ends[2 * s + 1]);
            }
            if (rank == 0)
                sums = next;
        }
    }
}

/// Sets of indices to start from: texels spread over all indices, or over fewer of them: how many are left
/// out at the low end and at the high end. Fits end in the local optimum next to where they start, and this,
/// not more turns of fitting, is what finds others.
NTC_TABLE(int, kNtcBc7StartLows, 6) = {0, 1, 0, 1, 2, 0};
NTC_TABLE(int, kNtcBc7StartsLeft, 6) = {0, 0, 1, 1, 0, 2};

/// The two bits a texel of a partition each lane.
NTC_FUNCTION NtcLane NtcBc7GetSubsets(int subsets, NtcLane pattern) {
    if (subsets == 1)
        return NtcSplat(0);
    if (subsets == 2) {
#if defined(__cplusplus)
        return NtcBc7SpreadBits(NtcLookup(kNtcBc7Partitions2, pattern));
#else
        return NtcBc7SpreadBits(int(NtcBc7GetPartition2(pattern)));
#endif
    }
    return NtcLookup(kNtcBc7Partitions3, pattern);
}

/// Tries a mode of one set of indices with a partition (two bits a texel) each lane.
NTC_BC7_LEAF void NtcBc7TrySubsets(int mode, NTC_BC7_IN(NtcBc7Effort, effort), NTC_BC7_TEXELS(x),
                                   NtcMask isOwn, NtcLane pattern, NtcLane forced, NtcLane alphaError,
                                   NTC_INOUT(NtcBc7Coding, best)) {
    NtcBc7Shape shape = NtcBc7MakeShape(mode);
    NtcLane subset = NtcBc7GetSubsets(shape.subsets, pattern);
    NtcBc7Moments moments;
    NtcBc7Gather(shape.subsets, x, subset, moments);
    NtcBc7Ends ends;
    NtcLane error[3];
    NTC_LOOP for (int s = 0; s < 3; s++) {
        ends.ends[2 * s] = NtcSplat(0);
        ends.ends[2 * s + 1] = NtcSplat(0);
        error[s] = NtcSplat(1 << 24);
    }
    NTC_LOOP for (int start = 0; start < effort.starts; start++) {
        NtcBc7Sums sums;
        int low = kNtcBc7StartLows[start];
        int high = shape.steps - kNtcBc7StartsLeft[start];
        if (high > low) {
            if (shape.channels == 4)
                NtcBc7StartBoth(shape.subsets, low, high, x, subset, moments, sums);
            else
                NtcBc7StartColor(shape.subsets, low, high, x, subset, moments, sums);
            NtcBc7Refine(shape, effort.rounds, effort.ranks, forced, x, subset, moments, sums, ends, error);
        }
    }
    NtcLane total = error[0];
    NTC_LOOP for (int s = 1; s < shape.subsets; s++) total = total + error[s];
    if (shape.channels < 4)
        total = total + alphaError;
    NtcBc7Keep(isOwn, total, (pattern << 3) | mode, ends, best);
}

/// Tries mode 4 or 5 on texels whose channels are rotated already.
NTC_BC7_LEAF void NtcBc7TryDual(int mode, int selector, NTC_BC7_IN(NtcBc7Effort, effort), NTC_BC7_TEXELS(x),
                                NtcMask isOwn, NtcLane rotation, NTC_INOUT(NtcBc7Coding, best)) {
    NtcBc7Moments moments;
    NtcBc7Gather(1, x, NtcSplat(0), moments);
    NtcBc7Ends both;
    both.ends[0] = NtcSplat(0);
    both.ends[1] = NtcSplat(0);
    NtcLane total = NtcSplat(0);
    NTC_LOOP for (int plane = 0; plane < 2; plane++) {
        NtcBc7Shape shape = NtcBc7MakeShape(mode);
        if (mode == 4)
            shape.steps = plane == selector ? 3 : 7;
        if (plane == 1) {
            shape.first = 3;
            shape.channels = 1;
            shape.bits = kNtcBc7AlphaBits[mode];
        }
        NtcBc7Ends ends;
        NtcLane error[3];
        NTC_LOOP for (int s = 0; s < 3; s++) {
            ends.ends[2 * s] = NtcSplat(0);
            ends.ends[2 * s + 1] = NtcSplat(0);
            error[s] = NtcSplat(1 << 24);
        }
        NTC_LOOP for (int start = 0; start < effort.starts; start++) {
            NtcBc7Sums sums;
            int low = kNtcBc7StartLows[start];
            int high = shape.steps - kNtcBc7StartsLeft[start];
            if (high > low) {
                if (plane == 0)
                    NtcBc7StartColor(1, low, high, x, NtcSplat(0), moments, sums);
                else
                    NtcBc7StartAlpha(low, high, x, sums);
                NtcBc7Refine(shape, effort.rounds, 1, NtcSplat(-1), x, NtcSplat(0), moments, sums, ends,
                             error);
            }
        }
        total = total + error[0];
        both.ends[0] = both.ends[0] | ends.ends[0];
        both.ends[1] = both.ends[1] | ends.ends[1];
    }
    NTC_LOOP for (int i = 2; i < 6; i++) both.ends[i] = NtcSplat(0);
    NtcBc7Keep(isOwn, total, (rotation << 9) | (mode | (selector << 11)), both, best);
}

/// y = x with channel rotation - 1 and alpha swapped; 0: as they are.
NTC_BC7_LEAF void NtcBc7Rotate(NTC_BC7_TEXELS(x), NtcLane rotation, NTC_BC7_INOUT_TEXELS(y)) {
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcLane color[3];
        NtcLane alpha = NtcBc7Channel(x, t, 3);
        NtcLane swapped = alpha;
        NTC_BC7_UNROLL for (int c = 0; c < 3; c++) {
            NtcMask isSwapped = rotation == c + 1;
            NtcLane own = NtcBc7Channel(x, t, c);
            swapped = NtcSelect(isSwapped, own, swapped);
            color[c] = NtcSelect(isSwapped, alpha, own);
        }
        NTC_BC7_SET_TEXEL(y, t, color[0], color[1], color[2], swapped);
    }
}

NTC_LANES_NAMESPACE_END

#endif
