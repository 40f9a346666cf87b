// SPDX-License-Identifier: MIT
// `ntc constants`: what a shader needs besides the latents, as bytes and checksums.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"

#include "openntc/core/Crc32.h"

#include <memory>
#include <optional>

namespace openntc::tool {

namespace {

struct ConstantsOptions {
    std::string file;
    std::string weights = "int8";
    std::optional<int> firstMip;
    std::optional<int> mips;
    bool json = false;
};

int RunConstants(const ConstantsOptions& options) {
    const TextureSet set = LoadTextureSet(options.file);
    const int imageMips = set.metadata.GetDesc().mips;
    const int firstMip = options.firstMip.value_or(0);
    if (firstMip < 0 || firstMip >= imageMips)
        FailUsage(options.file, Format("--first-mip: %d: 0 ... %d", firstMip, imageMips - 1));
    const int mips = options.mips.value_or(options.firstMip ? 1 : imageMips);
    if (mips < 1 || mips > imageMips - firstMip)
        FailUsage(options.file,
                  Format("--mips: %d: 1 ... %d from mip %d", mips, imageMips - firstMip, firstMip));

    const InferenceWeightType type =
        options.weights == "fp8" ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
    const std::span<const std::byte> weights = GetWeights(set, type);
    const StreamRange range =
        Require(set.metadata.GetStreamRangeForLatents(firstMip, mips), ExitCode::BadInput, options.file);
    const NtcTextureSetConstants constants =
        Require(MakeInferenceData(set.metadata, range, type), ExitCode::BadInput, options.file);
    const std::string hex = ToHex(std::as_bytes(std::span(&constants, 1)));

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
            Format("constants %s\nweightBytes %zu\nweightCrc32 %u\nlatentOffset %llu\nlatentSize %llu\n",
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
    AddFileArgument(*command, options->file);
    command
        ->add_option_function<std::string>(
            "--weights",
            [options](const std::string& name) {
                if (name != "int8" && name != "fp8")
                    FailUsage("--weights", name + ": int8 or fp8");
                options->weights = name;
            },
            "int8 (default) or fp8")
        ->type_name("TYPE");
    CLI::Option* firstMip = command->add_option("--first-mip", options->firstMip,
                                                "First colour mip of the latent range (default: all mips)");
    command->add_option("--mips", options->mips, "Number of colour mips (default: 1)")->needs(firstMip);
    AddLaterOption(*command, "--rect");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunConstants(*options); }; });
}

} // namespace openntc::tool
