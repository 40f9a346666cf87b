// SPDX-License-Identifier: MIT
// Stability: internal
// Decoding of canonical Huffman codes of 1 to 15 bits that come first bit first, as in DEFLATE.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

inline constexpr unsigned kMaxCodeBits = 15;

/// What a symbol stands for: base + extra bits that follow the code.
struct SymbolEntry {
    unsigned base;  ///< below 65536
    unsigned extra; ///< 0 … 16
    std::uint32_t flags;
};

/// A symbol found: its code's length, what it stands for. Zero: no code.
class HuffmanEntry {
public:
    static constexpr std::uint32_t kLiteral = 1u << 10;
    static constexpr std::uint32_t kEnd = 1u << 11;

    constexpr HuffmanEntry() noexcept = default;
    constexpr HuffmanEntry(SymbolEntry symbol, unsigned codeBits) noexcept
        : bits_(codeBits | (codeBits + symbol.extra) << 5 | symbol.flags | symbol.base << 16) {}

    constexpr bool IsValid() const noexcept { return bits_ != 0; }
    constexpr bool IsLiteral() const noexcept { return (bits_ & kLiteral) != 0; }
    constexpr bool IsEnd() const noexcept { return (bits_ & kEnd) != 0; }
    constexpr unsigned GetCodeBits() const noexcept { return bits_ & 31u; }
    constexpr unsigned GetAllBits() const noexcept { return (bits_ >> 5) & 31u; }
    constexpr unsigned GetValue() const noexcept { return bits_ >> 16; }
    /// Base and extra bits, of the bits that begin with the code.
    constexpr std::size_t GetValue(std::uint64_t bits) const noexcept {
        const std::uint64_t mask = (std::uint64_t{1} << GetAllBits()) - 1;
        return GetValue() + static_cast<std::size_t>((bits & mask) >> GetCodeBits());
    }

private:
    std::uint32_t bits_ = 0;
};

/// Codes of up to TableBits are looked up; longer ones, which are rare, searched by length.
template <unsigned TableBits, std::size_t Symbols>
class HuffmanTable {
public:
    /// False if the lengths ask for more codes than there are. Bits that no code has are allowed; Find tells.
    template <typename GetEntry>
    bool Build(std::span<const std::uint8_t> lengths, GetEntry getEntry) noexcept {
        counts_.fill(0);
        for (const std::uint8_t length : lengths)
            ++counts_[length];
        counts_[0] = 0;
        std::uint32_t free = 1;
        std::array<std::uint16_t, kMaxCodeBits + 2> places{}; // in sorted_, of the first symbol of a length
        std::array<std::uint32_t, kMaxCodeBits + 2> codes{};  // the next code of a length
        for (unsigned length = 1; length <= kMaxCodeBits; ++length) {
            free *= 2;
            if (counts_[length] > free)
                return false;
            free -= counts_[length];
            places[length + 1] = static_cast<std::uint16_t>(places[length] + counts_[length]);
            codes[length + 1] = (codes[length] + counts_[length]) * 2;
        }
        table_.fill({});
        for (unsigned symbol = 0; symbol < lengths.size(); ++symbol) {
            const unsigned length = lengths[symbol];
            if (length == 0)
                continue;
            const HuffmanEntry entry(getEntry(symbol), length);
            sorted_[places[length]++] = entry;
            const std::uint32_t code = codes[length]++;
            if (length > TableBits)
                continue;
            for (std::size_t i = Reverse(code, length); i < table_.size(); i += std::size_t{1} << length)
                table_[i] = entry;
        }
        return true;
    }

    /// The symbol whose code `bits` begin with, or an entry that is not valid.
    HuffmanEntry Find(std::uint64_t bits) const noexcept {
        const HuffmanEntry entry = table_[static_cast<std::size_t>(bits) & (table_.size() - 1)];
        return entry.IsValid() ? entry : FindLong(bits);
    }

private:
    static std::uint32_t Reverse(std::uint32_t code, unsigned length) noexcept {
        std::uint32_t reversed = 0;
        for (unsigned i = 0; i < length; ++i)
            reversed |= ((code >> i) & 1u) << (length - 1 - i);
        return reversed;
    }

    HuffmanEntry FindLong(std::uint64_t bits) const noexcept {
        std::uint32_t code = 0;
        std::uint32_t first = 0;
        std::size_t place = 0;
        for (unsigned length = 1; length <= kMaxCodeBits; ++length) {
            code = code * 2 + static_cast<std::uint32_t>(bits & 1u);
            bits >>= 1;
            if (code - first < counts_[length])
                return sorted_[place + (code - first)];
            place += counts_[length];
            first = (first + counts_[length]) * 2;
        }
        return {};
    }

    std::array<HuffmanEntry, std::size_t{1} << TableBits> table_;
    std::array<HuffmanEntry, Symbols> sorted_; // by length, then by symbol
    std::array<std::uint16_t, kMaxCodeBits + 1> counts_;
};

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
