// SPDX-License-Identifier: MIT
// What the group of a GDeflate tile shares, and its codes: read from headers, sorted, found. For
// GDeflateGroup.h, whose includer defines what is used here.
#ifndef OPENNTC_GDEFLATE_CODES_H
#define OPENNTC_GDEFLATE_CODES_H

#if defined(__cplusplus)
#error GDeflateCodes.h is GLSL and HLSL only
#endif
#include "GDeflateConstants.h"
#include "GDeflateLanes.h"

#define NTC_GDEFLATE_SYMBOLS 320u // 288 literals and lengths, 32 distances

NTC_GROUP_SHARED uint ntcLow[32];
NTC_GROUP_SHARED uint ntcHigh[32];
NTC_GROUP_SHARED uint ntcBits[32];
NTC_GROUP_SHARED uint ntcScan[32];
NTC_GROUP_SHARED uint ntcMatchAt[32]; // of lanes that know a length and no distance yet
NTC_GROUP_SHARED uint ntcMatchLength[32];
NTC_GROUP_SHARED uint ntcCopyDistance[32];
NTC_GROUP_SHARED uint ntcCopyLanes;    // whose matches have a distance now: a bit for each
NTC_GROUP_SHARED uint ntcLengths[320]; // of codes
NTC_GROUP_SHARED uint ntcSorted[320];  // symbols by length, then by symbol; distances from 288 on
NTC_GROUP_SHARED uint ntcCounts[32];   // codes of each length, of literals; from 16 on of distances
NTC_GROUP_SHARED uint ntcNext;         // word
NTC_GROUP_SHARED uint ntcOut;          // bytes
NTC_GROUP_SHARED uint ntcEnd;          // lane that found the end of the block
NTC_GROUP_SHARED uint ntcIsLast;
NTC_GROUP_SHARED uint ntcType;
NTC_GROUP_SHARED uint ntcStoredBytes;
NTC_GROUP_SHARED uint ntcLiterals; // of the dynamic block
NTC_GROUP_SHARED uint ntcDistances;
NTC_GROUP_SHARED uint ntcIsCorrupt; // 0: it is not

uint NtcGetTileWord(NtcGDeflateTile tile, uint index) {
    uint word = 0u; // and beyond the tile
    if (index < tile.words)
        word = NtcLoadTileWord(tile.firstWord + index);
    return word;
}

NtcBitLane NtcLoadLane(uint lane) {
    NtcBitLane bits;
    bits.low = ntcLow[lane];
    bits.high = ntcHigh[lane];
    bits.count = ntcBits[lane];
    return bits;
}

void NtcStoreLane(uint lane, NtcBitLane bits) {
    ntcLow[lane] = bits.low;
    ntcHigh[lane] = bits.high;
    ntcBits[lane] = bits.count;
}

/// Of one thread, in headers: takes bits of a lane, which gets a word if it holds less than one afterwards.
uint NtcTakeAlone(NtcGDeflateTile tile, uint lane, uint bits, bool isTurnOver) {
    NtcBitLane own = NtcLoadLane(lane);
    uint value = NtcTakeBits(own, bits);
    if (isTurnOver && own.count < 32u) {
        NtcAppendWord(own, NtcGetTileWord(tile, ntcNext));
        ntcNext = ntcNext + 1u;
    }
    NtcStoreLane(lane, own);
    return value;
}

/// Counts and sorts the codes of symbols first ... first + number - 1; by one thread for each length.
void NtcSortCodes(uint first, uint number, uint length, uint counts) {
    uint before = 0u;
    uint own = 0u;
    NTC_LOOP for (uint i = 0u; i < number; i++) {
        uint other = ntcLengths[first + i];
        before = before + (other > 0u && other < length ? 1u : 0u);
        own = own + (other == length ? 1u : 0u);
    }
    ntcCounts[counts + length] = own;
    NTC_LOOP for (uint k = 0u; k < number; k++) {
        if (ntcLengths[first + k] == length) {
            ntcSorted[first + before] = k;
            before = before + 1u;
        }
    }
}

/// True if there are more codes than bits for them.
bool NtcIsOverfull(uint counts) {
    uint free_ = 1u;
    bool isOverfull = false;
    NTC_LOOP for (uint length = 1u; length < 16u; length++) {
        free_ = free_ * 2u;
        isOverfull = isOverfull || ntcCounts[counts + length] > free_;
        free_ = free_ - min(ntcCounts[counts + length], free_);
    }
    return isOverfull;
}

/// The symbol that a lane's bits begin with, and from bit 16 on the bits of its code; 0xFFFFFFFF: none.
uint NtcFindSymbol(uint bits, uint first, uint counts) {
    uint code = 0u;
    uint firstCode = 0u;
    uint place = first;
    uint found = 0xFFFFFFFFu;
    NTC_UNROLL for (uint length = 1u; length < 16u; length++) {
        code = code * 2u + ((bits >> (length - 1u)) & 1u);
        uint number = ntcCounts[counts + length];
        if (found == 0xFFFFFFFFu && code - firstCode < number)
            found = (place + (code - firstCode)) | (length << 16);
        place = place + number;
        firstCode = (firstCode + number) * 2u;
    }
    if (found != 0xFFFFFFFFu)
        found = ntcSorted[found & 0xFFFFu] | (found & 0xFFFF0000u);
    return found;
}

/// Code lengths of a dynamic block, by one thread.
void NtcReadCodeLengths(NtcGDeflateTile tile) {
    ntcLiterals = NtcTakeAlone(tile, 0u, 5u, false) + 257u;
    ntcDistances = NtcTakeAlone(tile, 0u, 5u, false) + 1u;
    uint precodes = NtcTakeAlone(tile, 0u, 4u, true) + 4u;
    NTC_LOOP for (uint p = 0u; p < 19u; p++) {
        uint bits = 0u;
        if (p < precodes)
            bits = NtcTakeAlone(tile, p, 3u, true);
        ntcLengths[NtcGetPrecodeSymbol(p)] = bits;
    }
    NTC_LOOP for (uint length = 1u; length < 16u; length++) NtcSortCodes(0u, 19u, length, 0u);
    if (NtcIsOverfull(0u))
        ntcIsCorrupt = 1u;
    uint known = 0u;
    uint lane = 0u;
    uint last = 0u;
    uint total = ntcLiterals + ntcDistances;
    NTC_LOOP while (known < total && ntcIsCorrupt == 0u) {
        uint found = NtcFindSymbol(ntcLow[lane], 0u, 0u);
        uint symbol = found & 0xFFFFu;
        if (found == 0xFFFFFFFFu || (symbol == 16u && known == 0u)) {
            ntcIsCorrupt = 1u;
        } else {
            uint extra = symbol < 16u ? 0u : (symbol == 16u ? 2u : (symbol == 17u ? 3u : 7u));
            uint value = NtcTakeAlone(tile, lane, (found >> 16) + extra, false);
            value = value >> (found >> 16);
            NtcTakeAlone(tile, lane, 0u, true);
            uint run = symbol < 16u ? 1u : (symbol == 18u ? 11u + value : 3u + value);
            last = symbol < 16u ? symbol : (symbol == 16u ? last : 0u);
            if (run > total - known)
                ntcIsCorrupt = 1u;
            // Lengths of distances go to where those of static blocks are. The precode's, in the first 19
            // places, are not needed any more.
            NTC_LOOP for (uint r = 0u; r < run && ntcIsCorrupt == 0u; r++) {
                uint place = known + r;
                ntcLengths[place < ntcLiterals ? place : 288u + (place - ntcLiterals)] = last;
            }
            known = known + run;
            lane = (lane + 1u) % 32u;
        }
    }
}

#endif
