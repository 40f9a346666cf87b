// SPDX-License-Identifier: MIT
// Stability: stable
// CRC-32 as in zlib and PNG: reflected polynomial 0xEDB88320, initial and final value inverted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

namespace detail {

using Crc32Tables = std::array<std::array<std::uint32_t, 256>, 8>;

/// Table k is for a byte that k others follow.
constexpr Crc32Tables MakeCrc32Tables() noexcept {
    Crc32Tables tables{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t c = i;
        for (int bit = 0; bit < 8; ++bit)
            c = (c & 1u) != 0 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
        tables[0][i] = c;
    }
    for (std::size_t k = 1; k < 8; ++k) {
        for (std::size_t i = 0; i < 256; ++i) {
            const std::uint32_t c = tables[k - 1][i];
            tables[k][i] = tables[0][c & 0xFFu] ^ (c >> 8);
        }
    }
    return tables;
}

} // namespace detail

/// CRC-32 of `bytes`. Pass the result for the first part as `previous` to continue with the next part.
inline std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t previous = 0) noexcept {
    static constexpr detail::Crc32Tables kTables = detail::MakeCrc32Tables();
    std::uint32_t c = ~previous;
    // Eight bytes at once: of each the table of how many follow it.
    while (bytes.size() >= 8) {
        std::uint32_t next = 0;
        for (std::size_t i = 0; i < 8; ++i) {
            const std::uint32_t old = i < 4 ? c >> (8 * i) : 0;
            next ^= kTables[7 - i][(old ^ static_cast<std::uint32_t>(bytes[i])) & 0xFFu];
        }
        c = next;
        bytes = bytes.subspan(8);
    }
    for (const std::byte b : bytes)
        c = kTables[0][(c ^ static_cast<std::uint32_t>(b)) & 0xFFu] ^ (c >> 8);
    return ~c;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
