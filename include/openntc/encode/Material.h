// SPDX-License-Identifier: MIT
// Stability: stable
// What is to be encoded: textures that share a size, as channels of one set.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/format/Enums.h"
#include "openntc/format/Limits.h"
#include "openntc/image/MipGeneration.h"
#include "openntc/image/NormalMips.h"

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

    /// How GenerateMips makes the mips of `channel` after this. Errors: OutOfRange.
    Expected<void> SetMipRule(int channel, image::MipRule rule) {
        OPENNTC_CHECK(CheckDeclared(channel));
        rules_[static_cast<std::size_t>(channel)] = rule;
        return {};
    }

    /// The channels are a normal map, x, y and z stored as (n + 1) / 2, or x and y alone with z above 0:
    /// mips, made by GenerateMips after this, are unit vectors along the average of mip 0's. Errors:
    /// OutOfRange.
    Expected<void> SetNormalMap(int firstChannel, int channels) {
        if (channels != 2 && channels != 3)
            return Fail(Status::OutOfRange, "normal map: %d channels: must be 2 or 3", channels);
        for (int c = 0; c < channels; ++c)
            OPENNTC_CHECK(CheckDeclared(firstChannel + c));
        normalMaps_.push_back({firstChannel, channels});
        return {};
    }

    /// Mips of `channel`, made by GenerateMips after this, are averages weighed by `alphaChannel`, so that
    /// what cannot be seen does not bleed into what can. Errors: OutOfRange.
    Expected<void> WeighMips(int channel, int alphaChannel) {
        OPENNTC_CHECK(CheckDeclared(channel));
        OPENNTC_CHECK(CheckDeclared(alphaChannel));
        weightOf_[static_cast<std::size_t>(channel)] = alphaChannel;
        return {};
    }

    /// Mips of an alpha-tested channel, made by GenerateMips after this, are scaled so that the share of
    /// texels of at least `threshold` is as near to that of mip 0 as their number allows. Errors: OutOfRange.
    Expected<void> KeepCoverage(int channel, float threshold) {
        OPENNTC_CHECK(CheckDeclared(channel));
        if (!(threshold > 0.0f && threshold <= 1.0f))
            return Fail(Status::OutOfRange, "threshold: %g: must be above 0 and at most 1",
                        static_cast<double>(threshold));
        thresholds_[static_cast<std::size_t>(channel)] = threshold;
        return {};
    }

    /// Makes mips 1 ... count - 1 of every channel that lacks them; 0: the full chain, at most kMaxMips.
    /// Channels with an alpha channel are weighed by it.
    void GenerateMips(int count = 0) {
        const int full = std::min(image::GetFullMipCount(width_, height_), kMaxMips);
        const int wanted = count > 0 ? std::min(count, full) : full;
        mips_.resize(static_cast<std::size_t>(wanted));
        std::vector<std::uint32_t> made(mips_.size());
        for (int m = 1; m < wanted; ++m) {
            const auto at = static_cast<std::size_t>(m);
            for (std::size_t c = 0; c < kMaxChannels; ++c) {
                if ((declared_ >> c & 1u) == 0 || !mips_[at][c].empty())
                    continue;
                std::span<const float> weights;
                if (weightOf_[c] >= 0)
                    weights = mips_[at - 1][static_cast<std::size_t>(weightOf_[c])];
                mips_[at][c] = image::MakeNextMip(mips_[at - 1][c], GetWidth(m - 1), GetHeight(m - 1),
                                                  spaces_[c], weights, rules_[c]);
                made[at] |= 1u << c;
            }
        }
        // Last: the chain is that of the vectors, and of the alpha, that were averaged.
        for (const NormalMap& map : normalMaps_)
            NormalizeMips(map, made);
        for (std::size_t c = 0; c < kMaxChannels; ++c) {
            if (thresholds_[c] <= 0.0f)
                continue;
            const double coverage = image::MeasureCoverage(mips_[0][c], thresholds_[c]);
            for (std::size_t m = 1; m < mips_.size(); ++m) {
                if ((made[m] >> c & 1u) != 0)
                    image::ScaleToCoverage(mips_[m][c], thresholds_[c], coverage);
            }
        }
    }

    /// Replaces one channel of one mip. Errors: OutOfRange, InvalidArgument.
    Expected<void> SetMip(int mip, int channel, std::vector<float> texels) {
        if (mip < 0 || mip >= image::GetFullMipCount(width_, height_) || mip >= kMaxMips)
            return Fail(Status::OutOfRange, "mip: %d: the chain has %d", mip,
                        image::GetFullMipCount(width_, height_));
        OPENNTC_CHECK(CheckDeclared(channel));
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
    static constexpr std::array<int, kMaxChannels> MakeFilled(int value) {
        std::array<int, kMaxChannels> result{};
        result.fill(value);
        return result;
    }
    struct NormalMap {
        int first = 0, channels = 0;
    };

    Expected<void> CheckDeclared(int channel) const {
        if (channel < 0 || channel >= kMaxChannels || (declared_ >> channel & 1u) == 0)
            return Fail(Status::OutOfRange, "channel: %d: belongs to no texture", channel);
        return {};
    }
    /// `made`: for each mip the channels that were made, not given.
    void NormalizeMips(const NormalMap& map, const std::vector<std::uint32_t>& made) {
        const auto x = static_cast<std::size_t>(map.first), y = x + 1;
        const std::uint32_t own = ((1u << map.channels) - 1u) << map.first;
        std::vector<float> z; // of normals that are stored without it
        for (std::size_t m = 0; m < mips_.size(); ++m) {
            const bool isMade = (made[m] & own) == own;
            std::span<const float> weights;
            if (isMade && weightOf_[x] >= 0)
                weights = mips_[m - 1][static_cast<std::size_t>(weightOf_[x])];
            if (map.channels == 2)
                z = isMade ? image::MakeNextMip(z, GetWidth(static_cast<int>(m) - 1),
                                                GetHeight(static_cast<int>(m) - 1), ColorSpace::Linear,
                                                weights, rules_[x])
                           : image::MakeNormalZ(mips_[m][x], mips_[m][y]);
            if (!isMade)
                continue;
            std::vector<float> copy = z;
            image::NormalizeVectors(mips_[m][x], mips_[m][y], map.channels == 2 ? copy : mips_[m][y + 1]);
        }
    }
    std::size_t GetTexelCount(int mip) const {
        return static_cast<std::size_t>(GetWidth(mip)) * static_cast<std::size_t>(GetHeight(mip));
    }

    int width_ = 0, height_ = 0;
    std::uint32_t declared_ = 0;
    std::array<ColorSpace, kMaxChannels> spaces_{};
    std::array<int, kMaxChannels> weightOf_ = MakeFilled(-1); ///< channel that weighs this one in mips
    std::array<image::MipRule, kMaxChannels> rules_{};
    std::vector<NormalMap> normalMaps_;
    std::array<float, kMaxChannels> thresholds_{}; ///< of alpha tests whose coverage is kept; 0: none
    std::vector<std::array<std::vector<float>, kMaxChannels>> mips_;
    std::vector<MaterialTexture> textures_;
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
