// SPDX-License-Identifier: MIT
#include "encode/TrainingArguments.h"

#include "encode/TrainingLimits.h"

#include <cmath>
#include <cstdio>

namespace openntc::tool {

namespace {

/// "S,F" of generation 3 or "S,HF,LF,HB,LB" of generation 1.
LatentShape ParseShape(const std::string& text) {
    LatentShape shape;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%d,%d%c", &shape.gridSizeScale, &shape.highResFeatures, &rest) == 2)
        return MakeLayeredShape(shape.gridSizeScale, shape.highResFeatures);
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d,%d%c", &shape.gridSizeScale, &shape.highResFeatures,
                    &shape.lowResFeatures, &shape.highResQuantBits, &shape.lowResQuantBits, &rest) != 5 ||
        shape.IsEmpty())
        FailUsage("--latent-shape", text + ": five numbers S,HF,LF,HB,LB, or S,F of generation 3");
    return shape;
}

void ParseTarget(TrainingChoices& choices, const std::string& text) {
    constexpr NumberLimits kDecibels{1e-3, 1000.0};
    if (text.find('=') != std::string::npos)
        choices.textureTargets.push_back(ParseNamedNumber("--target-psnr", text, kDecibels));
    else
        choices.targetPsnr = ParseNumber("--target-psnr", text, kDecibels, false);
}

void FinishGeneration(TrainingChoices& choices, bool hasNetwork) {
    encode::EncodeOptions& encode = choices.encode;
    if (choices.generation == 3) {
        if (hasNetwork)
            FailUsage("--network", "generation 3 has one network");
        encode.networkVersion = NTC_NETWORK_GENERATION_3;
    }
    const bool layered = GetGeneration(encode.networkVersion) == 3;
    encode.fp8 = HasFp8Network(encode);
    if (encode.compress && !layered)
        FailUsage("--compress", "only sets of generation 3 have compressed latents: --generation 3");
    if (choices.blockModes && !layered)
        FailUsage("--bc7-modes", "only sets of generation 3 keep modes of blocks: --generation 3");
}

} // namespace

NamedNumber ParseNamedNumber(const char* option, const std::string& text, const NumberLimits& limits) {
    const std::size_t at = text.rfind('=');
    if (at == std::string::npos || at == 0)
        FailUsage(option, text + ": NAME=NUMBER, with the name of a texture");
    return {text.substr(0, at), ParseNumber(option, text.substr(at + 1), limits, false)};
}

void AddTrainingOptions(CLI::App& command, TrainingChoices& choices) {
    encode::EncodeOptions& encode = choices.encode;
    CLI::Option* bits = AddNumberOption(command, "--bits-per-pixel", encode.bitsPerPixel, kBitsPerPixelLimits,
                                        "Size of the latents (default 4)", "B");
    CLI::Option* shape =
        command
            .add_option_function<std::string>(
                "--latent-shape",
                [&encode](const std::string& text) { encode.latentShape = ParseShape(text); },
                "Instead: grid scale, high- and low-res features, high- and low-res bits; of generation 3 "
                "S,F")
            ->type_name("S,HF,LF,HB,LB")
            ->excludes(bits);
    command
        .add_option_function<std::string>(
            "--generation",
            [&choices](const std::string& name) {
                if (name == "2")
                    FailUsage("--generation", "2: is read, not written: must be 1 or 3");
                choices.generation = SelectName("--generation", name, {"1", "3"}, {1, 3});
            },
            "Of the file: 1 (default), which LibNTC 0.5 to 0.7 read, or 3, which LibNTC 0.9 reads")
        ->type_name("N");
    CLI::Option* network =
        command
            .add_option_function<std::string>(
                "--network",
                [&encode](const std::string& name) {
                    encode.networkVersion = SelectName(
                        "--network", name, {"small", "medium", "large", "xlarge"},
                        {NTC_NETWORK_SMALL, NTC_NETWORK_MEDIUM, NTC_NETWORK_LARGE, NTC_NETWORK_XLARGE});
                },
                "small, medium (default), large or xlarge")
            ->type_name("NAME");
    command.add_flag("--compress", encode.compress,
                     "Generation 3: store latents, and modes, by GDeflate where that makes them smaller");
    command.add_flag(
        "--bc7-modes", choices.blockModes,
        "Generation 3: search for the best BC7 blocks of the textures that are for BC7, and keep "
        "their modes in the set: ntc decode --set-modes and LibNTC 0.9 need not search");
    CLI::Option* target =
        command
            .add_option_function<std::vector<std::string>>(
                "--target-psnr",
                [&choices](const std::vector<std::string>& texts) {
                    for (const std::string& text : texts)
                        ParseTarget(choices, text);
                },
                "Smallest known shape that reaches this quality, of all or (may be repeated) of a texture")
            ->type_name("[NAME=]DB (0.001 to 1000)")
            ->allow_extra_args(false)
            ->excludes(bits)
            ->excludes(shape);
    command.parse_complete_callback([&choices, bits, shape, network] {
        choices.hasShape = bits->count() + shape->count() > 0;
        FinishGeneration(choices, network->count() > 0);
    });
    AddNumberOption(command, "--max-bits-per-pixel", choices.maximumBits, kBitsPerPixelLimits,
                    "Limit of that search", "B")
        ->needs(target);
    CLI::Option* effort =
        command
            .add_option_function<std::string>(
                "--effort",
                [&encode](const std::string& name) {
                    encode.effort =
                        SelectName("--effort", name, {"fast", "normal", "best"},
                                   {encode::Effort::Fast, encode::Effort::Normal, encode::Effort::Best});
                },
                "fast, normal (default) or best")
            ->type_name("NAME");
    CLI::Option* seconds = AddNumberOption(command, "--seconds", encode.seconds, kSecondLimits,
                                           "Instead: end training after this time")
                               ->excludes(effort);
    AddNumberOption(command, "--steps", encode.steps, kStepLimits, "Instead: number of training steps")
        ->excludes(effort)
        ->excludes(seconds);
    AddNumberOption(command, "--seed", encode.seed, kSeedLimits,
                    "Same seed and steps: same bytes (default 1)");
    AddNumberOption(command, "--threads", encode.threads, kThreadLimits,
                    "Default (0): all cores; never changes the result");
    CLI::Option* device =
        command
            .add_option("--device", choices.device,
                        "Train on a Vulkan device: its index or part of its name (ntc devices)")
            ->type_name("NAME");
    AddNumberOption(command, "--batch", encode.batchTexels, {1024, 65536},
                    "Texels of a training step, a multiple of 1024 (default by size, 4096 to 65536); steps "
                    "count in units of 4096",
                    "N")
        ->needs(device);
    command
        .add_flag_callback(
            "--portable", [&encode] { encode.kernel = encode::KernelChoice::Portable; },
            "Same seed and steps: same bytes also across compilers and processors; many times slower")
        ->excludes(device);
    command.add_flag(
        "--fp8", encode.fp8,
        "Add an FP8 network, for GPUs with 8-bit float matrix units; generation 3 always has one");
    command.add_flag("--discard-masked", encode.discardMasked, "Texels whose mask is 0 may become anything");
    command.add_flag("--strict", choices.strict,
                     "Refuse sizes that differ; exit 1 when exact 0 or 1 of a mask changes");
}

} // namespace openntc::tool
