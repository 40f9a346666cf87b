// SPDX-License-Identifier: MIT
// Stability: experimental
// Where tiles come from: the interface of a source, and sources that are pixels in memory.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Shared.h"
#include "openntc/streaming/TileLayout.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Lets a source that takes its time see that nobody wants the tile any more. Copies refer to the same flag.
class TileCancellation {
public:
    TileCancellation() noexcept = default;
    explicit TileCancellation(const std::atomic<bool>& flag) noexcept : flag_(&flag) {}
    bool IsCancelled() const noexcept { return flag_ != nullptr && flag_->load(std::memory_order_relaxed); }

private:
    const std::atomic<bool>* flag_ = nullptr;
};

enum class TileAnswer {
    Ready, ///< the data are there
    Later, ///< not yet: the tile stays missing, and is asked for again
};

struct TileRead {
    TileAnswer answer = TileAnswer::Ready;
    std::size_t bytes = 0; ///< written; fewer than GetTileBytes is an error of the tile
};

/// Tiles of one texture. All methods may be called by several threads at once; ReadTile may be called for
/// several tiles at once and twice for one. Everything else always gives the same answer.
class TileSource {
public:
    virtual ~TileSource() = default;

    /// How the texture is cut up.
    virtual const TileLayout& GetLayout() const noexcept = 0;

    /// Bytes of a tile, 1 or more, for tile = 0 … GetLayout().GetTileCount() - 1. A partial tile at the right
    /// or lower edge may be smaller, or padded by the source.
    virtual std::size_t GetTileBytes(std::uint32_t tile) const noexcept = 0;

    /// No tile has more bytes: what slots are sized for.
    virtual std::size_t GetLargestTileBytes() const noexcept = 0;

    /// Writes the tile to the front of `destination`, which has GetTileBytes(tile) bytes. May block, and may
    /// throw where exceptions are on: that is an error of the tile as well. An error's text is what the user
    /// reads: name the file, and what is wrong.
    virtual Expected<TileRead> ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                        const TileCancellation& cancellation) = 0;

    /// Texture sets: the slice constants of a tile, offsets counted from the tile's first byte. One row for a
    /// regular tile; for the tail one for each mip from GetTailFirstMip() on. How many were written; 0 for
    /// images.
    virtual std::uint32_t GetSliceRows(std::uint32_t tile, std::span<NtcSliceConstants> rows) const noexcept {
        static_cast<void>(tile);
        static_cast<void>(rows);
        return 0;
    }

    /// Names the data. Sources whose names are equal, and their layouts' sizes, have the same tiles: textures
    /// of both share tiles, reads and slots as textures of one source do. Empty: no other source has these
    /// data. Files: MakeFileIdentity.
    virtual std::span<const std::byte> GetIdentity() const noexcept { return {}; }
};

/// Whether textures of both show the same tiles: one source, or two of one identity, cut up alike.
inline bool IsSameSource(const TileSource& a, const TileSource& b) noexcept {
    if (&a == &b)
        return true;
    const std::span<const std::byte> name = a.GetIdentity(), other = b.GetIdentity();
    const TileLayout &layout = a.GetLayout(), &otherLayout = b.GetLayout();
    return !name.empty() && name.size() == other.size() &&
           std::memcmp(name.data(), other.data(), name.size()) == 0 &&
           layout.GetWidth() == otherLayout.GetWidth() && layout.GetHeight() == otherLayout.GetHeight() &&
           layout.GetMips() == otherLayout.GetMips() && layout.GetTileWidth() == otherLayout.GetTileWidth() &&
           layout.GetTileHeight() == otherLayout.GetTileHeight() &&
           layout.GetTileCount() == otherLayout.GetTileCount() &&
           a.GetLargestTileBytes() == b.GetLargestTileBytes();
}

/// Texels of one mip in memory, row by row.
struct PixelMip {
    std::span<const std::byte> pixels; ///< width × height × bytes per pixel
};

/// An ordinary image in memory. A tile is its texels row by row, always tileWidth × tileHeight of them: what
/// lies beyond the right and lower edge repeats the last column and row. The tail is its mips one after
/// another, each without padding.
class PixelTileSource final : public TileSource {
public:
    /// `mips` has one entry for each mip of the layout, whose levels must be one mip each, with a tail of at
    /// most one tile; the pixels must stay until the source is gone. Errors: InvalidArgument, OutOfRange,
    /// OutOfMemory.
    static Expected<Shared<PixelTileSource>> Create(const TileLayout& layout, std::span<const PixelMip> mips,
                                                    std::uint32_t bytesPerPixel,
                                                    Allocator& allocator = GetDefaultAllocator());

    const TileLayout& GetLayout() const noexcept override { return layout_; }
    std::size_t GetTileBytes(std::uint32_t tile) const noexcept override;
    std::size_t GetLargestTileBytes() const noexcept override {
        const std::size_t tail = GetTileBytes(static_cast<std::uint32_t>(layout_.GetRegularTileCount()));
        return std::max(tail, layout_.GetLevelCount() > 0 ? GetTileBytes(0) : 0);
    }
    Expected<TileRead> ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                const TileCancellation& cancellation) override;

    PixelTileSource(const TileLayout& layout, Array<PixelMip> mips, std::uint32_t bytesPerPixel) noexcept
        : layout_(layout), mips_(std::move(mips)), bytesPerPixel_(bytesPerPixel) {}

private:
    bool IsTail(std::uint32_t tile) const noexcept {
        return tile >= static_cast<std::uint32_t>(layout_.GetRegularTileCount());
    }

    TileLayout layout_;
    Array<PixelMip> mips_;
    std::size_t bytesPerPixel_;
};

inline Expected<Shared<PixelTileSource>> PixelTileSource::Create(const TileLayout& layout,
                                                                 std::span<const PixelMip> mips,
                                                                 std::uint32_t bytesPerPixel,
                                                                 Allocator& allocator) {
    if (bytesPerPixel < 1 || bytesPerPixel > 16)
        return Fail(Status::OutOfRange, "bytesPerPixel: %u: must be 1 … 16", bytesPerPixel);
    if (mips.size() != static_cast<std::size_t>(layout.GetMips()))
        return Fail(Status::InvalidArgument, "mips: %zu: the layout has %d", mips.size(), layout.GetMips());
    if (layout.GetTailTileCount() > 1)
        return Fail(Status::InvalidArgument, "layout: %d tail tiles: must be 1 at most",
                    layout.GetTailTileCount());
    for (const TileLevel& level : layout.GetLevels()) {
        if (level.firstMip != level.lastMip || level.width != layout.GetMipWidth(level.firstMip) ||
            level.height != layout.GetMipHeight(level.firstMip))
            return Fail(Status::InvalidArgument, "layout: mips %d to %d in one level: must be one mip each",
                        level.firstMip, level.lastMip);
    }
    for (int mip = 0; mip < layout.GetMips(); ++mip) {
        const std::uint64_t needed = static_cast<std::uint64_t>(layout.GetMipWidth(mip)) *
                                     static_cast<std::uint64_t>(layout.GetMipHeight(mip)) * bytesPerPixel;
        const std::size_t given = mips[static_cast<std::size_t>(mip)].pixels.size();
        if (given != needed)
            return Fail(Status::InvalidArgument, "mip %d: %zu bytes: must be %llu", mip, given,
                        static_cast<unsigned long long>(needed));
    }
    Array<PixelMip> copy(allocator);
    OPENNTC_CHECK(copy.Assign(mips));
    return MakeShared<PixelTileSource>(allocator, layout, std::move(copy), bytesPerPixel);
}

inline std::size_t PixelTileSource::GetTileBytes(std::uint32_t tile) const noexcept {
    if (!IsTail(tile))
        return static_cast<std::size_t>(layout_.GetTileWidth()) *
               static_cast<std::size_t>(layout_.GetTileHeight()) * bytesPerPixel_;
    std::size_t bytes = 0;
    for (std::size_t mip = static_cast<std::size_t>(layout_.GetTailFirstMip()); mip < mips_.size(); ++mip)
        bytes += mips_[mip].pixels.size();
    return bytes;
}

inline Expected<TileRead> PixelTileSource::ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                                    const TileCancellation&) {
    std::byte* to = destination.data();
    if (IsTail(tile)) {
        for (std::size_t mip = static_cast<std::size_t>(layout_.GetTailFirstMip()); mip < mips_.size();
             ++mip) {
            std::memcpy(to, mips_[mip].pixels.data(), mips_[mip].pixels.size());
            to += mips_[mip].pixels.size();
        }
        return TileRead{TileAnswer::Ready, static_cast<std::size_t>(to - destination.data())};
    }
    OPENNTC_ASSIGN(const TilePosition position, layout_.GetTilePosition(tile));
    const TileLevel& level = layout_.GetLevels()[static_cast<std::size_t>(position.level)];
    const std::byte* from = mips_[static_cast<std::size_t>(level.firstMip)].pixels.data();
    const std::size_t pitch = static_cast<std::size_t>(level.width) * bytesPerPixel_;
    const int left = position.x * layout_.GetTileWidth();
    const int inside = std::min(layout_.GetTileWidth(), level.width - left);
    const std::size_t copied = static_cast<std::size_t>(inside) * bytesPerPixel_;
    for (int y = 0; y < layout_.GetTileHeight(); ++y) {
        const int row = std::min(position.y * layout_.GetTileHeight() + y, level.height - 1);
        const std::byte* source =
            from + static_cast<std::size_t>(row) * pitch + static_cast<std::size_t>(left) * bytesPerPixel_;
        std::memcpy(to, source, copied);
        to += copied;
        for (int x = inside; x < layout_.GetTileWidth(); ++x, to += bytesPerPixel_)
            std::memcpy(to, source + copied - bytesPerPixel_, bytesPerPixel_);
    }
    return TileRead{TileAnswer::Ready, static_cast<std::size_t>(to - destination.data())};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
