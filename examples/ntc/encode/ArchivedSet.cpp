// SPDX-License-Identifier: MIT
#include "encode/ArchivedSet.h"

#include "Failure.h"
#include "Output.h"
#include "encode/ComparedSet.h"
#include "encode/TextureNames.h"

#include <algorithm>

namespace openntc::tool {

namespace {

int GetTexelBytes(ChannelFormat format) {
    switch (format) {
    case ChannelFormat::UNORM8:
        return 1;
    case ChannelFormat::UNORM16:
    case ChannelFormat::FLOAT16:
        return 2;
    default:
        return 4;
    }
}

bool IsUnorm(ChannelFormat format) {
    return format == ChannelFormat::UNORM8 || format == ChannelFormat::UNORM16;
}

/// The encoding that channels [first, last) are stored in.
ColorSpace GetStoredSpace(const TextureSet& set, const Texture& texture, int first, int last) {
    const ColorSpace space = set.metadata.GetChannelStorageColorSpace(first);
    for (int c = first; c < last; ++c) {
        const ColorSpace other = set.metadata.GetChannelStorageColorSpace(c);
        if (other != space)
            throw CommandError(ExitCode::BadInput, set.input.GetName(),
                               Format("channels[%d].colorSpace: %s: the channels before it in %s are %s", c,
                                      GetName(other), Printable(texture.name).c_str(), GetName(space)));
    }
    return space;
}

encode::MaterialTexture DescribeTexture(const TextureSet& set, const Texture& texture) {
    const int first = texture.firstChannel, end = first + texture.numChannels;
    const int colors = std::min(end, first + 3), alphas = std::min(end, first + 4);
    encode::MaterialTexture result;
    result.name = texture.name;
    result.firstChannel = first;
    result.channels = texture.numChannels;
    result.format = texture.channelFormat;
    result.rgbColorSpace = texture.rgbColorSpace;
    result.alphaColorSpace = texture.alphaColorSpace;
    result.storedRgb = GetStoredSpace(set, texture, first, colors);
    if (alphas > colors)
        result.storedAlpha = GetStoredSpace(set, texture, colors, alphas);
    if (end > alphas && GetStoredSpace(set, texture, alphas, end) != ColorSpace::Linear)
        throw CommandError(ExitCode::BadInput, set.input.GetName(),
                           Format("channels[%d].colorSpace: %s: channels of %s after the fourth are Linear",
                                  alphas, GetName(set.metadata.GetChannelStorageColorSpace(alphas)),
                                  Printable(texture.name).c_str()));
    result.bcFormat = texture.bcFormat;
    return result;
}

std::vector<float> Interleave(const ComparedSet::Mip& mip, const Texture& texture) {
    const auto channels = static_cast<std::size_t>(texture.numChannels);
    const auto first = static_cast<std::size_t>(texture.firstChannel);
    std::vector<float> texels(channels * mip.planes[first].size());
    for (std::size_t c = 0; c < channels; ++c) {
        const std::vector<float>& plane = mip.planes[first + c];
        for (std::size_t i = 0; i < plane.size(); ++i)
            texels[i * channels + c] = plane[i];
    }
    return texels;
}

void AddArchivedTexture(TextureSet& set, const Texture& texture, ComparedSet& decoded, EncodeInputs& inputs) {
    const std::string& name = set.input.GetName();
    for (int c = texture.firstChannel; c < texture.firstChannel + texture.numChannels; ++c) {
        if (IsUnorm(texture.channelFormat) || c == inputs.maskChannel)
            ClampChannel(decoded, c);
    }
    const encode::MaterialTexture described = DescribeTexture(set, texture);
    Require(inputs.material.AddTexture(described, Interleave(decoded.mips[0], texture)), ExitCode::BadInput,
            name);
    UnderstoodTexture& understood = inputs.textures.emplace_back();
    understood.name = texture.name;
    understood.file = name;
    understood.firstChannel = texture.firstChannel;
    understood.channels = texture.numChannels;
    understood.space = *described.storedRgb;
    understood.reason = "as the set says";
    for (std::size_t m = 0; m < decoded.mips.size(); ++m) {
        ComparedSet::Mip& mip = decoded.mips[m];
        inputs.rawBytes +=
            static_cast<std::uint64_t>(mip.width) * static_cast<std::uint64_t>(mip.height) *
            static_cast<std::uint64_t>(texture.numChannels * GetTexelBytes(texture.channelFormat));
        for (int c = texture.firstChannel; m > 0 && c < texture.firstChannel + texture.numChannels; ++c)
            Require(inputs.material.SetMip(static_cast<int>(m), c, std::move(mip.planes[c])),
                    ExitCode::BadInput, name);
    }
}

void UseNumbers(const ArchivedSetOptions& options, EncodeInputs& inputs) {
    for (UnderstoodTexture& texture : inputs.textures) {
        for (const NamedNumber& target : options.targets) {
            if (target.name == texture.name)
                texture.targetPsnr = target.number;
        }
        for (const NamedNumber& weight : options.weights) {
            if (weight.name == texture.name)
                std::fill_n(inputs.lossScales.begin() + texture.firstChannel, texture.channels,
                            static_cast<float>(weight.number));
        }
    }
}

void CheckNames(const TextureSet& set, const ArchivedSetOptions& options) {
    TextureNames names;
    for (const Texture& texture : set.metadata.GetTextures()) {
        if (texture.numChannels > 0)
            names.Add(std::string(texture.name));
    }
    InputOptions inputs;
    inputs.weights = options.weights;
    TrainingChoices training;
    training.textureTargets = options.targets;
    if (const std::optional<CommandError> error = names.FindUnknown(inputs, training))
        throw *error;
}

} // namespace

EncodeInputs LoadArchivedSet(TextureSet& set, const ArchivedSetOptions& options) {
    CheckNames(set, options);
    const std::string& name = set.input.GetName();
    const TextureSetDesc& desc = set.metadata.GetDesc();
    EncodeInputs inputs;
    inputs.material = Require(encode::Material::Create(desc.width, desc.height), ExitCode::BadInput, name);
    inputs.lossScales.fill(1.0f);
    inputs.maskChannel = options.maskChannel;
    if (name != "-")
        inputs.files.push_back(name);
    ComparedSet decoded = DecodeSet(set);
    inputs.warnings = decoded.warnings;
    bool hasBlockModes = false;
    for (const Texture& texture : set.metadata.GetTextures()) {
        if (texture.numChannels == 0)
            continue;
        AddArchivedTexture(set, texture, decoded, inputs);
        hasBlockModes = hasBlockModes || !texture.bcModes.empty() || !texture.blockModes.empty();
    }
    if (inputs.textures.empty())
        throw CommandError(ExitCode::BadInput, name, "textures: none: nothing to encode");
    UseNumbers(options, inputs);
    inputs.warnings.push_back(name + ": texels: decoded: what the new file loses adds to what this one lost; "
                                     "encode the sources where they still exist");
    if (hasBlockModes && !options.newModes)
        inputs.warnings.push_back(
            name + ": BC7 modes: not kept: they belong to the old texels (" +
            (options.generation == 3 ? "--bc7-modes, or ntc optimize-bc --in-set," : "ntc optimize-bc") +
            " makes new ones)");
    return inputs;
}

} // namespace openntc::tool
