// SPDX-License-Identifier: MIT
#include "RepeatedSet.h"

#include "Failure.h"
#include "TextureSet.h"
#include "TextureSizes.h"

#include "openntc/texture_set/WritableTextureSet.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>

namespace openntc::landscape {

using tool::CommandError;
using tool::ExitCode;
using tool::Require;

namespace {

[[noreturn]] void Refuse(const std::string& path, const std::string& text) {
    throw CommandError(ExitCode::BadInput, path, text);
}

TextureSetMetadata LoadSmall(const std::string& path, int size) {
    tool::TextureSet small = tool::LoadTextureSet(path);
    const TextureSetDesc& desc = small.metadata.GetDesc();
    if (desc.width != desc.height || !std::has_single_bit(static_cast<unsigned>(desc.width)) ||
        desc.width > size)
        Refuse(path, "size: " + std::to_string(desc.width) + "x" + std::to_string(desc.height) +
                         ": must be square and a power of two, at most " + std::to_string(size));
    const LatentShape& shape = small.metadata.GetLatentShape();
    if (shape.highResFeatures * shape.highResQuantBits % 8 != 0 ||
        shape.lowResFeatures * shape.lowResQuantBits % 8 != 0)
        Refuse(path, "latents: pixels of half bytes: must be whole bytes to be repeated");
    if (small.metadata.GetWeights().int8.empty())
        Refuse(path, "weights: no Int8 network: the landscape decodes with one");
    return std::move(small.metadata);
}

/// The file that a set of that size would be, with latents of zeros, as far as metadata need it.
TextureSetMetadata MakeLarge(const std::string& path, int size) {
    const TextureSetMetadata small = LoadSmall(path, size);
    const LatentShape& shape = small.GetLatentShape();
    TextureSetDesc desc = small.GetDesc();
    desc.width = desc.height = size;
    desc.mips = static_cast<int>(std::bit_width(static_cast<unsigned>(size)));
    WritableTextureSet large;
    Require(large.SetDescription(desc, shape, small.GetWeights().channelColorSpaces), ExitCode::Failed, path);
    Require(large.AddNetwork(small.GetWeights(), InferenceWeightType::GenericInt8), ExitCode::Failed, path);
    for (const Texture& texture : small.GetTextures())
        Require(large.AddTexture(texture), ExitCode::Failed, path);
    const int images = GetNeuralMipCount(desc, shape.gridSizeScale);
    for (int i = 0; i < images; ++i) {
        LatentImage image;
        image.highRes.width = image.highRes.height = GetLatentGridDimension(size, shape.gridSizeScale, i);
        image.lowRes.width = image.lowRes.height = GetLatentGridDimension(size, 2 * shape.gridSizeScale, i);
        const std::vector<std::byte> highRes(GetLatentGridBytes(
            image.highRes.width, image.highRes.height, shape.highResFeatures, shape.highResQuantBits));
        const std::vector<std::byte> lowRes(GetLatentGridBytes(image.lowRes.width, image.lowRes.height,
                                                               shape.lowResFeatures, shape.lowResQuantBits));
        Require(large.AddLatentImage(image, highRes, lowRes), ExitCode::Failed, path);
    }
    for (int mip = 0; mip < desc.mips; ++mip) {
        const int image = GetNeuralMipForColorMip(mip, shape.gridSizeScale, images);
        Require(large.AddColorMip({GetMipDimension(size, mip), GetMipDimension(size, mip), image,
                                   GetPositionLod(mip, image), GetPositionScale(mip, image)}),
                ExitCode::Failed, path);
    }
    MemoryStream stream;
    Require(large.Write(stream), ExitCode::Failed, path);
    static_cast<void>(stream.Seek(0));
    return Require(TextureSetMetadata::Load(stream), ExitCode::Failed, path);
}

} // namespace

RepeatedSet::RepeatedSet(const std::string& path, int size, int tileSize)
    : name_(std::filesystem::path(path).filename().string()), metadata_(MakeLarge(path, size)),
      layout_(Require(MakeTextureSetTileLayout(metadata_, tileSize, tileSize), ExitCode::Usage, "--tile")) {
    ReadPatterns(path, static_cast<int>(metadata_.GetLatentImages().size()));
    latentRange_ =
        Require(metadata_.GetStreamRangeForLatents(0, metadata_.GetDesc().mips), ExitCode::Failed, path);
    latentRange_.size = (latentRange_.size + 3) / 4 * 4;
    constants_ = Require(MakeInferenceData(metadata_, latentRange_, InferenceWeightType::GenericInt8),
                         ExitCode::Failed, path);
    blockBytes_ = tool::GetSetBytes(metadata_).blocks;
    PickChannels();
    for (int tile = 0; tile < layout_.GetTileCount(); ++tile) {
        const SliceLayout slice =
            Require(GetTileSlice(static_cast<std::uint32_t>(tile)), ExitCode::Failed, "--tile");
        tileBytes_.push_back(static_cast<std::uint32_t>(slice.bytes));
        largestTileBytes_ = std::max(largestTileBytes_, tileBytes_.back());
    }
}

void RepeatedSet::PickChannels() {
    for (const Texture& texture : metadata_.GetTextures()) {
        if (texture.numChannels >= 3 && texture.name == "Normal")
            normalChannel_ = texture.firstChannel;
    }
    for (const Texture& texture : metadata_.GetTextures()) {
        if (texture.numChannels >= 3 && texture.firstChannel != normalChannel_) {
            colorChannel_ = std::min(texture.firstChannel, NTC_MAX_CHANNELS - 3);
            return;
        }
    }
}

void RepeatedSet::ReadPatterns(const std::string& path, int images) {
    tool::TextureSet small = tool::LoadTextureSet(path);
    const LatentShape& shape = small.metadata.GetLatentShape();
    const std::span<const LatentImage> from = small.metadata.GetLatentImages();
    for (std::size_t i = 0; i < static_cast<std::size_t>(images); ++i) {
        for (const bool isLowRes : {false, true}) {
            const int bits = isLowRes ? shape.lowResQuantBits : shape.highResQuantBits;
            if (i >= from.size()) { // coarser than the small set is
                patterns_.push_back(HalveTwice(patterns_[patterns_.size() - 2], bits));
                continue;
            }
            const LatentGrid& grid = isLowRes ? from[i].lowRes : from[i].highRes;
            const int features = isLowRes ? shape.lowResFeatures : shape.highResFeatures;
            Pattern pattern{grid.width, grid.height, static_cast<std::size_t>(features * bits / 8), {}};
            const std::uint64_t bytes = GetLatentGridBytes(grid.width, grid.height, features, bits);
            pattern.pixels = tool::ReadRange(small.input, {grid.offset, bytes});
            patterns_.push_back(std::move(pattern));
        }
    }
    const Pattern& coarsest = patterns_[2 * std::min(from.size(), static_cast<std::size_t>(images)) - 1];
    phases_ = coarsest.width;
}

RepeatedSet::Pattern RepeatedSet::HalveTwice(const Pattern& pattern, int bits) {
    const auto getCode = [&](int x, int y, std::size_t code) {
        const std::size_t bit = static_cast<std::size_t>(y * pattern.width + x) * pattern.pixelBytes * 8 +
                                code * static_cast<std::size_t>(bits);
        return std::to_integer<unsigned>(pattern.pixels[bit / 8] >> (bit % 8)) & ((1u << bits) - 1u);
    };
    Pattern half{std::max(pattern.width / 4, 1), std::max(pattern.height / 4, 1), pattern.pixelBytes, {}};
    half.pixels.resize(static_cast<std::size_t>(half.width * half.height) * half.pixelBytes);
    const int across = pattern.width / half.width, down = pattern.height / half.height;
    const unsigned count = static_cast<unsigned>(across * down);
    for (int y = 0; y < half.height; ++y) {
        for (int x = 0; x < half.width; ++x) {
            for (std::size_t code = 0; code < pattern.pixelBytes * 8 / static_cast<std::size_t>(bits);
                 ++code) {
                unsigned sum = 0;
                for (int i = 0; i < across * down; ++i)
                    sum += getCode(x * across + i % across, y * down + i / across, code);
                const std::size_t bit = static_cast<std::size_t>(y * half.width + x) * half.pixelBytes * 8 +
                                        code * static_cast<std::size_t>(bits);
                half.pixels[bit / 8] |=
                    std::byte(static_cast<unsigned char>(((sum + count / 2) / count) << (bit % 8)));
            }
        }
    }
    return half;
}

Expected<SliceLayout> RepeatedSet::GetTileSlice(std::uint32_t tile) const noexcept {
    OPENNTC_ASSIGN(const TileSlice slice, layout_.GetTileSlice(tile));
    return GetSliceLayout(metadata_,
                          {slice.firstMip, slice.mips, {slice.left, slice.top, slice.width, slice.height}});
}

void RepeatedSet::WritePart(const Part& part, Phase phase, std::byte* to) const noexcept {
    const Pattern& pattern = GetPattern(part.image, part.isLowRes);
    const int shiftX = phase.x * pattern.width / phases_, shiftY = phase.y * pattern.height / phases_;
    for (int row = 0; row < part.height; ++row) {
        const std::size_t y = static_cast<std::size_t>((part.top + row + shiftY) % pattern.height);
        const std::byte* const line =
            pattern.pixels.data() + y * static_cast<std::size_t>(pattern.width) * pattern.pixelBytes;
        int x = (part.left + shiftX) % pattern.width;
        for (int left = part.width; left > 0; x = 0) {
            const int count = std::min(left, pattern.width - x);
            const std::size_t bytes = static_cast<std::size_t>(count) * pattern.pixelBytes;
            std::memcpy(to, line + static_cast<std::size_t>(x) * pattern.pixelBytes, bytes);
            to += bytes;
            left -= count;
        }
    }
}

void RepeatedSet::WriteSlice(const SliceLayout& slice, Phase phase,
                             std::span<std::byte> destination) const noexcept {
    std::memset(destination.data(), 0, slice.bytes);
    for (const SliceGrid& grid : slice.GetGrids())
        WritePart({grid.neuralMip, grid.isLowRes, grid.left, grid.top, grid.width, grid.height}, phase,
                  destination.data() + grid.dataOffset);
}

std::vector<std::byte> RepeatedSet::MakeLatents(Phase phase) const {
    std::vector<std::byte> latents(static_cast<std::size_t>(latentRange_.size));
    const std::span<const LatentImage> images = metadata_.GetLatentImages();
    for (std::size_t i = 0; i < images.size(); ++i) {
        for (const bool isLowRes : {false, true}) {
            const LatentGrid& grid = isLowRes ? images[i].lowRes : images[i].highRes;
            WritePart({static_cast<int>(i), isLowRes, 0, 0, grid.width, grid.height}, phase,
                      latents.data() + (grid.offset - latentRange_.offset));
        }
    }
    return latents;
}

} // namespace openntc::landscape
