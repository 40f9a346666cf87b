// SPDX-License-Identifier: MIT
// Bits of device results, as tests compare them.
#pragma once

#include <bit>
#include <cstdint>

namespace openntc_tests {

/// The bits of a binary32 number, subnormal numbers taken as zero: devices may flush them.
inline std::uint32_t GetDeviceBits(std::uint32_t bits) {
    return (bits & 0x7F800000u) == 0 ? bits & 0x80000000u : bits;
}
inline std::uint32_t GetDeviceBits(float value) {
    return GetDeviceBits(std::bit_cast<std::uint32_t>(value));
}

} // namespace openntc_tests
