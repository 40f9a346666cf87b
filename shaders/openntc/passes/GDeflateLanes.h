// SPDX-License-Identifier: MIT
// Bits and symbols of GDeflate, for one of the 32 lanes of a tile. C++ includes this file too.
#ifndef OPENNTC_GDEFLATE_LANES_H
#define OPENNTC_GDEFLATE_LANES_H

#include "openntc/Portability.h"

#define NTC_GDEFLATE_LANES 32
#define NTC_GDEFLATE_END 256u // the symbol that ends a block

NTC_NAMESPACE_BEGIN

/// Up to 64 bits, the next one lowest. A lane whose turn ends holds 32 or more.
struct NtcBitLane {
    uint low;
    uint high;
    uint count;
};

/// Takes off 0 to 31 bits.
NTC_FUNCTION void NtcSkipBits(NTC_INOUT(NtcBitLane, lane), uint bits) {
    if (bits > 0u)
        lane.low = (lane.low >> bits) | (lane.high << (32u - bits));
    lane.high = lane.high >> bits;
    lane.count = lane.count - bits;
}

NTC_FUNCTION uint NtcTakeBits(NTC_INOUT(NtcBitLane, lane), uint bits) {
    uint value = lane.low & ((1u << bits) - 1u);
    NtcSkipBits(lane, bits);
    return value;
}

/// Appends a word to a lane that holds less than one.
NTC_FUNCTION void NtcAppendWord(NTC_INOUT(NtcBitLane, lane), uint word) {
    lane.low = lane.low | (word << lane.count);
    if (lane.count > 0u)
        lane.high = word >> (32u - lane.count);
    lane.count = lane.count + 32u;
}

/// What a length symbol, 257 to 287, stands for: base, and extra bits from bit 20 on.
NTC_FUNCTION uint NtcGetLengthCode(uint symbol) {
    if (symbol >= 285u)
        return 3u | (16u << 20);
    uint code = symbol - 257u;
    if (code < 8u)
        return 3u + code;
    uint extra = code / 4u - 1u;
    return (3u + ((4u + code % 4u) << extra)) | (extra << 20);
}

/// The same of a distance symbol, 0 to 31.
NTC_FUNCTION uint NtcGetDistanceCode(uint symbol) {
    if (symbol < 4u)
        return 1u + symbol;
    uint extra = symbol / 2u - 1u;
    return (1u + ((2u + symbol % 2u) << extra)) | (extra << 20);
}

/// In static blocks, bits of the code of a literal or length symbol, or (from 288 on) of a distance symbol.
NTC_FUNCTION uint NtcGetStaticCodeBits(uint symbol) {
    if (symbol >= 288u)
        return 5u;
    return symbol < 144u ? 8u : (symbol < 256u ? 9u : (symbol < 280u ? 7u : 8u));
}

/// The symbol of which code length number `index` of a dynamic block's header is.
NTC_FUNCTION uint NtcGetPrecodeSymbol(uint index) {
    if (index < 3u)
        return 16u + index;
    if (index == 3u)
        return 0u;
    uint step = (index - 4u) / 2u;
    return index % 2u == 0u ? 8u + step : 7u - step;
}

NTC_NAMESPACE_END

#endif
