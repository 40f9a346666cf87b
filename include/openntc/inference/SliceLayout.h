// SPDX-License-Identifier: MIT
// Stability: experimental
// Slices of texture sets: which latent pixels a rectangle of texels needs, where they lie in the file and
// where in the slice's own buffer. Only numbers; PartialInference.h reads the bytes and makes the constants.
//
// A slice holds what the texels of a rectangle of mip `firstMip` need, and those of the coarser mips below
// it, down to mip firstMip + numMips - 1. Of mip firstMip + k these are the texels left >> k up to ceil((left
// + width) / 2^k) - 1 across, and likewise down, as far as the mip has them. They decode to the same bits as
// from the whole set, by the same coordinates.
//
// Source of all formulas: format specification, "streaming" 3 and 4, with these of our own: the lower edge is
// tested against the height; rows are packed bit by bit where pixels are half bytes and rows odd; and where
// sizes do not halve, latents that the finer mips need are added (SliceCoverage).
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/Rect.h"
#include "openntc/inference/detail/SliceAxis.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Which latents a slice holds.
enum class SliceCoverage : std::uint8_t {
    /// All that its texels need. The same as Published, unless a mip of the slice is more than twice as large
    /// as the next (2^n + 1 texels, for example), which makes the rectangle's place differ from mip to mip.
    Whole,
    /// What LibNTC 0.7 cuts out: the rectangle as the slice's coarsest mip sees it. For comparisons; texels
    /// of finer mips may lack latents at the left and upper edges, and decode to something else then.
    Published,
};

/// What is asked for: a rectangle of mip `firstMip`, and what lies below it in the next numMips - 1 mips.
struct SliceDesc {
    int firstMip = 0;
    int numMips = 1;
    Rect rect; ///< in texels of firstMip, inside that mip
    SliceCoverage coverage = SliceCoverage::Whole;
};

/// The part of one grid that a slice holds. In the slice it is a grid of its own, width × height pixels
/// packed bit by bit without padding between rows; the bits behind its end, up to `bytes`, are zero.
struct SliceGrid {
    int neuralMip = 0;
    bool isLowRes = false;
    int bitsPerPixel = 0; ///< 4 … 128, a multiple of 4
    int imageWidth = 0;   ///< of the whole grid, latent pixels
    int imageHeight = 0;
    int left = 0; ///< latent pixels of the whole grid
    int top = 0;
    int width = 0; ///< 1 … imageWidth - left
    int height = 0;
    std::uint64_t sourceOffset = 0; ///< of the whole grid: bytes, absolute in the stream
    std::uint32_t dataOffset = 0;   ///< bytes from the start of the slice, a multiple of 4
    std::uint32_t bytes = 0;        ///< in the slice, a multiple of 4
};

/// Where everything is in a slice: high-res and low-res grid of each latent image that the slice's mips need,
/// images in increasing order.
struct SliceLayout {
    std::array<SliceGrid, 2 * NTC_MAX_NEURAL_MIPS> grids;
    int gridCount = 0;
    std::uint64_t bytes = 0; ///< of the whole slice, below 4 GiB

    std::span<const SliceGrid> GetGrids() const noexcept {
        return {grids.data(), static_cast<std::size_t>(gridCount)};
    }
};

/// Rows of a grid that are one block in the stream: bits [sourceBit, sourceBit + bits), counted from byte
/// sourceOffset, become the bits [destinationBit, …) of the slice. All numbers of bits are multiples of 4.
struct SliceRun {
    std::uint64_t sourceOffset = 0;   ///< bytes, absolute in the stream
    std::uint64_t destinationBit = 0; ///< from the start of the slice
    std::uint64_t bits = 0;
    std::uint32_t sourceBit = 0; ///< 0 or 4

    /// The run is whole bytes at whole bytes, but for half a byte at its end.
    constexpr bool IsAligned() const noexcept { return sourceBit == 0 && destinationBit % 8 == 0; }
    /// Bytes of the stream that the run touches.
    constexpr std::uint64_t GetSourceBytes() const noexcept { return (sourceBit + bits + 7) / 8; }
};

/// Runs of a grid: 1 where its rows follow each other in the stream, otherwise one a row.
constexpr int GetSliceRunCount(const SliceGrid& grid) noexcept {
    return grid.width == grid.imageWidth ? 1 : grid.height;
}

/// Run 0 … GetSliceRunCount - 1 of a grid, in the order of the stream and of the slice.
constexpr SliceRun GetSliceRun(const SliceGrid& grid, int index) noexcept {
    const std::uint64_t bitsPerPixel = static_cast<std::uint64_t>(grid.bitsPerPixel);
    const std::uint64_t rowBits = static_cast<std::uint64_t>(grid.width) * bitsPerPixel;
    const std::uint64_t pixel =
        static_cast<std::uint64_t>(grid.top + index) * static_cast<std::uint64_t>(grid.imageWidth) +
        static_cast<std::uint64_t>(grid.left);
    const std::uint64_t bit = pixel * bitsPerPixel;
    SliceRun run;
    run.sourceOffset = grid.sourceOffset + bit / 8;
    run.sourceBit = static_cast<std::uint32_t>(bit % 8);
    run.destinationBit = std::uint64_t{grid.dataOffset} * 8 + static_cast<std::uint64_t>(index) * rowBits;
    run.bits = grid.width == grid.imageWidth ? rowBits * static_cast<std::uint64_t>(grid.height) : rowBits;
    return run;
}

namespace detail {

inline Expected<void> CheckMipRange(int mips, int firstMip, int numMips) noexcept {
    if (firstMip < 0 || firstMip >= mips)
        return Fail(Status::OutOfRange, "firstMip: %d: must be 0 … %d", firstMip, mips - 1);
    if (numMips < 1 || numMips > mips - firstMip)
        return Fail(Status::OutOfRange, "numMips: %d: must be 1 … %d", numMips, mips - firstMip);
    return {};
}

inline Expected<void> CheckSliceAxis(const char* start, const char* size, int begin, int count,
                                     int limit) noexcept {
    if (begin < 0 || begin >= limit)
        return Fail(Status::OutOfRange, "%s: %d: must be 0 … %d", start, begin, limit - 1);
    if (count < 1 || count > limit - begin)
        return Fail(Status::OutOfRange, "%s: %d: must be 1 … %d from %s %d on", size, count, limit - begin,
                    start, begin);
    return {};
}

/// The mips [first, end) of a set that one latent image serves; a hand-made file may use it for any.
struct ServedMips {
    std::array<int, NTC_MAX_MIPS> mips{};
    int count = 0;

    ServedMips(std::span<const ColorMip> colorMips, int firstMip, int numMips, int neuralMip) noexcept {
        for (int mip = firstMip; mip < firstMip + numMips; ++mip) {
            if (colorMips[static_cast<std::size_t>(mip)].neuralMip == neuralMip)
                mips[static_cast<std::size_t>(count++)] = mip;
        }
    }
    int GetCoarsest() const noexcept { return mips[static_cast<std::size_t>(count - 1)]; }
    std::span<const int> GetFiner() const noexcept {
        return {mips.data(), static_cast<std::size_t>(count - 1)};
    }
};

/// What the formulas need to know about one axis of a set.
struct SliceAxisSizes {
    std::span<const ColorMip> colorMips;
    bool isVertical = false;

    int GetSize(int mip) const noexcept {
        const ColorMip& size = colorMips[static_cast<std::size_t>(mip)];
        return isVertical ? size.height : size.width;
    }
};

/// Latent pixels [first, last] of an axis for texels [begin, end) of firstMip and what lies below them.
inline LatentInterval GetSliceInterval(const SliceAxisSizes& sizes, const ServedMips& served, int firstMip,
                                       int begin, int end, int latents, SliceCoverage coverage) noexcept {
    const int coarsest = served.GetCoarsest();
    const int size = sizes.GetSize(coarsest);
    const int shift = coarsest - firstMip;
    LatentInterval interval = GetEdgeInterval(size, latents, begin >> shift, ((end - 1) >> shift) + 1);
    if (coverage == SliceCoverage::Published)
        return interval;
    // The upper edge of the coarsest mip's texels is never below that of the finer ones: a mip's size is at
    // most half of the one before. At the lower edge it is the other way round where a size is odd.
    for (const int mip : served.GetFiner()) {
        const int finer = sizes.GetSize(mip);
        if (finer > size << (coarsest - mip))
            interval.first = std::min(interval.first, GetFirstTap(finer, latents, begin >> (mip - firstMip)));
    }
    return interval;
}

/// Half-byte pixels start at even positions and come in pairs, as far as the grid has them.
constexpr LatentInterval PairHalfBytes(LatentInterval interval, int latents) noexcept {
    interval.first &= ~1;
    interval.last = std::min(interval.last | 1, latents - 1);
    return interval;
}

constexpr bool IsOddNibbles(std::uint64_t bits) noexcept {
    return (bits & 4u) != 0;
}

constexpr std::uint64_t GetBitsPerPixel(const LatentShape& shape, bool isLowRes) noexcept {
    return static_cast<std::uint64_t>(isLowRes ? shape.lowResFeatures * shape.lowResQuantBits
                                               : shape.highResFeatures * shape.highResQuantBits);
}

/// Bytes of a packed grid: whole 32-bit words.
constexpr std::uint64_t GetPackedBytes(int width, int height, std::uint64_t bitsPerPixel) noexcept {
    return (static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) * bitsPerPixel + 31) / 32 *
           4;
}

} // namespace detail

namespace detail {

/// The part of one grid, without its place in the slice.
inline SliceGrid MakeSliceGrid(const TextureSetMetadata& metadata, const SliceDesc& desc,
                               const ServedMips& served, int image, bool isLowRes) noexcept {
    const LatentImage& latents = metadata.GetLatentImages()[static_cast<std::size_t>(image)];
    const LatentGrid& grid = isLowRes ? latents.lowRes : latents.highRes;
    const std::uint64_t bitsPerPixel = GetBitsPerPixel(metadata.GetLatentShape(), isLowRes);
    const Rect& rect = desc.rect;
    LatentInterval x = GetSliceInterval({metadata.GetColorMips(), false}, served, desc.firstMip, rect.left,
                                        rect.left + rect.width, grid.width, desc.coverage);
    LatentInterval y = GetSliceInterval({metadata.GetColorMips(), true}, served, desc.firstMip, rect.top,
                                        rect.top + rect.height, grid.height, desc.coverage);
    if (IsOddNibbles(bitsPerPixel))
        x = PairHalfBytes(x, grid.width);
    if (IsOddNibbles(bitsPerPixel * static_cast<std::uint64_t>(grid.width)))
        y = PairHalfBytes(y, grid.height);
    SliceGrid part;
    part.neuralMip = image;
    part.isLowRes = isLowRes;
    part.bitsPerPixel = static_cast<int>(bitsPerPixel);
    part.imageWidth = grid.width;
    part.imageHeight = grid.height;
    part.left = x.first;
    part.top = y.first;
    part.width = x.last - x.first + 1;
    part.height = y.last - y.first + 1;
    part.sourceOffset = grid.offset;
    return part;
}

/// GetSliceLayout into an empty layout that exists: nothing of its 1 KB is copied.
inline Expected<void> FillSliceLayout(const TextureSetMetadata& metadata, const SliceDesc& desc,
                                      SliceLayout& layout) noexcept {
    OPENNTC_CHECK(metadata.CheckHasGrids("slice"));
    OPENNTC_CHECK(CheckMipRange(metadata.GetDesc().mips, desc.firstMip, desc.numMips));
    const std::span<const ColorMip> colorMips = metadata.GetColorMips();
    const ColorMip& first = colorMips[static_cast<std::size_t>(desc.firstMip)];
    OPENNTC_CHECK(CheckSliceAxis("left", "width", desc.rect.left, desc.rect.width, first.width));
    OPENNTC_CHECK(CheckSliceAxis("top", "height", desc.rect.top, desc.rect.height, first.height));
    for (int image = 0; image < static_cast<int>(metadata.GetLatentImages().size()); ++image) {
        const ServedMips served(colorMips, desc.firstMip, desc.numMips, image);
        if (served.count == 0)
            continue;
        for (const bool isLowRes : {false, true}) {
            SliceGrid& part = layout.grids[static_cast<std::size_t>(layout.gridCount++)];
            part = MakeSliceGrid(metadata, desc, served, image, isLowRes);
            const std::uint64_t bytes =
                GetPackedBytes(part.width, part.height, static_cast<std::uint64_t>(part.bitsPerPixel));
            if (layout.bytes + bytes > 0xFFFFFFFFu)
                return Fail(Status::OutOfRange, "slice: %llu bytes and more: must be below 4 GiB",
                            static_cast<unsigned long long>(layout.bytes + bytes));
            part.dataOffset = static_cast<std::uint32_t>(layout.bytes);
            part.bytes = static_cast<std::uint32_t>(bytes);
            layout.bytes += bytes;
        }
    }
    return {};
}

} // namespace detail

/// The geometry of a slice. Errors: OutOfRange for mips that the set does not have, a rectangle that is empty
/// or not inside mip firstMip, or a slice of 4 GiB or more.
inline Expected<SliceLayout> GetSliceLayout(const TextureSetMetadata& metadata,
                                            const SliceDesc& desc) noexcept {
    Expected<SliceLayout> layout(tl::in_place);
    if (const Expected<void> filled = detail::FillSliceLayout(metadata, desc, *layout); !filled)
        layout = PassError(filled);
    return layout;
}

namespace detail {

/// The largest number of latent pixels that a slice of `count` texels of firstMip can need on an axis.
inline int GetConservativeLatents(const SliceAxisSizes& sizes, const ServedMips& served, int firstMip,
                                  int count, int alignment, int latents, bool isPaired) noexcept {
    const int coarsest = served.GetCoarsest();
    const int shift = coarsest - firstMip;
    const int size = sizes.GetSize(coarsest);
    const int cell = 1 << shift;
    const int step = (alignment + cell - 1) >> shift; // in texels of the coarsest mip
    const int texels = (std::max(cell - step, 0) + count + cell - 1) >> shift;
    // Where every slice starts between two latent pixels, none is lost at its ends.
    bool isExact = std::int64_t{step} * latents % size == 0;
    // Unless latents are added at the lower edge: at most those of (finer - size * 2^k - 1/2) / finer of the
    // grid.
    for (const int mip : served.GetFiner()) {
        const std::int64_t finer = sizes.GetSize(mip);
        const std::int64_t excess = finer - (std::int64_t{size} << (coarsest - mip));
        if ((2 * excess - 1) * latents > finer)
            isExact = false;
    }
    std::int64_t pixels = std::int64_t{GetScaledCeiling(texels + (isExact ? 0 : 1), size, latents)} + 2;
    if (isPaired)
        pixels = (pixels + 2) & ~std::int64_t{1};
    return static_cast<int>(std::min<std::int64_t>(pixels, latents));
}

} // namespace detail

/// Bytes that hold the latents of any slice of the given size and mips, wherever it lies, of either coverage;
/// for slices whose left and top are multiples of `alignment`, in texels of firstMip. An alignment that is no
/// power of two counts as 1. Errors: OutOfRange for mips that the set does not have, a size outside 1 … that
/// of firstMip, or an alignment below 1.
inline Expected<std::uint64_t> GetConservativeLatentBufferSize(const TextureSetMetadata& metadata,
                                                               int firstMip, int numMips, int sliceWidth,
                                                               int sliceHeight, int alignment = 1) noexcept {
    OPENNTC_CHECK(metadata.CheckHasGrids("slice"));
    OPENNTC_CHECK(detail::CheckMipRange(metadata.GetDesc().mips, firstMip, numMips));
    const std::span<const ColorMip> colorMips = metadata.GetColorMips();
    const ColorMip& first = colorMips[static_cast<std::size_t>(firstMip)];
    if (sliceWidth < 1 || sliceWidth > first.width)
        return Fail(Status::OutOfRange, "sliceWidth: %d: must be 1 … %d", sliceWidth, first.width);
    if (sliceHeight < 1 || sliceHeight > first.height)
        return Fail(Status::OutOfRange, "sliceHeight: %d: must be 1 … %d", sliceHeight, first.height);
    if (alignment < 1)
        return Fail(Status::OutOfRange, "alignment: %d: must be 1 or more", alignment);
    if (!std::has_single_bit(static_cast<unsigned>(alignment)))
        alignment = 1;
    alignment = std::min(alignment, kMaxImageDimension); // beyond it only 0 is left
    const std::span<const LatentImage> images = metadata.GetLatentImages();
    std::uint64_t total = 0;
    for (int image = 0; image < static_cast<int>(images.size()); ++image) {
        const detail::ServedMips served(colorMips, firstMip, numMips, image);
        if (served.count == 0)
            continue;
        for (const bool isLowRes : {false, true}) {
            const LatentImage& latents = images[static_cast<std::size_t>(image)];
            const LatentGrid& grid = isLowRes ? latents.lowRes : latents.highRes;
            const std::uint64_t bitsPerPixel = detail::GetBitsPerPixel(metadata.GetLatentShape(), isLowRes);
            const int width =
                detail::GetConservativeLatents({colorMips, false}, served, firstMip, sliceWidth, alignment,
                                               grid.width, detail::IsOddNibbles(bitsPerPixel));
            const int height = detail::GetConservativeLatents(
                {colorMips, true}, served, firstMip, sliceHeight, alignment, grid.height,
                detail::IsOddNibbles(bitsPerPixel * static_cast<std::uint64_t>(grid.width)));
            total += detail::GetPackedBytes(width, height, bitsPerPixel);
        }
    }
    return total;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
