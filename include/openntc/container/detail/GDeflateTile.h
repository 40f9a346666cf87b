// SPDX-License-Identifier: MIT
// Stability: internal
// One tile of a GDeflate stream: DEFLATE symbols over 32 interleaved lanes. No memory of its own but 16 KB of
// stack; every read is bounded by the input and every write by the output. Source: the format specification,
// generations, "tile bit stream".
#pragma once

#include "openntc/container/detail/HuffmanTable.h"
#include "openntc/core/Expected.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

inline constexpr unsigned kGDeflateLanes = 32;
inline constexpr std::size_t kLengthSymbols = 288;
inline constexpr std::size_t kDistanceSymbols = 32;
inline constexpr unsigned kEndOfBlock = 256;

/// Lanes of bits that share one input. A lane whose turn ends holds 32 bits or more.
class GDeflateLanes {
public:
    explicit GDeflateLanes(std::span<const std::byte> input) noexcept
        : next_(input.data()), end_(input.data() + input.size()) {
        for (unsigned lane = 0; lane < kGDeflateLanes; ++lane)
            Refill(lane);
    }

    std::uint64_t Peek(unsigned lane) const noexcept { return bits_[lane]; }
    void Skip(unsigned lane, unsigned count) noexcept {
        bits_[lane] >>= count;
        counts_[lane] -= count;
    }
    unsigned Take(unsigned lane, unsigned count) noexcept {
        const auto value = static_cast<unsigned>(bits_[lane]) & ((1u << count) - 1u);
        Skip(lane, count);
        return value;
    }
    /// Appends the next word of the input to a lane that holds less than one.
    void Refill(unsigned lane) noexcept {
        if (counts_[lane] >= 32)
            return;
        std::uint32_t word = 0;
        if (end_ - next_ >= 4) [[likely]] {
            std::memcpy(&word, next_, 4);
            next_ += 4;
        } else {
            for (unsigned shift = 0; next_ != end_; shift += 8)
                word |= static_cast<std::uint32_t>(*next_++) << shift;
            ++wordsBeyond_;
        }
        bits_[lane] |= std::uint64_t{word} << counts_[lane];
        counts_[lane] += 32;
    }
    /// Zeros follow the input: what lanes hold in advance may be among them, but no more.
    bool HasEnded() const noexcept { return wordsBeyond_ > 2 * kGDeflateLanes; }

private:
    std::array<std::uint64_t, kGDeflateLanes> bits_{};
    std::array<std::uint32_t, kGDeflateLanes> counts_{};
    const std::byte* next_;
    const std::byte* end_;
    unsigned wordsBeyond_ = 0;
};

/// Copies `length` bytes from `distance` before them. Bytes behind them may be there already.
inline void CopyMatch(std::byte* to, std::size_t distance, std::size_t length) noexcept {
    const std::byte* from = to - distance;
    if (distance < 8) {
        for (std::size_t i = 0; i < length; ++i)
            to[i] = from[i];
        return;
    }
    std::byte* const end = to + length;
    for (; end - to >= 8; to += 8, from += 8)
        std::memcpy(to, from, 8);
    while (to != end)
        *to++ = *from++;
}

/// A tile being decoded.
/// Blocks of a tile. A block of no bytes takes 10 bits, and time as any other: without a limit a tile could
/// take a thousand times a sound one's. Compressors make blocks of thousands of bytes.
inline constexpr unsigned kMaxGDeflateBlocks = 256;

class GDeflateTile {
public:
    GDeflateTile(std::span<const std::byte> input, std::span<std::byte> output) noexcept
        : lanes_(input), begin_(output.data()), out_(output.data()), end_(output.data() + output.size()) {}

    /// What is wrong with the tile, or null.
    const char* Decode() noexcept {
        bool isLast = false;
        for (unsigned blocks = 0; !isLast; ++blocks) {
            if (blocks == kMaxGDeflateBlocks)
                return "more than 256 blocks";
            lane_ = 0;
            isLast = lanes_.Take(0, 1) != 0;
            const unsigned type = lanes_.Take(0, 2);
            lanes_.Refill(0);
            const char* wrong = "a block: of type 3";
            if (type == 0)
                wrong = DecodeStored();
            else if (type == 1)
                wrong = DecodeStatic();
            else if (type == 2)
                wrong = DecodeDynamic();
            if (wrong != nullptr)
                return wrong;
            if (lanes_.HasEnded())
                return kCutShort;
        }
        return out_ == end_ ? nullptr : "too few bytes";
    }

private:
    static constexpr const char* kCutShort = "cut short";
    static constexpr const char* kTooLong = "too many bytes";
    static constexpr const char* kNoCode = "bits that are no code";

    void Advance() noexcept {
        lanes_.Refill(lane_);
        lane_ = (lane_ + 1) % kGDeflateLanes;
    }

    const char* DecodeStored() noexcept {
        const std::size_t length = lanes_.Take(0, 16);
        if (length > static_cast<std::size_t>(end_ - out_))
            return kTooLong;
        for (std::size_t i = 0; i < length; ++i) {
            *out_++ = static_cast<std::byte>(lanes_.Take(lane_, 8));
            Advance();
        }
        return FinishBlock();
    }

    const char* DecodeStatic() noexcept {
        std::array<std::uint8_t, kLengthSymbols + kDistanceSymbols> lengths;
        for (std::size_t i = 0; i < kLengthSymbols; ++i)
            lengths[i] = i < 144 ? 8 : i < 256 ? 9 : i < 280 ? 7 : 8;
        for (std::size_t i = 0; i < kDistanceSymbols; ++i)
            lengths[kLengthSymbols + i] = 5;
        return DecodeSymbols(lengths, kLengthSymbols, kDistanceSymbols);
    }

    const char* DecodeDynamic() noexcept {
        const std::size_t literals = lanes_.Take(0, 5) + 257;
        const std::size_t distances = lanes_.Take(0, 5) + 1;
        const std::size_t precodes = lanes_.Take(0, 4) + 4;
        lanes_.Refill(0);
        constexpr std::array<std::uint8_t, 19> kOrder = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                                         11, 4,  12, 3, 13, 2, 14, 1, 15};
        std::array<std::uint8_t, 19> precodeLengths{};
        for (std::size_t i = 0; i < precodes; ++i) {
            precodeLengths[kOrder[i]] = static_cast<std::uint8_t>(lanes_.Take(lane_, 3));
            Advance();
        }
        HuffmanTable<7, 19> precode;
        if (!precode.Build(precodeLengths, [](unsigned symbol) { return SymbolEntry{symbol, 0, 0}; }))
            return "code lengths of code lengths: more codes than there are bits for";
        std::array<std::uint8_t, kLengthSymbols + kDistanceSymbols> lengths{};
        lane_ = 0;
        for (std::size_t known = 0; known < literals + distances;) {
            const HuffmanEntry entry = precode.Find(lanes_.Peek(lane_));
            if (!entry.IsValid())
                return kNoCode;
            lanes_.Skip(lane_, entry.GetCodeBits());
            const unsigned symbol = entry.GetValue();
            std::size_t run = 1;
            std::uint8_t length = static_cast<std::uint8_t>(symbol);
            if (symbol >= 16) {
                if (symbol == 16 && known == 0)
                    return "code lengths: one repeated before the first";
                length = symbol == 16 ? lengths[known - 1] : std::uint8_t{0};
                run = symbol == 16   ? 3 + lanes_.Take(lane_, 2)
                      : symbol == 17 ? 3 + lanes_.Take(lane_, 3)
                                     : 11 + lanes_.Take(lane_, 7);
            }
            if (run > literals + distances - known)
                return "code lengths: more than there are symbols";
            std::memset(lengths.data() + known, length, run);
            known += run;
            Advance();
        }
        return DecodeSymbols(lengths, literals, distances);
    }

    /// `lengths` of codes: those of literals and lengths, then those of distances.
    const char* DecodeSymbols(std::span<const std::uint8_t> lengths, std::size_t literals,
                              std::size_t distances) noexcept {
        if (!symbols_.Build(lengths.first(literals), GetLengthEntry) ||
            !distances_.Build(lengths.subspan(literals, distances), GetDistanceEntry))
            return "code lengths: more codes than there are bits for";
        lane_ = 0;
        for (;;) {
            if (IsPending()) {
                if (const char* wrong = FinishMatch(); wrong != nullptr)
                    return wrong;
                Advance();
                continue;
            }
            const std::uint64_t bits = lanes_.Peek(lane_);
            const HuffmanEntry entry = symbols_.Find(bits);
            lanes_.Skip(lane_, entry.GetAllBits());
            if (entry.IsLiteral()) {
                if (out_ == end_)
                    return kTooLong;
                *out_++ = static_cast<std::byte>(entry.GetValue());
                Advance();
                continue;
            }
            if (!entry.IsValid())
                return kNoCode;
            if (entry.IsEnd())
                break;
            const std::size_t length = entry.GetValue(bits);
            if (length > static_cast<std::size_t>(end_ - out_))
                return kTooLong;
            matches_[lane_] = {out_, length};
            pending_ |= 1u << lane_;
            out_ += length;
            Advance();
            if (lanes_.HasEnded())
                return kCutShort;
        }
        return FinishBlock();
    }

    bool IsPending() const noexcept { return ((pending_ >> lane_) & 1u) != 0; }

    /// The distance of the lane's match, and the copy.
    const char* FinishMatch() noexcept {
        const std::uint64_t bits = lanes_.Peek(lane_);
        const HuffmanEntry entry = distances_.Find(bits);
        if (!entry.IsValid())
            return kNoCode;
        lanes_.Skip(lane_, entry.GetAllBits());
        const std::size_t distance = entry.GetValue(bits);
        const Match& match = matches_[lane_];
        if (distance > static_cast<std::size_t>(match.at - begin_))
            return "a match from before the start";
        CopyMatch(match.at, distance, match.length);
        pending_ &= ~(1u << lane_);
        return nullptr;
    }

    /// One more turn of every lane, for what they still have to do.
    const char* FinishBlock() noexcept {
        for (unsigned i = 0; i < kGDeflateLanes; ++i) {
            if (IsPending()) {
                if (const char* wrong = FinishMatch(); wrong != nullptr)
                    return wrong;
            }
            Advance();
        }
        return nullptr;
    }

    /// Base and extra bits of literals, of the end, and of lengths.
    static SymbolEntry GetLengthEntry(unsigned symbol) noexcept {
        if (symbol < kEndOfBlock)
            return {symbol, 0, HuffmanEntry::kLiteral};
        if (symbol == kEndOfBlock)
            return {0, 0, HuffmanEntry::kEnd};
        if (symbol >= 285)
            return {3, 16, 0};
        const unsigned code = symbol - 257;
        const unsigned extra = code < 8 ? 0 : code / 4 - 1;
        return {3 + (code < 8 ? code : (4 + code % 4) << extra), extra, 0};
    }
    static SymbolEntry GetDistanceEntry(unsigned symbol) noexcept {
        const unsigned extra = symbol < 4 ? 0 : symbol / 2 - 1;
        return {1 + (symbol < 4 ? symbol : (2 + symbol % 2) << extra), extra, 0};
    }

    struct Match {
        std::byte* at;
        std::size_t length;
    };

    GDeflateLanes lanes_;
    unsigned lane_ = 0;
    std::uint32_t pending_ = 0; // a bit for each lane whose match has no distance yet
    std::byte* begin_;
    std::byte* out_;
    std::byte* end_;
    std::array<Match, kGDeflateLanes> matches_;
    HuffmanTable<10, kLengthSymbols> symbols_;
    HuffmanTable<8, kDistanceSymbols> distances_;
};

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
