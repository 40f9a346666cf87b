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
#include "openntc/inference/ReadLatents.h"

#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct ExportOptions : ShaderInputsOptions {
    std::string outputFolder;
    bool json = false;
};

void WriteFileEntry(JsonWriter& json, const char* key, const char* name, std::span<const std::byte> bytes) {
    json.Key(key);
    json.BeginObject();
    json.Member("file", name);
    json.Member("bytes", static_cast<std::uint64_t>(bytes.size()));
    json.Member("crc32", Crc32(bytes));
    json.EndObject();
}

std::string MakeIndex(const TextureSet& set, const ShaderInputs& inputs, std::span<const std::byte> latents) {
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
    WriteFileEntry(json, "weights", "weights.bin", inputs.weights);
    WriteFileEntry(json, "latents", "latents.bin", latents);
    json.Member("latentBytes", set.metadata.GetGeneration() == 1 ? inputs.latents.size : latents.size());
    json.EndObject();
    return json.Take();
}

std::string_view ToText(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

int RunExport(const ExportOptions& options) {
    TextureSet set = LoadTextureSet(options.file);
    const ShaderInputs inputs = MakeShaderInputs(set, options);
    std::vector<std::byte> latents(Require(GetLatentBufferBytes(set.metadata, inputs.firstMip, inputs.mips),
                                           ExitCode::BadInput, options.file));
    Require(ReadLatents(set.metadata, set.input.GetStream(), inputs.firstMip, inputs.mips, latents),
            ExitCode::BadInput, options.file);
    const std::string index = MakeIndex(set, inputs, latents);

    OutputFolder folder(options.outputFolder);
    WriteBytes(folder.Stage("constants.bin"), ToText(std::as_bytes(std::span(&inputs.constants, 1))));
    WriteBytes(folder.Stage("weights.bin"), ToText(inputs.weights));
    WriteBytes(folder.Stage("latents.bin"), ToText(latents));
    WriteBytes(folder.Stage("index.json"), index);
    folder.Commit();
    if (options.json)
        WriteOutput(index);
    else
        WriteOutput(Format("constants.bin %zu bytes, weights.bin %zu, latents.bin %zu, index.json %zu\n",
                           sizeof(inputs.constants), inputs.weights.size(), latents.size(), index.size()));
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
                     "Folder of constants.bin, weights.bin, latents.bin and index.json")
        ->type_name("DIR")
        ->required();
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunExport(*options); }; });
}

} // namespace openntc::tool
