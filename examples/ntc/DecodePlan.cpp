// SPDX-License-Identifier: MIT
#include "DecodePlan.h"

#include "Exr.h"
#include "Failure.h"
#include "FileNames.h"
#include "Output.h"
#include "Png.h"
#include "TextureSet.h"
#include "textures/Tga.h"

#include <algorithm>
#include <utility>

namespace openntc::tool {

namespace {

const char* GetExtension(ImageFormat format) {
    switch (format) {
    case ImageFormat::Exr:
        return "exr";
    case ImageFormat::Tga:
        return "tga";
    case ImageFormat::Dds:
        return "dds";
    case ImageFormat::Ktx2:
        return "ktx2";
    case ImageFormat::Auto:
    case ImageFormat::Png:
        break;
    }
    return "png";
}

bool IsHeld(const Texture& texture, ImageFormat format) {
    if (format == ImageFormat::Exr)
        return IsExrAvailable();
    return TextureImage::IsSupported(texture) &&
           (format != ImageFormat::Tga || texture.channelFormat != ChannelFormat::UNORM16);
}

} // namespace

DecodePlan::DecodePlan(const TextureSetMetadata& metadata, const DecodePlanOptions& options,
                       std::string subject)
    : metadata_(metadata), options_(options), subject_(std::move(subject)) {
    CheckRect();
    CheckSize();
    CountMips();
    FileNames names;
    const std::span<const Texture> textures = metadata_.GetTextures();
    for (std::size_t i = 0; i < textures.size(); ++i) {
        const Texture& texture = textures[i];
        const std::string name = names.Add(texture.name);
        if (IsContainer()) {
            AddContainer(i, name);
            continue;
        }
        ImageFormat kind = options_.format;
        if (kind == ImageFormat::Auto)
            kind = TextureImage::IsFloat(texture) ? ImageFormat::Exr : ImageFormat::Png;
        AddImages(texture, name, kind);
    }
    if (files_.empty())
        throw CommandError(ExitCode::Failed, subject_,
                           unwritten_.empty() ? "textures: none in the file: at least 1"
                                              : DescribeUnwritten());
    WarnOfSize();
}

void DecodePlan::CheckRect() const {
    if (!options_.rect)
        return;
    const TextureSetDesc& desc = metadata_.GetDesc();
    const Rect& rect = *options_.rect;
    if (rect.left < 0 || rect.top < 0 || rect.width < 1 || rect.height < 1 || rect.left >= desc.width ||
        rect.top >= desc.height || rect.width > desc.width - rect.left ||
        rect.height > desc.height - rect.top)
        throw CommandError(ExitCode::Usage, subject_ + ": --rect",
                           Format("%d x %d at (%d, %d): must have texels and lie inside %d x %d", rect.width,
                                  rect.height, rect.left, rect.top, desc.width, desc.height));
}

void DecodePlan::CheckSize() const {
    const bool isTga = options_.format == ImageFormat::Tga;
    const int limit = isTga ? kTgaMaxSide : kPngMaxSide;
    const Rect rect = GetRect(0);
    if (!IsContainer() && std::max(rect.width, rect.height) > limit)
        throw CommandError(ExitCode::Failed, subject_,
                           Format("size: %d x %d: %s output has at most %d texels a side", rect.width,
                                  rect.height, isTga ? "TGA" : "PNG", limit));
}

void DecodePlan::CountMips() {
    if (!options_.mips && !IsContainer())
        return;
    mips_ = metadata_.GetDesc().mips;
    const Rect rect = GetRect(0);
    while (mips_ > 1 && std::max(rect.width, rect.height) >> (mips_ - 1) == 0)
        --mips_; // of a rectangle
}

Rect DecodePlan::GetRect(int mip) const {
    const ColorMip& size = metadata_.GetColorMips()[static_cast<std::size_t>(mip)];
    if (!options_.rect)
        return {0, 0, size.width, size.height};
    Rect rect;
    rect.width = std::max(options_.rect->width >> mip, 1);
    rect.height = std::max(options_.rect->height >> mip, 1);
    rect.left = std::min(options_.rect->left >> mip, size.width - rect.width);
    rect.top = std::min(options_.rect->top >> mip, size.height - rect.height);
    return rect;
}

std::uint64_t DecodePlan::CountTexels() const {
    std::uint64_t texels = 0;
    for (int mip = 0; mip < mips_; ++mip) {
        const Rect rect = GetRect(mip);
        texels += static_cast<std::uint64_t>(rect.width) * static_cast<std::uint64_t>(rect.height);
    }
    return texels;
}

void DecodePlan::AddImages(const Texture& texture, const std::string& name, ImageFormat kind) {
    if (!IsHeld(texture, kind)) {
        AddUnwritten(texture, name);
        return;
    }
    const TextureImage& image = images_.emplace_back(metadata_, texture, options_.linear);
    for (int mip = 0; mip < mips_; ++mip) {
        PlannedFile file;
        file.texture = &texture;
        file.kind = kind;
        file.image = &image;
        file.mip = mip;
        file.name = mip == 0 ? name + "." + GetExtension(kind)
                             : Format("mips/%s.%02d.%s", name.c_str(), mip, GetExtension(kind));
        files_.push_back(std::move(file));
    }
}

void DecodePlan::AddContainer(std::size_t index, const std::string& name) {
    const Texture& texture = metadata_.GetTextures()[index];
    const std::optional<ChosenFormat> chosen = ChooseFormat(texture, options_.blocks, options_.linear);
    if (!chosen) {
        AddUnwritten(texture, name);
        return;
    }
    for (const std::string& loss : chosen->losses)
        warnings_.emplace_back(subject_).append(": ").append(name).append(": ").append(loss);
    PlannedFile file;
    file.texture = &texture;
    file.index = index;
    file.kind = options_.format;
    file.format = chosen->format;
    file.converter = &converters_.emplace_back(metadata_, texture, chosen->format);
    file.name = name + "." + GetExtension(options_.format);
    files_.push_back(std::move(file));
}

void DecodePlan::AddUnwritten(const Texture& texture, const std::string& name) {
    unwritten_ += (unwritten_.empty() ? "" : ", ") + name + " (" + GetName(texture.channelFormat) +
                  Format(" x %d)", texture.numChannels);
}

std::string DecodePlan::DescribeUnwritten() const {
    if (unwritten_.empty())
        return {};
    const char* what = options_.format == ImageFormat::Tga ? "TGA holds 1 to 4 channels of UNORM8"
                       : IsContainer() ? "DDS and KTX2 hold 1 to 4 channels of UNORM8, UNORM16 and floats"
                                       : "PNG holds 1 to 4 channels of UNORM8 or UNORM16";
    return "textures not written: " + unwritten_ + ": " + what +
           (IsExrAvailable() ? ": --format exr holds all" : ", and this build writes no OpenEXR");
}

void DecodePlan::WarnOfSize() {
    const Rect rect = GetRect(0);
    const bool hasBlocks = std::any_of(files_.begin(), files_.end(), [](const PlannedFile& file) {
        return file.format && file.format->block;
    });
    if (hasBlocks && !options_.pad && (rect.width % 4 != 0 || rect.height % 4 != 0))
        warnings_.push_back(
            subject_ + Format(": size: %d x %d: Direct3D creates block-compressed textures of multiples of "
                              "4 only: --pad makes it one",
                              rect.width, rect.height));
}

std::unique_ptr<ImageSink> DecodePlan::MakeSink(const PlannedFile& file, const SinkFile& where) const {
    switch (file.kind) {
    case ImageFormat::Exr:
        return MakeExrSink(where, *file.image);
    case ImageFormat::Tga:
        return MakeTgaSink(where, *file.image);
    case ImageFormat::Dds:
    case ImageFormat::Ktx2:
        break;
    case ImageFormat::Auto:
    case ImageFormat::Png:
        return MakePngSink(where, *file.image);
    }
    const Rect rect = GetRect(0);
    TextureFileDesc desc;
    desc.container = file.kind == ImageFormat::Dds ? TextureContainer::Dds : TextureContainer::Ktx2;
    desc.format = *file.format;
    const std::uint32_t unit = options_.pad ? GetUnitTexels(*file.format) : 1;
    desc.width = (static_cast<std::uint32_t>(rect.width) + unit - 1) / unit * unit;
    desc.height = (static_cast<std::uint32_t>(rect.height) + unit - 1) / unit * unit;
    desc.levels = static_cast<std::uint32_t>(mips_);
    desc.zstdLevel = options_.zstdLevel;
    return MakeTextureSink(where, *file.converter, desc, {options_.effort, file.hints});
}

bool DecodePlan::HasBc7() const {
    return std::any_of(files_.begin(), files_.end(), [](const PlannedFile& file) {
        return file.format && file.format->block == bc::BlockFormat::Bc7;
    });
}

void DecodePlan::UseHints(const HintFile& hints, DecodeMath math) {
    for (PlannedFile& file : files_) {
        if (!file.format || file.format->block != bc::BlockFormat::Bc7)
            continue;
        TextureHints found;
        std::string mismatch = "none for this texture";
        for (int mip = 0; mip < mips_; ++mip) {
            const std::optional<bc::BlockHintMap> map = hints.Find(file.index, mip);
            if (!map)
                continue;
            mismatch = DescribeMismatch(map->texels, math, *file.format);
            const ColorMip& size = metadata_.GetColorMips()[static_cast<std::size_t>(mip)];
            if (mismatch.empty())
                found.AddMip(mip, *map, GetRect(mip), size.width, size.height, hints.KnowsTexels());
        }
        if (!found.IsEmpty())
            file.hints = &hints_.emplace_back(std::move(found));
        else
            warnings_.push_back(hints.GetPath() + ": " + file.name + ": hints not used: " +
                                (mismatch.empty() ? "--rect starts within blocks" : mismatch));
    }
}

} // namespace openntc::tool
