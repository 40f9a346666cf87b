// SPDX-License-Identifier: MIT
// Stability: experimental
// GDeflate streams, in which files of generation 3 may store latents and BC7 modes: tiles of 64 KiB that are
// decoded one by one. Source: the format specification, generations, "GDeflate views".
#pragma once

#include "openntc/container/Header.h"
#include "openntc/container/detail/GDeflateTile.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

inline constexpr std::size_t kGDeflateTileBytes = 65536;  ///< of every tile but the last, uncompressed
inline constexpr std::size_t kGDeflateHeaderBytes = 8;    ///< then 4 for each tile
inline constexpr std::uint32_t kMaxGDeflateTiles = 65535; ///< of a stream
/// Larger compressed tiles are refused: a compressor stores what it cannot shorten.
inline constexpr std::size_t kMaxGDeflateTileBytes = 2 * kGDeflateTileBytes;

/// The first 8 bytes of a stream.
struct GDeflateHeader {
    std::uint32_t tiles = 0;         ///< 1 … 65535
    std::uint32_t lastTileBytes = 0; ///< 1 … 65536

    constexpr std::uint64_t GetBytes() const noexcept {
        return std::uint64_t{kGDeflateTileBytes} * (tiles - 1) + lastTileBytes;
    }
    constexpr std::size_t GetTileBytes(std::uint32_t tile) const noexcept {
        return tile + 1 == tiles ? lastTileBytes : kGDeflateTileBytes;
    }
    /// Header and table of offsets; the tiles follow.
    constexpr std::size_t GetTableBytes() const noexcept {
        return kGDeflateHeaderBytes + std::size_t{4} * tiles;
    }
};

/// Decodes the header of a stream, of which the first 8 bytes are needed. Errors: FileUnrecognized.
inline Expected<GDeflateHeader> DecodeGDeflateHeader(std::span<const std::byte> stream) noexcept {
    if (stream.size() < kGDeflateHeaderBytes)
        return Fail(Status::FileUnrecognized, "GDeflate: %zu bytes: the header has %zu", stream.size(),
                    kGDeflateHeaderBytes);
    const auto id = static_cast<unsigned>(stream[0]);
    const auto check = static_cast<unsigned>(stream[1]);
    if (id != 4 || check != 0xFB)
        return Fail(Status::FileUnrecognized, "GDeflate: id %u, %u: must be 4, 251", id, check);
    const auto sizes = detail::LoadLittleEndian<std::uint32_t>(stream, 4);
    GDeflateHeader header;
    header.tiles = detail::LoadLittleEndian<std::uint32_t>(stream, 0) >> 16;
    header.lastTileBytes = (sizes >> 2) & 0x3FFFFu;
    if (header.tiles == 0)
        return Fail(Status::FileUnrecognized, "GDeflate: tiles: 0: must be 1 or more");
    if ((sizes & 3u) != 1 || header.lastTileBytes >= kGDeflateTileBytes)
        return Fail(Status::FileUnrecognized,
                    "GDeflate: tile size %u, last tile of %u bytes: must be 1, and below %zu", sizes & 3u,
                    header.lastTileBytes, kGDeflateTileBytes);
    if (header.lastTileBytes == 0)
        header.lastTileBytes = kGDeflateTileBytes;
    return header;
}

/// Where a compressed tile lies in its stream: bytes [offset, offset + size).
struct GDeflateTileRange {
    std::uint64_t offset = 0;
    std::size_t size = 0;
};

/// Finds tile number `tile`, which the header has. `table` are the first GetTableBytes() of the stream, whose
/// whole size is `streamBytes`. Errors: FileUnrecognized.
inline Expected<GDeflateTileRange> FindGDeflateTile(const GDeflateHeader& header,
                                                    std::span<const std::byte> table,
                                                    std::uint64_t streamBytes, std::uint32_t tile) noexcept {
    if (table.size() < header.GetTableBytes() || streamBytes < header.GetTableBytes())
        return Fail(Status::FileUnrecognized, "GDeflate: %llu bytes: the table of %u tiles has %zu",
                    static_cast<unsigned long long>(streamBytes), header.tiles, header.GetTableBytes());
    const std::uint64_t dataBytes = streamBytes - header.GetTableBytes();
    // The number at the place of tile 0 is something else: writers differ.
    const auto getOffset = [&](std::uint32_t number) -> std::uint64_t {
        if (number == header.tiles)
            return dataBytes;
        const std::size_t at = kGDeflateHeaderBytes + std::size_t{4} * number;
        return number == 0 ? 0 : detail::LoadLittleEndian<std::uint32_t>(table, at);
    };
    const std::uint64_t begin = getOffset(tile);
    const std::uint64_t end = getOffset(tile + 1);
    if (begin > end || end > dataBytes || end - begin > kMaxGDeflateTileBytes)
        return Fail(Status::FileUnrecognized,
                    "GDeflate: tile %u: from %llu to %llu: must be in order, inside %llu bytes, at most %zu",
                    tile, static_cast<unsigned long long>(begin), static_cast<unsigned long long>(end),
                    static_cast<unsigned long long>(dataBytes), kMaxGDeflateTileBytes);
    return GDeflateTileRange{header.GetTableBytes() + begin, static_cast<std::size_t>(end - begin)};
}

/// Decompresses one tile, which fills `destination` exactly; `tile` numbers it in messages. Takes no memory.
/// Errors: FileUnrecognized.
inline Expected<void> DecompressGDeflateTile(std::span<const std::byte> compressed,
                                             std::span<std::byte> destination, std::uint32_t tile) noexcept {
    detail::GDeflateTile decoder(compressed, destination);
    if (const char* wrong = decoder.Decode(); wrong != nullptr)
        return Fail(Status::FileUnrecognized, "GDeflate: tile %u: %s: corrupt", tile, wrong);
    return {};
}

/// Decompresses a whole stream into the start of `destination` and returns how many bytes it has. Takes no
/// memory. Errors: FileUnrecognized for a stream that is corrupt, InvalidArgument for one that says it is
/// larger than the destination.
inline Expected<std::size_t> DecompressGDeflate(std::span<const std::byte> stream,
                                                std::span<std::byte> destination) noexcept {
    OPENNTC_ASSIGN(const GDeflateHeader header, DecodeGDeflateHeader(stream));
    if (header.GetBytes() > destination.size())
        return Fail(Status::InvalidArgument, "GDeflate: %llu bytes: the destination has %zu",
                    static_cast<unsigned long long>(header.GetBytes()), destination.size());
    for (std::uint32_t tile = 0; tile < header.tiles; ++tile) {
        OPENNTC_ASSIGN(const GDeflateTileRange range, FindGDeflateTile(header, stream, stream.size(), tile));
        OPENNTC_CHECK(DecompressGDeflateTile(
            stream.subspan(static_cast<std::size_t>(range.offset), range.size),
            destination.subspan(tile * kGDeflateTileBytes, header.GetTileBytes(tile)), tile));
    }
    return static_cast<std::size_t>(header.GetBytes());
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
