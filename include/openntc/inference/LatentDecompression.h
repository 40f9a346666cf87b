// SPDX-License-Identifier: MIT
// Stability: experimental
// Latents whose layers may be compressed, for a device that decompresses GDeflate tiles itself
// (VK_NV_memory_decompression): what to upload, which tile goes where, what is copied afterwards. Everything
// in headers is checked here; a device sees tiles alone. docs/generations.md, "On the GPU".
#pragma once

#include "openntc/inference/ReadLatents.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// One GDeflate tile: of the work buffer bytes [source, source + sourceBytes).
struct LatentTile {
    std::uint64_t source = 0;      ///< a multiple of 4
    std::uint64_t destination = 0; ///< a multiple of 4, in the latents or in the work buffer
    std::uint32_t sourceBytes = 0; ///< a multiple of 4, 128 … 131072
    std::uint32_t bytes = 0;       ///< decompressed, 1 … 65536
    bool isInWork = false;         ///< what `destination` counts in
};

/// Bytes of the work buffer that belong into the latents.
struct LatentCopy {
    std::uint64_t source = 0; ///< in the work buffer
    std::uint64_t destination = 0;
    std::uint64_t bytes = 0;
};

/// Bytes of the file that belong into the work buffer.
struct LatentUpload {
    StreamRange range;
    std::uint64_t destination = 0;
};

/// In this order: the first uploadBytes of the work buffer are uploaded, the tiles decompressed, the copies
/// made. Of latents, bytes that belong to no layer are not written.
struct LatentDecompression {
    std::uint64_t uploadBytes = 0; ///< a multiple of 4
    std::uint64_t workBytes = 0;   ///< a multiple of 4, at least uploadBytes
    std::uint64_t latentBytes = 0; ///< GetLatentBufferBytes of the same mips
    Array<LatentUpload> uploads;   ///< from the first byte to the last
    Array<LatentTile> tiles;
    Array<LatentCopy> copies;
};

namespace detail {

/// What the 32 lanes of a tile read before anything else: shorter tiles are followed by zeros.
inline constexpr std::uint64_t kLeastLatentTileBytes = 128;
/// What they may read in advance beyond the last tile.
inline constexpr std::uint64_t kLatentReadAhead = 256;

inline constexpr std::uint64_t AlignToWord(std::uint64_t bytes) noexcept {
    return (bytes + 3) / 4 * 4;
}

/// Adds up one plan.
class LatentDecompressionPlanner {
public:
    LatentDecompressionPlanner(Stream& stream, Allocator& allocator) noexcept
        : stream_(&stream), table_(allocator), tileCopies_(allocator), plan_{0,
                                                                             0,
                                                                             0,
                                                                             Array<LatentUpload>(allocator),
                                                                             Array<LatentTile>(allocator),
                                                                             Array<LatentCopy>(allocator)} {}

    Expected<void> AddStored(StreamRange range, std::uint64_t destination) noexcept {
        OPENNTC_CHECK(plan_.copies.PushBack({plan_.uploadBytes, destination, range.size}));
        return Upload(range, 0);
    }

    /// The first `bytes` of compressed data, which has as many.
    Expected<void> AddCompressed(const StoredData& data, std::uint64_t destination,
                                 std::uint64_t bytes) noexcept {
        OPENNTC_ASSIGN(const container::GDeflateHeader header,
                       ReadGDeflateTable(*stream_, data, table_, "latents"));
        for (std::uint32_t number = 0; bytes > 0; ++number) {
            OPENNTC_ASSIGN(
                const container::GDeflateTileRange range,
                container::FindGDeflateTile(header, std::as_const(table_).AsSpan(), data.range.size, number));
            LatentTile tile;
            tile.source = plan_.uploadBytes;
            tile.bytes = static_cast<std::uint32_t>(header.GetTileBytes(number));
            tile.destination = destination;
            OPENNTC_CHECK(Upload({data.range.offset + range.offset, range.size}, kLeastLatentTileBytes));
            tile.sourceBytes = static_cast<std::uint32_t>(plan_.uploadBytes - tile.source);
            const std::uint64_t used = std::min<std::uint64_t>(tile.bytes, bytes);
            // Devices write whole tiles, to multiples of 4.
            tile.isInWork = destination % 4 != 0 || used < tile.bytes;
            if (tile.isInWork) {
                tile.destination = std::exchange(scratchBytes_, scratchBytes_ + AlignToWord(tile.bytes));
                OPENNTC_CHECK(tileCopies_.PushBack({tile.destination, destination, used}));
            }
            OPENNTC_CHECK(plan_.tiles.PushBack(tile));
            destination += used;
            bytes -= used;
        }
        return {};
    }

    Expected<LatentDecompression> Finish(std::uint64_t latentBytes) noexcept {
        if (!plan_.tiles.empty())
            plan_.uploadBytes += kLatentReadAhead;
        plan_.workBytes = plan_.uploadBytes + scratchBytes_;
        plan_.latentBytes = latentBytes;
        for (LatentTile& tile : plan_.tiles)
            tile.destination += tile.isInWork ? plan_.uploadBytes : 0;
        for (LatentCopy& copy : tileCopies_) {
            copy.source += plan_.uploadBytes;
            OPENNTC_CHECK(plan_.copies.PushBack(copy));
        }
        return std::move(plan_);
    }

private:
    /// Takes at least `leastBytes` of the work buffer.
    Expected<void> Upload(StreamRange range, std::uint64_t leastBytes) noexcept {
        const std::uint64_t destination = plan_.uploadBytes;
        plan_.uploadBytes += AlignToWord(std::max(range.size, leastBytes));
        if (!plan_.uploads.empty()) { // tiles follow one another in the file, mostly without gaps
            LatentUpload& last = plan_.uploads.back();
            if (last.range.offset + last.range.size == range.offset &&
                last.destination + last.range.size == destination) {
                last.range.size += range.size;
                return {};
            }
        }
        return plan_.uploads.PushBack({range, destination});
    }

    Stream* stream_;
    Array<std::byte> table_;
    Array<LatentCopy> tileCopies_; // of what is decompressed into the work buffer
    std::uint64_t scratchBytes_ = 0;
    LatentDecompression plan_;
};

} // namespace detail

/// Plans the latents that ReadLatents of the same mips would write. The work buffer takes at most three times
/// their bytes and 192 KiB for each layer, whatever a file says. What a plan cannot know: whether the bits of
/// a tile are right, and the CRC-32. Vulkan promises nothing for tiles that are corrupt, so sets that were
/// not checked before (ntc validate) are for ReadLatents. Errors: OutOfRange for mips that the set does not
/// have; IOError; FileUnrecognized for headers and tables that are corrupt; OutOfMemory.
inline Expected<LatentDecompression>
PlanLatentDecompression(const TextureSetMetadata& metadata, Stream& stream, int firstMip, int numMips,
                        Allocator& allocator = GetDefaultAllocator()) noexcept {
    OPENNTC_ASSIGN(const std::size_t latentBytes, GetLatentBufferBytes(metadata, firstMip, numMips));
    detail::LatentDecompressionPlanner planner(stream, allocator);
    if (metadata.GetGeneration() == 1) {
        OPENNTC_ASSIGN(const StreamRange range, metadata.GetStreamRangeForLatents(firstMip, numMips));
        OPENNTC_CHECK(planner.AddStored(range, 0));
        return planner.Finish(latentBytes);
    }
    const MipRange images = metadata.GetLatentsOfMips(firstMip, numMips);
    std::uint64_t mipStart = 0;
    for (int i = images.first; i <= images.last; ++i) {
        const LatentMip& mip = metadata.GetLatentMips()[static_cast<std::size_t>(i)];
        const std::uint64_t layerBytes = mip.GetLayerBytes();
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer) {
            const StoredData& data = mip.layerData[layer];
            const std::uint64_t destination = mipStart + layer * layerBytes;
            if (data.isCompressed)
                OPENNTC_CHECK(planner.AddCompressed(data, destination, layerBytes));
            else
                OPENNTC_CHECK(planner.AddStored({data.range.offset, layerBytes}, destination));
        }
        mipStart += GetLatentMipBytes(mip.width, mip.height, mip.layers);
    }
    return planner.Finish(latentBytes);
}

/// Reads what is uploaded; zeros between. `upload` has uploadBytes. Errors: InvalidArgument for another size;
/// IOError.
inline Expected<void> ReadLatentUploads(const LatentDecompression& plan, Stream& stream,
                                        std::span<std::byte> upload) noexcept {
    if (upload.size() != plan.uploadBytes)
        return Fail(Status::InvalidArgument, "upload: %zu bytes: must be %llu", upload.size(),
                    static_cast<unsigned long long>(plan.uploadBytes));
    std::size_t end = 0; // of what is written
    for (const LatentUpload& piece : plan.uploads) {
        const auto begin = static_cast<std::size_t>(piece.destination);
        const auto bytes = static_cast<std::size_t>(piece.range.size);
        std::memset(upload.data() + end, 0, begin - end);
        if (!stream.ReadAt(piece.range.offset, upload.data() + begin, bytes))
            return Fail(Status::IOError, "latents: %zu bytes at %llu: cannot be read", bytes,
                        static_cast<unsigned long long>(piece.range.offset));
        end = begin + bytes;
    }
    std::memset(upload.data() + end, 0, upload.size() - end);
    return {};
}

/// Does on the CPU what a device does with a tile: for devices without the feature, where tiles are jobs for
/// threads. `work` has workBytes, `latents` latentBytes; `number` is the tile's in messages. Errors:
/// FileUnrecognized.
inline Expected<void> DecompressLatentTile(const LatentTile& tile, std::span<std::byte> work,
                                           std::span<std::byte> latents, std::uint32_t number) noexcept {
    const std::span<std::byte> target = tile.isInWork ? work : latents;
    return container::DecompressGDeflateTile(
        work.subspan(static_cast<std::size_t>(tile.source), tile.sourceBytes),
        target.subspan(static_cast<std::size_t>(tile.destination), tile.bytes), number);
}

/// The copies, on the CPU, when all tiles are decompressed.
inline void CopyLatents(const LatentDecompression& plan, std::span<const std::byte> work,
                        std::span<std::byte> latents) noexcept {
    for (const LatentCopy& copy : plan.copies)
        std::memcpy(latents.data() + copy.destination, work.data() + copy.source,
                    static_cast<std::size_t>(copy.bytes));
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
