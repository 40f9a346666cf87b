// SPDX-License-Identifier: MIT
// Stability: internal
// The bytes of a slice of latent mips, read row by row from stored and from compressed layers.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/inference/detail/SliceRows.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// A rectangle of a layer. Columns wrap; rows first … first + count - 1 do not.
struct LayerRows {
    int left = 0;
    int width = 0; ///< at most that of the layer
    int first = 0;
    int count = 0;
    int layerWidth = 0;

    int GetWidthBeforeEdge() const noexcept { return std::min(width, layerWidth - left); }
    bool IsWrapped() const noexcept { return width > layerWidth - left; }
    std::uint64_t GetStride() const noexcept { return 2 * static_cast<std::uint64_t>(layerWidth); }
    std::size_t GetRowBytes() const noexcept { return 2 * static_cast<std::size_t>(width); }
    std::uint64_t GetRowOffset(int row) const noexcept {
        return static_cast<std::uint64_t>(first + row) * GetStride();
    }
};

/// Of a layer of `layerHeight` rows those from `top` on, and those that wrap.
inline std::array<LayerRows, 2> WrapLayerRows(LayerRows rows, int top, int height, int layerHeight) noexcept {
    const int beforeEdge = std::min(height, layerHeight - top);
    std::array<LayerRows, 2> groups = {rows, rows};
    groups[0].first = top;
    groups[0].count = beforeEdge;
    groups[1].count = height - beforeEdge;
    return groups;
}

/// Reads from a layer that begins at `offset`; at least one row.
template <typename Rows>
bool ReadStoredRows(const LayerRows& rows, Rows& source, std::uint64_t offset,
                    std::byte* destination) noexcept {
    const std::uint64_t begin = offset + rows.GetRowOffset(0);
    const std::uint64_t left = 2 * static_cast<std::uint64_t>(rows.left);
    const std::size_t rowBytes = rows.GetRowBytes();
    if (rows.width == rows.layerWidth) { // one piece
        const std::size_t bytes = rowBytes * static_cast<std::size_t>(rows.count);
        source.Begin(0, begin + bytes);
        return source.ReadRows({begin, bytes, bytes, 1}, destination);
    }
    const std::uint64_t lastEnd = rows.IsWrapped() ? rows.GetStride() : left + rowBytes;
    source.Begin(rows.GetStride() - rowBytes,
                 begin + static_cast<std::uint64_t>(rows.count - 1) * rows.GetStride() + lastEnd);
    if (!rows.IsWrapped())
        return source.ReadRows({begin + left, rows.GetStride(), rowBytes, rows.count}, destination);
    const std::size_t beforeEdge = 2 * static_cast<std::size_t>(rows.GetWidthBeforeEdge());
    for (int row = 0; row < rows.count; ++row, destination += rowBytes) {
        const std::uint64_t at = begin + static_cast<std::uint64_t>(row) * rows.GetStride();
        if (!source.Read(at + left, destination, beforeEdge) ||
            !source.Read(at, destination + beforeEdge, rowBytes - beforeEdge))
            return false;
    }
    return true;
}

inline Expected<void> ReadStoredRows(const LayerRows& rows, Stream& stream, std::uint64_t offset,
                                     std::byte* destination) noexcept {
    MemoryRows memory{stream.GetMemory(), 0};
    bool isRead = false;
    if (!memory.source.empty()) {
        isRead = ReadStoredRows(rows, memory, offset, destination);
    } else {
        StreamRows windowed(stream);
        isRead = ReadStoredRows(rows, windowed, offset, destination);
    }
    if (isRead)
        return {};
    return Fail(Status::IOError, "latents: %d rows of %zu bytes at %llu: cannot be read", rows.count,
                rows.GetRowBytes(), static_cast<unsigned long long>(offset + rows.GetRowOffset(0)));
}

/// Reads from a compressed layer. `Reader` has StoredDataReader's ReadPart.
template <typename Reader>
Expected<void> ReadCompressedRows(const LayerRows& rows, Reader& reader, const StoredData& data,
                                  std::span<std::byte> destination) {
    const std::size_t beforeEdge = 2 * static_cast<std::size_t>(rows.GetWidthBeforeEdge());
    for (int row = 0; row < rows.count; ++row) {
        const std::uint64_t at = rows.GetRowOffset(row);
        const std::span<std::byte> to =
            destination.subspan(static_cast<std::size_t>(row) * rows.GetRowBytes(), rows.GetRowBytes());
        OPENNTC_CHECK(reader.ReadPart(data, at + 2 * static_cast<std::uint64_t>(rows.left),
                                      to.first(beforeEdge), "latents"));
        OPENNTC_CHECK(reader.ReadPart(data, at, to.subspan(beforeEdge), "latents"));
    }
    return {};
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
