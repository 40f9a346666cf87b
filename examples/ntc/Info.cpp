// SPDX-License-Identifier: MIT
// `ntc info`: what is in texture sets, for people, with --json everything in the metadata.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Findings.h"
#include "InfoLatents.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"
#include "TextureSizes.h"

#include "openntc/format/NetworkDescription.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/LatentShape.h"

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace openntc::tool {

namespace {

struct InfoOptions {
    std::vector<std::string> files;
    bool verbose = false;
    bool json = false;
};

constexpr InferenceWeightType kWeightTypes[] = {InferenceWeightType::GenericInt8,
                                                InferenceWeightType::GenericFP8};
constexpr const char* kWeightNames[] = {"int8", "fp8"};

double GetFileBitsPerTexel(TextureSet& set) {
    const TextureSetDesc& desc = set.metadata.GetDesc();
    return 8.0 * static_cast<double>(set.input.GetStream().Size()) /
           (static_cast<double>(desc.width) * static_cast<double>(desc.height));
}

// The shape's own figure is defined only when it has a grid scale.
float GetShapeBitsPerPixel(const LatentShape& shape) {
    return shape.gridSizeScale > 0 ? GetLatentShapeBitsPerPixel(shape) : 0.0f;
}

/// The bytes of latents that a renderer needs to sample this mip and all smaller ones: of generation 1 a part
/// of the file, of later ones decompressed and packed.
std::uint64_t GetLatentBytes(const TextureSetMetadata& metadata, int mip) {
    const int mips = metadata.GetDesc().mips - mip;
    if (metadata.GetGeneration() > 1)
        return GetLatentBufferBytes(metadata, mip, mips).value_or(0);
    const auto range = metadata.GetStreamRangeForLatents(mip, mips);
    return range ? range->size : 0;
}

double GetRatio(std::uint64_t bytes, std::uint64_t fileSize) {
    return static_cast<double>(bytes) / static_cast<double>(fileSize);
}

/// "BC7", or what was chosen because the file has no hint.
std::string DescribeBlockFormat(const Texture& texture) {
    const BlockCompressedFormat format = ChooseBlockFormat(texture);
    if (format == BlockCompressedFormat::None)
        return "none";
    return GetName(format) + std::string(texture.bcFormat == BlockCompressedFormat::None ? "*" : "");
}

void PrintSummary(TextureSet& set) {
    const TextureSetMetadata& metadata = set.metadata;
    const TextureSetDesc& desc = metadata.GetDesc();
    const std::uint64_t fileSize = set.input.GetStream().Size();
    WriteOutput(Format("%s\n  size      %d x %d texels, %d channels, %d mips\n",
                       Printable(set.input.GetName()).c_str(), desc.width, desc.height, desc.channels,
                       desc.mips));
    const bool isRefused = !FindRefusals(metadata).empty();
    WriteOutput(Format("  format    generation %d (schemaVersion %d), which LibNTC %s %s: %s network",
                       metadata.GetGeneration(), metadata.GetGeneration(),
                       GetReleases(metadata.GetGeneration()),
                       isRefused ? "refuses (ntc validate says why)" : "reads",
                       GetNetworkName(metadata.GetNetworkVersion())));
    for (std::size_t i = 0; i < 2; ++i) {
        const auto weights = metadata.GetInferenceWeights(kWeightTypes[i]);
        if (weights)
            WriteOutput(Format(", %s weights of %s", kWeightNames[i], FormatBytes(weights->size()).c_str()));
    }
    WriteOutput("\n");
    if (metadata.GetGeneration() == 2)
        WriteOutput("  note      no file of LibNTC 0.8 was at hand: read as the format is described\n");
    PrintLatentShape(metadata);
    const TextureBytes bytes = GetSetBytes(metadata);
    WriteOutput(Format("  file      %s, %.2f bits per texel of mip 0\n", FormatBytes(fileSize).c_str(),
                       GetFileBitsPerTexel(set)));
    WriteOutput(Format("  raw       %s, %.2f times the file\n  BCn       %s, %.2f times the file\n",
                       FormatBytes(bytes.raw).c_str(), GetRatio(bytes.raw, fileSize),
                       FormatBytes(bytes.blocks).c_str(), GetRatio(bytes.blocks, fileSize)));
}

void PrintTextures(const TextureSetMetadata& metadata) {
    bool hasChosen = false;
    WriteOutput("\n  texture                   channels  format   colour  BCn   raw         BCn\n");
    for (const Texture& texture : metadata.GetTextures()) {
        TextureBytes bytes;
        for (const ColorMip& mip : metadata.GetColorMips())
            bytes += GetTextureBytes(texture, mip.width, mip.height);
        const std::string channels =
            texture.numChannels == 0 ? "none"
            : texture.numChannels == 1
                ? Format("%d", texture.firstChannel)
                : Format("%d - %d", texture.firstChannel, texture.firstChannel + texture.numChannels - 1);
        const std::string block = DescribeBlockFormat(texture);
        hasChosen = hasChosen || block.back() == '*';
        WriteOutput(Format("  %-25s %-9s %-8s %-7s %-5s %-11s %s\n", Printable(texture.name).c_str(),
                           channels.c_str(), GetName(texture.channelFormat), GetName(texture.rgbColorSpace),
                           block.c_str(), FormatBytes(bytes.raw).c_str(), FormatBytes(bytes.blocks).c_str()));
    }
    if (hasChosen)
        WriteOutput("  * by the number of channels: the file has no hint\n");
}

void PrintMips(const TextureSetMetadata& metadata) {
    WriteOutput("\n  mip  size           raw         BCn         latents, with all smaller mips\n");
    int index = 0;
    for (const ColorMip& mip : metadata.GetColorMips()) {
        const TextureBytes bytes = GetMipBytes(metadata, index);
        WriteOutput(Format("  %3d  %-14s %-11s %-11s %s\n", index,
                           Format("%d x %d", mip.width, mip.height).c_str(), FormatBytes(bytes.raw).c_str(),
                           FormatBytes(bytes.blocks).c_str(),
                           FormatBytes(GetLatentBytes(metadata, index)).c_str()));
        ++index;
    }
}

/// What only people who write files or loaders want to know.
void PrintDetails(const TextureSetMetadata& metadata) {
    WriteOutput("\n");
    for (const Texture& texture : metadata.GetTextures())
        WriteOutput(Format("  texture %s: alpha %s, BC quality %d, %zu BC7 modes, %zu mips with BC7 modes of "
                           "every block\n",
                           Printable(texture.name).c_str(), GetName(texture.alphaColorSpace),
                           texture.bcQuality, texture.bcModes.size(), texture.blockModes.size()));
    for (int channel = 0; channel < metadata.GetDesc().channels; ++channel)
        WriteOutput(Format("  channel %d: %s%s\n", channel,
                           GetName(metadata.GetChannelStorageColorSpace(channel)),
                           ((metadata.GetValidChannelMask() >> channel) & 1u) != 0 ? "" : ", in no texture"));
    PrintLatentDetails(metadata);
    std::size_t index = 0;
    for (const ColorMip& mip : metadata.GetColorMips())
        WriteOutput(Format("  mip %zu: latent %s %d, positionLod %s, positionScale %s\n", index++,
                           metadata.GetGeneration() == 1 ? "image" : "mip", mip.neuralMip,
                           FormatFloat(mip.positionLod).c_str(), FormatFloat(mip.positionScale).c_str()));
    PrintViews(metadata);
}

void PrintText(TextureSet& set, bool verbose) {
    PrintSummary(set);
    PrintTextures(set.metadata);
    PrintMips(set.metadata);
    if (verbose)
        PrintDetails(set.metadata);
}

void WriteTextures(JsonWriter& json, const TextureSetMetadata& metadata) {
    json.Key("textures");
    json.BeginArray();
    for (const Texture& texture : metadata.GetTextures()) {
        json.BeginObject();
        json.Member("name", texture.name);
        json.Member("firstChannel", texture.firstChannel);
        json.Member("numChannels", texture.numChannels);
        json.Member("channelFormat", GetName(texture.channelFormat));
        json.Member("rgbColorSpace", GetName(texture.rgbColorSpace));
        json.Member("alphaColorSpace", GetName(texture.alphaColorSpace));
        json.Member("bcFormat", GetName(texture.bcFormat));
        json.Member("bcQuality", texture.bcQuality);
        json.Member("bcModes", static_cast<std::uint64_t>(texture.bcModes.size()));
        json.Member("bcModeBuffers", static_cast<std::uint64_t>(texture.blockModes.size()));
        TextureBytes bytes;
        for (const ColorMip& mip : metadata.GetColorMips())
            bytes += GetTextureBytes(texture, mip.width, mip.height);
        json.Member("comparedBcFormat", GetName(ChooseBlockFormat(texture)));
        json.Member("rawBytes", bytes.raw);
        json.Member("bcBytes", bytes.blocks);
        json.EndObject();
    }
    json.EndArray();
}

void WriteLatentsAndMips(JsonWriter& json, const TextureSetMetadata& metadata) {
    WriteLatents(json, metadata);
    json.Key("colorMips");
    json.BeginArray();
    int index = 0;
    for (const ColorMip& mip : metadata.GetColorMips()) {
        const TextureBytes bytes = GetMipBytes(metadata, index);
        json.BeginObject();
        json.Member("width", mip.width);
        json.Member("height", mip.height);
        json.Member("latentImage", mip.neuralMip);
        json.Member("positionLod", mip.positionLod);
        json.Member("positionScale", mip.positionScale);
        json.Member("rawBytes", bytes.raw);
        json.Member("bcBytes", bytes.blocks);
        json.Member("latentBytes", GetLatentBytes(metadata, index++));
        json.EndObject();
    }
    json.EndArray();
}

void WriteSet(JsonWriter& json, TextureSet& set) {
    const TextureSetMetadata& metadata = set.metadata;
    const TextureSetDesc& desc = metadata.GetDesc();
    const LatentShape& shape = metadata.GetLatentShape();
    const TextureBytes bytes = GetSetBytes(metadata);
    json.BeginObject();
    json.Member("file", std::string_view(set.input.GetName()));
    json.Member("schemaVersion", metadata.GetDocument().schemaVersion);
    json.Member("generation", metadata.GetGeneration());
    json.Member("libntc", GetReleases(metadata.GetGeneration()));
    json.Key("libntcRefuses");
    json.BeginArray();
    for (const Finding& finding : FindRefusals(metadata))
        json.Value(std::string_view(finding.text));
    json.EndArray();
    json.Member("fileSize", set.input.GetStream().Size());
    json.Member("width", desc.width);
    json.Member("height", desc.height);
    json.Member("channels", desc.channels);
    json.Member("mips", desc.mips);
    json.Member("bitsPerPixel", GetShapeBitsPerPixel(shape));
    json.Member("fileBitsPerTexel", GetFileBitsPerTexel(set));
    json.Member("rawBytes", bytes.raw);
    json.Member("bcBytes", bytes.blocks);
    json.Member("rawRatio", GetRatio(bytes.raw, set.input.GetStream().Size()));
    json.Member("bcRatio", GetRatio(bytes.blocks, set.input.GetStream().Size()));
    json.Key("network");
    json.BeginObject();
    json.Member("version", metadata.GetNetworkVersion());
    json.Member("name", GetNetworkName(metadata.GetNetworkVersion()));
    json.EndObject();
    WriteLatentShape(json, shape);
    json.Key("weights");
    json.BeginObject();
    for (std::size_t i = 0; i < 2; ++i) {
        const auto weights = metadata.GetInferenceWeights(kWeightTypes[i]);
        if (weights)
            json.Member(kWeightNames[i], static_cast<std::uint64_t>(weights->size()));
    }
    json.EndObject();
    WriteTextures(json, metadata);
    json.Member("validChannelMask", metadata.GetValidChannelMask());
    json.Key("channelColorSpaces");
    json.BeginArray();
    for (int channel = 0; channel < desc.channels; ++channel)
        json.Value(GetName(metadata.GetChannelStorageColorSpace(channel)));
    json.EndArray();
    WriteLatentsAndMips(json, metadata);
    WriteViews(json, metadata);
    json.EndObject();
}

/// One file gives its object, several the member "files". Files that cannot be read are told of at the end.
int RunInfo(const InfoOptions& options) {
    CheckOneStandardInput(options.files);
    const bool isList = options.files.size() > 1;
    JsonWriter json;
    if (isList) {
        json.BeginObject();
        json.Key("files");
        json.BeginArray();
    }
    std::vector<CommandError> errors;
    bool isFirst = true;
    for (const std::string& file : options.files) {
        try {
            TextureSet set = LoadTextureSet(file);
            if (options.json) {
                WriteSet(json, set);
            } else {
                WriteOutput(isFirst ? "" : "\n");
                PrintText(set, options.verbose);
            }
            isFirst = false;
        } catch (const CommandError& error) {
            if (!isList || error.GetCode() != ExitCode::BadInput)
                throw;
            errors.push_back(error);
        }
    }
    if (isList) {
        json.EndArray();
        json.EndObject();
    }
    if (options.json)
        WriteOutput(json.Take());
    FinishOutput();
    for (const CommandError& error : errors)
        std::fprintf(stderr, "%s\n", error.GetLine().c_str());
    return static_cast<int>(errors.empty() ? ExitCode::Ok : ExitCode::BadInput);
}

} // namespace

void AddInfoCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<InfoOptions>();
    CLI::App* command = app.add_subcommand("info", "What is in texture sets, and what they save");
    AddFilesArgument(*command, options->files);
    command->add_flag("--verbose", options->verbose, "Also channels, latent images, positions and views");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunInfo(*options); }; });
}

} // namespace openntc::tool
