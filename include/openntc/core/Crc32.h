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

constexpr std::array<std::uint32_t, 256> MakeCrc32Table() noexcept {
    std::array<std::uint32_t, 256> table{};
    for (std::uint32_t i = 0; i < 256; ++i) {
        std::uint32_t c = i;
        for (int bit = 0; bit < 8; ++bit)
            c = (c & 1u) != 0 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
        table[i] = c;
    }
    return table;
}

} // namespace detail

/// CRC-32 of `bytes`. Pass the result for the first part as `previous` to continue with the next part.
inline std::uint32_t Crc32(std::span<const std::byte> bytes, std::uint32_t previous = 0) noexcept {
    static constexpr std::array<std::uint32_t, 256> kTable = detail::MakeCrc32Table();
    std::uint32_t c = ~previous;
    for (const std::byte b : bytes)
        c = kTable[(c ^ static_cast<std::uint32_t>(b)) & 0xFFu] ^ (c >> 8);
    return ~c;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
