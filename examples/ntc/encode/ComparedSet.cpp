// SPDX-License-Identifier: MIT
#include "encode/ComparedSet.h"

#include "Decoder.h"
#include "Failure.h"
#include "FileNames.h"
#include "InputFile.h"
#include "TextureSet.h"
#include "encode/EncodeInputs.h"
#include "encode/InputImage.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>

namespace openntc::tool {

namespace {

bool IsTextureSet(const std::string& path) {
    constexpr std::size_t kMagicBytes = 4;
    const std::vector<std::byte> magic = PeekInput(path, kMagicBytes);
    return magic.size() == kMagicBytes && std::memcmp(magic.data(), "NTEX", kMagicBytes) == 0;
}

std::uint32_t GetBits(const ComparedTexture& texture) {
    return ((1u << texture.channels) - 1u) << texture.firstChannel;
}

/// Decode writes a texture of two channels as RGB, whose third channel says nothing.
void LeaveOutBlue(Manifest& images, std::span<const ComparedTexture> textures) {
    for (ManifestTexture& image : images.textures) {
        for (const ComparedTexture& texture : textures) {
            const bool isOf = image.name == texture.name || image.name == texture.fileName;
            std::error_code error; // what is no file can be read once
            if (isOf && texture.channels == 2 && std::filesystem::is_regular_file(image.path, error) &&
                ReadImage(image.path).channels == 3)
                image.swizzle = "RG";
        }
    }
}

/// `textures`: of the texture set that images are compared with, or none.
ComparedSet LoadImages(const std::string& path, std::span<const ComparedTexture> textures) {
    InputOptions options;
    options.paths = {path};
    if (!textures.empty() && !path.ends_with(".json")) {
        options.manifest = MakeManifest(options.paths);
        LeaveOutBlue(*options.manifest, textures);
    }
    const EncodeInputs inputs = LoadInputs(options);
    ComparedSet result;
    result.path = path;
    result.declared = inputs.material.GetDeclaredChannels();
    result.maskChannel = inputs.maskChannel;
    FileNames files;
    for (const encode::MaterialTexture& texture : inputs.material.GetTextures())
        result.textures.push_back(
            {texture.name, files.Add(texture.name), texture.firstChannel, texture.channels});
    for (int m = 0; m < inputs.material.GetMipCount(); ++m) {
        ComparedSet::Mip mip;
        mip.width = inputs.material.GetWidth(m);
        mip.height = inputs.material.GetHeight(m);
        for (int c = 0; c < 16; ++c) {
            const std::span<const float> plane = inputs.material.GetPlane(m, c);
            mip.planes[c].assign(plane.begin(), plane.end());
        }
        result.mips.push_back(std::move(mip));
    }
    return result;
}

/// A texture set, or images with it as in LoadImages.
ComparedSet LoadSide(const std::string& path, bool isSet, std::span<const ComparedTexture> textures) {
    if (!isSet)
        return LoadImages(path, textures);
    TextureSet set = LoadTextureSet(path);
    return DecodeSet(set);
}

} // namespace

ComparedSet DecodeSet(TextureSet& set) {
    const std::string& path = set.input.GetName();
    ComparedSet result;
    result.path = path;
    FileNames files;
    for (const Texture& texture : set.metadata.GetTextures()) {
        result.textures.push_back(
            {std::string(texture.name), files.Add(texture.name), texture.firstChannel, texture.numChannels});
        result.declared |= GetBits(result.textures.back());
    }
    DecodeOptions stored;
    stored.math =
        ChooseMath(set, std::nullopt, [&](const std::string& text) { result.warnings.push_back(text); });
    const DecodeData data = LoadDecodeData(set, stored.math);
    const std::unique_ptr<Decoder> decoder = RequireDecoder(path, data, {});
    constexpr int kRows = 256; // decoded at once
    for (int m = 0; m < set.metadata.GetDesc().mips; ++m) {
        const ColorMip& info = set.metadata.GetColorMips()[static_cast<std::size_t>(m)];
        ComparedSet::Mip mip;
        mip.width = info.width;
        mip.height = info.height;
        const auto count = static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height);
        for (std::size_t c = 0; c < 16; ++c) {
            if ((result.declared >> c & 1u) != 0)
                mip.planes[c].resize(count);
        }
        std::vector<float> texels;
        for (int y = 0; y < info.height; y += kRows) {
            const int rows = std::min(kRows, info.height - y);
            const std::size_t begin = static_cast<std::size_t>(y) * static_cast<std::size_t>(info.width);
            texels.resize(static_cast<std::size_t>(rows) * static_cast<std::size_t>(info.width) * 16);
            Require(decoder->Decode(m, {0, y, info.width, rows}, stored, texels), ExitCode::BadInput, path);
            for (std::size_t i = 0; i < texels.size(); ++i) {
                std::vector<float>& plane = mip.planes[i % 16];
                if (!plane.empty())
                    plane[begin + i / 16] = texels[i];
            }
        }
        result.mips.push_back(std::move(mip));
    }
    return result;
}

ComparedSet LoadComparedSet(const std::string& path) {
    return LoadSide(path, IsTextureSet(path), {});
}

std::pair<ComparedSet, ComparedSet> LoadComparedSets(const std::string& a, const std::string& b) {
    const bool isSetA = IsTextureSet(a), isSetB = IsTextureSet(b); // each once: standard input is looked into
    if (!isSetA && isSetB) {
        ComparedSet set = LoadSide(b, true, {});
        return {LoadSide(a, false, set.textures), std::move(set)};
    }
    ComparedSet first = LoadSide(a, isSetA, {});
    ComparedSet second = LoadSide(b, isSetB,
                                  isSetA ? std::span<const ComparedTexture>(first.textures)
                                         : std::span<const ComparedTexture>());
    return {std::move(first), std::move(second)};
}

std::vector<float> InterleaveColors(const ComparedSet::Mip& mip, int firstChannel) {
    const auto first = static_cast<std::size_t>(firstChannel);
    std::vector<float> colors(3 * mip.planes[first].size());
    for (std::size_t i = 0; i < colors.size(); ++i)
        colors[i] = mip.planes[first + i % 3][i / 3];
    return colors;
}

void ClampChannel(ComparedSet& set, int channel) {
    for (ComparedSet::Mip& mip : set.mips) {
        for (float& value : mip.planes[channel])
            value = std::clamp(value, 0.0f, 1.0f);
    }
}

void ChannelDifference::Add(const ChannelDifference& other) {
    squares += other.squares;
    texels += other.texels;
    if (other.worst > worst) {
        worst = other.worst;
        worstX = other.worstX;
        worstY = other.worstY;
    }
}

double ChannelDifference::Psnr() const {
    return texels > 0.0 ? -10.0 * std::log10(squares / texels) : std::numeric_limits<double>::infinity();
}

ChannelDifference CompareChannel(const ComparedSet::Mip& a, const ComparedSet::Mip& b, int channel,
                                 std::span<const float> mask) {
    ChannelDifference result;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const std::size_t i =
                static_cast<std::size_t>(y) * static_cast<std::size_t>(a.width) + static_cast<std::size_t>(x);
            if (!mask.empty() && mask[i] <= 0.0f)
                continue;
            result.texels += 1.0;
            const float difference = std::fabs(a.planes[channel][i] - b.planes[channel][i]);
            result.squares += static_cast<double>(difference) * static_cast<double>(difference);
            if (difference > result.worst) {
                result.worst = difference;
                result.worstX = x;
                result.worstY = y;
            }
        }
    }
    return result;
}

double MeasureSsim(const ComparedSet::Mip& a, const ComparedSet::Mip& b, int channel,
                   std::span<const float> mask) {
    constexpr int kWindow = 8, kStep = 4;
    constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
    const int w = std::min(kWindow, a.width), h = std::min(kWindow, a.height);
    double total = 0.0, windows = 0.0;
    for (int y = 0; y + h <= a.height; y += kStep) {
        for (int x = 0; x + w <= a.width; x += kStep) {
            double sa = 0.0, sb = 0.0, saa = 0.0, sbb = 0.0, sab = 0.0;
            bool isDiscarded = false;
            for (int j = 0; j < h; ++j) {
                for (int i = 0; i < w; ++i) {
                    const std::size_t at =
                        static_cast<std::size_t>(y + j) * static_cast<std::size_t>(a.width) +
                        static_cast<std::size_t>(x + i);
                    isDiscarded = isDiscarded || (!mask.empty() && mask[at] <= 0.0f);
                    const double va = static_cast<double>(a.planes[channel][at]);
                    const double vb = static_cast<double>(b.planes[channel][at]);
                    sa += va;
                    sb += vb;
                    saa += va * va;
                    sbb += vb * vb;
                    sab += va * vb;
                }
            }
            if (isDiscarded)
                continue;
            const double n = static_cast<double>(w) * h;
            const double ma = sa / n, mb = sb / n;
            const double variances = saa / n - ma * ma + sbb / n - mb * mb, covariance = sab / n - ma * mb;
            total += (2.0 * ma * mb + kC1) * (2.0 * covariance + kC2) /
                     ((ma * ma + mb * mb + kC1) * (variances + kC2));
            windows += 1.0;
        }
    }
    return windows > 0.0 ? total / windows : 1.0;
}

} // namespace openntc::tool
