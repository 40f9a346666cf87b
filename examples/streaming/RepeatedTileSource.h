// SPDX-License-Identifier: MIT
// The tiles of a repeated set: slices of its latents, made when they are asked for.
#pragma once

#include "RepeatedSet.h"

#include "openntc/streaming/TileSource.h"

#include <algorithm>

namespace openntc::landscape {

/// The set must outlive it.
class RepeatedTileSource final : public TileSource {
public:
    RepeatedTileSource(const RepeatedSet& set, Phase phase) noexcept : set_(set), phase_(phase) {}

    const TileLayout& GetLayout() const noexcept override { return set_.GetLayout(); }
    std::size_t GetTileBytes(std::uint32_t tile) const noexcept override { return set_.GetTileBytes(tile); }
    std::size_t GetLargestTileBytes() const noexcept override { return set_.GetLargestTileBytes(); }

    Expected<TileRead> ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                const TileCancellation&) override {
        OPENNTC_ASSIGN(const SliceLayout slice, set_.GetTileSlice(tile));
        set_.WriteSlice(slice, phase_, destination);
        return TileRead{TileAnswer::Ready, static_cast<std::size_t>(slice.bytes)};
    }

    std::uint32_t GetSliceRows(std::uint32_t tile,
                               std::span<NtcSliceConstants> rows) const noexcept override {
        const auto slice = set_.GetTileSlice(tile);
        const auto texels = set_.GetLayout().GetTileSlice(tile);
        if (!slice || !texels)
            return 0;
        const bool isTail = tile >= static_cast<std::uint32_t>(set_.GetLayout().GetRegularTileCount());
        const std::size_t count = std::min(rows.size(), isTail ? static_cast<std::size_t>(texels->mips) : 1);
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t mip = static_cast<std::size_t>(texels->firstMip) + i;
            rows[i] = MakeSliceConstants(*slice, set_.GetMetadata().GetColorMips()[mip].neuralMip);
        }
        return static_cast<std::uint32_t>(count);
    }

private:
    const RepeatedSet& set_;
    Phase phase_;
};

} // namespace openntc::landscape
