// SPDX-License-Identifier: MIT
// From network outputs to the samples of one texture's image file.
#pragma once

#include "Png.h"

#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace openntc::tool {

/// One texture of a set as an image. `metadata` must outlive it.
class TextureImage {
public:
    /// True if PNG holds it: 1 to 4 channels of UNORM8 or UNORM16; UNKNOWN is written as UNORM8.
    static bool IsSupported(const Texture& texture);
    /// True for FLOAT16 and FLOAT32.
    static bool IsFloat(const Texture& texture);

    /// Colours are converted from each channel's storage colour space to the one that the texture declares
    /// (the first three channels to its colour, the fourth to its alpha), or to linear if `linear`.
    TextureImage(const TextureSetMetadata& metadata, const Texture& texture, bool linear);

    std::string_view GetName() const { return texture_->name; }

    /// 1 channel: gray; 2: RGB with blue 0 (gray with alpha would be shown as transparency); 3: RGB; 4: RGBA.
    PngFormat GetPngFormat(int width, int height) const;

    /// Samples of a texel that ConvertRowToLinear gives: as many as channels, for 2 as in PNG.
    int GetLinearSampleCount() const {
        return channels_.size() == 2 ? 3 : static_cast<int>(channels_.size());
    }
    bool IsHalf() const { return texture_->channelFormat == ChannelFormat::FLOAT16; }

    /// The same row in linear light as floats, as they are.
    void ConvertRowToLinear(std::span<const float> outputs, std::vector<float>& samples) const;

    /// Samples of a row of texels (16 outputs each): floor(clamp(v, 0, 1) * max + 1/2), NaN as 0, no dither.
    void ConvertRow(std::span<const float> outputs, std::vector<std::uint16_t>& samples) const;

private:
    struct Channel {
        int output;
        int source; // NTC_COLOR_SPACE_*
        int destination;
    };

    const Texture* texture_;
    std::vector<Channel> channels_;
    int bits_;
};

/// floor(clamp(value, 0, 1) * maximum + 1/2), exactly; NaN gives 0.
std::uint16_t QuantiseUnorm(float value, std::uint16_t maximum);

} // namespace openntc::tool
