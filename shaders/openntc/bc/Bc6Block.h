// SPDX-License-Identifier: MIT
// BC6H: input, the frame in which a block is searched, candidates, and their error as the decoder yields it.
#ifndef OPENNTC_BC6_BLOCK_H
#define OPENNTC_BC6_BLOCK_H

#include "openntc/bc/Bc6Tables.h"
#include "openntc/bc/Lanes.h"

NTC_LANES_NAMESPACE_BEGIN

/// What a half counts as, from its bits: the sign and the magnitude as an integer, which is how BC6H
/// interpolates and how error is measured here (close to a relative error). NaN is 0, infinity the largest
/// finite value, 31743; negative numbers, -0 among them, are 0 in unsigned blocks. -31743 ... 31743.
NTC_FUNCTION NtcLane NtcBc6Input(NtcLane halfBits, bool isSigned) {
    NtcLane size = halfBits & 0x7FFF;
    size = NtcSelect(size > 0x7C00, NtcSplat(0), NtcLaneMin(size, NtcSplat(0x7BFF)));
    NtcLane negative = isSigned ? -size : NtcSplat(0);
    return NtcSelect((halfBits & 0x8000) != 0, negative, size);
}

/// A block is searched in integers around the middle of its values: x = (half - center) << up >> down, of
/// -2048 ... 2048. Decoded values are limited to `limit` halves from the center, so that 48 squares fit in
/// an int.
struct NtcBc6Frame {
    NtcLane center[3];
    NtcLane up;
    NtcLane down;
    NtcLane limit;
};

/// halves: 3 texel + channel, from NtcBc6Input. Replaced by x.
NTC_FUNCTION NtcBc6Frame NtcBc6EnterFrame(NTC_INOUT_ARRAY(NtcLane, halves, 48)) {
    NtcBc6Frame frame;
    NtcLane range = NtcSplat(1);
    NTC_LOOP for (int c = 0; c < 3; c++) {
        NtcLane low = halves[c];
        NtcLane high = halves[c];
        NTC_LOOP for (int t = 1; t < 16; t++) {
            low = NtcLaneMin(low, halves[3 * t + c]);
            high = NtcLaneMax(high, halves[3 * t + c]);
        }
        frame.center[c] = (low + high) >> 1;
        range = NtcLaneMax(range, high - low);
    }
    NtcLane bits = NtcHighestBit(range) + 1;
    frame.down = NtcLaneMax(bits - 12, NtcSplat(0));
    frame.up = NtcLaneClamp(12 - bits, 0, 4);
    frame.limit = (NtcSplat(4600) << frame.down) >> frame.up;
    NTC_LOOP for (int i = 0; i < 16; i++) {
        NTC_UNROLL for (int c = 0; c < 3; c++) {
            halves[3 * i + c] = ((halves[3 * i + c] - frame.center[c]) << frame.up) >> frame.down;
        }
    }
    return frame;
}

/// A block before it is packed. endpoints: 3 endpoint + channel, quantised, absolute; of one subset the first
/// six. indices: 4 bits each, texels 0 ... 7 and 8 ... 15. error: of squares in the frame.
struct NtcBc6Choice {
    NtcLane error;
    NtcLane mode;
    NtcLane pattern;
    NtcLane endpoints[12];
    NtcLane indices[2];
};

NTC_FUNCTION void NtcBc6Take(NtcMask mask, NtcBc6Choice other, NTC_INOUT(NtcBc6Choice, to)) {
    to.error = NtcSelect(mask, other.error, to.error);
    to.mode = NtcSelect(mask, other.mode, to.mode);
    to.pattern = NtcSelect(mask, other.pattern, to.pattern);
    NTC_UNROLL for (int i = 0; i < 12; i++) {
        to.endpoints[i] = NtcSelect(mask, other.endpoints[i], to.endpoints[i]);
    }
    NTC_UNROLL for (int w = 0; w < 2; w++) {
        to.indices[w] = NtcSelect(mask, other.indices[w], to.indices[w]);
    }
}

/// Index t of a choice.
NTC_FUNCTION NtcLane NtcBc6Index(NtcBc6Choice choice, int t) {
    return ((t < 8 ? choice.indices[0] : choice.indices[1]) >> (4 * (t & 7))) & 15;
}

/// The weight of an index in 64ths; subsets 1: of sixteen, 2: of eight.
NTC_FUNCTION NtcLane NtcBc6Weight(NtcLane index, int subsets) {
    return subsets == 2 ? (index * 585 + 32) >> 6 : (index * 273 + 32) >> 6;
}

/// The largest magnitude of an endpoint of n bits.
NTC_FUNCTION NtcLane NtcBc6LargestEndpoint(NtcLane n, bool isSigned) {
    return isSigned ? (NtcSplat(1) << (n - 1)) - 1 : (NtcSplat(1) << n) - 1;
}

/// The decoder's 16-bit value of an endpoint of n bits: 0 ... 65535, signed -32767 ... 32767.
NTC_FUNCTION NtcLane NtcBc6Unquantize(NtcLane q, NtcLane n, bool isSigned) {
    NtcLane size = NtcLaneAbs(q);
    NtcLane value = ((size << 16) + 0x8000) >> n;
    value = NtcSelect(size == 0, NtcSplat(0), value);
    value =
        NtcSelect(size >= NtcBc6LargestEndpoint(n, isSigned), NtcSplat(isSigned ? 0x7FFF : 0xFFFF), value);
    value = NtcSelect(n == 16, size, value);
    return NtcSelect(q < 0, -value, value);
}

/// The endpoint of n bits whose value is nearest to u. The decoder puts values in the middle of their steps,
/// but the first at 0 and the last at the end.
NTC_FUNCTION NtcLane NtcBc6Quantize(NtcLane u, NtcLane n, bool isSigned) {
    NtcLane size = NtcLaneAbs(u);
    NtcLane q = size >> (16 - n);
    NtcLane inStep = size & ((NtcSplat(1) << (16 - n)) - 1);
    NtcLane quarter = (NtcSplat(1) << (16 - n)) >> 2;
    NtcMask up = NtcMaskAnd(q == 0, inStep >= 3 * quarter);
    NtcMask down = NtcMaskAnd(q == NtcBc6LargestEndpoint(n, isSigned), inStep < quarter);
    q = q + NtcSelect(n == 16, NtcSplat(0),
                      NtcSelect(up, NtcSplat(1), NtcSelect(down, NtcSplat(-1), NtcSplat(0))));
    return NtcSelect(u < 0, -q, q);
}

/// Quantises endpoints u (16-bit values) for a mode (an entry of kNtcBc6Modes), held where its deltas reach.
NTC_FUNCTION void NtcBc6QuantizeAll(NTC_IN_ARRAY(NtcLane, u, 12), NtcLane entry, int subsets, bool isSigned,
                                    NTC_OUT_ARRAY(NtcLane, q, 12)) {
    NtcLane n = entry & 31;
    NTC_LOOP for (int c = 0; c < 3; c++) {
        NtcLane reach = NtcSplat(1) << (((entry >> (5 + 5 * c)) & 31) - 1);
        q[c] = NtcBc6Quantize(u[c], n, isSigned);
        NTC_LOOP for (int e = 1; e < 4; e++) {
            NtcLane other = NtcBc6Quantize(u[3 * e + c], n, isSigned);
            q[3 * e + c] = NtcLaneMax(NtcLaneMin(other, q[c] + reach - 1), q[c] - reach);
            if (e == 1 && subsets == 1)
                break;
        }
    }
    if (subsets == 1) {
        NTC_UNROLL for (int i = 6; i < 12; i++) {
            q[i] = NtcSplat(0);
        }
    }
}

/// Entry k of the palette between two endpoints' 16-bit values, as the decoder computes it, in the frame.
NTC_FUNCTION NtcLane NtcBc6PaletteValue(NtcLane a, NtcLane b, NtcLane weight, NtcLane center,
                                        NtcBc6Frame frame, bool isSigned) {
    NtcLane value = (a * 64 + (b - a) * weight + 32) >> 6;
    NtcLane size = NtcLaneAbs(value) * 31;
    size = isSigned ? size >> 5 : size >> 6;
    NtcLane away = NtcSelect(value < 0, -size, size) - center;
    away = NtcLaneMax(NtcLaneMin(away, frame.limit), -frame.limit);
    return (away << frame.up) >> frame.down;
}

/// Finds the best indices for the choice's mode, partition and endpoints, and the error. masks:
/// kNtcBc6Partitions' entry, 0 for one subset. The texels of which an index bit is not stored have indices
/// of the lower half.
NTC_FUNCTION void NtcBc6Measure(NTC_IN_ARRAY(NtcLane, x, 48), NtcBc6Frame frame, int subsets, bool isSigned,
                                NtcLane masks, NTC_INOUT(NtcBc6Choice, choice)) {
    NtcLane n = NtcLookup(kNtcBc6Modes, choice.mode) & 31;
    int levels = subsets == 2 ? 8 : 16;
    NtcLane palette[48]; // 3 (subset levels + index) + channel
    NTC_LOOP for (int s = 0; s < subsets; s++) {
        NTC_LOOP for (int c = 0; c < 3; c++) {
            NtcLane a = NtcBc6Unquantize(choice.endpoints[6 * s + c], n, isSigned);
            NtcLane b = NtcBc6Unquantize(choice.endpoints[6 * s + 3 + c], n, isSigned);
            NTC_LOOP for (int k = 0; k < levels; k++) {
                palette[3 * (s * levels + k) + c] = NtcBc6PaletteValue(
                    a, b, NtcBc6Weight(NtcSplat(k), subsets), frame.center[c], frame, isSigned);
            }
        }
    }
    choice.error = NtcSplat(0);
    choice.indices[0] = NtcSplat(0);
    choice.indices[1] = NtcSplat(0);
    NtcLane anchors = (NtcSplat(1) << (masks >> 16)) | 1;
    NTC_LOOP for (int t = 0; t < 16; t++) {
        NtcMask second = ((masks >> t) & 1) != 0;
        NtcMask isAnchor = ((anchors >> t) & 1) != 0;
        NtcLane least = NtcSplat(0x7FFFFFFF);
        NtcLane index = NtcSplat(0);
        NTC_LOOP for (int k = 0; k < levels; k++) {
            NtcLane error = NtcSplat(0);
            NTC_UNROLL for (int c = 0; c < 3; c++) {
                NtcLane value = palette[3 * k + c];
                if (subsets == 2)
                    value = NtcSelect(second, palette[3 * (8 + k) + c], value);
                NtcLane difference = value - x[3 * t + c];
                error = error + difference * difference;
            }
            if (2 * k >= levels)
                error = NtcSelect(isAnchor, NtcSplat(0x7FFFFFFF), error);
            NtcMask better = error < least;
            least = NtcSelect(better, error, least);
            index = NtcSelect(better, NtcSplat(k), index);
        }
        choice.error = choice.error + least;
        if (t < 8)
            choice.indices[0] = choice.indices[0] | (index << (4 * t));
        else
            choice.indices[1] = choice.indices[1] | (index << (4 * (t - 8)));
    }
}

NTC_LANES_NAMESPACE_END

#endif
