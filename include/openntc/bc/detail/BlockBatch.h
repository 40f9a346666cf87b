// SPDX-License-Identifier: MIT
// Stability: internal
// What the CPU encoder hands to the kernel of one instruction set: as many blocks as it has lanes.
#pragma once

#include "openntc/bc/BlockFormat.h"

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

/// How much search an encoder does. Values equal NTC_BC_QUALITY_*.
enum class BlockQuality : std::uint8_t { Fast = 0, Normal = 1, Best = 2 };

inline constexpr int kMaxLanes = 16;

/// Texel t (row by row), channel c of lane l is texels[(4 t + c) lanes + l]: 0 … 255, -127 … 127 for signed
/// formats, bits of a half (sign-extended to 32 bits) for Bc6. Words of lane l: words[4 l …], of which Bc1
/// and Bc4 use the first two.
struct BlockBatch {
    alignas(64) std::int32_t texels[64 * kMaxLanes];
    /// Instead of texels for Bc1 to Bc5: texel t of lane l is packed[t lanes + l], R in the lowest byte.
    alignas(64) std::uint32_t packed[16 * kMaxLanes];
    bool isSigned = false; ///< of packed
    std::uint32_t words[4 * kMaxLanes];
    std::int32_t hints[kMaxLanes]; ///< Bc7: what NtcBc7Hint packs, or -1: search
    BlockQuality quality = BlockQuality::Normal;
    std::int32_t alphaThreshold = 0;   ///< Bc1: texels whose alpha is at most this are transparent; -1: none
    std::uint32_t allowedModes = 0xFF; ///< Bc7: bit m allows mode m
};

using EncodeLanes = void (*)(BlockBatch& batch) noexcept;

/// One instruction set's encoders, by format. Null: there is none.
struct BlockKernels {
    int lanes;
    EncodeLanes encode[kBlockFormatCount];
};

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
