// SPDX-License-Identifier: MIT
// Stability: internal
// Huffman codes of limited length for writing DEFLATE's symbols.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

/// Lengths and codes of up to Symbols symbols; a symbol that does not occur has length 0.
template <std::size_t Symbols>
struct HuffmanCode {
    std::array<std::uint8_t, Symbols> lengths{};
    std::array<std::uint16_t, Symbols> codes{}; ///< first bit of the code in bit 0

    /// Shortest codes of at most `maxBits` for these counts, of at least two symbols: readers differ about
    /// codes of one.
    void Make(std::span<const std::uint32_t> counts, unsigned maxBits) noexcept {
        struct Weighted {
            std::uint32_t count;
            std::uint16_t symbol;
        };
        std::array<Weighted, Symbols> used;
        std::size_t n = 0;
        for (std::size_t symbol = 0; symbol < counts.size(); ++symbol) {
            if (counts[symbol] > 0)
                used[n++] = {counts[symbol], static_cast<std::uint16_t>(symbol)};
        }
        for (std::uint16_t symbol = 0; n < 2; ++symbol) {
            if (n == 0 || used[0].symbol != symbol)
                used[n++] = {1, symbol};
        }
        std::sort(used.begin(), used.begin() + static_cast<std::ptrdiff_t>(n),
                  [](const Weighted& a, const Weighted& b) {
                      return a.count != b.count ? a.count < b.count : a.symbol < b.symbol;
                  });
        std::array<std::uint32_t, Symbols> depths;
        for (std::size_t i = 0; i < n; ++i)
            depths[i] = used[i].count;
        FindDepths(std::span(depths).first(n));
        std::array<std::uint32_t, 64> ofLength{};
        for (std::size_t i = 0; i < n; ++i)
            ++ofLength[std::min(depths[i], std::uint32_t{63})];
        Limit(ofLength, maxBits);
        lengths.fill(0);
        std::size_t next = n; // the most frequent first
        for (unsigned length = 1; length <= maxBits; ++length) {
            for (std::uint32_t i = 0; i < ofLength[length]; ++i)
                lengths[used[--next].symbol] = static_cast<std::uint8_t>(length);
        }
        AssignCodes();
    }

    /// The codes that belong to the lengths.
    void AssignCodes() noexcept {
        std::array<std::uint32_t, 17> next{};
        for (const std::uint8_t length : lengths)
            next[length + 1u] += length > 0 ? 1u : 0u;
        for (std::size_t length = 1; length < next.size(); ++length)
            next[length] = (next[length] + next[length - 1]) * 2;
        for (std::size_t symbol = 0; symbol < Symbols; ++symbol) {
            const unsigned length = lengths[symbol];
            std::uint32_t code = length > 0 ? next[length]++ : 0;
            std::uint32_t reversed = 0;
            for (unsigned i = 0; i < length; ++i, code >>= 1)
                reversed = reversed * 2 + (code & 1u);
            codes[symbol] = static_cast<std::uint16_t>(reversed);
        }
    }

private:
    /// Turns ascending counts into the depths of their leaves in a Huffman tree, in place (Moffat and
    /// Katajainen).
    static void FindDepths(std::span<std::uint32_t> a) noexcept {
        const std::size_t n = a.size();
        std::size_t leaf = 2;
        std::size_t root = 0;
        a[0] += a[1];
        for (std::size_t next = 1; next + 1 < n; ++next) { // a[i] becomes the parent of inner node i
            const auto takeSmaller = [&]() -> std::uint32_t {
                if (leaf >= n || (root < next && a[root] < a[leaf])) {
                    const std::uint32_t count = a[root];
                    a[root++] = static_cast<std::uint32_t>(next);
                    return count;
                }
                return a[leaf++];
            };
            const std::uint32_t first = takeSmaller();
            a[next] = first;
            a[next] += takeSmaller();
        }
        a[n - 2] = 0;
        for (std::size_t i = n - 2; i-- > 0;)
            a[i] = a[a[i]] + 1; // depths of inner nodes
        std::size_t available = 1;
        std::size_t inner = n - 1; // one beyond the next inner node to look at
        std::size_t at = n;
        for (std::uint32_t depth = 0; available > 0; ++depth) {
            std::size_t used = 0;
            while (inner > 0 && a[inner - 1] == depth) {
                ++used;
                --inner;
            }
            for (; available > used; --available)
                a[--at] = depth;
            available = 2 * used;
        }
    }

    /// Shortens what is too long at the expense of what is not.
    static void Limit(std::array<std::uint32_t, 64>& ofLength, unsigned maxBits) noexcept {
        for (std::size_t length = maxBits + 1; length < ofLength.size(); ++length) {
            ofLength[maxBits] += ofLength[length];
            ofLength[length] = 0;
        }
        std::uint32_t total = 0;
        for (unsigned length = 1; length <= maxBits; ++length)
            total += ofLength[length] << (maxBits - length);
        for (; total > 1u << maxBits; --total) {
            unsigned length = maxBits - 1;
            while (ofLength[length] == 0)
                --length;
            --ofLength[maxBits];
            --ofLength[length];
            ofLength[length + 1] += 2;
        }
    }
};

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
