// SPDX-License-Identifier: MIT
// BC6H blocks, unsigned and signed.
#ifndef OPENNTC_BC6_H
#define OPENNTC_BC6_H

#include "openntc/bc/Bc6Block.h"
#include "openntc/bc/Bc6Search.h"
#include "openntc/bc/Bc6Tables.h"
#include "openntc/bc/Lanes.h"

NTC_LANES_NAMESPACE_BEGIN

struct NtcBc6Block {
    NtcLane words[4];
};

/// Ors the lowest bits of value (no others are set) in at a position that all lanes share.
NTC_FUNCTION void NtcBc6Put(NtcLane value, int position, int bits, NTC_INOUT_ARRAY(NtcLane, words, 4)) {
    int word = position >> 5;
    int shift = position & 31;
    words[word] = words[word] | (value << shift);
    if (shift + bits > 32)
        words[word + 1] = words[word + 1] | (value >> (32 - shift));
}

NTC_FUNCTION NtcBc6Block NtcBc6Pack(NtcBc6Choice choice) {
    NtcBc6Block block;
    NTC_UNROLL for (int w = 0; w < 4; w++) {
        block.words[w] = NtcSplat(0);
    }
    NTC_LOOP for (int mode = 0; mode < NTC_BC6_MODES; mode++) {
        NtcMask chosen = choice.mode == mode;
        if (!NtcAnyLane(chosen))
            continue;
        int entry = kNtcBc6Modes[mode];
        NtcLane words[4];
        words[0] = NtcSplat(entry >> 20);
        NTC_UNROLL for (int w = 1; w < 4; w++) {
            words[w] = NtcSplat(0);
        }
        int position = mode < 2 ? 2 : 5;
        NTC_LOOP for (int f = kNtcBc6FirstField[mode]; f < kNtcBc6FirstField[mode + 1]; f++) {
            int component = kNtcBc6Fields[f] & 15;
            int first = (kNtcBc6Fields[f] >> 4) & 15;
            int bits = kNtcBc6Fields[f] >> 8;
            NtcLane value = choice.endpoints[component];
            if (component >= 3 && ((entry >> 5) & 31) != 16)
                value = value - choice.endpoints[component % 3];
            NtcBc6Put((value >> first) & NtcSplat((1 << bits) - 1), position, bits, words);
            position = position + bits;
        }
        NTC_UNROLL for (int w = 0; w < 4; w++) {
            block.words[w] = NtcSelect(chosen, words[w], block.words[w]);
        }
    }
    NtcMask two = choice.mode < NTC_BC6_TWO_SUBSET_MODES;
    NtcBc6Put(NtcSelect(two, choice.pattern, NtcSplat(0)), 77, 5, block.words);
    // Indices lie in words 2 and 3, from bit 82 or 65 on.
    NtcLane anchor = NtcSelect(two, NtcLookup(kNtcBc6Partitions, choice.pattern) >> 16, NtcSplat(0));
    NtcLane bits = NtcSelect(two, NtcSplat(3), NtcSplat(4));
    NtcLane position = NtcSelect(two, NtcSplat(82 - 64), NtcSplat(65 - 64));
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcLane index = NtcBc6Index(choice, t);
        NtcLane low = index << (position & 31);
        NtcLane crossing = index >> NtcLaneClamp(32 - position, 0, 31);
        block.words[2] = block.words[2] | NtcSelect(position < 32, low, NtcSplat(0));
        block.words[3] = block.words[3] | NtcSelect(position < 32, crossing, low);
        position = position + bits;
        if (t == 0)
            position = position - 1;
        else
            position = position - NtcSelect(anchor == t, NtcSplat(1), NtcSplat(0));
    }
    return block;
}

/// halves: 3 texel + channel, from NtcBc6Input of the same isSigned. quality: NTC_BC_QUALITY_*.
NTC_FUNCTION NtcBc6Block NtcEncodeBc6(NTC_IN_ARRAY(NtcLane, halves, 48), int quality, bool isSigned) {
    return NtcBc6Pack(NtcBc6Search(halves, quality, isSigned));
}

NTC_LANES_NAMESPACE_END

#endif
