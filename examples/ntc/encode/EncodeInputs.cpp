// SPDX-License-Identifier: MIT
#include "encode/EncodeInputs.h"

#include "Failure.h"
#include "Output.h"
#include "encode/InputImage.h"
#include "encode/Manifest.h"
#include "encode/TextureNames.h"

#include <algorithm>
#include <map>
#include <utility>

namespace openntc::tool {

namespace {

/// A texture being assembled: its channels within the set.
struct PlacedTexture {
    int firstChannel = 0;
    int channels = 0;
    ColorSpace storedRgb = ColorSpace::Linear;
    bool isColor = false;  ///< sRGB
    int alphaChannel = -1; ///< of the set: how much of a texel is seen
};

class InputLoader {
public:
    explicit InputLoader(const InputOptions& options) : options_(options) {
        const bool isManifest = options.paths.size() == 1 && options.paths[0].size() > 5 &&
                                options.paths[0].compare(options.paths[0].size() - 5, 5, ".json") == 0;
        if (options.manifest)
            manifest_ = *options.manifest;
        else
            manifest_ = isManifest ? ReadManifest(options.paths[0]) : MakeManifest(options.paths);
        if (isManifest)
            inputs_.files.push_back(options.paths[0]);
        ChooseColorSpaces("--srgb", options.srgb, true);
        ChooseColorSpaces("--linear", options.linear, false);
        ChooseTextures();
        inputs_.lossScales.fill(1.0f);
    }

    EncodeInputs Load() {
        for (const ManifestTexture& texture : manifest_.textures) {
            const bool isFile = texture.bytes.buffer == nullptr;
            if (isFile)
                inputs_.files.push_back(texture.path);
            images_.push_back(isFile ? ReadImage(texture.path)
                                     : ReadImage(texture.path, texture.bytes.Get()));
        }
        ChooseSize();
        inputs_.material =
            Require(encode::Material::Create(width_, height_), ExitCode::BadInput, options_.paths[0]);
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (manifest_.textures[i].mipLevel == 0)
                Place(manifest_.textures[i], images_[i]);
        }
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (manifest_.textures[i].mipLevel > 0)
                PlaceMip(manifest_.textures[i], images_[i]);
        }
        UseAlpha();
        inputs_.material.GenerateMips(options_.mips);
        for (int m = 0; m < inputs_.material.GetMipCount(); ++m)
            inputs_.rawBytes += rawTexelBytes_ * static_cast<std::uint64_t>(inputs_.material.GetWidth(m)) *
                                static_cast<std::uint64_t>(inputs_.material.GetHeight(m));
        return std::move(inputs_);
    }

private:
    void Warn(const std::string& text) { inputs_.warnings.push_back(text); }

    /// The textures, with their mips, that an option means by a name: theirs, or that of their file.
    std::vector<ManifestTexture*> Find(const char* option, const std::string& name) {
        std::vector<ManifestTexture*> found;
        for (ManifestTexture& texture : manifest_.textures) {
            if (IsNamed(texture, name))
                found.push_back(&texture);
        }
        if (found.empty()) {
            TextureNames names;
            names.Add(manifest_);
            throw names.MakeError(option, name);
        }
        return found;
    }

    void ChooseColorSpaces(const char* option, const std::vector<std::string>& names, bool isSrgb) {
        for (const std::string& name : names) {
            for (ManifestTexture* texture : Find(option, name)) {
                if (std::exchange(texture->colorReason, option) == "--srgb" && !isSrgb)
                    throw CommandError(ExitCode::Usage, option, name + ": is in --srgb too");
                texture->isSrgb = isSrgb;
            }
        }
    }

    /// What else options say of single textures, and of the mips of all.
    void ChooseTextures() {
        manifest_.mips.filter = options_.mipFilter.value_or(manifest_.mips.filter);
        manifest_.mips.wrap = options_.mipWrap.value_or(manifest_.mips.wrap);
        for (const std::string& name : options_.normalMaps) {
            for (ManifestTexture* texture : Find("--normal-map", name))
                texture->normalMap = true;
        }
        for (const NamedNumber& weight : options_.weights) {
            for (ManifestTexture* texture : Find("--weight", weight.name))
                texture->lossScales = {static_cast<float>(weight.number)};
        }
        for (const NamedNumber& target : options_.targets) {
            for (ManifestTexture* texture : Find("--target-psnr", target.name))
                texture->targetPsnr = target.number;
        }
    }

    /// What alpha does to mips: it weighs the colours of its texture, a mask those of the textures that have
    /// no alpha of their own; and its coverage may be kept.
    void UseAlpha() {
        if (options_.maskChannel)
            inputs_.maskChannel = *options_.maskChannel;
        encode::Material& material = inputs_.material;
        for (const auto& [name, placed] : placed_) {
            const int alpha = placed.alphaChannel >= 0 ? placed.alphaChannel
                              : placed.isColor         ? inputs_.maskChannel
                                                       : -1;
            for (int c = placed.firstChannel; alpha >= 0 && c < placed.firstChannel + placed.channels; ++c) {
                if (c != alpha)
                    Require(material.WeighMips(c, alpha), ExitCode::Usage, "--mask-channel");
            }
        }
        const float threshold = options_.keepCoverage > 0.0f ? options_.keepCoverage : manifest_.keepCoverage;
        if (threshold <= 0.0f)
            return;
        const int channel = inputs_.maskChannel >= 0 ? inputs_.maskChannel : alphaChannel_;
        if (channel < 0 && options_.manifest &&
            options_.keepCoverage > 0.0f) // said to many materials: others have alpha
            return;
        if (channel < 0)
            throw CommandError(
                ExitCode::Usage, options_.keepCoverage > 0.0f ? "--keep-coverage" : "keepCoverage",
                "no channel is alpha: a mask label, --mask-channel N, or a colour image with alpha");
        Require(inputs_.material.KeepCoverage(channel, threshold), ExitCode::Usage, "--mask-channel");
    }

    void ChooseSize() {
        width_ = manifest_.width;
        height_ = manifest_.height;
        for (std::size_t i = 0; i < images_.size(); ++i) {
            if (manifest_.textures[i].mipLevel > 0)
                continue;
            if (manifest_.width == 0)
                width_ = std::max(width_, images_[i].width);
            if (manifest_.height == 0)
                height_ = std::max(height_, images_[i].height);
        }
        if (width_ == 0 || height_ == 0)
            throw CommandError(ExitCode::BadInput, options_.paths[0], "textures: no image fills mip 0");
    }

    /// Alpha is the second channel of two and the fourth of four.
    static bool IsColor(const InputImage& image, std::size_t sample) {
        const int channel = static_cast<int>(sample % static_cast<std::size_t>(image.channels));
        return image.channels % 2 != 0 || channel != image.channels - 1;
    }

    /// The image at the wanted size; filtered in linear light.
    InputImage Fit(const InputImage& image, const ManifestTexture& texture, int width, int height,
                   ColorSpace space) {
        if (image.width == width && image.height == height)
            return image;
        const std::string text =
            Format("image: %d x %d: the set's size is %d x %d", image.width, image.height, width, height);
        if (options_.strict)
            throw CommandError(ExitCode::Failed, texture.path, text);
        Warn(texture.path + ": " + text + "; resampled");
        InputImage linear = image;
        for (std::size_t i = 0; i < linear.texels.size(); ++i) {
            if (IsColor(linear, i))
                linear.texels[i] = image::DecodeColor(space, linear.texels[i]);
        }
        linear = ResizeImage(linear, width, height);
        for (std::size_t i = 0; i < linear.texels.size(); ++i) {
            if (IsColor(linear, i))
                linear.texels[i] = image::EncodeColor(space, linear.texels[i]);
        }
        return linear;
    }

    static void Flip(InputImage& image) {
        const auto row = static_cast<std::ptrdiff_t>(image.width) * image.channels;
        for (int y = 0; y < image.height / 2; ++y)
            std::swap_ranges(image.texels.begin() + y * row, image.texels.begin() + (y + 1) * row,
                             image.texels.begin() + (image.height - 1 - y) * row);
    }

    /// Letters of the image's channels that are used.
    std::string ChooseChannels(const ManifestTexture& texture, const InputImage& image) const {
        static constexpr const char* kAll[] = {"R", "RA", "RGB",
                                               "RGBA"}; // stb: 2 channels are gray and alpha
        std::string available = kAll[image.channels - 1];
        if (!texture.swizzle.empty()) {
            // Gray is R, G and B alike. Alpha beside colours is 1 where there is none; alpha alone was asked
            // of the wrong image.
            if (available.back() != 'A' && texture.swizzle.find_first_not_of('A') == std::string::npos)
                throw CommandError(ExitCode::BadInput, texture.path,
                                   "channelSwizzle: A: the image has " + available);
            return texture.swizzle;
        }
        if (available.back() != 'A' || texture.keepAlpha)
            return available;
        const auto channels = static_cast<std::size_t>(image.channels);
        for (std::size_t i = channels - 1; i < image.texels.size(); i += channels) {
            if (image.texels[i] != 1.0f)
                return available;
        }
        return available.substr(0, available.size() - 1);
    }
    /// -1: alpha of an image that has none.
    static int GetImageChannel(const InputImage& image, char letter) {
        if (letter == 'A')
            return image.channels % 2 == 0 ? image.channels - 1 : -1;
        if (image.channels <= 2)
            return 0;
        return letter == 'R' ? 0 : letter == 'G' ? 1 : 2;
    }

    int FindFree(int channels, const ManifestTexture& texture) const {
        const std::uint32_t taken = inputs_.material.GetDeclaredChannels();
        const std::uint32_t run = (1u << channels) - 1u;
        for (int first = 0; first + channels <= 16; ++first) {
            if ((taken & (run << first)) == 0)
                return first;
        }
        throw CommandError(ExitCode::Usage, texture.path,
                           Format("channels: %d more: a set holds 16", channels));
    }

    void Place(const ManifestTexture& texture, const InputImage& source) {
        InputImage image = source;
        const bool isSrgb = texture.isSrgb.value_or(!image.IsFloat()) && !image.IsFloat();
        PlacedTexture placed;
        placed.storedRgb = image.IsFloat() ? ColorSpace::HLG : isSrgb ? ColorSpace::sRGB : ColorSpace::Linear;
        Prepare(texture, image, placed.storedRgb, width_, height_);
        const std::string letters = ChooseChannels(texture, image);
        placed.channels = static_cast<int>(letters.size());
        placed.firstChannel =
            texture.firstChannel >= 0 ? texture.firstChannel : FindFree(placed.channels, texture);

        encode::MaterialTexture description;
        description.name = texture.name;
        description.firstChannel = placed.firstChannel;
        description.channels = placed.channels;
        description.format = image.IsFloat()    ? ChannelFormat::FLOAT16
                             : image.bits == 16 ? ChannelFormat::UNORM16
                                                : ChannelFormat::UNORM8;
        description.rgbColorSpace = isSrgb ? ColorSpace::sRGB : ColorSpace::Linear;
        description.storedRgb = placed.storedRgb;
        description.bcFormat = texture.bcFormat;
        Require(inputs_.material.AddTexture(description, Select(image, letters)), ExitCode::Usage,
                texture.path);
        placed.isColor = isSrgb;
        placed.alphaChannel = FindAlpha(texture, letters, placed);
        placed_[texture.name] = placed;
        ChooseMips(texture, image, placed);
        Explain(texture, image, letters, placed);
        rawTexelBytes_ += static_cast<std::uint64_t>(placed.channels) * (image.bits == 8 ? 1u : 2u);

        if (const std::size_t mask = letters.find(texture.maskLetter);
            texture.maskLetter != 0 && mask != std::string::npos)
            inputs_.maskChannel = placed.firstChannel + static_cast<int>(mask);
        for (std::size_t c = 0; c < letters.size() && !texture.lossScales.empty(); ++c)
            inputs_.lossScales[static_cast<std::size_t>(placed.firstChannel) + c] =
                texture.lossScales[std::min(c, texture.lossScales.size() - 1)];
    }

    void ChooseMips(const ManifestTexture& texture, const InputImage& image, const PlacedTexture& placed) {
        encode::Material& material = inputs_.material;
        image::MipRule rule = manifest_.mips;
        rule.filter = texture.mipFilter.value_or(rule.filter);
        for (int c = placed.firstChannel; c < placed.firstChannel + placed.channels; ++c)
            Require(material.SetMipRule(c, rule), ExitCode::Usage, texture.path);
        if (!texture.normalMap)
            return;
        if (image.IsFloat() || placed.isColor)
            throw CommandError(ExitCode::BadInput, texture.path,
                               std::string("normalMap: ") +
                                   (placed.isColor ? "an sRGB image" : "an image of floats") +
                                   ": must be stored linearly as (n + 1) / 2");
        if (placed.channels < 2)
            throw CommandError(ExitCode::BadInput, texture.path,
                               "normalMap: 1 channel: must be x and y, or x, y and z");
        Require(material.SetNormalMap(placed.firstChannel, std::min(placed.channels, 3)), ExitCode::Usage,
                texture.path);
    }

    /// The channel that says how much of a texel is seen: the one that a label names, or alpha of a colour
    /// texture. Other images keep all kinds of data there.
    int FindAlpha(const ManifestTexture& texture, const std::string& letters, const PlacedTexture& placed) {
        const char letter = texture.maskLetter != 0 ? texture.maskLetter : 'A';
        const std::size_t at = letters.find(letter);
        const bool isData = !placed.isColor || texture.alphaIsData;
        if (at == std::string::npos || letters.size() < 2 || (texture.maskLetter == 0 && isData))
            return -1;
        const int channel = placed.firstChannel + static_cast<int>(at);
        if (alphaChannel_ < 0)
            alphaChannel_ = channel;
        return channel;
    }

    void Explain(const ManifestTexture& texture, const InputImage& image, const std::string& letters,
                 const PlacedTexture& placed) {
        UnderstoodTexture understood;
        understood.name = texture.name;
        understood.file = texture.path;
        understood.firstChannel = placed.firstChannel;
        understood.channels = placed.channels;
        understood.targetPsnr = texture.targetPsnr;
        understood.space = placed.storedRgb;
        understood.reason = image.IsFloat() ? "an image of floats" : texture.colorReason;
        if (image.channels == 2 && texture.swizzle.empty() && letters == "RA")
            understood.hint = "gray and alpha become the channels R and G; \"channelSwizzle\": \"RRRA\" in a "
                              "manifest makes them colour with alpha";
        inputs_.textures.push_back(std::move(understood));
    }

    void PlaceMip(const ManifestTexture& texture, const InputImage& source) {
        const auto found = placed_.find(texture.name);
        if (found == placed_.end())
            throw CommandError(ExitCode::BadInput, texture.path,
                               "mipLevel: " + texture.name + ": has no mip 0");
        const PlacedTexture& placed = found->second;
        InputImage image = source;
        Prepare(texture, image, placed.storedRgb, std::max(width_ >> texture.mipLevel, 1),
                std::max(height_ >> texture.mipLevel, 1));
        ManifestTexture whole = texture;
        whole.keepAlpha = placed.channels == image.channels;
        const std::string letters = ChooseChannels(whole, image);
        if (static_cast<int>(letters.size()) != placed.channels)
            throw CommandError(
                ExitCode::BadInput, texture.path,
                Format("mipLevel: %zu channels: mip 0 has %d", letters.size(), placed.channels));
        if (options_.mips > 0 && texture.mipLevel >= options_.mips)
            return;
        const std::vector<float> texels = Select(image, letters);
        for (int c = 0; c < placed.channels; ++c) {
            std::vector<float> plane;
            for (auto i = static_cast<std::size_t>(c); i < texels.size();
                 i += static_cast<std::size_t>(placed.channels))
                plane.push_back(texels[i]);
            Require(inputs_.material.SetMip(texture.mipLevel, placed.firstChannel + c, std::move(plane)),
                    ExitCode::BadInput, texture.path);
        }
    }

    void Prepare(const ManifestTexture& texture, InputImage& image, ColorSpace space, int width, int height) {
        if (image.IsFloat()) {
            for (std::size_t i = 0; i < image.texels.size(); ++i) {
                if (IsColor(image, i))
                    image.texels[i] = image::EncodeColor(space, image.texels[i]);
            }
        }
        image = Fit(image, texture, width, height, space);
        if (texture.verticalFlip)
            Flip(image);
    }
    static std::vector<float> Select(const InputImage& image, const std::string& letters) {
        std::vector<float> texels;
        const auto channels = static_cast<std::size_t>(image.channels);
        texels.reserve(image.texels.size() / channels * letters.size());
        for (std::size_t i = 0; i < image.texels.size(); i += channels) {
            for (char letter : letters) {
                const int channel = GetImageChannel(image, letter);
                texels.push_back(channel < 0 ? 1.0f : image.texels[i + static_cast<std::size_t>(channel)]);
            }
        }
        return texels;
    }

    const InputOptions& options_;
    Manifest manifest_;
    std::vector<InputImage> images_;
    std::map<std::string, PlacedTexture> placed_;
    EncodeInputs inputs_;
    int width_ = 0, height_ = 0;
    int alphaChannel_ = -1; ///< of the first texture that has alpha
    std::uint64_t rawTexelBytes_ = 0;
};

} // namespace

EncodeInputs LoadInputs(const InputOptions& options) {
    return InputLoader(options).Load();
}

} // namespace openntc::tool
