// SPDX-License-Identifier: MIT
#include "TextureImage.h"

#include "openntc/ColorSpaces.h"

#include <cmath>

namespace openntc::tool {

std::uint16_t QuantiseUnorm(float value, std::uint16_t maximum) {
    if (!(value > 0.0f)) // NaN too
        return 0;
    if (value >= 1.0f)
        return maximum;
    // 24 + 16 bits of product, and one half: exact in binary64.
    return static_cast<std::uint16_t>(std::floor(static_cast<double>(value) * maximum + 0.5));
}

bool TextureImage::IsSupported(const Texture& texture) {
    const bool unorm = texture.channelFormat == ChannelFormat::UNORM8 ||
                       texture.channelFormat == ChannelFormat::UNORM16 ||
                       texture.channelFormat == ChannelFormat::UNKNOWN;
    return unorm && texture.numChannels >= 1 && texture.numChannels <= 4;
}

bool TextureImage::IsFloat(const Texture& texture) {
    return texture.channelFormat == ChannelFormat::FLOAT16 || texture.channelFormat == ChannelFormat::FLOAT32;
}

TextureImage::TextureImage(const TextureSetMetadata& metadata, const Texture& texture, bool linear)
    : texture_(&texture), bits_(texture.channelFormat == ChannelFormat::UNORM16 ? 16 : 8) {
    for (int i = 0; i < texture.numChannels; ++i) {
        const ColorSpace declared = i < 3 ? texture.rgbColorSpace : texture.alphaColorSpace;
        const ColorSpace destination = linear ? ColorSpace::Linear : declared;
        const int output = texture.firstChannel + i;
        channels_.push_back({output, static_cast<int>(metadata.GetChannelStorageColorSpace(output)),
                             static_cast<int>(destination)});
    }
}

PngFormat TextureImage::GetPngFormat(int width, int height) const {
    const int channels = static_cast<int>(channels_.size());
    return {width, height, channels == 2 ? 3 : channels, bits_};
}

void TextureImage::ConvertRowToLinear(std::span<const float> outputs, std::vector<float>& samples) const {
    samples.clear();
    for (std::size_t texel = 0; texel < outputs.size(); texel += 16) {
        for (const Channel& channel : channels_)
            samples.push_back(
                shader::NtcConvertColorSpace(outputs[texel + static_cast<std::size_t>(channel.output)],
                                             channel.source, NTC_COLOR_SPACE_LINEAR));
        if (channels_.size() == 2)
            samples.push_back(0.0f);
    }
}

void TextureImage::ConvertRow(std::span<const float> outputs, std::vector<std::uint16_t>& samples) const {
    const std::uint16_t maximum = bits_ == 16 ? 65535 : 255;
    samples.clear();
    for (std::size_t texel = 0; texel < outputs.size(); texel += 16) {
        for (const Channel& channel : channels_) {
            const float stored = outputs[texel + static_cast<std::size_t>(channel.output)];
            samples.push_back(QuantiseUnorm(
                shader::NtcConvertColorSpace(stored, channel.source, channel.destination), maximum));
        }
        if (channels_.size() == 2)
            samples.push_back(0);
    }
}

} // namespace openntc::tool
