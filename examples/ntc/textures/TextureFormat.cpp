// SPDX-License-Identifier: MIT
#include "textures/TextureFormat.h"

#include "Output.h"

#include <array>

namespace openntc::tool {

namespace {

using bc::BlockFormat;

struct TexelRow {
    TexelNumber number;
    int channels;
    const char* name;
    std::uint32_t vulkan, vulkanSrgb;
    std::uint32_t dxgi, dxgiSrgb;
};

// VkFormat and DXGI_FORMAT of vulkan_core.h and dxgiformat.h. RGBA8 alone has an sRGB form that all APIs know.
constexpr TexelRow kTexels[] = {
    {TexelNumber::Unorm8, 1, "r8", 9, 0, 61, 0},       {TexelNumber::Unorm8, 2, "rg8", 16, 0, 49, 0},
    {TexelNumber::Unorm8, 4, "rgba8", 37, 43, 28, 29}, {TexelNumber::Unorm16, 1, "r16", 70, 0, 56, 0},
    {TexelNumber::Unorm16, 2, "rg16", 77, 0, 35, 0},   {TexelNumber::Unorm16, 4, "rgba16", 91, 0, 11, 0},
    {TexelNumber::Half, 1, "r16f", 76, 0, 54, 0},      {TexelNumber::Half, 2, "rg16f", 83, 0, 34, 0},
    {TexelNumber::Half, 4, "rgba16f", 97, 0, 10, 0},   {TexelNumber::Float, 1, "r32f", 100, 0, 41, 0},
    {TexelNumber::Float, 2, "rg32f", 103, 0, 16, 0},   {TexelNumber::Float, 4, "rgba32f", 109, 0, 2, 0},
};

const TexelRow& FindRow(const TextureFormat& format) {
    for (const TexelRow& row : kTexels) {
        if (row.number == format.number && row.channels == format.channels)
            return row;
    }
    return kTexels[2]; // ChooseFormat makes no others
}

bool IsSigned(BlockFormat block) {
    return block == BlockFormat::Bc4Signed || block == BlockFormat::Bc5Signed ||
           block == BlockFormat::Bc6Signed;
}

bool IsHdr(BlockFormat block) {
    return block == BlockFormat::Bc6Unsigned || block == BlockFormat::Bc6Signed;
}

ChosenFormat ChooseBlocks(const Texture& texture, BlockFormat block, bool isSrgb) {
    ChosenFormat chosen;
    chosen.format.block = block;
    const int kept = bc::GetBlockChannels(block);
    chosen.format.channels = kept;
    chosen.format.hasAlpha = kept == 4 && texture.numChannels == 4;
    chosen.format.number = IsHdr(block)      ? TexelNumber::Half
                           : IsSigned(block) ? TexelNumber::Snorm8
                                             : TexelNumber::Unorm8;
    chosen.format.srgb = isSrgb && bc::HasSrgbForm(block);
    const char* name = bc::BlockFormatToString(block);
    if (texture.numChannels > kept)
        chosen.losses.push_back(Format("%s keeps %d of %d channels", name, kept, texture.numChannels));
    if (isSrgb && !chosen.format.srgb && !IsHdr(block))
        chosen.losses.push_back(Format("%s has no sRGB form: values are linear", name));
    const bool isHdr =
        texture.channelFormat == ChannelFormat::FLOAT16 || texture.channelFormat == ChannelFormat::FLOAT32;
    if (isHdr && !IsHdr(block))
        chosen.losses.push_back(
            Format("%s keeps values of %s", name, IsSigned(block) ? "-1 to 1" : "0 to 1"));
    return chosen;
}

ChosenFormat ChooseTexels(const Texture& texture, bool isSrgb, bool isHlg) {
    ChosenFormat chosen;
    TextureFormat& format = chosen.format;
    format.hasAlpha = texture.numChannels == 4;
    format.channels = texture.numChannels == 3 ? 4 : texture.numChannels;
    switch (texture.channelFormat) {
    case ChannelFormat::FLOAT32:
        format.number = TexelNumber::Float;
        break;
    case ChannelFormat::FLOAT16:
        format.number = TexelNumber::Half;
        break;
    case ChannelFormat::UNORM16:
        format.number = isHlg ? TexelNumber::Half : TexelNumber::Unorm16;
        break;
    default:
        format.number = isHlg ? TexelNumber::Half : TexelNumber::Unorm8;
        break;
    }
    if (isSrgb && format.number == TexelNumber::Unorm8) {
        format.channels = 4;
        format.srgb = true;
    }
    return chosen;
}

} // namespace

std::string GetName(const TextureFormat& format) {
    return format.block ? bc::BlockFormatToString(*format.block) : FindRow(format).name;
}

std::uint32_t GetVulkanFormat(const TextureFormat& format) {
    if (format.block) {
        // BC1 without alpha is a format of its own, two numbers before the one with alpha.
        const bool isOpaqueBc1 = *format.block == BlockFormat::Bc1 && !format.hasAlpha;
        return bc::GetVulkanFormat(*format.block, format.srgb) - (isOpaqueBc1 ? 2 : 0);
    }
    const TexelRow& row = FindRow(format);
    return format.srgb ? row.vulkanSrgb : row.vulkan;
}

std::uint32_t GetDxgiFormat(const TextureFormat& format) {
    if (format.block)
        return bc::GetDxgiFormat(*format.block, format.srgb);
    const TexelRow& row = FindRow(format);
    return format.srgb ? row.dxgiSrgb : row.dxgi;
}

int GetNumberBytes(TexelNumber number) {
    switch (number) {
    case TexelNumber::Unorm16:
    case TexelNumber::Half:
        return 2;
    case TexelNumber::Float:
        return 4;
    case TexelNumber::Unorm8:
    case TexelNumber::Snorm8:
        break;
    }
    return 1;
}

std::uint32_t GetUnitBytes(const TextureFormat& format) {
    return format.block ? static_cast<std::uint32_t>(bc::GetBytesPerBlock(*format.block))
                        : static_cast<std::uint32_t>(GetNumberBytes(format.number) * format.channels);
}

std::uint32_t GetUnitTexels(const TextureFormat& format) {
    return format.block ? static_cast<std::uint32_t>(bc::kBlockSize) : 1;
}

std::optional<ChosenFormat> ChooseFormat(const Texture& texture, const BlockChoice& choice, bool linear) {
    if (texture.numChannels < 1 || texture.numChannels > 4 || texture.channelFormat == ChannelFormat::UINT32)
        return std::nullopt;
    const bool isSrgb = !linear && texture.rgbColorSpace == ColorSpace::sRGB;
    const bool isHlg = !linear && texture.rgbColorSpace == ColorSpace::HLG;
    if (choice.isAuto ? texture.bcFormat != BlockCompressedFormat::None : choice.block.has_value())
        return ChooseBlocks(texture, choice.isAuto ? bc::GetBlockFormat(texture.bcFormat) : *choice.block,
                            isSrgb);
    return ChooseTexels(texture, isSrgb, isHlg);
}

std::optional<BlockFormat> FindBlockFormat(const std::string& name) {
    if (name == "bc6h")
        return BlockFormat::Bc6Unsigned;
    for (int i = 0; i < bc::kBlockFormatCount; ++i) {
        const auto format = static_cast<BlockFormat>(i);
        if (name == bc::BlockFormatToString(format))
            return format;
    }
    return std::nullopt;
}

} // namespace openntc::tool
