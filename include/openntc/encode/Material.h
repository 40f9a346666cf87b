// SPDX-License-Identifier: MIT
// Stability: stable
// What is to be encoded: textures that share a size, as channels of one set.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/format/Enums.h"
#include "openntc/format/Limits.h"
#include "openntc/image/MipGeneration.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// One texture of a material, as the file will describe it.
struct MaterialTexture {
    std::string name; ///< UTF-8
    int firstChannel = 0;
    int channels = 0; ///< 1 ... 16
    ChannelFormat format = ChannelFormat::UNORM8;
    ColorSpace rgbColorSpace = ColorSpace::Linear;   ///< of channels 0 - 2 of the decoded texture
    ColorSpace alphaColorSpace = ColorSpace::Linear; ///< of channel 3
    /// Encoding of the texels given, which the network reproduces; absent: as the decoded texture. HDR
    /// textures are stored as HLG and decoded to Linear.
    std::optional<ColorSpace> storedRgb = {}, storedAlpha = {};
    BlockCompressedFormat bcFormat = BlockCompressedFormat::None;
};

/// Texels of up to 16 channels with their mips. Values are stored values (sRGB- or HLG-encoded where the
/// texture says so), nominally 0 ... 1.
class Material {
public:
    static constexpr int kMaxChannels = openntc::kMaxChannels;
    static constexpr int kMaxSize = 16384;

    Material() = default;

    /// Errors: OutOfRange.
    static Expected<Material> Create(int width, int height) {
        if (width < 1 || height < 1 || width > kMaxSize || height > kMaxSize)
            return Fail(Status::OutOfRange, "size: %d x %d: must be 1 ... %d per side", width, height,
                        kMaxSize);
        Material material;
        material.width_ = width;
        material.height_ = height;
        material.mips_.resize(1);
        return material;
    }

    /// Adds a texture; `texels` holds width x height x channels values, channels interleaved. Errors:
    /// OutOfRange (channels outside the set or taken), InvalidArgument (number of texels).
    Expected<void> AddTexture(const MaterialTexture& texture, std::span<const float> texels) {
        if (texture.channels < 1 || texture.firstChannel < 0 ||
            texture.firstChannel + texture.channels > kMaxChannels)
            return Fail(Status::OutOfRange, "%s: channels %d + %d: the set has %d", texture.name.c_str(),
                        texture.firstChannel, texture.channels, kMaxChannels);
        const std::size_t count = GetTexelCount(0);
        if (texels.size() != count * static_cast<std::size_t>(texture.channels))
            return Fail(Status::InvalidArgument, "%s: %zu values: %zu expected", texture.name.c_str(),
                        texels.size(), count * static_cast<std::size_t>(texture.channels));
        for (int c = 0; c < texture.channels; ++c) {
            if ((declared_ >> (texture.firstChannel + c) & 1u) != 0)
                return Fail(Status::OutOfRange, "%s: channel %d: used by two textures", texture.name.c_str(),
                            texture.firstChannel + c);
        }
        for (int c = 0; c < texture.channels; ++c) {
            const int channel = texture.firstChannel + c;
            declared_ |= 1u << channel;
            const auto at = static_cast<std::size_t>(channel);
            spaces_[at] = c == 3  ? texture.storedAlpha.value_or(texture.alphaColorSpace)
                          : c < 3 ? texture.storedRgb.value_or(texture.rgbColorSpace)
                                  : ColorSpace::Linear;
            std::vector<float>& plane = mips_[0][at];
            plane.resize(count);
            for (std::size_t i = 0; i < count; ++i) {
                const float value =
                    texels[i * static_cast<std::size_t>(texture.channels) + static_cast<std::size_t>(c)];
                plane[i] = value == value ? std::clamp(value, -65504.0f, 65504.0f) : 0.0f;
            }
        }
        textures_.push_back(texture);
        return {};
    }

    /// Makes mips 1 ... count - 1 of every channel that lacks them; 0: the full chain, at most kMaxMips.
    void GenerateMips(int count = 0) {
        const int full = std::min(image::GetFullMipCount(width_, height_), kMaxMips);
        const int wanted = count > 0 ? std::min(count, full) : full;
        mips_.resize(static_cast<std::size_t>(wanted));
        for (int m = 1; m < wanted; ++m) {
            const auto at = static_cast<std::size_t>(m);
            for (std::size_t c = 0; c < kMaxChannels; ++c) {
                if ((declared_ >> c & 1u) != 0 && mips_[at][c].empty())
                    mips_[at][c] =
                        image::MakeNextMip(mips_[at - 1][c], GetWidth(m - 1), GetHeight(m - 1), spaces_[c]);
            }
        }
    }

    /// Replaces one channel of one mip. Errors: OutOfRange, InvalidArgument.
    Expected<void> SetMip(int mip, int channel, std::vector<float> texels) {
        if (mip < 0 || mip >= image::GetFullMipCount(width_, height_) || mip >= kMaxMips)
            return Fail(Status::OutOfRange, "mip: %d: the chain has %d", mip,
                        image::GetFullMipCount(width_, height_));
        if (channel < 0 || channel >= kMaxChannels || (declared_ >> channel & 1u) == 0)
            return Fail(Status::OutOfRange, "channel: %d: belongs to no texture", channel);
        if (static_cast<std::size_t>(mip) >= mips_.size())
            mips_.resize(static_cast<std::size_t>(mip) + 1);
        if (texels.size() != GetTexelCount(mip))
            return Fail(Status::InvalidArgument, "mip %d: %zu values: %zu expected", mip, texels.size(),
                        GetTexelCount(mip));
        mips_[static_cast<std::size_t>(mip)][static_cast<std::size_t>(channel)] = std::move(texels);
        return {};
    }

    int GetWidth(int mip = 0) const { return std::max(width_ >> mip, 1); }
    int GetHeight(int mip = 0) const { return std::max(height_ >> mip, 1); }
    int GetMipCount() const { return static_cast<int>(mips_.size()); }
    /// Number of the highest channel in use, plus 1.
    int GetChannelCount() const {
        int count = 0;
        while (count < kMaxChannels && (declared_ >> count) != 0)
            ++count;
        return std::max(count, 1);
    }
    std::uint32_t GetDeclaredChannels() const { return declared_; }
    /// 2 bits per channel, values of ColorSpace.
    std::uint32_t GetChannelColorSpaces() const {
        std::uint32_t bits = 0;
        for (std::size_t c = 0; c < kMaxChannels; ++c)
            bits |= static_cast<std::uint32_t>(spaces_[c]) << (2 * c);
        return bits;
    }
    const std::vector<MaterialTexture>& GetTextures() const { return textures_; }
    /// Texels of a channel in rows; empty where nothing was given.
    std::span<const float> GetPlane(int mip, int channel) const {
        return mips_[static_cast<std::size_t>(mip)][static_cast<std::size_t>(channel)];
    }
    /// Frees all texels; sizes, textures and channels stay. The material is then incomplete.
    void ReleaseTexels() {
        for (auto& mip : mips_)
            mip = {};
    }
    /// True when every channel in use has this mip.
    bool IsComplete() const {
        for (const auto& mip : mips_) {
            for (std::size_t c = 0; c < kMaxChannels; ++c) {
                if ((declared_ >> c & 1u) != 0 && mip[c].empty())
                    return false;
            }
        }
        return declared_ != 0;
    }

private:
    std::size_t GetTexelCount(int mip) const {
        return static_cast<std::size_t>(GetWidth(mip)) * static_cast<std::size_t>(GetHeight(mip));
    }

    int width_ = 0, height_ = 0;
    std::uint32_t declared_ = 0;
    std::array<ColorSpace, kMaxChannels> spaces_{};
    std::vector<std::array<std::vector<float>, kMaxChannels>> mips_;
    std::vector<MaterialTexture> textures_;
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
