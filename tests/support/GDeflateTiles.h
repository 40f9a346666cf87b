// SPDX-License-Identifier: MIT
// GDeflate tiles that no compressor makes.
#pragma once

#include <cstddef>
#include <vector>

namespace openntc_tests {

/// A tile of one byte, 7, behind `blocks` static blocks of no bytes.
inline std::vector<std::byte> MakeEmptyBlocks(std::size_t blocks) {
    std::vector<bool> bits; // of lane 0, which alone has something to do
    for (std::size_t i = 0; i < blocks; ++i)
        bits.insert(bits.end(), {false, true, false, false, false, false, false, false, false, false});
    bits.insert(bits.end(), {true, true, false, false, false, true, true, false, true, true, true});
    bits.resize((bits.size() + 31) / 32 * 32);
    // The first word is lane 0's, the next 31 are the other lanes', and then it takes one after the other. Lane 1 ends.
    std::vector<std::byte> tile(4 * (31 + 64) + bits.size() / 8);
    for (std::size_t i = 0; i < bits.size(); ++i) {
        const std::size_t at = i / 8 + (i < 32 ? 0 : 4 * 31);
        if (bits[i])
            tile[at] |= static_cast<std::byte>(1u << (i % 8));
    }
    return tile;
}

} // namespace openntc_tests
