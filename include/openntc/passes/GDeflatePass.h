// SPDX-License-Identifier: MIT
// Stability: experimental
// What the compute pass openntc/passes/DecompressGDeflate needs: GDeflate tiles on devices that do not
// decompress them themselves. It never reads or writes beyond a tile's words, whatever the tile's bits.
#pragma once

#include "openntc/inference/LatentDecompression.h"
#include "openntc/passes/GDeflateConstants.h"

#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

static_assert(NTC_GDEFLATE_MAX_BLOCKS == container::detail::kMaxGDeflateBlocks);

/// A dispatch; binding 1 is the work buffer.
struct GDeflateDispatch {
    NtcGDeflateConstants constants{}; ///< push constants; no tiles: nothing to dispatch
    std::uint32_t groups[3] = {0, 1, 1};
};

struct GDeflatePass {
    Array<NtcGDeflateTile> tiles; ///< binding 0
    GDeflateDispatch intoLatents; ///< binding 2 is the latents
    GDeflateDispatch intoWork;    ///< binding 2 is the work buffer
};

namespace detail {

inline Expected<GDeflateDispatch> AddGDeflateTiles(const LatentDecompression& plan, bool inWork,
                                                   Array<NtcGDeflateTile>& tiles) noexcept {
    GDeflateDispatch dispatch;
    dispatch.constants.firstTile = static_cast<std::uint32_t>(tiles.size());
    for (const LatentTile& tile : plan.tiles) {
        if (tile.isInWork == inWork)
            OPENNTC_CHECK(tiles.PushBack({static_cast<std::uint32_t>(tile.source / 4), tile.sourceBytes / 4,
                                          static_cast<std::uint32_t>(tile.destination / 4), tile.bytes}));
    }
    const std::uint32_t count = static_cast<std::uint32_t>(tiles.size()) - dispatch.constants.firstTile;
    dispatch.constants.tiles = count;
    constexpr std::uint32_t kAlongX = NTC_GDEFLATE_GROUPS;
    dispatch.groups[0] = count < kAlongX ? count : kAlongX;
    dispatch.groups[1] = count == 0 ? 1 : (count + kAlongX - 1) / kAlongX;
    return dispatch;
}

} // namespace detail

/// Tiles and dispatches of a plan, in the place of what LatentTile says. Errors: OutOfRange for buffers of
/// 16 GiB or more; OutOfMemory.
inline Expected<GDeflatePass> MakeGDeflatePass(const LatentDecompression& plan,
                                               Allocator& allocator = GetDefaultAllocator()) noexcept {
    constexpr std::uint64_t kMostBytes = std::uint64_t{4} << 32;
    if (plan.workBytes >= kMostBytes || plan.latentBytes >= kMostBytes)
        return Fail(Status::OutOfRange, "latents: %llu bytes, %llu of the work buffer: must be below 2^34",
                    static_cast<unsigned long long>(plan.latentBytes),
                    static_cast<unsigned long long>(plan.workBytes));
    GDeflatePass pass{Array<NtcGDeflateTile>(allocator), {}, {}};
    OPENNTC_ASSIGN(pass.intoLatents, detail::AddGDeflateTiles(plan, false, pass.tiles));
    OPENNTC_ASSIGN(pass.intoWork, detail::AddGDeflateTiles(plan, true, pass.tiles));
    return pass;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
