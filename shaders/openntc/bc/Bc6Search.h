// SPDX-License-Identifier: MIT
// BC6H: which partitions, modes and endpoints are tried.
#ifndef OPENNTC_BC6_SEARCH_H
#define OPENNTC_BC6_SEARCH_H

#include "openntc/bc/Bc6Block.h"
#include "openntc/bc/Bc6Fit.h"
#include "openntc/bc/Lanes.h"
#include "openntc/bc/Quality.h"

NTC_LANES_NAMESPACE_BEGIN

#define NTC_BC6_RANKS 8 // how many of the partitions and modes are kept in order

/// Inserts a key into keys in ascending order.
NTC_FUNCTION void NtcBc6Insert(NtcLane key, NTC_INOUT_ARRAY(NtcLane, keys, NTC_BC6_RANKS)) {
    NTC_UNROLL for (int i = 0; i < NTC_BC6_RANKS; i++) {
        NtcLane low = NtcLaneMin(key, keys[i]);
        key = NtcLaneMax(key, keys[i]);
        keys[i] = low;
    }
}

/// What a line leaves of a subset's moments: what lies off it, and a 48th of what lies along it for eight
/// indices. In 4096ths; below 2^21.
NTC_FUNCTION NtcLane NtcBc6LineError(NtcBc6Moments moments) {
    NtcLane axis[3];
    NtcBc6Moments m;
    NtcBc6Axis(moments, 2, axis, m);
    NtcLane x = axis[0] * m.v[0] + axis[1] * m.v[1] + axis[2] * m.v[2];
    NtcLane y = axis[0] * m.v[1] + axis[1] * m.v[3] + axis[2] * m.v[4];
    NtcLane z = axis[0] * m.v[2] + axis[1] * m.v[4] + axis[2] * m.v[5];
    NtcLane along = (x >> 4) * axis[0] + (y >> 4) * axis[1] + (z >> 4) * axis[2];
    NtcLane size = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    along = NtcDivide(along, NtcLaneMax(size >> 4, NtcSplat(1)));
    NtcLane left = NtcLaneMax(m.v[0] + m.v[3] + m.v[5] - along, NtcSplat(0)) * 16 + ((along * 85) >> 8);
    NtcLane largest = NtcLaneMax(NtcLaneMax(moments.v[0], moments.v[3]), moments.v[5]);
    NtcLane shift = NtcHighestBit(NtcLaneMax(largest, NtcSplat(1))) - 9 - 16;
    return (left << NtcLaneMax(shift, NtcSplat(0))) >> NtcLaneMax(-shift, NtcSplat(0));
}

/// The partitions of least estimated error, best first: keys whose lowest five bits are the partition.
NTC_FUNCTION void NtcBc6RankPartitions(NTC_IN_ARRAY(NtcLane, x, 48),
                                       NTC_OUT_ARRAY(NtcLane, keys, NTC_BC6_RANKS)) {
    NTC_UNROLL for (int i = 0; i < NTC_BC6_RANKS; i++) {
        keys[i] = NtcSplat(0x7FFFFFFF);
    }
    NtcLane sums[9]; // x y z xx xy xz yy yz zz
    NtcLane products[96];
    NTC_UNROLL for (int i = 0; i < 9; i++) {
        sums[i] = NtcSplat(0);
    }
    NTC_LOOP for (int t = 0; t < 16; t++) {
        products[6 * t] = x[3 * t] * x[3 * t];
        products[6 * t + 1] = x[3 * t] * x[3 * t + 1];
        products[6 * t + 2] = x[3 * t] * x[3 * t + 2];
        products[6 * t + 3] = x[3 * t + 1] * x[3 * t + 1];
        products[6 * t + 4] = x[3 * t + 1] * x[3 * t + 2];
        products[6 * t + 5] = x[3 * t + 2] * x[3 * t + 2];
        NTC_UNROLL for (int c = 0; c < 3; c++) {
            sums[c] = sums[c] + x[3 * t + c];
        }
        NTC_UNROLL for (int i = 0; i < 6; i++) {
            sums[3 + i] = sums[3 + i] + products[6 * t + i];
        }
    }
    NTC_LOOP for (int p = 0; p < 32; p++) {
        int mask = kNtcBc6Partitions[p];
        NtcLane part[9];
        NTC_UNROLL for (int i = 0; i < 9; i++) {
            part[i] = NtcSplat(0);
        }
        int count = 0;
        NTC_LOOP for (int t = 0; t < 16; t++) {
            if (((mask >> t) & 1) != 0) {
                count = count + 1;
                NTC_UNROLL for (int c = 0; c < 3; c++) {
                    part[c] = part[c] + x[3 * t + c];
                }
                NTC_UNROLL for (int i = 0; i < 6; i++) {
                    part[3 + i] = part[3 + i] + products[6 * t + i];
                }
            }
        }
        NtcLane score = NtcSplat(0);
        NTC_LOOP for (int s = 0; s < 2; s++) {
            NtcBc6Moments m;
            m.v[0] = part[3] * count - part[0] * part[0];
            m.v[1] = part[4] * count - part[0] * part[1];
            m.v[2] = part[5] * count - part[0] * part[2];
            m.v[3] = part[6] * count - part[1] * part[1];
            m.v[4] = part[7] * count - part[1] * part[2];
            m.v[5] = part[8] * count - part[2] * part[2];
            score = score + ((NtcBc6LineError(m) * (256 / count)) >> 3);
            count = 16 - count;
            NTC_UNROLL for (int i = 0; i < 9; i++) {
                part[i] = sums[i] - part[i];
            }
        }
        NtcBc6Insert((NtcLaneMin(score, NtcSplat(0x3FFFFFF)) << 5) | p, keys);
    }
}

/// The modes by how far they move the endpoints u, best first: keys whose lowest four bits are the mode.
NTC_FUNCTION void NtcBc6RankModes(NTC_IN_ARRAY(NtcLane, u, 12), int subsets, bool isSigned,
                                  NTC_OUT_ARRAY(NtcLane, keys, NTC_BC6_RANKS)) {
    NTC_UNROLL for (int i = 0; i < NTC_BC6_RANKS; i++) {
        keys[i] = NtcSplat(0x7FFFFFFF);
    }
    int first = subsets == 2 ? 0 : NTC_BC6_TWO_SUBSET_MODES;
    int end = subsets == 2 ? NTC_BC6_TWO_SUBSET_MODES : NTC_BC6_MODES;
    NTC_LOOP for (int mode = first; mode < end; mode++) {
        NtcLane entry = NtcSplat(kNtcBc6Modes[mode]);
        NtcLane q[12];
        NtcBc6QuantizeAll(u, entry, subsets, isSigned, q);
        NtcLane moved = NtcSplat(0);
        NTC_LOOP for (int i = 0; i < 6 * subsets; i++) {
            moved = moved + NtcLaneAbs(NtcBc6Unquantize(q[i], entry & 31, isSigned) - u[i]);
        }
        NtcBc6Insert((moved << 4) | mode, keys);
    }
}

/// Endpoints of one step of a fit: each of the first modes (by `ranks`, which step 0 finds) has `rounds` of
/// endpoints for given indices; those of the first round come from `weights`.
NTC_FUNCTION void NtcBc6PrepareFit(NTC_IN_ARRAY(NtcLane, x, 48), NtcBc6Frame frame, int subsets,
                                   bool isSigned, NtcLane masks, NTC_IN_ARRAY(NtcLane, weights, 16), int step,
                                   int rounds, NTC_INOUT_ARRAY(NtcLane, ranks, NTC_BC6_RANKS),
                                   NTC_INOUT(NtcBc6Choice, choice)) {
    NtcLane origin[16];
    NTC_LOOP for (int t = 0; t < 16; t++) {
        origin[t] = weights[t];
        if (step % rounds != 0)
            origin[t] = NtcBc6Weight(NtcBc6Index(choice, t), subsets);
    }
    NtcLane u[12];
    NtcBc6FitLines(x, frame, subsets, isSigned, masks, origin, u);
    if (step == 0)
        NtcBc6RankModes(u, subsets, isSigned, ranks);
    choice.mode = ranks[step / rounds] & 15;
    NtcBc6QuantizeAll(u, NtcLookup(kNtcBc6Modes, choice.mode), subsets, isSigned, choice.endpoints);
}

/// Moves one component of one endpoint by one: step / 2, down or up. False where the mode has no such
/// endpoint.
NTC_FUNCTION NtcMask NtcBc6PrepareMove(int subsets, bool isSigned, int step,
                                       NTC_INOUT(NtcBc6Choice, choice)) {
    NtcLane entry = NtcLookup(kNtcBc6Modes, choice.mode);
    NtcLane largest = NtcBc6LargestEndpoint(entry & 31, isSigned);
    int which = step >> 1;
    int channel = which % 3;
    NtcLane moved = choice.endpoints[which] + ((step & 1) * 2 - 1);
    NtcLane least = isSigned ? -largest : NtcSplat(0);
    NtcMask exists = NtcMaskAnd(moved >= least, moved <= largest);
    choice.endpoints[which] = moved;
    NtcLane reach = NtcSplat(1) << (((entry >> (5 + 5 * channel)) & 31) - 1);
    NTC_LOOP for (int e = 1; e < 2 * subsets; e++) {
        NtcLane delta = choice.endpoints[3 * e + channel] - choice.endpoints[channel];
        exists = NtcMaskAnd(exists, NtcMaskAnd(delta >= -reach, delta < reach));
    }
    return exists;
}

/// The best block found. halves: 3 texel + channel, from NtcBc6Input of the same isSigned. One subset is
/// fitted, then the partitions of least estimated error; at NTC_BC_QUALITY_BEST the best of one subset and
/// the best of two are moved in small steps as long as that helps. A higher quality tries what a lower one
/// tries, and more.
NTC_FUNCTION NtcBc6Choice NtcBc6Search(NTC_IN_ARRAY(NtcLane, halves, 48), int quality, bool isSigned) {
    NtcLane x[48];
    NTC_LOOP for (int i = 0; i < 48; i++) {
        x[i] = halves[i];
    }
    NtcBc6Frame frame = NtcBc6EnterFrame(x);
    NtcLane keys[NTC_BC6_RANKS];
    NtcLane ranks[NTC_BC6_RANKS];
    NtcLane weights[16];
    NtcBc6RankPartitions(x, keys);
    int partitions = quality == NTC_BC_QUALITY_FAST ? 1 : quality == NTC_BC_QUALITY_NORMAL ? 3 : 8;
    int modes = quality == NTC_BC_QUALITY_FAST ? 1 : 2;
    int rounds = quality == NTC_BC_QUALITY_FAST ? 2 : 3;
    int moves = quality == NTC_BC_QUALITY_BEST ? 3 : 0;
    NtcBc6Choice one;
    one.error = NtcSplat(0x7FFFFFFF);
    one.mode = NtcSplat(NTC_BC6_TWO_SUBSET_MODES);
    one.pattern = NtcSplat(0);
    NTC_LOOP for (int e = 0; e < 12; e++) {
        one.endpoints[e] = NtcSplat(0);
    }
    one.indices[0] = NtcSplat(0);
    one.indices[1] = NtcSplat(0);
    NtcBc6Choice two = one;
    two.mode = NtcSplat(0);
    int fits = 1 + partitions;
    NTC_LOOP for (int job = 0; job < (moves > 0 ? fits + 2 : fits); job++) {
        int subsets = job == 0 || job == fits ? 1 : 2;
        NtcBc6Choice best = one;
        if (subsets == 2)
            best = two;
        NtcBc6Choice choice = best;
        if (subsets == 2 && job < fits)
            choice.pattern = keys[job - 1] & 31;
        NtcLane masks = NtcSplat(0);
        if (subsets == 2)
            masks = NtcLookup(kNtcBc6Partitions, choice.pattern);
        if (job < fits)
            NtcBc6FirstWeights(x, subsets, masks, weights);
        NtcLane before = best.error;
        int steps = job < fits ? modes * rounds : moves * 12 * subsets;
        NTC_LOOP for (int step = 0; step < steps; step++) {
            NtcMask exists = NtcSplat(0) == 0;
            if (job < fits) {
                NtcBc6PrepareFit(x, frame, subsets, isSigned, masks, weights, step, rounds, ranks, choice);
            } else {
                int moveBy = step % (12 * subsets);
                if (moveBy == 0 && step > 0 && !NtcAnyLane(best.error < before))
                    break;
                if (moveBy == 0)
                    before = best.error;
                choice = best;
                exists = NtcBc6PrepareMove(subsets, isSigned, moveBy, choice);
                if (!NtcAnyLane(exists))
                    continue;
            }
            NtcBc6Measure(x, frame, subsets, isSigned, masks, choice);
            NtcBc6Take(NtcMaskAnd(exists, choice.error < best.error), choice, best);
        }
        if (subsets == 2)
            two = best;
        else
            one = best;
    }
    NtcBc6Take(two.error < one.error, two, one);
    return one;
}

NTC_LANES_NAMESPACE_END

#endif
