// SPDX-License-Identifier: MIT
#include "RepeatedSet.h"

#include "Failure.h"
#include "TextureSet.h"
#include "TextureSizes.h"

#include "openntc/inference/ReadLatents.h"
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
    const LatentShape& shape = small.metadata.GetLatentShape(); // of later generations: 4 bits, 4 features
    if (shape.highResFeatures * shape.highResQuantBits % 8 != 0 ||
        shape.lowResFeatures * shape.lowResQuantBits % 8 != 0)
        Refuse(path, "latents: pixels of half bytes: must be whole bytes to be repeated");
    if (small.metadata.GetWeights().int8.empty())
        Refuse(path, "weights: no Int8 network: the landscape decodes with one");
    return std::move(small.metadata);
}

/// Latents of zeros, and the mips.
void AddLatentImages(WritableTextureSet& large, const TextureSetDesc& desc, const LatentShape& shape) {
    const int size = desc.width, images = GetNeuralMipCount(desc, shape.gridSizeScale);
    for (int i = 0; i < images; ++i) {
        LatentImage image;
        image.highRes.width = image.highRes.height = GetLatentGridDimension(size, shape.gridSizeScale, i);
        image.lowRes.width = image.lowRes.height = GetLatentGridDimension(size, 2 * shape.gridSizeScale, i);
        const std::vector<std::byte> highRes(GetLatentGridBytes(
            image.highRes.width, image.highRes.height, shape.highResFeatures, shape.highResQuantBits));
        const std::vector<std::byte> lowRes(GetLatentGridBytes(image.lowRes.width, image.lowRes.height,
                                                               shape.lowResFeatures, shape.lowResQuantBits));
        Require(large.AddLatentImage(image, highRes, lowRes), ExitCode::Failed, "latents");
    }
    for (int mip = 0; mip < desc.mips; ++mip) {
        const int image = GetNeuralMipForColorMip(mip, shape.gridSizeScale, images);
        Require(large.AddColorMip({GetMipDimension(size, mip), GetMipDimension(size, mip), image,
                                   GetPositionLod(mip, image), GetPositionScale(mip, image)}),
                ExitCode::Failed, "mips");
    }
}

/// The same of generations 2 and 3.
void AddLatentMips(WritableTextureSet& large, const TextureSetDesc& desc, const LatentShape& shape) {
    const int count = GetLatentMipCount(desc, shape.gridSizeScale);
    const auto getSize = [&](int i) { return GetLatentMipDimension(desc.width, shape.gridSizeScale, i); };
    for (int i = 0; i < count; ++i) {
        const auto texels = static_cast<std::size_t>(getSize(i)) * static_cast<std::size_t>(getSize(i));
        const std::vector<std::byte> layers(2 * texels * static_cast<std::size_t>(GetLatentLayers(shape)));
        Require(large.AddLatentMip(getSize(i), getSize(i), layers), ExitCode::Failed, "latents");
    }
    for (int mip = 0; mip < desc.mips; ++mip) {
        ColorMip record{GetMipDimension(desc.width, mip), GetMipDimension(desc.width, mip)};
        record.neuralMip = GetLatentMipForColorMip(mip, shape.gridSizeScale, count);
        const int latents = getSize(record.neuralMip);
        record.positionScale = GetLatentPositionScale(record.width, record.height, latents, latents);
        record.positionLod = GetLatentPositionLod(record.positionScale);
        Require(large.AddColorMip(record), ExitCode::Failed, "mips");
    }
}

/// The file that a set of that size would be, with latents of zeros, as far as metadata need it.
TextureSetMetadata MakeLarge(const std::string& path, int size) {
    const TextureSetMetadata small = LoadSmall(path, size);
    const LatentShape& shape = small.GetLatentShape();
    TextureSetDesc desc = small.GetDesc();
    desc.width = desc.height = size;
    desc.mips = static_cast<int>(std::bit_width(static_cast<unsigned>(size)));
    WritableTextureSet large;
    Require(large.SetDescription(desc, shape, small.GetWeights().channelColorSpaces, small.GetGeneration()),
            ExitCode::Failed, path);
    Require(large.AddNetwork(small.GetWeights(), InferenceWeightType::GenericInt8), ExitCode::Failed, path);
    for (const Texture& texture : small.GetTextures())
        Require(large.AddTexture(texture), ExitCode::Failed, path);
    if (small.GetGeneration() == 1)
        AddLatentImages(large, desc, shape);
    else
        AddLatentMips(large, desc, shape);
    MemoryStream stream;
    Require(large.Write(stream), ExitCode::Failed, path);
    static_cast<void>(stream.Seek(0));
    return Require(TextureSetMetadata::Load(stream), ExitCode::Failed, path);
}

} // namespace

RepeatedSet::RepeatedSet(const std::string& path, int size, int tileSize)
    : name_(std::filesystem::path(path).filename().string()), metadata_(MakeLarge(path, size)),
      layout_(Require(MakeTextureSetTileLayout(metadata_, tileSize, tileSize), ExitCode::Usage, "--tile")) {
    ReadPatterns(path);
    const int mips = metadata_.GetDesc().mips;
    latentBytes_ = Require(GetLatentBufferBytes(metadata_, 0, mips), ExitCode::Failed, path);
    constants_ = Require(MakeInferenceData(metadata_, 0, mips, InferenceWeightType::GenericInt8),
                         ExitCode::Failed, path);
    blockBytes_ = tool::GetSetBytes(metadata_).blocks;
    PickChannels();
    for (int tile = 0; tile < layout_.GetTileCount(); ++tile) {
        const TileSlice slice =
            Require(layout_.GetTileSlice(static_cast<std::uint32_t>(tile)), ExitCode::Failed, "--tile");
        tileBytes_.push_back(static_cast<std::uint32_t>(Require(
            GetPartialLatentBufferSize(metadata_, MakeSliceDesc(slice)), ExitCode::Failed, "--tile")));
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

std::size_t RepeatedSet::GetPatternsEach() const noexcept {
    return metadata_.GetGeneration() == 1
               ? 2
               : static_cast<std::size_t>(GetLatentLayers(metadata_.GetLatentShape()));
}

/// Those of the small set.
std::vector<RepeatedSet::Pattern> RepeatedSet::ReadGrids(const std::string& path) const {
    tool::TextureSet small = tool::LoadTextureSet(path);
    const LatentShape& shape = small.metadata.GetLatentShape();
    std::vector<Pattern> grids;
    for (const LatentImage& image : small.metadata.GetLatentImages()) {
        for (const bool isLowRes : {false, true}) {
            const LatentGrid& grid = isLowRes ? image.lowRes : image.highRes;
            const int bits = isLowRes ? shape.lowResQuantBits : shape.highResQuantBits;
            const int features = isLowRes ? shape.lowResFeatures : shape.highResFeatures;
            const std::uint64_t bytes = GetLatentGridBytes(grid.width, grid.height, features, bits);
            grids.push_back({grid.width, grid.height, static_cast<std::size_t>(features * bits / 8),
                             tool::ReadRange(small.input, {grid.offset, bytes})});
        }
    }
    StoredDataReader reader(small.input.GetStream(), GetDefaultAllocator());
    for (const LatentMip& mip : small.metadata.GetLatentMips()) {
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer) {
            std::vector<std::byte> texels(static_cast<std::size_t>(mip.GetLayerBytes()));
            Require(reader.Read(mip.layerData[layer], texels, "latents"), ExitCode::BadInput, path);
            grids.push_back({mip.width, mip.height, 2, std::move(texels)});
        }
    }
    return grids;
}

void RepeatedSet::ReadPatterns(const std::string& path) {
    const LatentShape& shape = metadata_.GetLatentShape();
    const bool isLayered = metadata_.GetGeneration() > 1;
    const std::size_t each = GetPatternsEach();
    const std::size_t images =
        isLayered ? metadata_.GetLatentMips().size() : metadata_.GetLatentImages().size();
    patterns_ = ReadGrids(path);
    patterns_.resize(std::min(patterns_.size(), images * each));
    phases_ = patterns_.back().width;
    while (patterns_.size() < images * each) { // coarser than the small set is
        const bool isLowRes = !isLayered && patterns_.size() % 2 != 0;
        const int bits = isLayered ? 4 : isLowRes ? shape.lowResQuantBits : shape.highResQuantBits;
        patterns_.push_back(Shrink(patterns_[patterns_.size() - each], isLayered ? 2 : 4, bits));
    }
}

RepeatedSet::Pattern RepeatedSet::Shrink(const Pattern& pattern, int factor, int bits) {
    const auto getCode = [&](int x, int y, std::size_t code) {
        const std::size_t bit = static_cast<std::size_t>(y * pattern.width + x) * pattern.pixelBytes * 8 +
                                code * static_cast<std::size_t>(bits);
        return std::to_integer<unsigned>(pattern.pixels[bit / 8] >> (bit % 8)) & ((1u << bits) - 1u);
    };
    Pattern small{
        std::max(pattern.width / factor, 1), std::max(pattern.height / factor, 1), pattern.pixelBytes, {}};
    small.pixels.resize(static_cast<std::size_t>(small.width * small.height) * small.pixelBytes);
    const int across = pattern.width / small.width, down = pattern.height / small.height;
    const unsigned count = static_cast<unsigned>(across * down);
    for (int y = 0; y < small.height; ++y) {
        for (int x = 0; x < small.width; ++x) {
            for (std::size_t code = 0; code < pattern.pixelBytes * 8 / static_cast<std::size_t>(bits);
                 ++code) {
                unsigned sum = 0;
                for (int i = 0; i < across * down; ++i)
                    sum += getCode(x * across + i % across, y * down + i / across, code);
                const std::size_t bit = static_cast<std::size_t>(y * small.width + x) * small.pixelBytes * 8 +
                                        code * static_cast<std::size_t>(bits);
                small.pixels[bit / 8] |=
                    std::byte(static_cast<unsigned char>(((sum + count / 2) / count) << (bit % 8)));
            }
        }
    }
    return small;
}

void RepeatedSet::WritePart(const Part& part, Phase phase, std::byte* to) const noexcept {
    const Pattern& pattern = patterns_[part.pattern];
    const int shiftX = phase.x * pattern.width / phases_, shiftY = phase.y * pattern.height / phases_;
    for (int row = 0; row < part.height; ++row) {
        const int y = ((part.top + row) % part.gridHeight + shiftY) % pattern.height;
        const std::byte* const line =
            pattern.pixels.data() + static_cast<std::size_t>(y * pattern.width) * pattern.pixelBytes;
        for (int column = 0; column < part.width;) {
            const int inGrid = (part.left + column) % part.gridWidth;
            const int x = (inGrid + shiftX) % pattern.width;
            const int count = std::min({part.width - column, part.gridWidth - inGrid, pattern.width - x});
            const std::size_t bytes = static_cast<std::size_t>(count) * pattern.pixelBytes;
            std::memcpy(to, line + static_cast<std::size_t>(x) * pattern.pixelBytes, bytes);
            to += bytes;
            column += count;
        }
    }
}

void RepeatedSet::WriteGrids(const SliceLayout& slice, Phase phase, std::byte* to) const noexcept {
    for (const SliceGrid& grid : slice.GetGrids()) {
        const std::size_t pattern = 2 * static_cast<std::size_t>(grid.neuralMip) + (grid.isLowRes ? 1 : 0);
        WritePart({pattern, grid.left, grid.top, grid.width, grid.height, grid.imageWidth, grid.imageHeight},
                  phase, to + grid.dataOffset);
    }
}

void RepeatedSet::WriteLatentMips(const LatentMipSliceLayout& slice, Phase phase,
                                  std::byte* to) const noexcept {
    for (const LatentMipSlice& part : slice.GetParts()) {
        const LatentMip& mip = metadata_.GetLatentMips()[static_cast<std::size_t>(part.latentMip)];
        const std::size_t layerBytes =
            2 * static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
        for (std::size_t layer = 0; layer < GetPatternsEach(); ++layer) {
            const std::size_t pattern = static_cast<std::size_t>(part.latentMip) * GetPatternsEach() + layer;
            WritePart({pattern, part.left, part.top, part.width, part.height, mip.width, mip.height}, phase,
                      to + part.dataOffset + layer * layerBytes);
        }
    }
}

Expected<void> RepeatedSet::WriteTile(std::uint32_t tile, Phase phase,
                                      std::span<std::byte> destination) const noexcept {
    OPENNTC_ASSIGN(const TileSlice slice, layout_.GetTileSlice(tile));
    std::memset(destination.data(), 0, tileBytes_[tile]);
    if (metadata_.GetGeneration() == 1) {
        OPENNTC_ASSIGN(const SliceLayout grids, GetSliceLayout(metadata_, MakeSliceDesc(slice)));
        WriteGrids(grids, phase, destination.data());
    } else {
        OPENNTC_ASSIGN(const LatentMipSliceLayout mips, GetLatentMipSlices(metadata_, MakeSliceDesc(slice)));
        WriteLatentMips(mips, phase, destination.data());
    }
    return {};
}

std::vector<std::byte> RepeatedSet::MakeLatents(Phase phase) const {
    std::vector<std::byte> latents(static_cast<std::size_t>(latentBytes_));
    const TextureSetDesc& desc = metadata_.GetDesc();
    const SliceDesc whole = {0, desc.mips, {0, 0, desc.width, desc.height}};
    if (metadata_.GetGeneration() > 1) {
        WriteLatentMips(Require(GetLatentMipSlices(metadata_, whole), ExitCode::Failed, name_), phase,
                        latents.data());
        return latents;
    }
    const std::uint64_t start =
        Require(metadata_.GetStreamRangeForLatents(0, desc.mips), ExitCode::Failed, name_).offset;
    SliceLayout grids = Require(GetSliceLayout(metadata_, whole), ExitCode::Failed, name_);
    for (SliceGrid& grid : grids.grids)
        grid.dataOffset = static_cast<std::uint32_t>(grid.sourceOffset - start);
    WriteGrids(grids, phase, latents.data());
    return latents;
}

} // namespace openntc::landscape
