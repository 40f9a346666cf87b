// SPDX-License-Identifier: MIT
// Stability: internal
// Data of a file that may be compressed, read whole or in parts.
#pragma once

#include "openntc/container/GDeflate.h"
#include "openntc/core/Allocator.h"
#include "openntc/core/Crc32.h"
#include "openntc/core/Stream.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

namespace detail {

inline Expected<void> ReadStoredBytes(Stream& stream, const StoredData& data, std::uint64_t offset,
                                      std::span<std::byte> destination, const char* what) noexcept {
    if (!stream.ReadAt(data.range.offset + offset, destination.data(), destination.size()))
        return Fail(Status::IOError, "%s: %zu bytes at %llu: cannot be read", what, destination.size(),
                    static_cast<unsigned long long>(data.range.offset + offset));
    return {};
}

/// Reads the header and the table of compressed data, which has as many bytes as it says. Errors: IOError;
/// FileUnrecognized; OutOfMemory.
inline Expected<container::GDeflateHeader> ReadGDeflateTable(Stream& stream, const StoredData& data,
                                                             Array<std::byte>& table,
                                                             const char* what) noexcept {
    std::byte memory[container::kGDeflateHeaderBytes] = {};
    const auto start = std::span(memory).first(
        static_cast<std::size_t>(std::min<std::uint64_t>(sizeof memory, data.range.size)));
    OPENNTC_CHECK(ReadStoredBytes(stream, data, 0, start, what));
    OPENNTC_ASSIGN(const container::GDeflateHeader header, container::DecodeGDeflateHeader(start));
    if (header.GetBytes() != data.bytes)
        return Fail(Status::FileUnrecognized, "%s: uncompressedSize: %llu: the GDeflate stream has %llu",
                    what, static_cast<unsigned long long>(data.bytes),
                    static_cast<unsigned long long>(header.GetBytes()));
    const std::size_t tableBytes = header.GetTableBytes();
    if (tableBytes > data.range.size)
        return Fail(Status::FileUnrecognized, "%s: %llu bytes: a table of %u tiles has %zu", what,
                    static_cast<unsigned long long>(data.range.size), header.tiles, tableBytes);
    OPENNTC_CHECK(table.Resize(tableBytes));
    OPENNTC_CHECK(ReadStoredBytes(stream, data, 0, table.AsSpan(), what));
    return header;
}

} // namespace detail

/// Keeps the tile that was decompressed last, for reading rows. Takes at most 192 KiB, and 4 bytes for each
/// tile of the data, whatever the file says.
class StoredDataReader {
public:
    StoredDataReader(Stream& stream, Allocator& allocator) noexcept
        : stream_(&stream), table_(allocator), compressed_(allocator), tile_(allocator) {}

    /// Reads the first bytes of the data, and checks the CRC-32 of compressed data that have one; the format
    /// defines none of stored data. As many as `destination` has must be there. `what` names them in
    /// messages. Errors: IOError; FileUnrecognized for compressed data that are corrupt; OutOfMemory.
    Expected<void> Read(const StoredData& data, std::span<std::byte> destination, const char* what) noexcept {
        if (!data.isCompressed)
            return ReadStored(data, 0, destination, what);
        OPENNTC_CHECK(Open(data, what));
        const bool isChecked = data.crc32 != 0;
        std::uint32_t crc = 0;
        for (std::uint32_t tile = 0; tile < header_.tiles && (isChecked || !destination.empty()); ++tile) {
            const std::size_t bytes = header_.GetTileBytes(tile);
            const bool fits = bytes <= destination.size();
            if (fits)
                OPENNTC_CHECK(Decompress(tile, destination.first(bytes), what));
            else
                OPENNTC_CHECK(LoadTile(tile, what));
            const std::span<const std::byte> whole = fits ? destination.first(bytes) : GetTile();
            if (isChecked)
                crc = Crc32(whole, crc);
            const std::size_t used = std::min(bytes, destination.size());
            if (!fits && used > 0)
                std::memcpy(destination.data(), whole.data(), used);
            destination = destination.subspan(used);
        }
        return isChecked ? CheckCrc(data, crc, what) : Expected<void>();
    }

    /// Decompresses compressed data and checks their CRC-32, for nothing else. Errors: those of Read.
    Expected<void> Verify(const StoredData& data, const char* what) noexcept {
        if (!data.isCompressed)
            return {};
        OPENNTC_CHECK(Open(data, what));
        std::uint32_t crc = 0;
        for (std::uint32_t tile = 0; tile < header_.tiles; ++tile) {
            OPENNTC_CHECK(LoadTile(tile, what));
            crc = Crc32(GetTile(), crc);
        }
        return CheckCrc(data, crc, what);
    }

    /// Reads bytes from `offset` of the data on, which must be there; checks no CRC-32. Whole tiles are
    /// decompressed where they go to, and not kept. Errors: those of Read.
    Expected<void> ReadPart(const StoredData& data, std::uint64_t offset, std::span<std::byte> destination,
                            const char* what) noexcept {
        if (!data.isCompressed)
            return ReadStored(data, offset, destination, what);
        OPENNTC_CHECK(Open(data, what));
        while (!destination.empty()) {
            const auto tile = static_cast<std::uint32_t>(offset / container::kGDeflateTileBytes);
            const auto begin = static_cast<std::size_t>(offset % container::kGDeflateTileBytes);
            std::size_t used = header_.GetTileBytes(tile) - begin;
            if (begin == 0 && used <= destination.size() && tile != loadedTile_) {
                OPENNTC_CHECK(Decompress(tile, destination.first(used), what));
            } else {
                OPENNTC_CHECK(LoadTile(tile, what));
                used = std::min(used, destination.size());
                std::memcpy(destination.data(), GetTile().data() + begin, used);
            }
            destination = destination.subspan(used);
            offset += used;
        }
        return {};
    }

private:
    static constexpr std::uint32_t kNoTile = 0xFFFFFFFFu;

    static Expected<void> CheckCrc(const StoredData& data, std::uint32_t crc, const char* what) noexcept {
        if (data.crc32 == 0 || data.crc32 == crc)
            return {};
        return Fail(Status::FileUnrecognized, "%s: crc32: %08x: must be %08x: corrupt", what, crc,
                    data.crc32);
    }

    Expected<void> ReadStored(const StoredData& data, std::uint64_t offset, std::span<std::byte> destination,
                              const char* what) noexcept {
        return detail::ReadStoredBytes(*stream_, data, offset, destination, what);
    }

    /// Reads the header and the table of tiles, unless they are those of the last call.
    Expected<void> Open(const StoredData& data, const char* what) noexcept {
        if (isOpen_ && data.range == range_)
            return {};
        isOpen_ = false;
        loadedTile_ = kNoTile;
        range_ = data.range;
        OPENNTC_ASSIGN(header_, detail::ReadGDeflateTable(*stream_, data, table_, what));
        isOpen_ = true;
        return {};
    }

    Expected<void> Decompress(std::uint32_t tile, std::span<std::byte> destination,
                              const char* what) noexcept {
        OPENNTC_ASSIGN(
            const container::GDeflateTileRange place,
            container::FindGDeflateTile(header_, std::as_const(table_).AsSpan(), range_.size, tile));
        const std::uint64_t offset = range_.offset + place.offset;
        const std::span<const std::byte> memory = stream_->GetMemory();
        if (!memory.empty() && IsRangeInside(offset, place.size, memory.size()))
            return container::DecompressGDeflateTile(
                memory.subspan(static_cast<std::size_t>(offset), place.size), destination, tile);
        OPENNTC_CHECK(compressed_.Resize(place.size));
        if (!stream_->ReadAt(offset, compressed_.data(), place.size))
            return Fail(Status::IOError, "%s: %zu bytes at %llu: cannot be read", what, place.size,
                        static_cast<unsigned long long>(offset));
        return container::DecompressGDeflateTile(std::as_const(compressed_).AsSpan(), destination, tile);
    }

    Expected<void> LoadTile(std::uint32_t tile, const char* what) noexcept {
        if (tile == loadedTile_)
            return {};
        loadedTile_ = kNoTile;
        OPENNTC_CHECK(tile_.Resize(container::kGDeflateTileBytes));
        OPENNTC_CHECK(Decompress(tile, tile_.AsSpan().first(header_.GetTileBytes(tile)), what));
        loadedTile_ = tile;
        return {};
    }
    std::span<const std::byte> GetTile() const noexcept {
        return tile_.AsSpan().first(header_.GetTileBytes(loadedTile_));
    }

    Stream* stream_;
    bool isOpen_ = false;
    StreamRange range_; // of the compressed data that table_ is of
    container::GDeflateHeader header_;
    std::uint32_t loadedTile_ = kNoTile;
    Array<std::byte> table_;
    Array<std::byte> compressed_; // a tile
    Array<std::byte> tile_;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
