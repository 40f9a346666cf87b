// SPDX-License-Identifier: MIT
// Stability: experimental
// Slices of sets of generations 2 and 3: the latent texels that a rectangle of a mip, and what lies below it
// in further mips, is decoded from, of each of two latent mips and all layers. Latent mips wrap, so a slice
// may go on at the other edge. MakePartialInferenceData does all of it.
#pragma once

#include "openntc/inference/InferenceData.h"
#include "openntc/inference/SliceLayout.h"
#include "openntc/inference/detail/LatentMipRows.h"
#include "openntc/texture_set/StoredDataReader.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// The part of one latent mip. Columns left … left + width - 1 and rows likewise, beyond the edge from 0 on.
struct LatentMipSlice {
    int latentMip = 0;
    int left = 0; ///< inside the latent mip
    int top = 0;
    int width = 0; ///< at most that of the latent mip
    int height = 0;
    std::uint32_t dataOffset = 0; ///< in the slice's latents, a multiple of 4; [layer][y][x]
};

struct LatentMipSliceLayout {
    std::array<LatentMipSlice, NTC_MAX_NEURAL_MIPS> parts{};
    int count = 0;
    std::uint64_t bytes = 0;

    std::span<const LatentMipSlice> GetParts() const noexcept {
        return {parts.data(), static_cast<std::size_t>(count)};
    }
};

namespace detail {

/// Latent texels first … last of an axis before they wrap; empty if last < first.
struct LatentSpan {
    std::int64_t first = 0;
    std::int64_t last = -1;

    void Include(LatentSpan other) noexcept {
        const bool isEmpty = last < first;
        first = isEmpty ? other.first : std::min(first, other.first);
        last = isEmpty ? other.last : std::max(last, other.last);
    }
};

/// The greatest integer that is not above the quotient.
constexpr std::int64_t DivideDown(std::int64_t dividend, std::int64_t divisor) noexcept {
    const std::int64_t quotient = dividend / divisor;
    return dividend % divisor < 0 ? quotient - 1 : quotient;
}

/// What texels begin … end - 1 of an axis of `size` read of `latents`: both texels around each sample, and
/// one more at each end, because decoders work the sample's place out in binary32.
constexpr LatentSpan GetLatentSpan(int size, int latents, int begin, int end) noexcept {
    const auto getCell = [&](int texel) {
        const std::int64_t twice = (2 * std::int64_t{texel} + 1) * latents - size; // 2 * size times the place
        return DivideDown(twice, 2 * std::int64_t{size});
    };
    return {getCell(begin) - 1, getCell(end - 1) + 2};
}

struct WrappedSpan {
    int start;
    int size;
};

constexpr WrappedSpan WrapSpan(LatentSpan span, int latents) noexcept {
    const std::int64_t size = span.last - span.first + 1;
    if (size >= latents)
        return {0, latents};
    const std::int64_t start = span.first % latents;
    return {static_cast<int>(start < 0 ? start + latents : start), static_cast<int>(size)};
}

/// Texels of mip firstMip + levels below texels begin … begin + count - 1 of firstMip.
constexpr std::array<int, 2> GetTexelsBelow(int begin, int count, int levels, int size) noexcept {
    const int first = std::min(begin >> levels, size - 1);
    const std::int64_t end = (std::int64_t{begin} + count + (std::int64_t{1} << levels) - 1) >> levels;
    return {first, static_cast<int>(std::clamp<std::int64_t>(end, first + 1, size))};
}

inline Expected<void> CheckSliceRect(const TextureSetMetadata& metadata, const SliceDesc& desc) noexcept {
    OPENNTC_CHECK(metadata.CheckMips(desc.firstMip, desc.numMips));
    const ColorMip& first = metadata.GetColorMips()[static_cast<std::size_t>(desc.firstMip)];
    const Rect& rect = desc.rect;
    const auto isInside = [](int begin, int count, int size) {
        return begin >= 0 && count >= 1 && begin < size && count <= size - begin;
    };
    if (!isInside(rect.left, rect.width, first.width) || !isInside(rect.top, rect.height, first.height))
        return Fail(Status::OutOfRange, "rect: %d,%d,%d,%d: must lie inside mip %d of %d x %d", rect.left,
                    rect.top, rect.width, rect.height, desc.firstMip, first.width, first.height);
    return {};
}

} // namespace detail

namespace detail {

/// Every latent texel that texels [begin, begin + count) of an axis may read is among those of the slice.
constexpr bool IsWrappedAxisPresent(int size, int latents, int sliceStart, int sliceSize, int begin,
                                    int count) noexcept {
    const WrappedSpan needed = WrapSpan(GetLatentSpan(size, latents, begin, begin + count), latents);
    if (sliceSize >= latents || needed.size >= latents)
        return sliceSize >= latents;
    const int into =
        needed.start < sliceStart ? needed.start + latents - sliceStart : needed.start - sliceStart;
    return into + needed.size <= sliceSize;
}

/// isAxisPresent(size, latents, sliceStart, sliceSize, begin, count) of both axes of a slice that is there.
template <typename IsAxisPresent>
constexpr bool IsSlicePresent(const NtcNeuralMipConstants& grid, int width, int height, const Rect& rect,
                              IsAxisPresent isAxisPresent) noexcept {
    const auto low = [](std::uint32_t word) { return static_cast<int>(word & 0xFFFFu); };
    const auto high = [](std::uint32_t word) { return static_cast<int>(word >> 16); };
    return low(grid.sliceWidthHeight) > 0 && high(grid.sliceWidthHeight) > 0 &&
           isAxisPresent(width, low(grid.imageWidthHeight), low(grid.sliceLeftTop),
                         low(grid.sliceWidthHeight), rect.left, rect.width) &&
           isAxisPresent(height, high(grid.imageWidthHeight), high(grid.sliceLeftTop),
                         high(grid.sliceWidthHeight), rect.top, rect.height);
}

} // namespace detail

/// HoldsLatents (PartialInference.h) of a latent mip: also what lies beyond its edges is there, and a texel
/// more round all of it, as GetLatentMipSlices takes them.
constexpr bool HoldsLatentTexels(const NtcNeuralMipConstants& mip, int width, int height,
                                 const Rect& rect) noexcept {
    return detail::IsSlicePresent(mip, width, height, rect, detail::IsWrappedAxisPresent);
}

/// Which latent texels a slice needs, and where they go. `coverage` of the description has no meaning here: a
/// slice holds all that its texels need. Errors: Unsupported for a set of generation 1; OutOfRange for mips
/// or a rectangle that the set does not have, and for slices of 4 GiB.
inline Expected<LatentMipSliceLayout> GetLatentMipSlices(const TextureSetMetadata& metadata,
                                                         const SliceDesc& desc) noexcept {
    if (metadata.GetGeneration() == 1)
        return Fail(Status::Unsupported, "slice: of a set of generation 1: GetSliceLayout makes those");
    OPENNTC_CHECK(detail::CheckSliceRect(metadata, desc));
    LatentMipSliceLayout layout;
    const std::span<const LatentMip> latents = metadata.GetLatentMips();
    for (int i = 0; i < static_cast<int>(latents.size()); ++i) {
        const LatentMip& latent = latents[static_cast<std::size_t>(i)];
        detail::LatentSpan x;
        detail::LatentSpan y;
        for (int level = 0; level < desc.numMips; ++level) {
            const ColorMip& mip = metadata.GetColorMips()[static_cast<std::size_t>(desc.firstMip + level)];
            if (i != mip.neuralMip && i != mip.neuralMip + 1)
                continue;
            const auto columns = detail::GetTexelsBelow(desc.rect.left, desc.rect.width, level, mip.width);
            const auto rows = detail::GetTexelsBelow(desc.rect.top, desc.rect.height, level, mip.height);
            x.Include(detail::GetLatentSpan(mip.width, latent.width, columns[0], columns[1]));
            y.Include(detail::GetLatentSpan(mip.height, latent.height, rows[0], rows[1]));
        }
        if (x.last < x.first)
            continue;
        const detail::WrappedSpan columns = detail::WrapSpan(x, latent.width);
        const detail::WrappedSpan rows = detail::WrapSpan(y, latent.height);
        layout.parts[static_cast<std::size_t>(layout.count++)] = {
            i, columns.start, rows.start, columns.size, rows.size, static_cast<std::uint32_t>(layout.bytes)};
        layout.bytes += GetLatentMipBytes(columns.size, rows.size, latent.layers);
        if (layout.bytes > std::numeric_limits<std::uint32_t>::max())
            return Fail(Status::OutOfRange, "slice: %llu bytes: must be below 4 GiB",
                        static_cast<unsigned long long>(layout.bytes));
    }
    return layout;
}

namespace detail {

/// Latent texels that a slice of `count` texels of firstMip takes at most, wherever it lies.
inline int GetConservativeSpan(std::span<const ColorMip> mips, const SliceDesc& desc, int latentMip,
                               bool isVertical, int count, int latents) noexcept {
    std::int64_t most = 0;
    for (int level = 0; level < desc.numMips; ++level) {
        const ColorMip& mip = mips[static_cast<std::size_t>(desc.firstMip + level)];
        if (latentMip != mip.neuralMip && latentMip != mip.neuralMip + 1)
            continue;
        const std::int64_t size = isVertical ? mip.height : mip.width;
        // At worst a part of a texel at either end, and as much again where sizes do not halve.
        const std::int64_t texels = ((std::int64_t{count} - 1) >> level) + 2 + (level > 0 ? 2 : 0);
        most = std::max(most, (std::min(texels, size) * latents + size - 1) / size + 5);
    }
    return static_cast<int>(std::min<std::int64_t>(most, latents));
}

} // namespace detail

/// Bytes that hold the latents of any slice of a size in texels of firstMip, wherever it lies. Errors: those
/// of GetLatentMipSlices.
inline Expected<std::uint64_t> GetConservativeLatentMipBytes(const TextureSetMetadata& metadata, int firstMip,
                                                             int numMips, int width, int height) noexcept {
    const SliceDesc desc{firstMip, numMips, {0, 0, width, height}};
    OPENNTC_CHECK(GetLatentMipSlices(metadata, desc));
    std::uint64_t bytes = 0;
    for (int i = 0; i < static_cast<int>(metadata.GetLatentMips().size()); ++i) {
        const LatentMip& latent = metadata.GetLatentMips()[static_cast<std::size_t>(i)];
        const int columns =
            detail::GetConservativeSpan(metadata.GetColorMips(), desc, i, false, width, latent.width);
        const int rows =
            detail::GetConservativeSpan(metadata.GetColorMips(), desc, i, true, height, latent.height);
        bytes += GetLatentMipBytes(columns, rows, latent.layers);
    }
    return bytes;
}

namespace detail {

/// ReadLatentMipSlices with a reader of compressed data: StoredDataReader, or what has its ReadPart.
template <typename Reader>
Expected<void> ReadLatentMipParts(const TextureSetMetadata& metadata, const LatentMipSliceLayout& layout,
                                  Stream& stream, Reader& reader, std::span<std::byte> destination) {
    if (destination.size() < layout.bytes)
        return Fail(Status::OutOfRange, "latents: %zu bytes: the slice needs %llu", destination.size(),
                    static_cast<unsigned long long>(layout.bytes));
    for (const LatentMipSlice& part : layout.GetParts()) {
        const LatentMip& latent = metadata.GetLatentMips()[static_cast<std::size_t>(part.latentMip)];
        const auto groups =
            WrapLayerRows({part.left, part.width, 0, 0, latent.width}, part.top, part.height, latent.height);
        std::size_t offset = part.dataOffset;
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(latent.layers); ++layer) {
            const StoredData& data = latent.layerData[layer];
            for (const LayerRows& rows : groups) {
                if (rows.count == 0)
                    continue;
                const std::size_t bytes = static_cast<std::size_t>(rows.count) * rows.GetRowBytes();
                const std::span<std::byte> to = destination.subspan(offset, bytes);
                OPENNTC_CHECK(data.isCompressed ? ReadCompressedRows(rows, reader, data, to)
                                                : ReadStoredRows(rows, stream, data.range.offset, to.data()));
                offset += bytes;
            }
        }
        if (offset % 4 != 0)
            std::fill_n(destination.begin() + static_cast<std::ptrdiff_t>(offset), 2, std::byte{0});
    }
    return {};
}

} // namespace detail

/// Reads the latents of a slice into the first layout.bytes bytes of `destination`. Stored rows that lie at
/// most 4 KiB apart come together, up to 16 KiB with one read. Of compressed layers only the tiles of 64 KiB
/// that hold rows of the slice are read and decompressed, each once where rows do not wrap; no CRC-32 is
/// checked. Errors: OutOfRange, naming the size that is needed, for a destination that is smaller; IOError;
/// FileUnrecognized for corrupt data; OutOfMemory.
inline Expected<void> ReadLatentMipSlices(const TextureSetMetadata& metadata,
                                          const LatentMipSliceLayout& layout, Stream& stream,
                                          std::span<std::byte> destination,
                                          Allocator& allocator = GetDefaultAllocator()) noexcept {
    StoredDataReader reader(stream, allocator);
    return detail::ReadLatentMipParts(metadata, layout, stream, reader, destination);
}

/// The row of a slice for the colour mips that are decoded from latent mips `latentMip` and the next; all
/// zero (absent) unless the slice has both.
inline NtcSliceConstants MakeSliceConstants(const TextureSetMetadata& metadata,
                                            const LatentMipSliceLayout& layout, int latentMip) noexcept {
    const auto pack = [](int low, int high) {
        return static_cast<std::uint32_t>(low) | static_cast<std::uint32_t>(high) << 16;
    };
    NtcSliceConstants row{};
    for (const LatentMipSlice& part : layout.GetParts()) {
        if (part.latentMip != latentMip && part.latentMip != latentMip + 1)
            continue;
        const LatentMip& latent = metadata.GetLatentMips()[static_cast<std::size_t>(part.latentMip)];
        (part.latentMip == latentMip ? row.highRes : row.lowRes) = {
            part.dataOffset, pack(latent.width, latent.height), pack(part.left, part.top),
            pack(part.width, part.height)};
    }
    const bool hasBoth = row.highRes.sliceWidthHeight != 0 && row.lowRes.sliceWidthHeight != 0;
    return hasBoth ? row : NtcSliceConstants{};
}

/// The constants of a set for the latents of a slice. Errors: those of MakeInferenceData.
inline Expected<NtcTextureSetConstants> MakeSliceInferenceData(const TextureSetMetadata& metadata,
                                                               const LatentMipSliceLayout& layout,
                                                               InferenceWeightType weightType) noexcept {
    const InferenceWeights& weights = metadata.GetWeights();
    OPENNTC_CHECK(detail::CheckWeights(metadata, weightType, weights));
    NtcTextureSetConstants c = detail::MakeCommonConstants(metadata, weights);
    detail::SetLayeredEncoding(metadata, c);
    for (int i = 0; i < NTC_MAX_NEURAL_MIPS; ++i) {
        const NtcSliceConstants row = MakeSliceConstants(metadata, layout, i);
        c.highResNeuralMips[i] = row.highRes;
        c.lowResNeuralMips[i] = row.lowRes;
    }
    return c;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
