// SPDX-License-Identifier: MIT
// Images of files as tiles of the demand loader.
#pragma once

#include "openntc/core/Shared.h"
#include "openntc/streaming/TileSource.h"
#include "openntc/streaming/TiledTexture.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

struct InputImage;

/// An image in memory with all its mips, cut up; PixelTileSource says how its tiles look. What NtcDemandGrad
/// gives of it are the file's values, colours in linear light:
///
///   8 bits, sRGB            RGBA8Srgb
///   8 bits, linear          R8 for one channel, otherwise RGBA8
///   16 bits, floats         R32F for one channel, otherwise RGBA32F; R16F and RGBA16F if binary16 holds
///                           every value of mip 0. Colours of 16-bit sRGB files are decoded when
///                           the file is read.
///
/// Gray becomes red, green and blue wherever there is more than one channel. Mips are averages by area in
/// linear light, weighed by alpha.
class ImageTileSource final : public TileSource {
public:
    /// Reads a file of any format that ReadImage reads (encode/InputImage.h). `isSrgb`: colours of integers
    /// are sRGB; floats never are. Throws CommandError(BadInput) about a file that cannot be read.
    static Shared<ImageTileSource> Open(const std::string& path, int tileWidth, int tileHeight, bool isSrgb);

    /// The same of an image that was read.
    static Shared<ImageTileSource> Make(const InputImage& image, const std::string& name, int tileWidth,
                                        int tileHeight, bool isSrgb);

    /// For the texture's description.
    TileFormat GetFormat() const noexcept { return format_; }

    const TileLayout& GetLayout() const noexcept override { return tiles_->GetLayout(); }
    std::size_t GetTileBytes(std::uint32_t tile) const noexcept override {
        return tiles_->GetTileBytes(tile);
    }
    std::size_t GetLargestTileBytes() const noexcept override { return tiles_->GetLargestTileBytes(); }
    Expected<TileRead> ReadTile(std::uint32_t tile, std::span<std::byte> destination,
                                const TileCancellation& cancellation) override {
        return tiles_->ReadTile(tile, destination, cancellation);
    }

    std::span<const std::byte> GetIdentity() const noexcept override { return identity_.AsSpan(); }

    ImageTileSource(TileFormat format, std::vector<std::vector<std::byte>>&& mips,
                    Shared<PixelTileSource> tiles)
        : format_(format), mips_(std::move(mips)), tiles_(std::move(tiles)) {}

private:
    TileFormat format_;
    std::vector<std::vector<std::byte>> mips_; ///< tiles_ reads them
    Shared<PixelTileSource> tiles_;
    Array<std::byte> identity_; ///< of the file, and how it was read
};

/// True if a file begins as a PNG or an OpenEXR file does.
bool IsTileableImage(std::span<const std::byte> file);

} // namespace openntc::tool
