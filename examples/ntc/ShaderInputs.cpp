// SPDX-License-Identifier: MIT
#include "ShaderInputs.h"

#include "Arguments.h"
#include "Failure.h"
#include "Output.h"

#include "openntc/inference/ReadLatents.h"

namespace openntc::tool {

void AddShaderInputsOptions(CLI::App& command, ShaderInputsOptions& options) {
    AddFileArgument(command, options.file);
    command
        .add_option_function<std::string>(
            "--weights",
            [&options](const std::string& name) {
                if (name != "int8" && name != "fp8")
                    FailUsage("--weights", name + ": int8 or fp8");
                options.weights = name;
            },
            "int8 (default) or fp8")
        ->type_name("TYPE");
    CLI::Option* firstMip = command.add_option("--first-mip", options.firstMip,
                                               "First colour mip of the latent range (default: all mips)");
    command.add_option("--mips", options.mips, "Number of colour mips (default: 1)")->needs(firstMip);
}

ShaderInputs MakeShaderInputs(const TextureSet& set, const ShaderInputsOptions& options) {
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
        Require(MakeInferenceData(set.metadata, firstMip, mips, type), ExitCode::BadInput, options.file);
    const std::size_t bytes =
        Require(GetLatentBufferBytes(set.metadata, firstMip, mips), ExitCode::BadInput, options.file);
    return {constants, type, weights, range, bytes, firstMip, mips};
}

} // namespace openntc::tool
