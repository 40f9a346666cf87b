// SPDX-License-Identifier: MIT
// Stability: internal
// The bytes of a slice, read row by row from a stream or from memory. Source: format specification,
// "streaming" 3.3, and 3.4 for rows that start within a byte.
#pragma once

#include "openntc/core/CheckedMath.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/inference/SliceLayout.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// Rows of a grid that are whole bytes at equal distances; the last byte of the last one may be half used.
struct ByteRows {
    std::uint64_t sourceOffset = 0;
    std::uint64_t sourceStride = 0;
    std::size_t rowBytes = 0;
    int rows = 0;
};

/// Reads rows through a window, so that those that lie close together come with one call: a call of the
/// system costs as much as copying some thousands of bytes, and a disk gives whole pages anyway.
class StreamRows {
public:
    explicit StreamRows(Stream& stream) noexcept : stream_(stream) {}

    /// What is read next: pieces in increasing order, `gap` bytes between them, of which the last ends at
    /// `end`. Nothing is read behind it.
    void Begin(std::uint64_t gap, std::uint64_t end) noexcept {
        isWindowed_ = gap <= kMaxGap;
        end_ = end;
    }
    bool Read(std::uint64_t offset, std::byte* destination, std::size_t bytes) noexcept {
        if (!isWindowed_ || bytes > window_.size())
            return stream_.ReadAt(offset, destination, bytes);
        if (offset < start_ || !IsRangeInside(offset - start_, bytes, size_)) {
            size_ = static_cast<std::size_t>(std::min<std::uint64_t>(window_.size(), end_ - offset));
            start_ = offset;
            if (!stream_.ReadAt(offset, window_.data(), size_)) {
                size_ = 0;
                return false;
            }
        }
        std::memcpy(destination, window_.data() + (offset - start_), bytes);
        return true;
    }
    bool ReadRows(const ByteRows& rows, std::byte* destination) noexcept {
        for (int row = 0; row < rows.rows; ++row, destination += rows.rowBytes) {
            if (!Read(rows.sourceOffset + static_cast<std::uint64_t>(row) * rows.sourceStride, destination,
                      rows.rowBytes))
                return false;
        }
        return true;
    }

private:
    static constexpr std::uint64_t kMaxGap = 4096;

    Stream& stream_;
    bool isWindowed_ = false;
    std::uint64_t end_ = 0;
    std::uint64_t start_ = 0; ///< of the window in the stream
    std::size_t size_ = 0;    ///< read
    std::array<std::byte, 16384> window_;
};

struct MemoryRows {
    std::span<const std::byte> source;
    std::uint64_t sourceOffset;

    void Begin(std::uint64_t, std::uint64_t) const noexcept {}
    bool Holds(std::uint64_t offset, std::uint64_t bytes) const noexcept {
        return offset >= sourceOffset && IsRangeInside(offset - sourceOffset, bytes, source.size());
    }
    bool Read(std::uint64_t offset, std::byte* destination, std::size_t bytes) const noexcept {
        if (!Holds(offset, bytes))
            return false;
        std::memcpy(destination, source.data() + (offset - sourceOffset), bytes);
        return true;
    }
    bool ReadRows(const ByteRows& rows, std::byte* destination) const noexcept {
        // One test for all rows: the last one ends last, and below 2^63.
        const std::uint64_t distance = static_cast<std::uint64_t>(rows.rows - 1) * rows.sourceStride;
        if (!Holds(rows.sourceOffset, distance + rows.rowBytes))
            return false;
        const std::byte* from = source.data() + (rows.sourceOffset - sourceOffset);
        const std::size_t stride = static_cast<std::size_t>(rows.sourceStride);
        // Rows are short: blocks of a fixed size need no call. All but the last row may reach over their end
        // by less than a block, into the next row of source and destination, which comes next.
        constexpr std::size_t kBlock = 16;
        constexpr std::size_t kShort = 16 * kBlock;
        const bool isShort = rows.rowBytes >= kBlock && rows.rowBytes <= kShort && stride >= kBlock;
        for (int row = rows.rows; row > 1; --row, from += stride, destination += rows.rowBytes) {
            if (isShort) {
                for (std::size_t at = 0; at < rows.rowBytes; at += kBlock)
                    std::memcpy(destination + at, from + at, kBlock);
            } else {
                std::memcpy(destination, from, rows.rowBytes);
            }
        }
        std::memcpy(destination, from, rows.rowBytes); // no pointer beyond the source is made
        return true;
    }
};

/// Copies `count` half bytes, low halves first, from half byte `from` of `source` to half byte `to` of a
/// zeroed destination.
inline void CopyHalfBytes(const std::byte* source, std::uint64_t from, std::byte* destination,
                          std::uint64_t to, std::uint64_t count) noexcept {
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::byte half = (source[(from + i) / 2] >> (4 * ((from + i) % 2))) & std::byte{15};
        destination[(to + i) / 2] |= half << (4 * ((to + i) % 2));
    }
}

/// Reads a run that starts within a byte, there or here. `start` is that of the slice.
template <typename Rows>
bool ReadHalfBytes(const SliceRun& run, Rows& source, std::byte* start) noexcept {
    constexpr std::uint64_t kChunkBytes = 256;
    std::array<std::byte, kChunkBytes> chunk;
    const std::uint64_t firstHalf = run.sourceBit / 4;
    const std::uint64_t endHalf = firstHalf + run.bits / 4;
    for (std::uint64_t byte = 0; byte * 2 < endHalf; byte += kChunkBytes) {
        const std::uint64_t bytes = std::min(kChunkBytes, run.GetSourceBytes() - byte);
        if (!source.Read(run.sourceOffset + byte, chunk.data(), static_cast<std::size_t>(bytes)))
            return false;
        const std::uint64_t from = std::max(firstHalf, byte * 2);
        const std::uint64_t to = std::min(endHalf, (byte + bytes) * 2);
        CopyHalfBytes(chunk.data(), from - byte * 2, start, run.destinationBit / 4 + (from - firstHalf),
                      to - from);
    }
    return true;
}

template <typename Rows>
bool ReadSliceGrid(const SliceGrid& grid, Rows& source, std::byte* start) noexcept {
    const int runs = GetSliceRunCount(grid);
    const SliceRun first = GetSliceRun(grid, 0);
    std::byte* const destination = start + grid.dataOffset;
    const std::uint64_t strideBits =
        static_cast<std::uint64_t>(grid.imageWidth) * static_cast<std::uint64_t>(grid.bitsPerPixel);
    const SliceRun last = GetSliceRun(grid, runs - 1);
    source.Begin(strideBits / 8 - std::min(strideBits / 8, first.GetSourceBytes()),
                 last.sourceOffset + last.GetSourceBytes());
    if (first.IsAligned() && (runs == 1 || (first.bits % 8 == 0 && strideBits % 8 == 0))) {
        ByteRows rows;
        rows.sourceOffset = first.sourceOffset;
        rows.sourceStride = strideBits / 8;
        rows.rowBytes = static_cast<std::size_t>(first.GetSourceBytes());
        rows.rows = runs;
        if (!source.ReadRows(rows, destination))
            return false;
        const std::size_t used = rows.rowBytes * static_cast<std::size_t>(runs);
        if (first.bits % 8 != 0)
            destination[used - 1] &= std::byte{15}; // the other half belongs to the next pixel
        std::memset(destination + used, 0, grid.bytes - used);
        return true;
    }
    std::memset(destination, 0, grid.bytes);
    for (int i = 0; i < runs; ++i) {
        if (!ReadHalfBytes(GetSliceRun(grid, i), source, start))
            return false;
    }
    return true;
}

template <typename Rows>
Expected<void> ReadSliceRows(const SliceLayout& layout, Rows&& source,
                             std::span<std::byte> destination) noexcept {
    if (destination.size() < layout.bytes)
        return Fail(Status::OutOfRange, "latents: %zu bytes: the slice needs %llu", destination.size(),
                    static_cast<unsigned long long>(layout.bytes));
    for (const SliceGrid& grid : layout.GetGrids()) {
        if (!ReadSliceGrid(grid, source, destination.data()))
            return Fail(Status::IOError,
                        "latent image %d, %s grid: %dx%d latent pixels at %d,%d cannot be read",
                        grid.neuralMip, grid.isLowRes ? "low-res" : "high-res", grid.width, grid.height,
                        grid.left, grid.top);
    }
    return {};
}

inline Expected<void> CheckWeightType(InferenceWeightType type) noexcept {
    if (type < InferenceWeightType::GenericInt8 || type > InferenceWeightType::CoopVecFP8)
        return Fail(Status::InvalidArgument, "weightType: %d: must be 1 … 4", static_cast<int>(type));
    return {};
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
