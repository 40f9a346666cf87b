// SPDX-License-Identifier: MIT
// The tiles of a repeated set: slices of its latents, made when they are asked for.
#pragma once

#include "RepeatedSet.h"

#include "openntc/streaming/TileSource.h"

#include <cstddef>
#include <cstdint>
#include <span>

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
        OPENNTC_CHECK(set_.WriteTile(tile, phase_, destination));
        return TileRead{TileAnswer::Ready, GetTileBytes(tile)};
    }

    std::uint32_t GetSliceRows(std::uint32_t tile,
                               std::span<NtcSliceConstants> rows) const noexcept override {
        return MakeTileSliceRows(set_.GetMetadata(), set_.GetLayout(), tile, rows);
    }

private:
    const RepeatedSet& set_;
    Phase phase_;
};

} // namespace openntc::landscape
