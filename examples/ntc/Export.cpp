// SPDX-License-Identifier: MIT
// `ntc export`: constants, weights and latents as files, in the bytes that shaders read.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "ShaderInputs.h"

#include "openntc/MathModes.h"
#include "openntc/core/Crc32.h"
#include "openntc/format/NetworkDescription.h"
#include "openntc/inference/LatentTextures.h"
#include "openntc/inference/ReadLatents.h"

#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct ExportOptions : ShaderInputsOptions {
    std::string outputFolder;
    bool json = false;
};

constexpr const char* kTextureConstantsFile = "texture-constants.bin";

struct ExportedBytes {
    std::vector<std::byte> latents;
    std::vector<std::byte> textureConstants; ///< of LibNTC's own shaders; empty for generation 1
};

ExportedBytes ReadExportedBytes(TextureSet& set, const ShaderInputs& inputs, const std::string& file) {
    ExportedBytes bytes;
    bytes.latents.resize(inputs.latentBufferBytes);
    Require(ReadLatents(set.metadata, set.input.GetStream(), inputs.firstMip, inputs.mips, bytes.latents),
            ExitCode::BadInput, file);
    if (set.metadata.GetGeneration() > 1) {
        const NtcTextureSetConstants2 constants =
            Require(MakeTextureConstants(set.metadata, inputs.weightType), ExitCode::BadInput, file);
        const auto source = std::as_bytes(std::span(&constants, 1));
        bytes.textureConstants.assign(source.begin(), source.end());
    }
    return bytes;
}

void WriteFileEntry(JsonWriter& json, const char* key, const char* name, std::span<const std::byte> bytes) {
    json.Key(key);
    json.BeginObject();
    json.Member("file", name);
    json.Member("bytes", static_cast<std::uint64_t>(bytes.size()));
    json.Member("crc32", Crc32(bytes));
    json.EndObject();
}

/// What an array texture of the latents is made of, for hosts that have no LatentTextures.h.
void WriteLatentTexture(JsonWriter& json, const TextureSet& set, const ShaderInputs& inputs) {
    const std::string& file = set.input.GetName();
    const LatentTextureSize size = Require(GetLatentTextureSize(set.metadata), ExitCode::BadInput, file);
    json.Key("latentTexture");
    json.BeginObject();
    json.Member("width", size.width);
    json.Member("height", size.height);
    json.Member("levels", size.levels);
    json.Member("layers", size.layers);
    json.Key("mips");
    json.BeginArray();
    for (const LatentTextureCopy& copy : Require(
             GetLatentTextureCopies(set.metadata, inputs.firstMip, inputs.mips), ExitCode::BadInput, file)) {
        json.BeginObject();
        json.Member("level", copy.level);
        json.Member("width", copy.width);
        json.Member("height", copy.height);
        json.Member("layers", copy.layers);
        json.Member("offset", static_cast<std::uint64_t>(copy.offset));
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
}

std::string MakeIndex(const TextureSet& set, const ShaderInputs& inputs, const ExportedBytes& bytes) {
    const TextureSetDesc& desc = set.metadata.GetDesc();
    const int network = set.metadata.GetNetworkVersion();
    const bool isFP8 = inputs.weightType == InferenceWeightType::GenericFP8;
    JsonWriter json;
    json.BeginObject();
    json.Member("width", desc.width);
    json.Member("height", desc.height);
    json.Member("channels", desc.channels);
    json.Member("imageMips", desc.mips);
    json.Member("firstMip", inputs.firstMip);
    json.Member("mips", inputs.mips);
    json.Member("network", GetNetworkName(network));
    json.Member("weightType", isFP8 ? "fp8" : "int8");
    json.Key("defines");
    json.BeginArray();
    json.Value("NETWORK_VERSION=" + std::to_string(network));
    json.Value("NTC_MATH=" + std::to_string(isFP8 ? NTC_MATH_FP8 : NTC_MATH_INT8));
    json.EndArray();
    json.Key("textures");
    json.BeginArray();
    for (const Texture& texture : set.metadata.GetTextures()) {
        json.BeginObject();
        json.Member("name", std::string_view(texture.name));
        json.Member("firstChannel", texture.firstChannel);
        json.Member("channels", texture.numChannels);
        json.EndObject();
    }
    json.EndArray();
    WriteFileEntry(json, "constants", "constants.bin", std::as_bytes(std::span(&inputs.constants, 1)));
    if (!bytes.textureConstants.empty())
        WriteFileEntry(json, "textureConstants", kTextureConstantsFile, bytes.textureConstants);
    WriteFileEntry(json, "weights", "weights.bin", inputs.weights);
    WriteFileEntry(json, "latents", "latents.bin", bytes.latents);
    const bool isLayered = set.metadata.GetGeneration() > 1;
    json.Member("latentBytes", isLayered ? bytes.latents.size() : inputs.latents.size);
    if (isLayered)
        WriteLatentTexture(json, set, inputs);
    json.EndObject();
    return json.Take();
}

std::string_view ToText(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

int RunExport(const ExportOptions& options) {
    TextureSet set = LoadTextureSet(options.file);
    const ShaderInputs inputs = MakeShaderInputs(set, options);
    const ExportedBytes bytes = ReadExportedBytes(set, inputs, options.file);
    const std::string index = MakeIndex(set, inputs, bytes);

    OutputFolder folder(options.outputFolder);
    WriteBytes(folder.Stage("constants.bin"), ToText(std::as_bytes(std::span(&inputs.constants, 1))));
    WriteBytes(folder.Stage("weights.bin"), ToText(inputs.weights));
    WriteBytes(folder.Stage("latents.bin"), ToText(bytes.latents));
    if (!bytes.textureConstants.empty())
        WriteBytes(folder.Stage(kTextureConstantsFile), ToText(bytes.textureConstants));
    WriteBytes(folder.Stage("index.json"), index);
    folder.Commit();
    if (options.json)
        WriteOutput(index);
    else
        WriteOutput(
            Format("constants.bin %zu bytes, weights.bin %zu, latents.bin %zu, index.json %zu%s\n",
                   sizeof(inputs.constants), inputs.weights.size(), bytes.latents.size(), index.size(),
                   bytes.textureConstants.empty()
                       ? ""
                       : Format(", %s %zu", kTextureConstantsFile, bytes.textureConstants.size()).c_str()));
    return 0;
}

} // namespace

void AddExportCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ExportOptions>();
    CLI::App* command = app.add_subcommand(
        "export",
        "Shader constants, weights and latents of a texture set as files, for programs without C++");
    AddShaderInputsOptions(*command, *options);
    command
        ->add_option("-o,--output", options->outputFolder,
                     "Folder of constants.bin, weights.bin, latents.bin and index.json; of generations 2 and "
                     "3 also texture-constants.bin")
        ->type_name("DIR")
        ->required();
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunExport(*options); }; });
}

} // namespace openntc::tool
