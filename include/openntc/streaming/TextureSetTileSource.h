// SPDX-License-Identifier: MIT
// Stability: experimental
// Tiles of a texture set: slices of its latents, read from a file, a stream or memory.
#pragma once

#include "openntc/core/FileStream.h"
#include "openntc/inference/PartialInference.h"
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

/// A texture set whose levels are its latent images (MakeTextureSetTileLayout). A tile holds the slice of its
/// rectangle at all mips that the level serves, the tail the latents of all its mips whole; so any texel of
/// any of them decodes to the bits of the whole set. Its textures need TileFormat::TextureSet.
class TextureSetTileSource final : public TileSource {
public:
    /// From a file, which is opened once for each thread that reads at a time; sources of one file share
    /// their tiles in a loader. Errors: those of FileReader::Open, TextureSetMetadata::Load and
    /// MakeTextureSetTileLayout; Unsupported for a set whose tail would be several tiles.
    static Expected<Shared<TextureSetTileSource>> OpenFile(const std::filesystem::path& path, int tileWidth,
                                                           int tileHeight,
                                                           Allocator& allocator = GetDefaultAllocator());

    /// From the bytes of a file in memory, a mapping for instance, which stays until the source is gone. No
    /// reader waits for another one. Errors: as OpenFile.
    static Expected<Shared<TextureSetTileSource>> OpenMemory(std::span<const std::byte> file, int tileWidth,
                                                             int tileHeight,
                                                             Allocator& allocator = GetDefaultAllocator());

    /// From a stream, which stays until the source is gone and is nobody else's until then. One thread reads
    /// at a time. Errors: as OpenFile.
    static Expected<Shared<TextureSetTileSource>> OpenStream(Stream& stream, int tileWidth, int tileHeight,
                                                             Allocator& allocator = GetDefaultAllocator());

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

    TextureSetTileSource(TextureSetMetadata&& metadata, const TileLayout& layout, Allocator& allocator)
        : metadata_(std::move(metadata)), layout_(layout), readers_(allocator) {}

    static Expected<Shared<TextureSetTileSource>> Make(Stream& stream, int tileWidth, int tileHeight,
                                                       Allocator& allocator);
    Expected<SliceLayout> GetTileLayout(std::uint32_t tile) const noexcept;
    Expected<void> FindLargestTile() noexcept;
    Expected<void> ReadFromFile(const SliceLayout& slice, std::span<std::byte> destination);

    TextureSetMetadata metadata_;
    TileLayout layout_;
    std::size_t largestTileBytes_ = 0;
    std::span<const std::byte> memory_; ///< empty: a stream or a file
    Stream* stream_ = nullptr;          ///< null: memory or a file
    std::filesystem::path path_;
    Array<std::byte> identity_; ///< of the file
    detail::Mutex mutex_;
    Array<FileReader> readers_; ///< not in use
};

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::Make(Stream& stream, int tileWidth, int tileHeight, Allocator& allocator) {
    OPENNTC_ASSIGN(TextureSetMetadata metadata, TextureSetMetadata::Load(stream, allocator));
    OPENNTC_ASSIGN(const TileLayout layout, MakeTextureSetTileLayout(metadata, tileWidth, tileHeight));
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source,
                   MakeShared<TextureSetTileSource>(allocator, std::move(metadata), layout, allocator));
    OPENNTC_CHECK(source->FindLargestTile());
    return source;
}

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::OpenFile(const std::filesystem::path& path, int tileWidth, int tileHeight,
                               Allocator& allocator) {
    OPENNTC_ASSIGN(FileReader reader, FileReader::Open(path));
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source, Make(reader, tileWidth, tileHeight, allocator));
    source->path_ = path;
    OPENNTC_ASSIGN(source->identity_, MakeFileIdentity(path, allocator));
    OPENNTC_CHECK(source->readers_.PushBack(std::move(reader)));
    return source;
}

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::OpenMemory(std::span<const std::byte> file, int tileWidth, int tileHeight,
                                 Allocator& allocator) {
    ReadOnlyMemoryStream stream(file);
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source, Make(stream, tileWidth, tileHeight, allocator));
    source->memory_ = file;
    return source;
}

inline Expected<Shared<TextureSetTileSource>>
TextureSetTileSource::OpenStream(Stream& stream, int tileWidth, int tileHeight, Allocator& allocator) {
    OPENNTC_ASSIGN(Shared<TextureSetTileSource> source, Make(stream, tileWidth, tileHeight, allocator));
    source->stream_ = &stream;
    return source;
}

inline Expected<SliceLayout> TextureSetTileSource::GetTileLayout(std::uint32_t tile) const noexcept {
    OPENNTC_ASSIGN(const TileSlice slice, layout_.GetTileSlice(tile));
    return GetSliceLayout(metadata_,
                          {slice.firstMip, slice.mips, {slice.left, slice.top, slice.width, slice.height}});
}

inline std::size_t TextureSetTileSource::GetTileBytes(std::uint32_t tile) const noexcept {
    const Expected<SliceLayout> slice = GetTileLayout(tile);
    return slice ? static_cast<std::size_t>(slice->bytes) : 0;
}

/// A grid's width depends on the tile's column alone, its height on the row.
inline Expected<void> TextureSetTileSource::FindLargestTile() noexcept {
    const auto find = [this](const TileLevel& level) -> Expected<void> {
        std::array<std::array<int, 2>, 2> largest{}; // high, low resolution: width, height
        int bitsPerPixel[2] = {};
        for (const bool isColumn : {false, true}) {
            for (int i = 0; i < (isColumn ? level.tilesY : level.tilesX); ++i) {
                const int step = isColumn ? i * level.tilesX : i;
                OPENNTC_ASSIGN(const SliceLayout slice,
                               GetTileLayout(level.firstTile + static_cast<std::uint32_t>(step)));
                for (const SliceGrid& grid : slice.GetGrids()) {
                    std::array<int, 2>& size = largest[grid.isLowRes ? 1 : 0];
                    size[0] = std::max(size[0], grid.width);
                    size[1] = std::max(size[1], grid.height);
                    bitsPerPixel[grid.isLowRes ? 1 : 0] = grid.bitsPerPixel;
                }
            }
        }
        std::uint64_t bytes = 0;
        for (std::size_t i = 0; i < 2; ++i)
            bytes += detail::GetPackedBytes(largest[i][0], largest[i][1],
                                            static_cast<std::uint64_t>(bitsPerPixel[i]));
        largestTileBytes_ = std::max(largestTileBytes_, static_cast<std::size_t>(bytes));
        return {};
    };
    for (const TileLevel& level : layout_.GetLevels())
        OPENNTC_CHECK(find(level));
    if (layout_.GetTailTileCount() > 0) {
        OPENNTC_ASSIGN(const SliceLayout tail,
                       GetTileLayout(static_cast<std::uint32_t>(layout_.GetRegularTileCount())));
        largestTileBytes_ = std::max(largestTileBytes_, static_cast<std::size_t>(tail.bytes));
    }
    return {};
}

inline Expected<TileRead> TextureSetTileSource::ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                                         const TileCancellation&) {
    OPENNTC_ASSIGN(const SliceLayout slice, GetTileLayout(tile));
    if (stream_ != nullptr) {
        const detail::Lock lock(mutex_);
        OPENNTC_CHECK(ReadSlice(slice, *stream_, destination));
    } else if (!memory_.empty()) {
        OPENNTC_CHECK(ReadSlice(slice, memory_, 0, destination));
    } else {
        OPENNTC_CHECK(ReadFromFile(slice, destination));
    }
    return TileRead{TileAnswer::Ready, static_cast<std::size_t>(slice.bytes)};
}

inline Expected<void> TextureSetTileSource::ReadFromFile(const SliceLayout& slice,
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
    const Expected<void> read = ReadSlice(slice, reader, destination);
    lock.lock();
    static_cast<void>(readers_.PushBack(std::move(reader))); // without memory it is closed
    return read;
}

inline std::uint32_t TextureSetTileSource::GetSliceRows(std::uint32_t tile,
                                                        std::span<NtcSliceConstants> rows) const noexcept {
    const Expected<TileSlice> slice = layout_.GetTileSlice(tile);
    const Expected<SliceLayout> grids = GetTileLayout(tile);
    if (!slice || !grids)
        return 0;
    const bool isTail = tile >= static_cast<std::uint32_t>(layout_.GetRegularTileCount());
    std::uint32_t count = 0;
    for (int i = 0; i < (isTail ? slice->mips : 1) && count < rows.size(); ++i) {
        const ColorMip& mip = metadata_.GetColorMips()[static_cast<std::size_t>(slice->firstMip + i)];
        rows[count++] = MakeSliceConstants(*grids, mip.neuralMip);
    }
    return count;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
