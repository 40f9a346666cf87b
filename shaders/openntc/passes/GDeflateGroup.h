// SPDX-License-Identifier: MIT
// One GDeflate tile, decompressed by a group of 32 threads, which need not be a subgroup. GLSL and HLSL.
//
// The includer defines, before this file:
//   NTC_GROUP_SHARED              before a variable that the group shares
//   NTC_GROUP_BARRIER()           all threads have come, their shared writes are seen
//   NTC_DEVICE_BARRIER()          the same for the output
//   NtcLoadTileWord(i), NtcLoadOutputWord(i)
//   NtcClearOutputWord(i), NtcOrOutputWord(i, bits)
//   NtcLowerShared(place, value)  place = min(place, value), by threads at once
//   NtcOrShared(place, bits)      place |= bits, likewise
//   NtcLowestBit(x)               number of the lowest bit that is set
// Every thread calls NtcDecompressTile. Whatever the tile's bits, no word outside the given ones is asked
// for.
#ifndef OPENNTC_GDEFLATE_GROUP_H
#define OPENNTC_GDEFLATE_GROUP_H

#include "GDeflateCodes.h"

/// Sum over the ranks up to its own, of each thread.
uint NtcScan(uint rank, uint value) {
    ntcScan[rank] = value;
    NTC_GROUP_BARRIER();
    NTC_UNROLL for (uint step = 1u; step < 32u; step *= 2u) {
        uint other = ntcScan[rank >= step ? rank - step : rank]; // HLSL evaluates both sides of a choice
        other = rank >= step ? other : 0u;
        NTC_GROUP_BARRIER();
        ntcScan[rank] = ntcScan[rank] + other;
        NTC_GROUP_BARRIER();
    }
    return ntcScan[rank];
}

void NtcOrOutputByte(NtcGDeflateTile tile, uint at, uint value) {
    NtcOrOutputWord(tile.outputWord + at / 4u, value << (8u * (at % 4u)));
}

/// By all threads: bytes from `distance` before.
void NtcCopyMatch(NtcGDeflateTile tile, uint lane, uint at, uint length, uint distance) {
    uint lastWord = (at + length - 1u) / 4u;
    NTC_LOOP for (uint word = at / 4u + lane; word <= lastWord; word += 32u) {
        uint bits = 0u;
        NTC_UNROLL for (uint k = 0u; k < 4u; k++) {
            uint place = 4u * word + k;
            if (place >= at && place < at + length) {
                uint from = at - distance + (place - at) % distance;
                uint source = NtcLoadOutputWord(tile.outputWord + from / 4u);
                bits = bits | (((source >> (8u * (from % 4u))) & 255u) << (8u * k));
            }
        }
        NtcOrOutputWord(tile.outputWord + word, bits);
    }
}

/// The matches that have a distance now, in the order of ranks: rank 0 is lane `first`.
void NtcCopyMatches(NtcGDeflateTile tile, uint lane, uint first) {
    uint lanes = ntcCopyLanes; // the same for all threads, as all below
    if (lanes != 0u) {
        NTC_DEVICE_BARRIER();
        uint ranks = first == 0u ? lanes : (lanes >> first) | (lanes << (32u - first));
        NTC_LOOP while (ranks != 0u) {
            uint other = (first + NtcLowestBit(ranks)) % 32u;
            ranks = ranks & (ranks - 1u);
            NtcCopyMatch(tile, lane, ntcMatchAt[other], ntcMatchLength[other], ntcCopyDistance[other]);
            NTC_DEVICE_BARRIER();
        }
        if (((lanes >> lane) & 1u) != 0u)
            ntcMatchLength[lane] = 0u;
        NTC_GROUP_BARRIER();
    }
}

/// Takes the distance of the lane's match; 0: it is none.
uint NtcTakeDistance(uint lane, NTC_INOUT(NtcBitLane, own)) {
    uint found = NtcFindSymbol(own.low, 288u, 16u);
    if (found == 0xFFFFFFFFu)
        return 0u;
    NtcSkipBits(own, found >> 16);
    uint code = NtcGetDistanceCode(found & 0xFFFFu);
    uint distance = (code & 0xFFFFFu) + NtcTakeBits(own, code >> 20);
    return distance > ntcMatchAt[lane] ? 0u : distance;
}

/// Its copy is for NtcCopyMatches, after a barrier.
void NtcAddCopy(uint lane, uint distance) {
    if (distance == 0u) {
        ntcIsCorrupt = 1u;
    } else {
        ntcCopyDistance[lane] = distance;
        NtcOrShared(ntcCopyLanes, 1u << lane);
    }
}

/// A word for each lane whose turn is over and that holds less than one; words come in the order of ranks.
/// `bytes`: what the lane adds to the output. Returns where these begin.
uint NtcEndTurn(NtcGDeflateTile tile, uint lane, uint rank, bool isTurnOver, NtcBitLane own, uint bytes) {
    bool needsWord = isTurnOver && own.count < 32u;
    uint sum = NtcScan(rank, (bytes << 6) | (needsWord ? 1u : 0u)); // 32 x 65538 bytes at most
    uint all = ntcScan[31];
    uint start = ntcOut + (sum >> 6) - bytes;
    if (needsWord)
        NtcAppendWord(own, NtcGetTileWord(tile, ntcNext + (sum & 63u) - 1u));
    NtcStoreLane(lane, own);
    NTC_GROUP_BARRIER();
    if (lane == 0u) {
        ntcOut = ntcOut + (all >> 6);
        ntcNext = ntcNext + (all & 63u);
        // What lanes hold in advance may lie beyond the tile, but no more.
        if (ntcOut > tile.bytes || ntcNext > tile.words + 64u)
            ntcIsCorrupt = 1u;
    }
    NTC_GROUP_BARRIER();
    return start;
}

void NtcDecompressStored(NtcGDeflateTile tile, uint lane) {
    uint length = ntcStoredBytes;
    NTC_LOOP for (uint at = 0u; at < length && ntcIsCorrupt == 0u; at += 32u) {
        NtcBitLane own = NtcLoadLane(lane);
        bool isUsed = at + lane < length;
        uint value = 0u;
        if (isUsed)
            value = NtcTakeBits(own, 8u);
        uint start = NtcEndTurn(tile, lane, lane, isUsed, own, isUsed ? 1u : 0u);
        if (isUsed && ntcIsCorrupt == 0u)
            NtcOrOutputByte(tile, start, value);
        NTC_GROUP_BARRIER();
    }
    NtcBitLane last = NtcLoadLane(lane);
    NtcEndTurn(tile, lane, lane, true, last, 0u); // of no bytes: the header's lane
}

/// A turn of every lane; false when the block has ended.
bool NtcDecompressTurn(NtcGDeflateTile tile, uint lane) {
    NtcBitLane before = NtcLoadLane(lane);
    NtcBitLane own = before;
    bool hasMatch = ntcMatchLength[lane] > 0u;
    bool isRight = true;
    uint symbol = 0u;
    uint bytes = 0u;
    uint distance = 0u;
    if (hasMatch) {
        distance = NtcTakeDistance(lane, own);
    } else {
        uint found = NtcFindSymbol(own.low, 0u, 0u);
        isRight = found != 0xFFFFFFFFu;
        symbol = found & 0xFFFFu;
        if (isRight) {
            NtcSkipBits(own, found >> 16);
            bytes = 1u;
            if (symbol == NTC_GDEFLATE_END)
                NtcLowerShared(ntcEnd, lane);
            else if (symbol > NTC_GDEFLATE_END) {
                uint code = NtcGetLengthCode(symbol);
                bytes = (code & 0xFFFFFu) + NtcTakeBits(own, code >> 20);
            }
        }
    }
    NTC_GROUP_BARRIER();
    uint end = ntcEnd;
    bool isTaken = lane < end; // lanes behind the end have not had their turn
    if (lane > end)
        own = before;
    if (isTaken && hasMatch)
        NtcAddCopy(lane, distance);
    if (isTaken && !isRight)
        ntcIsCorrupt = 1u;
    bool isNew = isTaken && isRight && !hasMatch;
    uint start = NtcEndTurn(tile, lane, lane, isTaken, own, isNew ? bytes : 0u);
    if (isNew && ntcIsCorrupt == 0u) {
        if (symbol < NTC_GDEFLATE_END)
            NtcOrOutputByte(tile, start, symbol);
        else {
            ntcMatchAt[lane] = start;
            ntcMatchLength[lane] = bytes;
        }
    }
    if (ntcIsCorrupt == 0u) // the same for all threads
        NtcCopyMatches(tile, lane, 0u);
    return end == 32u;
}

/// One more turn of every lane, from the one that found the end on, for what they still have to do.
void NtcFinishBlock(NtcGDeflateTile tile, uint lane) {
    uint end = ntcEnd;
    NtcBitLane own = NtcLoadLane(lane);
    NTC_GROUP_BARRIER();
    if (lane == 0u)
        ntcCopyLanes = 0u;
    NTC_GROUP_BARRIER();
    if (ntcMatchLength[lane] > 0u)
        NtcAddCopy(lane, NtcTakeDistance(lane, own));
    NtcEndTurn(tile, lane, (lane + 32u - end) % 32u, true, own, 0u);
    if (ntcIsCorrupt == 0u) // the same for all threads
        NtcCopyMatches(tile, lane, end);
}

/// Type and header of a block, by one thread.
void NtcReadBlockHeader(NtcGDeflateTile tile) {
    ntcIsLast = NtcTakeAlone(tile, 0u, 1u, false);
    ntcType = NtcTakeAlone(tile, 0u, 2u, true);
    ntcLiterals = 288u;
    ntcDistances = 32u;
    if (ntcType == 0u)
        ntcStoredBytes = NtcTakeAlone(tile, 0u, 16u, false);
    else if (ntcType == 2u)
        NtcReadCodeLengths(tile);
    else if (ntcType == 3u)
        ntcIsCorrupt = 1u;
}

void NtcDecompressSymbols(NtcGDeflateTile tile, uint lane) {
    if (ntcType == 1u) {
        NTC_LOOP for (uint i = lane; i < NTC_GDEFLATE_SYMBOLS; i += 32u) ntcLengths[i] =
            NtcGetStaticCodeBits(i);
        NTC_GROUP_BARRIER();
    }
    if (lane % 16u > 0u) // sixteen threads for each kind of symbol
        NtcSortCodes(lane < 16u ? 0u : 288u, lane < 16u ? ntcLiterals : ntcDistances, lane % 16u,
                     lane < 16u ? 0u : 16u);
    NTC_GROUP_BARRIER();
    if (NtcIsOverfull(0u) || NtcIsOverfull(16u))
        ntcIsCorrupt = 1u;
    NTC_GROUP_BARRIER();
    bool goesOn = ntcIsCorrupt == 0u;
    NTC_LOOP while (goesOn) {
        if (lane == 0u) {
            ntcEnd = 32u;
            ntcCopyLanes = 0u;
        }
        NTC_GROUP_BARRIER();
        goesOn = NtcDecompressTurn(tile, lane);
        goesOn = goesOn && ntcIsCorrupt == 0u;
        NTC_GROUP_BARRIER();
    }
    if (ntcIsCorrupt == 0u)
        NtcFinishBlock(tile, lane);
}

/// True if the tile is right, for each thread.
bool NtcDecompressTile(NtcGDeflateTile tile, uint lane) {
    NTC_LOOP for (uint word = lane; word < (tile.bytes + 3u) / 4u; word += 32u)
        NtcClearOutputWord(tile.outputWord + word);
    NtcBitLane bits;
    bits.low = NtcGetTileWord(tile, lane);
    bits.high = 0u;
    bits.count = 32u;
    NtcStoreLane(lane, bits);
    ntcMatchLength[lane] = 0u;
    if (lane == 0u) {
        ntcNext = 32u;
        ntcOut = 0u;
        ntcIsCorrupt = 0u;
    }
    NTC_DEVICE_BARRIER();
    bool goesOn = true;
    uint blocks = 0u;
    NTC_LOOP while (goesOn) {
        if (lane == 0u)
            NtcReadBlockHeader(tile);
        NTC_GROUP_BARRIER();
        if (ntcIsCorrupt == 0u) { // the same for all threads
            if (ntcType == 0u)
                NtcDecompressStored(tile, lane);
            else
                NtcDecompressSymbols(tile, lane);
        }
        NTC_GROUP_BARRIER();
        blocks += 1u;
        goesOn = ntcIsLast == 0u && ntcIsCorrupt == 0u && blocks < uint(NTC_GDEFLATE_MAX_BLOCKS);
        NTC_GROUP_BARRIER();
    }
    return ntcIsCorrupt == 0u && ntcIsLast != 0u && ntcOut == tile.bytes;
}

#endif
