// SPDX-License-Identifier: MIT
#include "ImageTiles.h"

#include "Failure.h"
#include "encode/InputImage.h"
#include "encode/PngReader.h"

#include "openntc/core/Half.h"
#include "openntc/image/ColorEncoding.h"
#include "openntc/image/MipGeneration.h"
#include "openntc/streaming/FileIdentity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace openntc::tool {

namespace {

using ImagePlanes = std::vector<std::vector<float>>;

/// One plane, or four of which the last is alpha.
ImagePlanes Separate(const InputImage& image, bool isSingle) {
    const std::size_t texels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t channels = static_cast<std::size_t>(image.channels);
    const bool isGray = channels < 3, hasAlpha = channels % 2 == 0;
    ImagePlanes planes(isSingle ? 1 : 4, std::vector<float>(texels));
    for (std::size_t c = 0; c < planes.size(); ++c) {
        const bool isAlpha = c == 3;
        const std::size_t from = isAlpha ? channels - 1 : isGray ? 0 : c;
        for (std::size_t i = 0; i < texels; ++i)
            planes[c][i] = isAlpha && !hasAlpha ? 1.0f : image.texels[i * channels + from];
    }
    return planes;
}

TileFormat PickFormat(const InputImage& image, const ImagePlanes& planes, bool isSrgb) {
    const bool isSingle = planes.size() == 1;
    if (image.bits == 8)
        return isSrgb ? TileFormat::RGBA8Srgb : isSingle ? TileFormat::R8 : TileFormat::RGBA8;
    for (const std::vector<float>& plane : planes) {
        if (!std::all_of(plane.begin(), plane.end(),
                         [](float v) { return RoundToHalf(v) == v || std::isnan(v); }))
            return isSingle ? TileFormat::R32F : TileFormat::RGBA32F;
    }
    return isSingle ? TileFormat::R16F : TileFormat::RGBA16F;
}

std::vector<std::byte> Pack(const ImagePlanes& planes, TileFormat format) {
    const std::size_t size = GetTexelBytes(format) / planes.size();
    std::vector<std::byte> packed(planes[0].size() * planes.size() * size);
    std::byte* to = packed.data();
    for (std::size_t i = 0; i < planes[0].size(); ++i) {
        for (const std::vector<float>& plane : planes) {
            const float value = plane[i];
            if (size == 1) { // integers and their averages: never NaN
                *to = static_cast<std::byte>(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f);
            } else if (size == 2) {
                const std::uint16_t half = FloatToHalf(value);
                std::memcpy(to, &half, size);
            } else {
                std::memcpy(to, &value, size);
            }
            to += size;
        }
    }
    return packed;
}

} // namespace

Shared<ImageTileSource> ImageTileSource::Make(const InputImage& image, const std::string& name, int tileWidth,
                                              int tileHeight, bool isSrgb) {
    isSrgb = isSrgb && !image.IsFloat();
    const bool isStoredSrgb = isSrgb && image.bits == 8;
    ImagePlanes planes = Separate(image, image.channels == 1 && !isStoredSrgb);
    const std::size_t colors = std::min<std::size_t>(planes.size(), 3);
    if (isSrgb && !isStoredSrgb) {
        for (std::size_t c = 0; c < colors; ++c) {
            for (float& value : planes[c])
                value = image::DecodeColor(ColorSpace::sRGB, value);
        }
    }
    const TileFormat format = PickFormat(image, planes, isSrgb);

    TileLayoutDesc desc;
    desc.width = image.width;
    desc.height = image.height;
    desc.tileWidth = tileWidth;
    desc.tileHeight = tileHeight;
    desc.mips = image::GetFullMipCount(image.width, image.height);
    const TileLayout layout = Require(TileLayout::Create(desc), ExitCode::BadInput, name);
    std::vector<std::vector<std::byte>> mips;
    for (int mip = 0; mip < desc.mips; ++mip) {
        mips.push_back(Pack(planes, format));
        if (mip + 1 == desc.mips)
            break;
        ImagePlanes next;
        for (std::size_t c = 0; c < planes.size(); ++c) {
            const bool isColor = c < 3;
            next.push_back(image::MakeNextMip(planes[c], layout.GetMipWidth(mip), layout.GetMipHeight(mip),
                                              isColor && isStoredSrgb ? ColorSpace::sRGB : ColorSpace::Linear,
                                              isColor && planes.size() == 4
                                                  ? std::span<const float>(planes[3])
                                                  : std::span<const float>()));
        }
        planes = std::move(next);
    }
    std::vector<PixelMip> views;
    for (const std::vector<std::byte>& mip : mips)
        views.push_back({mip});
    Shared<PixelTileSource> tiles =
        Require(PixelTileSource::Create(layout, views, GetTexelBytes(format)), ExitCode::BadInput, name);
    return Require(
        MakeShared<ImageTileSource>(GetDefaultAllocator(), format, std::move(mips), std::move(tiles)),
        ExitCode::Failed, name);
}

Shared<ImageTileSource> ImageTileSource::Open(const std::string& path, int tileWidth, int tileHeight,
                                              bool isSrgb) {
    Shared<ImageTileSource> source = Make(ReadImage(path), path, tileWidth, tileHeight, isSrgb);
    Array<std::byte> identity = Require(MakeFileIdentity(path), ExitCode::Failed, path);
    if (!identity.empty())
        Require(identity.PushBack(static_cast<std::byte>(source->format_)), ExitCode::Failed, path);
    source->identity_ = std::move(identity);
    return source;
}

bool IsTileableImage(std::span<const std::byte> file) {
    constexpr std::array<unsigned char, 4> kExr = {0x76, 0x2f, 0x31, 0x01};
    return IsPng(file) ||
           (file.size() >= kExr.size() && std::memcmp(file.data(), kExr.data(), kExr.size()) == 0);
}

} // namespace openntc::tool
