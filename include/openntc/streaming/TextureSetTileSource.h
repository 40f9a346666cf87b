// SPDX-License-Identifier: MIT
// Stability: experimental
// Tiles of a texture set: slices of its latents, read from a file, a stream or memory.
#pragma once

#include "openntc/core/FileStream.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/streaming/DecompressedTileCache.h"
#include "openntc/streaming/FileIdentity.h"
#include "openntc/streaming/TextureSetTileLayout.h"
#include "openntc/streaming/TileSource.h"
#include "openntc/streaming/detail/Threads.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A texture set of any generation whose levels are its latent images (MakeTextureSetTileLayout). A tile
/// holds the slice of its rectangle at all mips that the level serves, the tail the latents of all its mips
/// whole; so any texel of any of them decodes to the bits of the whole set. Its textures need
/// TileFormat::TextureSet.
///
/// Where latents are compressed, a tile is made of GDeflate tiles of 64 KiB, of which `cache` keeps some; an
/// empty one is made when it is needed, of kCachedTiles. Several sources may share one. Each thread that
/// reads takes up to 384 KiB besides, from the allocator, which several threads call at once then.
class TextureSetTileSource final : public TileSource {
public:
    static constexpr std::size_t kCachedTiles = 16; ///< 1 MiB

    /// From a file, which is opened once for each thread that reads at a time; sources of one file share
    /// their tiles in a loader. Errors: those of FileReader::Open, TextureSetMetadata::Load and
    /// MakeTextureSetTileLayout; Unsupported for a set whose tail would be several tiles.
    static Expected<Shared<TextureSetTileSource>> OpenFile(const std::filesystem::path& path, int tileWidth,
                                                           int tileHeight,
                                                           Allocator& allocator = GetDefaultAllocator(),
                                                           Shared<DecompressedTileCache> cache = {});

    /// From the bytes of a file in memory, a mapping for instance, which stays until the source is gone. No
    /// reader waits for another one. Errors: as OpenFile.
    static Expected<Shared<TextureSetTileSource>> OpenMemory(std::span<const std::byte> file, int tileWidth,
                                                             int tileHeight,
                                                             Allocator& allocator = GetDefaultAllocator(),
                                                             Shared<DecompressedTileCache> cache = {});

    /// From a stream, which stays until the source is gone and is nobody else's until then. One thread reads
    /// at a time. Errors: as OpenFile.
    static Expected<Shared<TextureSetTileSource>> OpenStream(Stream& stream, int tileWidth, int tileHeight,
                                                             Allocator& allocator = GetDefaultAllocator(),
                                                             Shared<DecompressedTileCache> cache = {});

    /// Weights, constants and textures of the set.
    const TextureSetMetadata& GetMetadata() const noexcept { return metadata_; }

    const TileLayout& GetLayout() const noexcept override { return layout_; }
    std::size_t GetTileBytes(std::uint32_t tile) const noexcept override;
    std::size_t GetLargestTileBytes() const noexcept override { return largestTileBytes_; }
    Expected<TileRead> ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                const TileCancellation& cancellation) override;
    std::uint32_t GetSliceRows(std::uint32_t tile, std::span<NtcSliceConstants> rows) const noexcept override;
    std::span<const std::byte> GetIdentity() const noexcept override { return identity_.AsSpan(); }

private:
    template <typename Made, typename... Arguments>
    friend Expected<Shared<Made>> MakeShared(Allocator& allocator, Arguments&&... arguments);

    /// Of the two grids of a tile in front of the tail.
    using GridSizes = std::array<std::array<int, 2>, 2>;

    TextureSetTileSource(TextureSetMetadata&& metadata, const TileLayout& layout, Allocator& allocator)
        : metadata_(std::move(metadata)), layout_(layout), allocator_(&allocator), readers_(allocator) {}

    static Expected<Shared<TextureSetTileSource>> Make(Stream& stream, int tileWidth, int tileHeight,
                                                       Allocator& allocator,
                                                       Shared<DecompressedTileCache> cache);
    Expected<SliceDesc> GetSliceDesc(std::uint32_t tile) const noexcept;
    Expected<GridSizes> GetGridSizes(std::uint32_t tile) const noexcept;
    std::uint64_t GetGridBytes(std::size_t grid, std::array<int, 2> size) const noexcept;
    Expected<std::uint64_t> GetLargestTileBytesOf(const TileLevel& level) const noexcept;
    Expected<void> FindLargestTile() noexcept;
    Expected<std::uint64_t> ReadSliceFrom(Stream& stream, const SliceDesc& slice,
                                          std::span<std::byte> destination);
    Expected<std::uint64_t> ReadFromFile(const SliceDesc& slice, std::span<std::byte> destination);

    TextureSetMetadata metadata_;
    TileLayout layout_;
    Allocator* allocator_;
    std::size_t largestTileBytes_ = 0;
    std::span<const std::byte> memory_; ///< empty: a stream or a file
    Stream* stream_ = nullptr;          ///< null: memory or a file
    std::filesystem::path path_;
    Array<std::byte> identity_;           ///< of the file
    Shared<DecompressedTileCache> cache_; ///< empty: nothing is compressed
    std::uint64_t cacheSource_ = 0;
    detail::Mutex mutex_;
    Array<FileReader> readers_; ///< not in use
};

namespace detail {

inline bool HasCompressedLatents(const TextureSetMetadata& metadata) noexcept {
    for (const LatentMip& mip : metadata.GetLatentMips()) {
        for (int layer = 0; layer < mip.layers; ++layer) {
            if (mip.layerData[static_cast<std::size_t>(layer)].isCompressed)
                return true;
        }
    }
    return false;
}

} // namespace detail

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::Make(Stream& stream, int tileWidth, int tileHeight, Allocator& allocator,
                           Shared<DecompressedTileCache> cache) {
    OPENNTC_ASSIGN(TextureSetMetadata metadata, TextureSetMetadata::Load(stream, allocator));
    OPENNTC_ASSIGN(const TileLayout layout, MakeTextureSetTileLayout(metadata, tileWidth, tileHeight));
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source,
                   MakeShared<TextureSetTileSource>(allocator, std::move(metadata), layout, allocator));
    OPENNTC_CHECK(source->FindLargestTile());
    if (detail::HasCompressedLatents(source->metadata_)) {
        source->cache_ = std::move(cache);
        if (!source->cache_) {
            OPENNTC_ASSIGN(source->cache_, DecompressedTileCache::Create(kCachedTiles, allocator));
        }
        source->cacheSource_ = detail::CachedDataReader::GetNewSource(*source->cache_);
    }
    return source;
}

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::OpenFile(const std::filesystem::path& path, int tileWidth, int tileHeight,
                               Allocator& allocator, Shared<DecompressedTileCache> cache) {
    OPENNTC_ASSIGN(FileReader reader, FileReader::Open(path));
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source,
                   Make(reader, tileWidth, tileHeight, allocator, std::move(cache)));
    source->path_ = path;
    OPENNTC_ASSIGN(source->identity_, MakeFileIdentity(path, allocator));
    OPENNTC_CHECK(source->readers_.PushBack(std::move(reader)));
    return source;
}

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::OpenMemory(std::span<const std::byte> file, int tileWidth, int tileHeight,
                                 Allocator& allocator, Shared<DecompressedTileCache> cache) {
    ReadOnlyMemoryStream stream(file);
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source,
                   Make(stream, tileWidth, tileHeight, allocator, std::move(cache)));
    source->memory_ = file;
    return source;
}

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::OpenStream(Stream& stream, int tileWidth, int tileHeight, Allocator& allocator,
                                 Shared<DecompressedTileCache> cache) {
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source,
                   Make(stream, tileWidth, tileHeight, allocator, std::move(cache)));
    source->stream_ = &stream;
    return source;
}

inline Expected<SliceDesc> TextureSetTileSource::GetSliceDesc(std::uint32_t tile) const noexcept {
    OPENNTC_ASSIGN(const TileSlice slice, layout_.GetTileSlice(tile));
    return MakeSliceDesc(slice);
}

inline std::size_t TextureSetTileSource::GetTileBytes(std::uint32_t tile) const noexcept {
    const Expected<SliceDesc> slice = GetSliceDesc(tile);
    return slice ? static_cast<std::size_t>(GetPartialLatentBufferSize(metadata_, *slice).value_or(0)) : 0;
}

inline Expected<TextureSetTileSource::GridSizes>
TextureSetTileSource::GetGridSizes(std::uint32_t tile) const noexcept {
    OPENNTC_ASSIGN(const SliceDesc slice, GetSliceDesc(tile));
    GridSizes sizes{};
    if (metadata_.GetGeneration() > 1) {
        OPENNTC_ASSIGN(const LatentMipSliceLayout layered, GetLatentMipSlices(metadata_, slice));
        for (std::size_t i = 0; i < std::min(layered.GetParts().size(), sizes.size()); ++i)
            sizes[i] = {layered.parts[i].width, layered.parts[i].height};
        return sizes;
    }
    OPENNTC_ASSIGN(const SliceLayout grids, GetSliceLayout(metadata_, slice));
    for (const SliceGrid& grid : grids.GetGrids())
        sizes[grid.isLowRes ? 1 : 0] = {grid.width, grid.height};
    return sizes;
}

inline std::uint64_t TextureSetTileSource::GetGridBytes(std::size_t grid,
                                                        std::array<int, 2> size) const noexcept {
    if (metadata_.GetGeneration() > 1)
        return GetLatentMipBytes(size[0], size[1], metadata_.GetLatentMips()[0].layers);
    return detail::GetPackedBytes(size[0], size[1],
                                  detail::GetBitsPerPixel(metadata_.GetLatentShape(), grid == 1));
}

/// A grid's width depends on the tile's column alone, its height on the row.
inline Expected<std::uint64_t>
TextureSetTileSource::GetLargestTileBytesOf(const TileLevel& level) const noexcept {
    GridSizes largest{};
    for (const bool isColumn : {false, true}) {
        for (int i = 0; i < (isColumn ? level.tilesY : level.tilesX); ++i) {
            const int step = isColumn ? i * level.tilesX : i;
            OPENNTC_ASSIGN(const GridSizes sizes,
                           GetGridSizes(level.firstTile + static_cast<std::uint32_t>(step)));
            for (std::size_t grid = 0; grid < sizes.size(); ++grid)
                largest[grid] = {std::max(largest[grid][0], sizes[grid][0]),
                                 std::max(largest[grid][1], sizes[grid][1])};
        }
    }
    return GetGridBytes(0, largest[0]) + GetGridBytes(1, largest[1]);
}

inline Expected<void> TextureSetTileSource::FindLargestTile() noexcept {
    std::uint64_t bytes = 0;
    for (const TileLevel& level : layout_.GetLevels()) {
        OPENNTC_ASSIGN(const std::uint64_t ofLevel, GetLargestTileBytesOf(level));
        bytes = std::max(bytes, ofLevel);
    }
    if (layout_.GetTailTileCount() > 0)
        bytes = std::max<std::uint64_t>(
            bytes, GetTileBytes(static_cast<std::uint32_t>(layout_.GetRegularTileCount())));
    largestTileBytes_ = static_cast<std::size_t>(bytes);
    return {};
}

inline Expected<TileRead> TextureSetTileSource::ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                                         const TileCancellation&) {
    OPENNTC_ASSIGN(const SliceDesc slice, GetSliceDesc(tile));
    std::uint64_t bytes = 0;
    if (stream_ != nullptr) {
        const detail::Lock lock(mutex_);
        OPENNTC_ASSIGN(bytes, ReadSliceFrom(*stream_, slice, destination));
    } else if (!memory_.empty()) {
        ReadOnlyMemoryStream stream(memory_);
        OPENNTC_ASSIGN(bytes, ReadSliceFrom(stream, slice, destination));
    } else {
        OPENNTC_ASSIGN(bytes, ReadFromFile(slice, destination));
    }
    return TileRead{TileAnswer::Ready, static_cast<std::size_t>(bytes)};
}

inline Expected<std::uint64_t> TextureSetTileSource::ReadSliceFrom(Stream& stream, const SliceDesc& slice,
                                                                   std::span<std::byte> destination) {
    if (metadata_.GetGeneration() == 1) {
        SliceLayout grids;
        OPENNTC_CHECK(detail::FillSliceLayout(metadata_, slice, grids));
        OPENNTC_CHECK(ReadSlice(grids, stream, destination));
        return grids.bytes;
    }
    OPENNTC_ASSIGN(const LatentMipSliceLayout layered, GetLatentMipSlices(metadata_, slice));
    if (!cache_) {
        OPENNTC_CHECK(ReadLatentMipSlices(metadata_, layered, stream, destination, *allocator_));
        return layered.bytes;
    }
    detail::CachedDataReader reader(stream, *allocator_, *cache_, cacheSource_);
    OPENNTC_CHECK(detail::ReadLatentMipParts(metadata_, layered, stream, reader, destination));
    return layered.bytes;
}

inline Expected<std::uint64_t> TextureSetTileSource::ReadFromFile(const SliceDesc& slice,
                                                                  std::span<std::byte> destination) {
    detail::Lock lock(mutex_);
    if (readers_.empty()) {
        lock.unlock();
        OPENNTC_ASSIGN(FileReader opened, FileReader::Open(path_));
        lock.lock();
        OPENNTC_CHECK(readers_.PushBack(std::move(opened)));
    }
    FileReader reader = std::move(readers_.back());
    readers_.pop_back();
    lock.unlock();
    const Expected<std::uint64_t> bytes = ReadSliceFrom(reader, slice, destination);
    lock.lock();
    static_cast<void>(readers_.PushBack(std::move(reader))); // without memory it is closed
    return bytes;
}

inline std::uint32_t TextureSetTileSource::GetSliceRows(std::uint32_t tile,
                                                        std::span<NtcSliceConstants> rows) const noexcept {
    return MakeTileSliceRows(metadata_, layout_, tile, rows);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
