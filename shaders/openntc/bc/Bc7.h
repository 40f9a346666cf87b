// SPDX-License-Identifier: MIT
// The BC7 encoder: the search over modes, partitions and rotations, and coding as a hint says.
#ifndef OPENNTC_BC7_H
#define OPENNTC_BC7_H

#include "openntc/bc/Bc7Modes.h"

NTC_LANES_NAMESPACE_BEGIN

/// What of a block's alpha the modes need.
struct NtcBc7Alpha {
    NtcLane error;  // of modes that decode alpha as 255
    NtcLane forced; // p-bits that keep A = 255 and A = 0 where they are everywhere; -1: any
};

NTC_FUNCTION NtcBc7Alpha NtcBc7LookAtAlpha(NTC_BC7_TEXELS(x)) {
    NtcLane least = NtcSplat(255);
    NtcLane most = NtcSplat(0);
    NtcBc7Alpha alpha;
    alpha.error = NtcSplat(0);
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcLane a = NtcBc7Channel(x, t, 3);
        alpha.error = alpha.error + NtcBc7Square(a - 255);
        least = NtcLaneMin(least, a);
        most = NtcLaneMax(most, a);
    }
    alpha.forced = NtcSelect(least == 255, NtcSplat(1), NtcSelect(most == 0, NtcSplat(0), NtcSplat(-1)));
    return alpha;
}

/// One colour everywhere is coded without loss: in mode 5 index 1 between endpoints t >> 1 and t +- 1 >> 1 is
/// t for every t.
NTC_BC7_LEAF void NtcBc7KeepSolid(NTC_BC7_TEXELS(x), NTC_INOUT(NtcBc7Coding, best)) {
    NtcMask isSolid = NtcSplat(0) == 0;
    NTC_LOOP for (int t = 1; t < 16; t++) {
        NTC_BC7_UNROLL for (int c = 0; c < 4; c++) isSolid =
            NtcMaskAnd(isSolid, NtcBc7Channel(x, t, c) == NtcBc7Channel(x, 0, c));
    }
    best.choice = NtcSelect(isSolid, NtcSplat(5 | NTC_BC7_SOLID), best.choice);
    best.error = NtcSelect(isSolid, NtcSplat(0), best.error);
    NtcLane low = NtcBc7Channel(x, 0, 3) << 24;
    NtcLane high = low;
    NTC_LOOP for (int c = 0; c < 3; c++) {
        NtcLane value = NtcBc7Channel(x, 0, c);
        low = low | ((value >> 1) << (8 * c));
        high = high | (((value + NtcSelect(value < 128, NtcSplat(1), NtcSplat(-1))) >> 1) << (8 * c));
    }
    best.ends.ends[0] = NtcSelect(isSolid, low, best.ends.ends[0]);
    best.ends.ends[1] = NtcSelect(isSolid, high, best.ends.ends[1]);
}

NTC_FUNCTION void NtcBc7Clear(NTC_INOUT(NtcBc7Coding, best)) {
    best.error = NtcSplat(0x7FFFFFFF);
    best.choice = NtcSplat(6);
    NTC_LOOP for (int i = 0; i < 6; i++) best.ends.ends[i] = NtcSplat(0);
}

/// The best coding of a block. x: 0 ... 255, texel t, channel c at [4 t + c]. allowedModes: bit m allows mode
/// m, at least one is set; modes 0 ... 3 decode alpha as 255 whatever it was. hint: NtcBc7Hint of the only
/// coding that is tried, whatever modes are allowed, or negative.
NTC_FUNCTION NtcBc7Coding NtcBc7Search(NTC_BC7_TEXELS(x), int quality, int allowedModes, NtcLane hint) {
    NtcBc7Effort effort = NtcBc7GetEffort(quality);
    NtcBc7Alpha alpha = NtcBc7LookAtAlpha(x);
    NtcBc7Coding best;
    NtcBc7Clear(best);
    NtcMask isFree = hint < 0;
    bool anyFree = NtcAnyLane(isFree);
    // Where alpha is about opaque the modes of colour pay, elsewhere mode 7, unless nothing else is allowed.
    // Told of each lane: what its neighbours are must not matter.
    NtcMask takesColor = isFree;
    if ((allowedModes & 0xF0) != 0)
        takesColor = NtcMaskAnd(isFree, alpha.error < 256);
    NtcMask takesAlpha = isFree;
    if ((allowedModes & 0x7F) != 0)
        takesAlpha = NtcMaskAnd(isFree, alpha.error != 0);

    NtcBc7Ranking ranking;
    NtcBc7ClearRanking(ranking);
    int rotations = 1;
    NtcLane expected = NtcSplat(0); // the rotation, where not all are tried
    if (anyFree) {
        bool wantsColor = NtcAnyLane(takesColor);
        bool wantsAlpha = NtcAnyLane(takesAlpha);
        NTC_LOOP for (int mode = 0; mode < 8; mode++) {
            bool isTried =
                (allowedModes & (1 << mode)) != 0 && (mode < 4 ? wantsColor : mode < 7 || wantsAlpha);
            if (!isTried)
                effort.partitions[mode] = 0;
            else if ((allowedModes & 0x7A) == 0) // else the fast level leaves modes 0 and 2 out
                effort.partitions[mode] = max(effort.partitions[mode], 1);
        }
        NtcBc7Terms terms;
        NtcBc7Spread whole;
        NtcBc7MakeTerms(x, terms, whole);
        if (effort.partitions[1] + effort.partitions[3] > 0)
            NtcBc7Estimate2Color(effort.patterns, terms, whole, ranking);
        if (effort.partitions[0] + effort.partitions[2] > 0)
            NtcBc7Estimate3(effort.partitions[2] > 0 ? 64 : 16, terms, whole, ranking);
        if (effort.partitions[7] > 0)
            NtcBc7Estimate2Both(effort.patterns, terms, whole, ranking);
        rotations = effort.rotations;
        if (rotations == 1)
            expected = NtcBc7EstimateRotation(whole);
    }

    NTC_LOOP for (int mode = 0; mode < 8; mode++) {
        bool isDual = mode == 4 || mode == 5;
        NtcMask isHinted = NtcMaskAnd(NtcMaskNot(isFree), (hint & 7) == mode);
        int count = NtcAnyLane(isHinted) ? 1 : 0;
        if (anyFree)
            count = max(count, effort.partitions[mode]);
        if (isDual)
            count = 0;
        NTC_LOOP for (int i = 0; i < count; i++) {
            NtcLane pattern = NtcSelect(isFree, ranking.keys[NTC_BC7_KEPT * mode + i], hint >> 3);
            pattern = pattern & NtcSplat((1 << kNtcBc7PartitionBits[mode]) - 1);
            // A free lane takes part where the mode is tried at all, a hinted one where it is its own.
            NtcMask isOwn = isHinted;
            if (i < effort.partitions[mode]) {
                if (mode < 4)
                    isOwn = NtcMaskOr(isHinted, takesColor);
                else if (mode == 7)
                    isOwn = NtcMaskOr(isHinted, takesAlpha);
                else
                    isOwn = NtcMaskOr(isHinted, isFree);
            }
            NtcLane forced = NtcSplat(-1);
            if (mode > 3)
                forced = alpha.forced;
            NtcBc7TrySubsets(mode, effort, x, isOwn, pattern, forced, alpha.error, best);
        }
    }
    NTC_LOOP for (int r = 0; r < rotations; r++) {
        NtcLane rotation = NtcSelect(isFree, rotations == 1 ? expected : NtcSplat(r), (hint >> 9) & 3);
        NTC_BC7_DECLARE_TEXELS(y);
        NtcBc7Rotate(x, rotation, y);
        NTC_LOOP for (int i = 0; i < 3; i++) { // modes 5, 4 and 4 with the other selector
            int mode = i == 0 ? 5 : 4;
            int selector = i >> 1;
            NtcMask isOwn = (hint & 7) == mode;
            if (mode == 4)
                isOwn = NtcMaskAnd(isOwn, ((hint >> 11) & 1) == selector);
            isOwn = NtcMaskAnd(isOwn, NtcMaskNot(isFree));
            if (effort.partitions[mode] > 0)
                isOwn = NtcMaskOr(isOwn, isFree);
            if (NtcAnyLane(isOwn))
                NtcBc7TryDual(mode, selector, effort, y, isOwn, rotation, best);
        }
    }
    if ((allowedModes & 0x20) != 0)
        NtcBc7KeepSolid(x, best);
    return best;
}

NTC_LANES_NAMESPACE_END

#endif
