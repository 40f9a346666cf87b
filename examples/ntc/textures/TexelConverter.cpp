// SPDX-License-Identifier: MIT
#include "textures/TexelConverter.h"

#include "TextureImage.h"

#include "openntc/ColorSpaces.h"
#include "openntc/core/FloatBits.h"
#include "openntc/core/Half.h"

#include <algorithm>
#include <cmath>

namespace openntc::tool {

namespace {

/// Nearest of -127 … 127 to 127 times the value, which is clamped to -1 … 1; NaN gives 0.
std::int8_t QuantiseSnorm(float value) {
    if (!(value >= -1.0f)) // NaN too
        return std::isnan(value) ? std::int8_t{0} : std::int8_t{-127};
    const double scaled = static_cast<double>(std::min(value, 1.0f)) * 127.0;
    return static_cast<std::int8_t>(std::floor(scaled + 0.5));
}

bool IsFloats(const Texture& texture) {
    return texture.channelFormat == ChannelFormat::FLOAT16 || texture.channelFormat == ChannelFormat::FLOAT32;
}

void AppendBytes(std::uint32_t value, int bytes, std::vector<std::byte>& texels) {
    for (int i = 0; i < bytes; ++i)
        texels.push_back(static_cast<std::byte>((value >> (8 * i)) & 0xFFU));
}

} // namespace

TexelConverter::TexelConverter(const TextureSetMetadata& metadata, const Texture& texture,
                               const TextureFormat& format)
    : number_(format.number), isCentred_(format.number == TexelNumber::Snorm8 && !IsFloats(texture)) {
    for (int i = 0; i < format.channels; ++i) {
        const int output = i < texture.numChannels ? texture.firstChannel + i : -1;
        // Alpha is linear in every format.
        const int destination = format.srgb && i < 3 ? NTC_COLOR_SPACE_SRGB : NTC_COLOR_SPACE_LINEAR;
        channels_.push_back(
            {output, static_cast<int>(metadata.GetChannelStorageColorSpace(output)), destination});
    }
}

void TexelConverter::AppendNumber(float value, std::vector<std::byte>& texels) const {
    switch (number_) {
    case TexelNumber::Unorm8:
        return AppendBytes(QuantiseUnorm(value, 255), 1, texels);
    case TexelNumber::Snorm8:
        return AppendBytes(static_cast<std::uint8_t>(QuantiseSnorm(value)), 1, texels);
    case TexelNumber::Unorm16:
        return AppendBytes(QuantiseUnorm(value, 65535), 2, texels);
    case TexelNumber::Half:
        return AppendBytes(FloatToHalf(value), 2, texels);
    case TexelNumber::Float:
        break;
    }
    AppendBytes(BitCast<std::uint32_t>(value), 4, texels);
}

void TexelConverter::Append(std::span<const float> outputs, std::vector<std::byte>& texels) const {
    for (std::size_t texel = 0; texel < outputs.size(); texel += 16) {
        for (std::size_t c = 0; c < channels_.size(); ++c) {
            const Channel& channel = channels_[c];
            float value = c == 3 ? 1.0f : 0.0f;
            if (channel.output >= 0) {
                value =
                    shader::NtcConvertColorSpace(outputs[texel + static_cast<std::size_t>(channel.output)],
                                                 channel.source, channel.destination);
                if (isCentred_)
                    value = 2.0f * value - 1.0f;
            }
            AppendNumber(value, texels);
        }
    }
}

} // namespace openntc::tool
