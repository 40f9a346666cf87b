// SPDX-License-Identifier: MIT
// Stability: experimental
// Compression to GDeflate streams, as files of generation 3 hold them.
#pragma once

#include "openntc/container/GDeflate.h"
#include "openntc/container/detail/GDeflateCheapest.h"
#include "openntc/container/detail/GDeflateMatches.h"
#include "openntc/container/detail/GDeflateWriter.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

inline constexpr int kDefaultGDeflateLevel = 9;

/// Compresses streams one after the other with the same memory, 1.5 MB of `allocator`.
class GDeflateEncoder {
public:
    /// Level 1 (fastest) to 12 (smallest); values <= 0 mean 9. The same data and level give the same bytes.
    explicit GDeflateEncoder(int level = kDefaultGDeflateLevel,
                             Allocator& allocator = GetDefaultAllocator()) noexcept
        : effort_(detail::GetGDeflateEffort(level)), finder_(allocator), cheapest_(allocator),
          tokens_(allocator), words_(allocator) {}

    /// Replaces `stream` by the compressed `data`, of 1 byte to 65535 tiles of 64 KiB. Errors: OutOfRange for
    /// other sizes, OutOfMemory.
    Expected<void> Compress(std::span<const std::byte> data, Array<std::byte>& stream) noexcept {
        const std::size_t tiles = (data.size() + kGDeflateTileBytes - 1) / kGDeflateTileBytes;
        if (tiles < 1 || tiles > kMaxGDeflateTiles)
            return Fail(Status::OutOfRange, "GDeflate: %zu bytes: must be 1 byte to %u tiles of %zu",
                        data.size(), kMaxGDeflateTiles, kGDeflateTileBytes);
        const std::size_t tableBytes = kGDeflateHeaderBytes + 4 * tiles;
        stream.clear();
        OPENNTC_CHECK(stream.Resize(tableBytes));
        OPENNTC_CHECK(words_.Resize(detail::kMaxGDeflateTileWords));
        std::size_t lastTile = 0;
        for (std::size_t tile = 0; tile < tiles; ++tile) {
            const std::size_t begin = tile * kGDeflateTileBytes;
            lastTile = stream.size();
            if (tile > 0)
                detail::StoreLittleEndian<std::uint32_t>(stream.AsSpan(), kGDeflateHeaderBytes + 4 * tile,
                                                         static_cast<std::uint32_t>(lastTile - tableBytes));
            OPENNTC_CHECK(
                AddTile(data.subspan(begin, std::min(data.size() - begin, kGDeflateTileBytes)), stream));
        }
        const auto lastBytes = static_cast<std::uint32_t>(data.size() % kGDeflateTileBytes);
        detail::StoreLittleEndian<std::uint32_t>(stream.AsSpan(), 0,
                                                 0xFB04u | static_cast<std::uint32_t>(tiles) << 16);
        detail::StoreLittleEndian<std::uint32_t>(stream.AsSpan(), 4, 1u | lastBytes << 2);
        // The place of tile 0's offset, which is 0, holds the size of the last tile, as DirectStorage has it.
        detail::StoreLittleEndian<std::uint32_t>(stream.AsSpan(), kGDeflateHeaderBytes,
                                                 static_cast<std::uint32_t>(stream.size() - lastTile));
        return {};
    }

private:
    Expected<void> AddTile(std::span<const std::byte> tile, Array<std::byte>& stream) noexcept {
        OPENNTC_CHECK(finder_.Start(tile));
        OPENNTC_CHECK(detail::ParseGreedily(finder_, tile, effort_, tokens_));
        for (unsigned i = 0; i < effort_.iterations; ++i)
            OPENNTC_CHECK(cheapest_.Improve(finder_, tile, effort_, tokens_));
        const std::size_t count =
            detail::WriteGDeflateTile(tile, std::as_const(tokens_).AsSpan(), words_.AsSpan());
        static_assert(std::endian::native == std::endian::little);
        return stream.Append(std::as_bytes(std::as_const(words_).AsSpan().first(count)));
    }

    detail::GDeflateEffort effort_;
    detail::GDeflateMatchFinder finder_;
    detail::GDeflateCheapestParser cheapest_;
    Array<detail::GDeflateToken> tokens_;
    Array<std::uint32_t> words_; // of a tile
};

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
