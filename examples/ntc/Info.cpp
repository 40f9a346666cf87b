// SPDX-License-Identifier: MIT
// `ntc info`: everything in the metadata.
#include "Arguments.h"
#include "Commands.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"

#include "openntc/format/NetworkDescription.h"
#include "openntc/texture_set/LatentShape.h"

#include <memory>

namespace openntc::tool {

namespace {

struct InfoOptions {
    std::string file;
    bool json = false;
};

constexpr InferenceWeightType kWeightTypes[] = {InferenceWeightType::GenericInt8,
                                                InferenceWeightType::GenericFP8};
constexpr const char* kWeightNames[] = {"int8", "fp8"};

unsigned long long Wide(std::uint64_t value) {
    return value;
}

double GetFileBitsPerTexel(TextureSet& set) {
    const TextureSetDesc& desc = set.metadata.GetDesc();
    return 8.0 * static_cast<double>(set.input.GetStream().Size()) /
           (static_cast<double>(desc.width) * static_cast<double>(desc.height));
}

// The shape's own figure is defined only when it has a grid scale.
float GetShapeBitsPerPixel(const LatentShape& shape) {
    return shape.gridSizeScale > 0 ? GetLatentShapeBitsPerPixel(shape) : 0.0f;
}

void PrintGrid(const char* name, const LatentGrid& grid) {
    WriteOutput(Format(" %s %dx%d at %llu + %llu", name, grid.width, grid.height, Wide(grid.offset),
                       Wide(grid.size)));
}

void PrintText(TextureSet& set) {
    const TextureSetMetadata& metadata = set.metadata;
    const TextureSetDesc& desc = metadata.GetDesc();
    const LatentShape& shape = metadata.GetLatentShape();
    WriteOutput(Format("file %s\nschemaVersion %u\nfileSize %llu\nsize %d x %d\nchannels %d\nmips %d\n",
                       Printable(set.input.GetName()).c_str(), metadata.GetDocument().schemaVersion,
                       Wide(set.input.GetStream().Size()), desc.width, desc.height, desc.channels,
                       desc.mips));
    WriteOutput(Format("bitsPerPixel %.9g\nfileBitsPerTexel %.6g\n",
                       static_cast<double>(GetShapeBitsPerPixel(shape)), GetFileBitsPerTexel(set)));
    WriteOutput(Format("network %s (%d)\n", GetNetworkName(metadata.GetNetworkVersion()),
                       metadata.GetNetworkVersion()));
    WriteOutput(Format(
        "latentShape gridSizeScale %d, high-res %d features of %d bits, low-res %d features of %d bits\n",
        shape.gridSizeScale, shape.highResFeatures, shape.highResQuantBits, shape.lowResFeatures,
        shape.lowResQuantBits));
    for (std::size_t i = 0; i < 2; ++i) {
        const auto weights = metadata.GetInferenceWeights(kWeightTypes[i]);
        if (weights)
            WriteOutput(Format("weights %s %zu bytes\n", kWeightNames[i], weights->size()));
    }
    for (const Texture& texture : metadata.GetTextures())
        WriteOutput(Format(
            "texture %s: channels %d + %d, %s, rgb %s, alpha %s, %s quality %d, %zu BC7 modes\n",
            Printable(texture.name).c_str(), texture.firstChannel, texture.numChannels,
            GetName(texture.channelFormat), GetName(texture.rgbColorSpace), GetName(texture.alphaColorSpace),
            GetName(texture.bcFormat), texture.bcQuality, texture.bcModes.size()));
    for (int channel = 0; channel < desc.channels; ++channel)
        WriteOutput(Format("channel %d: %s%s\n", channel,
                           GetName(metadata.GetChannelStorageColorSpace(channel)),
                           ((metadata.GetValidChannelMask() >> channel) & 1u) != 0 ? "" : ", in no texture"));
    std::size_t index = 0;
    for (const LatentImage& image : metadata.GetLatentImages()) {
        WriteOutput(Format("latent image %zu:", index++));
        PrintGrid("high-res", image.highRes);
        PrintGrid("low-res", image.lowRes);
        WriteOutput("\n");
    }
    index = 0;
    for (const ColorMip& mip : metadata.GetColorMips())
        WriteOutput(Format("mip %zu: %d x %d, latent image %d, positionLod %s, positionScale %s\n", index++,
                           mip.width, mip.height, mip.neuralMip, FormatFloat(mip.positionLod).c_str(),
                           FormatFloat(mip.positionScale).c_str()));
    index = 0;
    for (const container::BufferView& view : metadata.GetDocument().views)
        WriteOutput(Format("view %zu: %llu + %llu\n", index++, Wide(view.offset), Wide(view.storedSize)));
}

void WriteGrid(JsonWriter& json, const char* key, const LatentGrid& grid) {
    json.Key(key);
    json.BeginObject();
    json.Member("width", grid.width);
    json.Member("height", grid.height);
    json.Member("offset", grid.offset);
    json.Member("size", grid.size);
    json.EndObject();
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
        json.EndObject();
    }
    json.EndArray();
}

void WriteLatentsAndMips(JsonWriter& json, const TextureSetMetadata& metadata) {
    json.Key("latentImages");
    json.BeginArray();
    for (const LatentImage& image : metadata.GetLatentImages()) {
        json.BeginObject();
        WriteGrid(json, "highRes", image.highRes);
        WriteGrid(json, "lowRes", image.lowRes);
        json.EndObject();
    }
    json.EndArray();
    json.Key("colorMips");
    json.BeginArray();
    for (const ColorMip& mip : metadata.GetColorMips()) {
        json.BeginObject();
        json.Member("width", mip.width);
        json.Member("height", mip.height);
        json.Member("latentImage", mip.neuralMip);
        json.Member("positionLod", mip.positionLod);
        json.Member("positionScale", mip.positionScale);
        json.EndObject();
    }
    json.EndArray();
}

void PrintJson(TextureSet& set) {
    const TextureSetMetadata& metadata = set.metadata;
    const TextureSetDesc& desc = metadata.GetDesc();
    const LatentShape& shape = metadata.GetLatentShape();
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(set.input.GetName()));
    json.Member("schemaVersion", metadata.GetDocument().schemaVersion);
    json.Member("fileSize", set.input.GetStream().Size());
    json.Member("width", desc.width);
    json.Member("height", desc.height);
    json.Member("channels", desc.channels);
    json.Member("mips", desc.mips);
    json.Member("bitsPerPixel", GetShapeBitsPerPixel(shape));
    json.Member("fileBitsPerTexel", GetFileBitsPerTexel(set));
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
    json.Key("views");
    json.BeginArray();
    for (const container::BufferView& view : metadata.GetDocument().views) {
        json.BeginObject();
        json.Member("offset", view.offset);
        json.Member("storedSize", view.storedSize);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    WriteOutput(json.Take());
}

int RunInfo(const InfoOptions& options) {
    TextureSet set = LoadTextureSet(options.file);
    options.json ? PrintJson(set) : PrintText(set);
    return 0;
}

} // namespace

void AddInfoCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<InfoOptions>();
    CLI::App* command = app.add_subcommand("info", "Print everything in the metadata");
    AddFileArgument(*command, options->file);
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunInfo(*options); }; });
}

} // namespace openntc::tool
