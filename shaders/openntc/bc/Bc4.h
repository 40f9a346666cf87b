// SPDX-License-Identifier: MIT
// BC4 blocks, and the channels of BC3's alpha and BC5.
#ifndef OPENNTC_BC4_H
#define OPENNTC_BC4_H

#include "openntc/bc/Lanes.h"
#include "openntc/bc/Quality.h"

NTC_LANES_NAMESPACE_BEGIN

/// The two words of a block: endpoints in bytes 0 and 1, then sixteen indices of three bits.
struct NtcBc4Block {
    NtcLane words[2];
};

/// Endpoints at the extremes, eight values. x: 0 ... 255.
NTC_FUNCTION NtcBc4Block NtcEncodeBc4(NTC_IN_ARRAY(NtcLane, x, 16)) {
    NtcLane low = x[0];
    NtcLane high = x[0];
    NTC_UNROLL for (int i = 1; i < 16; i++) {
        low = NtcLaneMin(low, x[i]);
        high = NtcLaneMax(high, x[i]);
    }
    NtcLane range = NtcLaneMax(high - low, NtcSplat(1));
    NtcBc4Block block;
    block.words[0] = high | (low << 8);
    block.words[1] = NtcSplat(0);
    NTC_UNROLL for (int t = 0; t < 16; t++) {
        NtcLane step = NtcDivide((high - x[t]) * 14 + range, range * 2); // to nearest of 7 steps from high
        NtcLane index = NtcSelect(step == 0, NtcSplat(0), NtcSelect(step == 7, NtcSplat(1), step + 1));
        index = NtcSelect(high == low, NtcSplat(0), index);
        int bit = 16 + 3 * t;
        if (bit < 32)
            block.words[0] = block.words[0] | (index << bit);
        if (bit >= 32)
            block.words[1] = block.words[1] | (index << (bit - 32));
        if (bit == 31)
            block.words[1] = block.words[1] | (index >> 1);
    }
    return block;
}

NTC_LANES_NAMESPACE_END

#endif
