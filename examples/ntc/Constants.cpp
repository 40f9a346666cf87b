// SPDX-License-Identifier: MIT
// `ntc constants`: what a shader needs besides the latents, as bytes and checksums; of the set or of a slice.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"
#include "ShaderInputs.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/PartialInference.h"

#include <memory>
#include <optional>
#include <vector>

namespace openntc::tool {

namespace {

struct ConstantsOptions : ShaderInputsOptions {
    std::optional<Rect> rect;
    SliceCoverage coverage = SliceCoverage::Published;
    bool json = false;
};

struct Slice {
    std::uint64_t latentBytes = 0;
    std::uint32_t latentCrc32 = 0;
    std::uint64_t conservativeAlign1 = 0;
    std::uint64_t conservativeAlign4 = 0;
    bool holdsAllTexels = false;
};

/// Cuts the slice out and makes `constants` its own.
Slice CutSlice(TextureSet& set, const ShaderInputs& inputs, const ConstantsOptions& options,
               NtcTextureSetConstants& constants) {
    SliceDesc desc{inputs.firstMip, inputs.mips, *options.rect, SliceCoverage::Whole};
    const std::string subject = options.file + ": --rect";
    const std::uint64_t whole =
        Require(GetPartialLatentBufferSize(set.metadata, desc), ExitCode::Usage, subject);
    desc.coverage = options.coverage;
    const std::uint64_t bytes =
        Require(GetPartialLatentBufferSize(set.metadata, desc), ExitCode::Usage, subject);
    std::vector<std::byte> latents(static_cast<std::size_t>(bytes));
    constants = Require(MakePartialInferenceData(set.metadata, set.input.GetStream(), desc, inputs.weightType,
                                                 latents),
                        ExitCode::BadInput, options.file)
                    .constants;
    const auto getConservative = [&](int alignment) {
        if (set.metadata.GetGeneration() > 1)
            return Require(GetConservativeLatentMipBytes(set.metadata, desc.firstMip, desc.numMips,
                                                         desc.rect.width, desc.rect.height),
                           ExitCode::Usage, subject);
        return Require(GetConservativeLatentBufferSize(set.metadata, desc.firstMip, desc.numMips,
                                                       desc.rect.width, desc.rect.height, alignment),
                       ExitCode::Usage, subject);
    };
    Slice slice;
    slice.latentBytes = bytes;
    slice.latentCrc32 = Crc32(latents);
    slice.conservativeAlign1 = getConservative(1);
    slice.conservativeAlign4 = getConservative(4);
    slice.holdsAllTexels = bytes == whole; // more latents are more bytes
    return slice;
}

void WriteSlice(JsonWriter& json, const Slice& slice) {
    json.Member("status", static_cast<std::uint32_t>(Status::Ok)); // WriteRefusal has the others
    json.Member("latentBytes", slice.latentBytes);
    json.Member("latentCrc32", slice.latentCrc32);
    json.Member("conservativeAlign1", slice.conservativeAlign1);
    json.Member("conservativeAlign4", slice.conservativeAlign4);
    json.Member("holdsAllTexels", slice.holdsAllTexels);
}

std::string DescribeSlice(const Slice& slice) {
    return Format("latentBytes %llu\nlatentCrc32 %08x\nconservativeAlign1 %llu\n"
                  "conservativeAlign4 %llu\nholdsAllTexels %s\n",
                  static_cast<unsigned long long>(slice.latentBytes), slice.latentCrc32,
                  static_cast<unsigned long long>(slice.conservativeAlign1),
                  static_cast<unsigned long long>(slice.conservativeAlign4),
                  slice.holdsAllTexels ? "yes" : "no");
}

/// Where the latents are: of generation 1 the bytes of the file that shaders read; of later ones no bytes of a
/// file are (layers lie apart and may be compressed), so that there is the size of what ReadLatents makes.
void WriteLatentPlace(JsonWriter& json, int generation, const ShaderInputs& inputs) {
    if (generation > 1)
        return json.Member("latentBufferBytes", static_cast<std::uint64_t>(inputs.latentBufferBytes));
    json.Member("latentOffset", inputs.latents.offset);
    json.Member("latentSize", inputs.latents.size);
}

std::string DescribeLatentPlace(int generation, const ShaderInputs& inputs) {
    if (generation > 1)
        return Format("latentBufferBytes %zu\n", inputs.latentBufferBytes);
    return Format("latentOffset %llu\nlatentSize %llu\n",
                  static_cast<unsigned long long>(inputs.latents.offset),
                  static_cast<unsigned long long>(inputs.latents.size));
}

/// Why the set has no such slice: the first of mips, rectangle and weights that it does not have.
Status FindRefusal(const TextureSet& set, const ConstantsOptions& options) {
    const int firstMip = options.firstMip.value_or(0);
    const int mips = options.mips.value_or(options.firstMip ? 1 : set.metadata.GetDesc().mips);
    const auto bytes =
        GetPartialLatentBufferSize(set.metadata, {firstMip, mips, *options.rect, options.coverage});
    if (!bytes)
        return bytes.error().GetStatus();
    const auto weights = set.metadata.GetInferenceWeights(
        options.weights == "fp8" ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8);
    return weights ? Status::IOError : weights.error().GetStatus();
}

/// What a script that asks for slices gets where there is none, beside the exit code and the line of the
/// error.
void WriteRefusal(Status status, const CommandError& error) {
    JsonWriter json;
    json.BeginObject();
    json.Member("status", static_cast<std::uint32_t>(status));
    json.Member("error", std::string_view(error.GetLine()));
    json.EndObject();
    WriteOutput(json.Take());
    FinishOutput();
}

int WriteConstants(TextureSet& set, const ConstantsOptions& options) {
    ShaderInputs inputs = MakeShaderInputs(set, options);
    std::optional<Slice> slice;
    if (options.rect)
        slice = CutSlice(set, inputs, options, inputs.constants);
    const std::span<const std::byte> weights = inputs.weights;
    const std::string hex = ToHex(std::as_bytes(std::span(&inputs.constants, 1)));
    const int generation = set.metadata.GetGeneration();
    std::string textureHex;
    if (generation > 1) {
        const NtcTextureSetConstants2 constants =
            Require(MakeTextureConstants(set.metadata, inputs.weightType), ExitCode::BadInput, options.file);
        textureHex = ToHex(std::as_bytes(std::span(&constants, 1)));
    }

    if (options.json) {
        JsonWriter json;
        json.BeginObject();
        json.Member("constants", std::string_view(hex));
        if (!textureHex.empty())
            json.Member("textureConstants", std::string_view(textureHex));
        json.Member("weightBytes", static_cast<std::uint64_t>(weights.size()));
        json.Member("weightCrc32", Crc32(weights));
        WriteLatentPlace(json, generation, inputs);
        if (slice)
            WriteSlice(json, *slice);
        json.EndObject();
        WriteOutput(json.Take());
    } else {
        WriteOutput(Format("constants %s\nweightBytes %zu\nweightCrc32 %08x\n", hex.c_str(), weights.size(),
                           Crc32(weights)) +
                    DescribeLatentPlace(generation, inputs) +
                    (textureHex.empty() ? "" : "textureConstants " + textureHex + "\n") +
                    (slice ? DescribeSlice(*slice) : ""));
    }
    return 0;
}

int RunConstants(const ConstantsOptions& options) {
    TextureSet set = LoadTextureSet(options.file); // a file that is none has no slices to refuse
    try {
        return WriteConstants(set, options);
    } catch (const CommandError& error) {
        if (options.rect && options.json)
            WriteRefusal(FindRefusal(set, options), error);
        throw;
    }
}

} // namespace

void AddConstantsCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ConstantsOptions>();
    CLI::App* command =
        app.add_subcommand("constants", "Shader constants, weights and latent range of a texture set");
    AddShaderInputsOptions(*command, *options);
    command
        ->add_option_function<std::string>(
            "--rect", [options](const std::string& text) { options->rect = ParseRect("--rect", text); },
            "A slice: this rectangle of the first mip, and what lies below it in the others")
        ->type_name("x,y,w,h");
    command
        ->add_option_function<std::string>(
            "--coverage",
            [options](const std::string& name) {
                if (name != "published" && name != "whole")
                    FailUsage("--coverage", name + ": published or whole");
                options->coverage = name == "whole" ? SliceCoverage::Whole : SliceCoverage::Published;
            },
            "Latents of the slice: published (default; as LibNTC cuts it) or whole (all that its texels "
            "need, "
            "which is more where the sizes of mips do not halve)")
        ->type_name("NAME")
        ->needs("--rect");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunConstants(*options); }; });
}

} // namespace openntc::tool
