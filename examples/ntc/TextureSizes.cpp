// SPDX-License-Identifier: MIT
#include "TextureSizes.h"

#include "Output.h"

#include <cinttypes>

namespace openntc::tool {

namespace {

std::uint64_t GetBytesPerChannel(ChannelFormat format) {
    switch (format) {
    case ChannelFormat::UNORM16:
    case ChannelFormat::FLOAT16:
        return 2;
    case ChannelFormat::FLOAT32:
    case ChannelFormat::UINT32:
        return 4;
    case ChannelFormat::UNKNOWN:
    case ChannelFormat::UNORM8:
        break;
    }
    return 1;
}

std::uint64_t GetBlockBytes(BlockCompressedFormat format) {
    return format == BlockCompressedFormat::BC1 || format == BlockCompressedFormat::BC4 ? 8 : 16;
}

} // namespace

BlockCompressedFormat ChooseBlockFormat(const Texture& texture) {
    if (texture.bcFormat != BlockCompressedFormat::None)
        return texture.bcFormat;
    switch (texture.channelFormat) {
    case ChannelFormat::UINT32:
    case ChannelFormat::FLOAT32:
        return BlockCompressedFormat::None;
    case ChannelFormat::FLOAT16:
        return BlockCompressedFormat::BC6;
    default:
        return texture.numChannels == 1   ? BlockCompressedFormat::BC4
               : texture.numChannels == 2 ? BlockCompressedFormat::BC5
                                          : BlockCompressedFormat::BC7;
    }
}

TextureBytes GetTextureBytes(const Texture& texture, int width, int height) {
    const auto w = static_cast<std::uint64_t>(width), h = static_cast<std::uint64_t>(height);
    const auto channels = static_cast<std::uint64_t>(texture.numChannels);
    const BlockCompressedFormat format = ChooseBlockFormat(texture);
    TextureBytes bytes;
    bytes.raw = w * h * channels * GetBytesPerChannel(texture.channelFormat);
    bytes.blocks = format == BlockCompressedFormat::None
                       ? bytes.raw
                       : (w + 3) / 4 * ((h + 3) / 4) * GetBlockBytes(format) * ((channels + 3) / 4);
    return bytes;
}

TextureBytes GetMipBytes(const TextureSetMetadata& metadata, int mip) {
    const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
    TextureBytes sum;
    for (const Texture& texture : metadata.GetTextures())
        sum += GetTextureBytes(texture, size.width, size.height);
    return sum;
}

TextureBytes GetSetBytes(const TextureSetMetadata& metadata) {
    TextureBytes sum;
    for (int mip = 0; mip < metadata.GetDesc().mips; ++mip)
        sum += GetMipBytes(metadata, mip);
    return sum;
}

std::string FormatBytes(std::uint64_t bytes) {
    const auto size = static_cast<double>(bytes);
    if (bytes < 10 * 1024)
        return Format("%" PRIu64 " bytes", bytes);
    return bytes < 1024 * 1024 ? Format("%.1f KiB", size / 1024.0) : Format("%.2f MiB", size / 1048576.0);
}

} // namespace openntc::tool
