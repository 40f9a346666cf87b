// SPDX-License-Identifier: MIT
// Stability: internal
// What the blocked kernels of all instruction sets share.
#pragma once

#include "openntc/core/Inline.h"
#include "openntc/core/Processor.h"
#include "openntc/encode/detail/LatentStore.h"

#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Of a tile's texel: inputs of the largest network, padded, or hidden channels.
inline constexpr int kMostChannels = 96;

/// Numbers of a tile in bfloat16, twice: pairs of channels of a texel, and pairs of texels of a channel.
struct PairedOperand {
    /// Odd numbers of cache lines between rows: their columns then lie in all sets of a cache.
    static constexpr int kRowPitch = kMostChannels / 2, kColumnPitch = kMostChannels + 16;

    AlignedBuffer<float> rows, columns; ///< bits of two numbers in each

    PairedOperand()
        : rows(std::size_t{kTileTexels} * kRowPitch), columns(std::size_t{kTileTexels / 2} * kColumnPitch) {}
    const float* GetRow(int texel) const { return rows.data() + texel * kRowPitch; }
    const float* GetColumns() const { return columns.data(); }
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
