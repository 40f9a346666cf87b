// SPDX-License-Identifier: MIT
// Stability: internal
// The bits of a GDeflate tile: lanes as the reader serves them, and blocks of symbols.
#pragma once

#include "openntc/container/detail/GDeflateMatches.h"
#include "openntc/container/detail/GDeflateTile.h"
#include "openntc/container/detail/HuffmanCode.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

/// A symbol with the bits that follow its code.
struct ExtraSymbol {
    unsigned symbol;
    unsigned extraBits;
    std::uint32_t extra;
};

constexpr unsigned CountBits(std::uint32_t value) noexcept {
    return static_cast<unsigned>(std::bit_width(value));
}

/// Lengths 3 … 65538; those above 258 have a symbol of their own.
constexpr ExtraSymbol GetLengthSymbol(std::uint32_t length) noexcept {
    const std::uint32_t code = length - 3;
    if (length > 258)
        return {285, 16, code};
    if (code < 8)
        return {257 + code, 0, 0};
    const unsigned bits = CountBits(code) - 3;
    return {257 + 4 * (bits + 1) + ((code >> bits) & 3u), bits, code & ((1u << bits) - 1u)};
}

/// Distances 1 … 65536.
constexpr ExtraSymbol GetDistanceSymbol(std::uint32_t distance) noexcept {
    const std::uint32_t code = distance - 1;
    if (code < 4)
        return {code, 0, 0};
    const unsigned bits = CountBits(code) - 2;
    return {2 * (bits + 1) + ((code >> bits) & 1u), bits, code & ((1u << bits) - 1u)};
}

/// Puts bits where a reader's lanes find them: a word goes to the lane that asks for it first.
class GDeflateLaneWriter {
public:
    explicit GDeflateLaneWriter(std::span<std::uint32_t> words) noexcept : words_(words) {
        for (Lane& lane : lanes_)
            Refill(lane);
    }

    void Put(std::uint32_t value, unsigned bits) noexcept { Put(lanes_[lane_], value, bits); }
    void PutCode(std::uint32_t code, unsigned bits, const ExtraSymbol& symbol) noexcept {
        Put(code, bits);
        Put(symbol.extra, symbol.extraBits);
    }
    /// The reader's turn goes on to the next lane.
    void Advance() noexcept {
        Refill(lanes_[lane_]);
        lane_ = (lane_ + 1) % kGDeflateLanes;
    }
    void RefillOnly() noexcept { Refill(lanes_[lane_]); }
    void Restart() noexcept { lane_ = 0; }
    unsigned GetLane() const noexcept { return lane_; }

    /// Writes what the lanes still hold, and returns how many words there are.
    std::size_t Finish() noexcept {
        for (Lane& lane : lanes_) {
            if (lane.filled > 0)
                words_[lane.places[lane.next % 4]] = static_cast<std::uint32_t>(lane.bits);
        }
        return count_;
    }

private:
    struct Lane {
        std::uint64_t bits = 0;              // written, not yet in a word
        unsigned filled = 0;                 // how many, below 32
        unsigned unread = 0;                 // bits that the reader holds
        std::array<std::uint32_t, 4> places; // words that the reader took in advance
        unsigned next = 0;                   // of the places, the one to fill
        unsigned end = 0;
    };

    void Put(Lane& lane, std::uint32_t value, unsigned bits) noexcept {
        lane.bits |= std::uint64_t{value} << lane.filled;
        lane.filled += bits;
        lane.unread -= bits;
        if (lane.filled < 32)
            return;
        words_[lane.places[lane.next++ % 4]] = static_cast<std::uint32_t>(lane.bits);
        lane.bits >>= 32;
        lane.filled -= 32;
    }
    void Refill(Lane& lane) noexcept {
        if (lane.unread >= 32)
            return;
        lane.unread += 32;
        words_[count_] = 0;
        lane.places[lane.end++ % 4] = static_cast<std::uint32_t>(count_++);
    }

    std::span<std::uint32_t> words_;
    std::size_t count_ = 0;
    unsigned lane_ = 0;
    std::array<Lane, kGDeflateLanes> lanes_{};
};

using LengthCode = HuffmanCode<kLengthSymbols>;
using DistanceCode = HuffmanCode<kDistanceSymbols>;

/// Code lengths as a block's header says them: symbols of runs, then their own code.
struct CodeLengthList {
    struct Item {
        std::uint8_t symbol;
        std::uint8_t extra;
    };
    std::array<Item, kLengthSymbols + kDistanceSymbols> items;
    std::size_t count = 0;
    unsigned literals = 257;
    unsigned distances = 1;
    unsigned precodes = 4;
    HuffmanCode<19> precode;
    std::size_t bits = 0; ///< of the header without the block's first three

    static constexpr std::array<std::uint8_t, 19> kOrder = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                            11, 4,  12, 3, 13, 2, 14, 1, 15};
    static constexpr unsigned GetExtraBits(unsigned symbol) noexcept {
        return symbol == 16 ? 2 : symbol == 17 ? 3 : symbol == 18 ? 7 : 0;
    }

    CodeLengthList(const LengthCode& lengthCode, const DistanceCode& distanceCode) noexcept {
        literals = CountUsed(lengthCode.lengths, 257);
        distances = CountUsed(distanceCode.lengths, 1);
        std::array<std::uint8_t, kLengthSymbols + kDistanceSymbols> all;
        std::copy_n(lengthCode.lengths.begin(), literals, all.begin());
        std::copy_n(distanceCode.lengths.begin(), distances, all.begin() + literals);
        std::array<std::uint32_t, 19> counts{};
        for (std::size_t i = 0; i < literals + distances;)
            i += AddRun(std::span(all).subspan(i, literals + distances - i), counts);
        precode.Make(counts, 7);
        for (unsigned i = 4; i < 19; ++i)
            precodes = precode.lengths[kOrder[i]] > 0 ? i + 1 : precodes;
        bits = 14 + std::size_t{3} * precodes;
        for (std::size_t i = 0; i < count; ++i)
            bits += precode.lengths[items[i].symbol] + GetExtraBits(items[i].symbol);
    }

private:
    static unsigned CountUsed(std::span<const std::uint8_t> lengths, unsigned least) noexcept {
        auto n = static_cast<unsigned>(lengths.size());
        while (n > least && lengths[n - 1] == 0)
            --n;
        return n;
    }

    /// Adds what says the longest run at the start of `rest`, and returns its length.
    std::size_t AddRun(std::span<const std::uint8_t> rest, std::array<std::uint32_t, 19>& counts) noexcept {
        std::size_t run = 1;
        while (run < rest.size() && rest[run] == rest[0])
            ++run;
        Item item{rest[0], 0};
        const bool isAgain = count > 0 && rest[0] != 0 && lastLength_ == rest[0];
        if (rest[0] == 0 && run >= 3) {
            run = std::min<std::size_t>(run, 138);
            item = run <= 10 ? Item{17, static_cast<std::uint8_t>(run - 3)}
                             : Item{18, static_cast<std::uint8_t>(run - 11)};
        } else if (isAgain && run >= 3) {
            run = std::min<std::size_t>(run, 6);
            item = {16, static_cast<std::uint8_t>(run - 3)};
        } else {
            run = 1;
        }
        lastLength_ = rest[0];
        items[count++] = item;
        ++counts[item.symbol];
        return run;
    }

    std::uint8_t lastLength_ = 0;
};

/// How often each symbol of a tile occurs, with the end of the block.
struct GDeflateCounts {
    std::array<std::uint32_t, kLengthSymbols> lengths{};
    std::array<std::uint32_t, kDistanceSymbols> distances{};

    explicit GDeflateCounts(std::span<const GDeflateToken> tokens) noexcept {
        for (const GDeflateToken& token : tokens) {
            if (token.distance == 0) {
                ++lengths[token.literal];
                continue;
            }
            ++lengths[GetLengthSymbol(token.length).symbol];
            ++distances[GetDistanceSymbol(token.distance).symbol];
        }
        lengths[kEndOfBlock] = 1;
    }
};

inline std::size_t CountBlockBits(const GDeflateCounts& counts, const LengthCode& lengths,
                                  const DistanceCode& distances) noexcept {
    std::size_t bits = 0;
    for (unsigned symbol = 0; symbol < kLengthSymbols; ++symbol) {
        const unsigned code = symbol - 257;
        const unsigned extra = symbol < 265 ? 0 : symbol < 285 ? code / 4 - 1 : 16;
        bits += std::size_t{counts.lengths[symbol]} * (lengths.lengths[symbol] + extra);
    }
    for (unsigned symbol = 0; symbol < kDistanceSymbols; ++symbol) {
        const unsigned extra = symbol < 4 ? 0 : symbol / 2 - 1;
        bits += std::size_t{counts.distances[symbol]} * (distances.lengths[symbol] + extra);
    }
    return bits;
}

/// The symbols of a block with its end, each match in two turns of its lane, and the turns that finish them.
inline void WriteSymbols(GDeflateLaneWriter& writer, std::span<const GDeflateToken> tokens,
                         const LengthCode& lengths, const DistanceCode& distances) noexcept {
    std::array<std::uint32_t, kGDeflateLanes> pending{}; // distances
    const auto finishMatch = [&] {
        std::uint32_t& distance = pending[writer.GetLane()];
        if (distance == 0)
            return false;
        const ExtraSymbol symbol = GetDistanceSymbol(distance);
        writer.PutCode(distances.codes[symbol.symbol], distances.lengths[symbol.symbol], symbol);
        distance = 0;
        return true;
    };
    writer.Restart();
    for (std::size_t i = 0; i < tokens.size(); writer.Advance()) {
        if (finishMatch())
            continue;
        const GDeflateToken& token = tokens[i++];
        const ExtraSymbol symbol =
            token.distance == 0 ? ExtraSymbol{token.literal, 0, 0} : GetLengthSymbol(token.length);
        writer.PutCode(lengths.codes[symbol.symbol], lengths.lengths[symbol.symbol], symbol);
        pending[writer.GetLane()] = token.distance;
    }
    while (finishMatch())
        writer.Advance();
    writer.Put(lengths.codes[kEndOfBlock], lengths.lengths[kEndOfBlock]);
    for (unsigned i = 0; i < kGDeflateLanes; ++i) {
        finishMatch();
        writer.Advance();
    }
}

inline void WriteCodeLengths(GDeflateLaneWriter& writer, const CodeLengthList& list) noexcept {
    writer.Put(list.literals - 257, 5);
    writer.Put(list.distances - 1, 5);
    writer.Put(list.precodes - 4, 4);
    writer.RefillOnly();
    for (unsigned i = 0; i < list.precodes; ++i) {
        writer.Put(list.precode.lengths[CodeLengthList::kOrder[i]], 3);
        writer.Advance();
    }
    writer.Restart();
    for (std::size_t i = 0; i < list.count; ++i) {
        const CodeLengthList::Item item = list.items[i];
        writer.Put(list.precode.codes[item.symbol], list.precode.lengths[item.symbol]);
        writer.Put(item.extra, CodeLengthList::GetExtraBits(item.symbol));
        writer.Advance();
    }
}

/// Words of a tile at most: stored, every lane with what it holds in advance.
inline constexpr std::size_t kMaxGDeflateTileWords = (65536 + 8) / 4 + 3 * kGDeflateLanes;

/// Writes a tile as one block of the kind that takes least, and returns its words.
inline std::size_t WriteGDeflateTile(std::span<const std::byte> tile, std::span<const GDeflateToken> tokens,
                                     std::span<std::uint32_t> words) noexcept {
    constexpr std::size_t kMaxStored = 65535;
    const GDeflateCounts counts(tokens);
    LengthCode staticLengths;
    DistanceCode staticDistances;
    for (unsigned i = 0; i < kLengthSymbols; ++i)
        staticLengths.lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
    staticDistances.lengths.fill(5);
    staticLengths.AssignCodes();
    staticDistances.AssignCodes();
    LengthCode lengths;
    DistanceCode distances;
    lengths.Make(counts.lengths, kMaxCodeBits);
    distances.Make(counts.distances, kMaxCodeBits);
    const CodeLengthList list(lengths, distances);
    const std::size_t dynamicBits = list.bits + CountBlockBits(counts, lengths, distances);
    const std::size_t staticBits = CountBlockBits(counts, staticLengths, staticDistances);
    const std::size_t storedBits =
        8 * tile.size() + 16 + (tile.size() > kMaxStored ? 3 + 16 + 32 * kGDeflateLanes : 0);

    GDeflateLaneWriter writer(words);
    const auto begin = [&writer](bool isLast, std::uint32_t type) {
        writer.Restart();
        writer.Put((isLast ? 1u : 0u) | type << 1, 3);
        writer.RefillOnly();
    };
    if (storedBits <= std::min(dynamicBits, staticBits)) {
        for (std::size_t at = 0; at < tile.size();) {
            const std::size_t count = std::min(tile.size() - at, kMaxStored);
            begin(at + count == tile.size(), 0);
            writer.Put(static_cast<std::uint32_t>(count), 16);
            for (std::size_t i = 0; i < count; ++i) {
                writer.Put(static_cast<std::uint32_t>(tile[at++]), 8);
                writer.Advance();
            }
            for (unsigned i = 0; i < kGDeflateLanes; ++i)
                writer.Advance();
        }
    } else if (staticBits <= dynamicBits) {
        begin(true, 1);
        WriteSymbols(writer, tokens, staticLengths, staticDistances);
    } else {
        begin(true, 2);
        WriteCodeLengths(writer, list);
        WriteSymbols(writer, tokens, lengths, distances);
    }
    return writer.Finish();
}

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
