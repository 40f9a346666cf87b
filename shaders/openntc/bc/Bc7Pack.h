// SPDX-License-Identifier: MIT
// BC7: the indices of the coding that was chosen, and the block's bits.
#ifndef OPENNTC_BC7_PACK_H
#define OPENNTC_BC7_PACK_H

#include "openntc/bc/Bc7.h"

NTC_LANES_NAMESPACE_BEGIN

/// Four bits a texel: [0] and [1] those of the colours, [2] and [3] those of alpha in modes 4 and 5.
struct NtcBc7Indices {
    NtcLane words[4];
};

NTC_FUNCTION NtcLane NtcBc7GetSteps(NtcLane choice) {
    NtcLane mode = choice & 7;
    NtcLane steps = (NtcSplat(1) << NtcLookup(kNtcBc7IndexBits, mode)) - 1;
    return NtcSelect(NtcMaskAnd(mode == 4, ((choice >> 11) & 1) != 0), NtcSplat(7), steps);
}

NTC_FUNCTION NtcLane NtcBc7GetAlphaSteps(NtcLane choice) {
    return NtcSelect((choice & 7) == 4, 10 - NtcBc7GetSteps(choice), NtcSplat(3));
}

NTC_FUNCTION NtcLane NtcBc7ExpandLane(NtcLane x, NtcLane bits) {
    return (x << (8 - bits)) | (x >> (2 * bits - 8));
}

/// What NtcBc7AssignShape chooses, for every lane's own mode. x: rotated as the coding says.
NTC_BC7_LEAF void NtcBc7ChooseIndices(NTC_BC7_IN(NtcBc7Coding, coding), NTC_BC7_TEXELS(x),
                                      NTC_INOUT(NtcBc7Indices, indices)) {
    NtcLane zero = NtcSplat(0);
    NtcLane mode = coding.choice & 7;
    NtcMask isDual = NtcMaskOr(mode == 4, mode == 5);
    NtcLane subsets = NtcLookup(kNtcBc7Subsets, mode);
    NtcLane pattern = (coding.choice >> 3) & 63;
    NtcLane subset = NtcSelect(subsets == 3, NtcBc7GetSubsets(3, pattern), NtcBc7GetSubsets(2, pattern));
    subset = NtcSelect(subsets == 1, zero, subset);
    NtcLane colorBits = NtcLookup(kNtcBc7ColorBits, mode);
    NtcLane alphaBits = NtcLaneMax(NtcLookup(kNtcBc7AlphaBits, mode), NtcSplat(5));
    NTC_LOOP for (int plane = 0; plane < 2; plane++) {
        NtcLane steps = plane == 0 ? NtcBc7GetSteps(coding.choice) : NtcBc7GetAlphaSteps(coding.choice);
        NtcLane factor =
            NtcSelect(steps == 3, NtcSplat(85), NtcSelect(steps == 7, NtcSplat(37), NtcSplat(17)));
        NtcLane offset = NtcSelect(steps == 7, zero, NtcSplat(2));
        NtcLane low[12];
        NtcLane delta[12];
        NtcLane length[3];
        NtcLane reciprocal[3];
        NTC_LOOP for (int s = 0; s < 3; s++) {
            length[s] = zero;
            NTC_LOOP for (int c = 0; c < 4; c++) {
                NtcLane bits = c == 3 ? alphaBits : colorBits;
                NtcLane first = NtcBc7ExpandLane((coding.ends.ends[2 * s] >> (8 * c)) & 255, bits);
                NtcLane last = NtcBc7ExpandLane((coding.ends.ends[2 * s + 1] >> (8 * c)) & 255, bits);
                // A channel without a part in this plane's choice has no extent.
                NtcMask isOut = (plane == 0) == (c == 3) ? isDual : NtcMaskAnd(isDual, NtcMaskNot(isDual));
                if (c == 3)
                    isOut = NtcMaskOr(isOut, mode < 4);
                low[4 * s + c] = first;
                delta[4 * s + c] = NtcSelect(isOut, zero, last - first);
                length[s] = length[s] + NtcBc7Square(delta[4 * s + c]);
            }
            reciprocal[s] = NtcBc7Reciprocal(steps, length[s]);
        }
        indices.words[2 * plane] = zero;
        indices.words[2 * plane + 1] = zero;
        NTC_LOOP for (int t = 0; t < 16; t++) {
            NtcMask isSecond = ((subset >> (2 * t)) & 1) != 0;
            NtcMask isThird = ((subset >> (2 * t + 1)) & 1) != 0;
            NtcLane span = NtcSelect(isThird, length[2], NtcSelect(isSecond, length[1], length[0]));
            NtcLane scale =
                NtcSelect(isThird, reciprocal[2], NtcSelect(isSecond, reciprocal[1], reciprocal[0]));
            NtcLane along = zero;
            NtcLane d[4];
            NtcLane y[4];
            NTC_UNROLL for (int c = 0; c < 4; c++) {
                d[c] = NtcSelect(isThird, delta[8 + c], NtcSelect(isSecond, delta[4 + c], delta[c]));
                y[c] = NtcBc7Channel(x, t, c) -
                       NtcSelect(isThird, low[8 + c], NtcSelect(isSecond, low[4 + c], low[c]));
                along = along + y[c] * d[c];
            }
            along = NtcLaneMin(NtcLaneMax(along, zero), span);
            NtcLane below = NtcLaneMin((along * scale) >> 26, steps - 1);
            NtcLane belowWeight = (below * factor + offset) >> 2;
            NtcLane aboveWeight = (below * factor + (offset + factor)) >> 2;
            NtcLane belowError = zero;
            NtcLane aboveError = zero;
            NTC_UNROLL for (int c = 0; c < 4; c++) {
                belowError = belowError + NtcBc7Square(y[c] - ((d[c] * belowWeight + 32) >> 6));
                aboveError = aboveError + NtcBc7Square(y[c] - ((d[c] * aboveWeight + 32) >> 6));
            }
            NtcLane index = NtcSelect(aboveError < belowError, below + 1, below);
            int word = 2 * plane + (t >> 3);
            indices.words[word] = indices.words[word] | (index << (4 * (t & 7)));
        }
    }
    NtcMask isSolid = (coding.choice & NTC_BC7_SOLID) != 0;
    NTC_LOOP for (int word = 0; word < 4; word++) indices.words[word] =
        NtcSelect(isSolid, NtcSplat(word < 2 ? 0x11111111 : 0), indices.words[word]);
}

NTC_LANES_NAMESPACE_END

#if NTC_LANES == 1
NTC_LANES_NAMESPACE_BEGIN

struct NtcBc7Block {
    uint words[4];
};

NTC_FUNCTION void NtcBc7Append(NTC_INOUT(NtcBc7Block, block), NTC_INOUT(int, at), uint value, int count) {
    block.words[at >> 5] |= value << uint(at & 31);
    if ((at & 31) + count > 32)
        block.words[(at >> 5) + 1] |= value >> uint(32 - (at & 31));
    at += count;
}

/// Turns the subset around whose anchor has its index's highest bit set: that bit is not stored.
NTC_FUNCTION bool NtcBc7MustTurn(uint low, uint high, int anchor, int bits) {
    uint word = anchor < 8 ? low : high;
    return ((word >> uint(4 * (anchor & 7) + bits - 1)) & 1u) != 0u;
}

/// The block of one lane's coding. ends: as of NtcBc7Coding; indices: as of NtcBc7Indices.
NTC_FUNCTION NtcBc7Block NtcBc7Pack(int choice, NTC_IN_ARRAY(int, ends, 6), NTC_IN_ARRAY(int, indices, 4)) {
    int mode = choice & 7;
    int pattern = (choice >> 3) & 63;
    int rotation = (choice >> 9) & 3;
    int selector = (choice >> 11) & 1;
    int subsets = kNtcBc7Subsets[mode];
    bool isDual = mode == 4 || mode == 5;
    int indexBits = mode == 4 && selector == 1 ? 3 : kNtcBc7IndexBits[mode];
    int alphaIndexBits = mode == 4 && selector == 0 ? 3 : 2;
    int anchors[3];
    anchors[0] = 0;
    anchors[1] = subsets == 2 ? int(kNtcBc7Anchors2[pattern]) : int(kNtcBc7Anchors3[pattern] & 15u);
    anchors[2] = int(kNtcBc7Anchors3[pattern] >> 4);
    uint partitionBits = 0u; // two a texel
    if (subsets == 2)
        partitionBits = uint(NtcBc7SpreadBits(int(NtcBc7GetPartition2(pattern))));
    if (subsets == 3)
        partitionBits = kNtcBc7Partitions3[pattern];

    uint stored[6];
    uint words[4];
    NTC_UNROLL for (int i = 0; i < 6; i++) stored[i] = uint(ends[i]);
    NTC_UNROLL for (int i = 0; i < 4; i++) words[i] = uint(indices[i]);
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        if (NtcBc7MustTurn(words[0], words[1], anchors[s], indexBits)) {
            uint keep = isDual ? 0xFF000000u : 0u;
            uint first = stored[2 * s];
            stored[2 * s] = (first & keep) | (stored[2 * s + 1] & ~keep);
            stored[2 * s + 1] = (stored[2 * s + 1] & keep) | (first & ~keep);
            uint every = (1u << uint(indexBits)) - 1u;
            NTC_LOOP for (int t = 0; t < 16; t++) {
                if (int((partitionBits >> uint(2 * t)) & 3u) == s)
                    words[t >> 3] ^= every << uint(4 * (t & 7));
            }
        }
    }
    if (isDual && NtcBc7MustTurn(words[2], words[3], 0, alphaIndexBits)) {
        uint first = stored[0];
        stored[0] = (first & 0xFFFFFFu) | (stored[1] & 0xFF000000u);
        stored[1] = (stored[1] & 0xFFFFFFu) | (first & 0xFF000000u);
        words[2] ^= alphaIndexBits == 2 ? 0x33333333u : 0x77777777u;
        words[3] ^= alphaIndexBits == 2 ? 0x33333333u : 0x77777777u;
    }

    NtcBc7Block block;
    NTC_UNROLL for (int i = 0; i < 4; i++) block.words[i] = 0u;
    int at = 0;
    NtcBc7Append(block, at, 1u << uint(mode), mode + 1);
    if (subsets > 1)
        NtcBc7Append(block, at, uint(pattern), kNtcBc7PartitionBits[mode]);
    if (isDual)
        NtcBc7Append(block, at, uint(rotation), 2);
    if (mode == 4)
        NtcBc7Append(block, at, uint(selector), 1);
    int pbits = kNtcBc7PBits[mode];
    uint unit = pbits == NTC_BC7_PBITS_NONE ? 0u : 1u;
    int channels = mode > 3 ? 4 : 3;
    NTC_LOOP for (int c = 0; c < channels; c++) {
        int bits = (c == 3 ? kNtcBc7AlphaBits[mode] : kNtcBc7ColorBits[mode]) - int(unit);
        NTC_LOOP for (int i = 0; i < 2 * subsets; i++)
            NtcBc7Append(block, at, ((stored[i] >> uint(8 * c)) & 255u) >> unit, bits);
    }
    if (pbits == NTC_BC7_PBITS_EACH) {
        NTC_LOOP for (int i = 0; i < 2 * subsets; i++) NtcBc7Append(block, at, stored[i] & 1u, 1);
    }
    if (pbits == NTC_BC7_PBITS_SHARED) {
        NTC_LOOP for (int s = 0; s < subsets; s++) NtcBc7Append(block, at, stored[2 * s] & 1u, 1);
    }
    // Mode 4 stores indices of two bits first, whosever they are.
    bool isSwapped = mode == 4 && selector == 1;
    NTC_LOOP for (int plane = 0; plane < (isDual ? 2 : 1); plane++) {
        bool isAlpha = (plane == 1) != isSwapped;
        int bits = isAlpha ? alphaIndexBits : indexBits;
        NTC_LOOP for (int t = 0; t < 16; t++) {
            uint word = isAlpha ? (t < 8 ? words[2] : words[3]) : (t < 8 ? words[0] : words[1]);
            uint index = (word >> uint(4 * (t & 7))) & 15u;
            bool isAnchor = t == 0 || (subsets > 1 && t == anchors[1]) || (subsets > 2 && t == anchors[2]);
            NtcBc7Append(block, at, index, isAnchor ? bits - 1 : bits);
        }
    }
    return block;
}

/// The block of 16 texels as CompressBlocks has them. quality: NTC_BC_QUALITY_*; hint: NtcBc7Hint, or -1 to
/// search among allowedModes.
NTC_FUNCTION NtcBc7Block NtcEncodeBc7(NTC_BC7_TEXELS(x), int quality, int allowedModes, int hint) {
    NtcBc7Coding coding = NtcBc7Search(x, quality, allowedModes, hint);
    NTC_BC7_DECLARE_TEXELS(y);
    NtcBc7Rotate(x, (coding.choice >> 9) & 3, y);
    NtcBc7Indices indices;
    NtcBc7ChooseIndices(coding, y, indices);
    return NtcBc7Pack(coding.choice, coding.ends.ends, indices.words);
}

NTC_LANES_NAMESPACE_END
#endif

#endif
