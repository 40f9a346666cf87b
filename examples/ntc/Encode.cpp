// SPDX-License-Identifier: MIT
// `ntc encode`: images to a texture-set file.
#include "Arguments.h"
#include "Commands.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"
#include "encode/EncodeJob.h"
#include "encode/InputArguments.h"
#include "encode/TrainingArguments.h"

#include <cinttypes>
#include <memory>

namespace openntc::tool {

namespace {

struct EncodeCommandOptions {
    EncodeJob job;
    std::string maskChannel;
};

int ParseMask(const std::string& text) {
    if (text == "none")
        return -1;
    char* end = nullptr;
    const long channel = std::strtol(text.c_str(), &end, 10);
    if (text.empty() || *end != '\0' || channel < 0 || channel > 15)
        FailUsage("--mask-channel", text + ": 0 to 15, or none");
    return static_cast<int>(channel);
}

void Print(const EncodeJob& job, const EncodedFile& file) {
    const encode::EncodeResult& result = file.result;
    WriteOutput(Format("%s: %" PRIu64 " bytes, %g bits per pixel, %.2f dB, %" PRIu64
                       " steps in %.1f s (%s, %.2f M texels/s)\n",
                       Printable(job.output).c_str(), file.bytes,
                       static_cast<double>(GetLatentShapeBitsPerPixel(result.latentShape)), result.psnr,
                       result.steps, result.seconds, result.kernel, result.texelsPerSecond * 1e-6));
    if (job.training.encode.fp8)
        WriteOutput(Format("FP8 network: %.2f dB\n", result.fp8Psnr));
    if (result.maskViolations > 0)
        WriteOutput(Format("mask: %" PRIu64 " texels of exactly 0 or 1 decode to another value\n",
                           result.maskViolations));
}

void PrintJson(const EncodeJob& job, const EncodedFile& file) {
    const encode::EncodeResult& result = file.result;
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(job.output));
    json.Key("textures");
    json.BeginArray();
    for (const UnderstoodTexture& texture : file.textures) {
        json.BeginObject();
        json.Member("name", std::string_view(texture.name));
        json.Member("file", std::string_view(texture.file));
        json.Member("channels", texture.channels);
        json.Member("colorSpace", std::string_view(GetName(texture.space)));
        json.Member("reason", std::string_view(texture.reason));
        json.Member("psnr", GetTexturePsnr(result, texture.firstChannel, texture.channels));
        if (!texture.hint.empty())
            json.Member("hint", std::string_view(texture.hint));
        json.EndObject();
    }
    json.EndArray();
    json.Member("bytes", file.bytes);
    json.Member("bitsPerPixel", static_cast<double>(GetLatentShapeBitsPerPixel(result.latentShape)));
    const LatentShape& s = result.latentShape;
    json.Key("latentShape");
    json.BeginArray();
    for (int value :
         {s.gridSizeScale, s.highResFeatures, s.lowResFeatures, s.highResQuantBits, s.lowResQuantBits})
        json.Value(value);
    json.EndArray();
    json.Member("network", job.training.encode.networkVersion);
    json.Member("psnr", result.psnr);
    if (job.training.encode.fp8)
        json.Member("fp8Psnr", result.fp8Psnr);
    json.Key("mipPsnr");
    json.BeginArray();
    for (double psnr : result.mipPsnr)
        json.Value(psnr);
    json.EndArray();
    json.Key("channelPsnr");
    json.BeginArray();
    for (int c = 0; c < file.channelCount; ++c) {
        if ((file.declaredChannels >> c & 1u) != 0)
            json.Value(result.channelPsnr[static_cast<std::size_t>(c)]);
        else
            json.Null();
    }
    json.EndArray();
    json.Member("steps", result.steps);
    json.Member("seed", job.training.encode.seed);
    json.Member("seconds", result.seconds);
    json.Member("texelsPerSecond", result.texelsPerSecond);
    json.Member("kernel", result.kernel);
    json.Member("maskViolations", result.maskViolations);
    json.EndObject();
    WriteOutput(json.Take());
}

int Run(const EncodeJob& job) {
    const EncodedFile file = RunEncodeJob(job);
    if (job.json)
        PrintJson(job, file);
    else
        Print(job, file);
    FinishOutput();
    CheckGoals(job, file);
    return 0;
}

} // namespace

void AddEncodeCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<EncodeCommandOptions>();
    EncodeJob& job = options->job;
    CLI::App* command = app.add_subcommand("encode", "Encode images to a texture set");
    command
        ->add_option("inputs", job.inputs.paths,
                     "Images (- for standard input), or a folder of images, or a manifest (.json)")
        ->required();
    command->add_option("-o,--output", job.output, "File to write")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("FILE");
    AddTrainingOptions(*command, job.training);
    AddInputOptions(*command, job.inputs);
    command->add_option("--srgb", job.inputs.srgb, "Texture or file that holds sRGB colours; may be repeated")
        ->type_name("NAME")
        ->allow_extra_args(false);
    command->add_option("--linear", job.inputs.linear, "Texture or file that holds data; may be repeated")
        ->type_name("NAME")
        ->allow_extra_args(false);
    AddNumberOption(*command, "--save-every", job.saveSeconds, {0.0, 1e9},
                    "Seconds between states for --resume (default 120; 0: only when interrupted)");
    command->add_option("--mask-channel", options->maskChannel, "Channel whose exact 0 and 1 are kept")
        ->type_name("N");
    command->add_flag("--resume", job.resume, "Continue the interrupted run of the same command");
    command->add_flag("--quiet", job.quiet, "No progress");
    AddJsonFlag(*command, job.json);
    command->callback([options, &action] {
        action = [options] {
            if (!options->maskChannel.empty())
                options->job.inputs.maskChannel = ParseMask(options->maskChannel);
            options->job.inputs.strict = options->job.training.strict;
            options->job.explains = true;
            return Run(options->job);
        };
    });
}

} // namespace openntc::tool
