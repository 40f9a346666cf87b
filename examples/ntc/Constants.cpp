// SPDX-License-Identifier: MIT
// `ntc constants`: what a shader needs besides the latents, as bytes and checksums.
#include "Arguments.h"
#include "Commands.h"
#include "Json.h"
#include "Output.h"
#include "ShaderInputs.h"

#include "openntc/core/Crc32.h"

#include <memory>

namespace openntc::tool {

namespace {

struct ConstantsOptions : ShaderInputsOptions {
    bool json = false;
};

int RunConstants(const ConstantsOptions& options) {
    const TextureSet set = LoadTextureSet(options.file);
    const ShaderInputs inputs = MakeShaderInputs(set, options);
    const std::span<const std::byte> weights = inputs.weights;
    const StreamRange range = inputs.latents;
    const std::string hex = ToHex(std::as_bytes(std::span(&inputs.constants, 1)));

    if (options.json) {
        JsonWriter json;
        json.BeginObject();
        json.Member("constants", std::string_view(hex));
        json.Member("weightBytes", static_cast<std::uint64_t>(weights.size()));
        json.Member("weightCrc32", Crc32(weights));
        json.Member("latentOffset", range.offset);
        json.Member("latentSize", range.size);
        json.EndObject();
        WriteOutput(json.Take());
    } else {
        WriteOutput(
            Format("constants %s\nweightBytes %zu\nweightCrc32 %08x\nlatentOffset %llu\nlatentSize %llu\n",
                   hex.c_str(), weights.size(), Crc32(weights), static_cast<unsigned long long>(range.offset),
                   static_cast<unsigned long long>(range.size)));
    }
    return 0;
}

} // namespace

void AddConstantsCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ConstantsOptions>();
    CLI::App* command =
        app.add_subcommand("constants", "Shader constants, weights and latent range of a texture set");
    AddShaderInputsOptions(*command, *options);
    AddLaterOption(*command, "--rect");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunConstants(*options); }; });
}

} // namespace openntc::tool
