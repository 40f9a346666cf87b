// SPDX-License-Identifier: MIT
// `ntc migrate`: a texture set whose sources are gone, encoded again from what it decodes to.
#include "Arguments.h"
#include "Commands.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"
#include "encode/ArchivedSet.h"
#include "encode/EncodeJob.h"
#include "encode/InputArguments.h"
#include "encode/ShapeChoice.h"
#include "encode/TrainingArguments.h"

#include <cinttypes>
#include <memory>

namespace openntc::tool {

namespace {

struct MigrateOptions {
    std::string file;
    ArchivedSetOptions set;
    EncodeJob job;
};

/// The old file, as far as the result names it.
struct OldFile {
    std::string name;
    int generation = 0;
    std::uint64_t bytes = 0;
    double bitsPerPixel = 0.0;
};

OldFile DescribeOldFile(TextureSet& set) {
    OldFile old;
    old.name = set.input.GetName();
    old.generation = set.metadata.GetGeneration();
    old.bytes = set.input.GetStream().Size();
    old.bitsPerPixel = static_cast<double>(GetLatentShapeBitsPerPixel(set.metadata.GetLatentShape()));
    return old;
}

void Print(const EncodeJob& job, const EncodedFile& file, const OldFile& old) {
    const encode::EncodeResult& result = file.result;
    WriteOutput(Format("%s: generation %d, %" PRIu64 " bytes, %g bits per pixel (%s: generation %d, %" PRIu64
                       " bytes, %g)\n",
                       Printable(job.output).c_str(), GetGeneration(job.training.encode.networkVersion),
                       file.bytes, static_cast<double>(GetLatentShapeBitsPerPixel(result.latentShape)),
                       Printable(old.name).c_str(), old.generation, old.bytes, old.bitsPerPixel));
    WriteOutput(Format("against the old file: %.2f dB", result.psnr));
    if (job.training.encode.fp8)
        WriteOutput(Format(", FP8 network %.2f dB", result.fp8Psnr));
    WriteOutput("\n");
    for (const UnderstoodTexture& texture : file.textures)
        WriteOutput("  " + Printable(texture.name) +
                    Format(": %.2f dB\n", GetTexturePsnr(result, texture.firstChannel, texture.channels)));
}

void PrintJson(const EncodeJob& job, const EncodedFile& file, const OldFile& old) {
    const encode::EncodeResult& result = file.result;
    const auto member = [](JsonWriter& json, int generation, std::uint64_t bytes, double bitsPerPixel) {
        json.Member("generation", generation);
        json.Member("bytes", bytes);
        json.Member("bitsPerPixel", bitsPerPixel);
    };
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(job.output));
    member(json, GetGeneration(job.training.encode.networkVersion), file.bytes,
           static_cast<double>(GetLatentShapeBitsPerPixel(result.latentShape)));
    json.Key("old");
    json.BeginObject();
    json.Member("file", std::string_view(old.name));
    member(json, old.generation, old.bytes, old.bitsPerPixel);
    json.EndObject();
    json.Member("network", std::string_view(GetNetworkName(job.training.encode.networkVersion)));
    json.Member("psnr", result.psnr);
    if (job.training.encode.fp8)
        json.Member("fp8Psnr", result.fp8Psnr);
    json.Key("textures");
    json.BeginArray();
    for (const UnderstoodTexture& texture : file.textures) {
        json.BeginObject();
        json.Member("name", std::string_view(texture.name));
        json.Member("psnr", GetTexturePsnr(result, texture.firstChannel, texture.channels));
        json.EndObject();
    }
    json.EndArray();
    json.Member("steps", result.steps);
    json.Member("seed", job.training.encode.seed);
    json.Member("seconds", result.seconds);
    json.Member("kernel", result.kernel);
    json.EndObject();
    WriteOutput(json.Take());
}

int Run(MigrateOptions& options, bool hasNetwork) {
    TextureSet set = LoadTextureSet(options.file);
    EncodeJob& job = options.job;
    encode::EncodeOptions& encode = job.training.encode;
    const int oldNetwork = set.metadata.GetNetworkVersion();
    if (!hasNetwork && GetGeneration(encode.networkVersion) == 1 && IsNetworkVersion(oldNetwork))
        encode.networkVersion = oldNetwork;
    const OldFile old = DescribeOldFile(set);
    if (!job.training.hasShape && job.training.targetPsnr <= 0.0 && job.training.textureTargets.empty())
        encode.latentShape = FindNearestShape(old.bitsPerPixel, encode.networkVersion);
    options.set.targets = job.training.textureTargets;
    options.set.generation = GetGeneration(encode.networkVersion);
    options.set.newModes = job.training.blockModes;
    job.load = [&set, &options] { return LoadArchivedSet(set, options.set); };
    const EncodedFile file = RunEncodeJob(job);
    if (job.json)
        PrintJson(job, file, old);
    else
        Print(job, file, old);
    FinishOutput();
    CheckGoals(job, file);
    return 0;
}

} // namespace

void AddMigrateCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<MigrateOptions>();
    EncodeJob& job = options->job;
    CLI::App* command = app.add_subcommand(
        "migrate", "Encode a texture set again, in another generation, from its own texels");
    command->add_option("file", options->file, "Texture set (- for standard input)")->required();
    command->add_option("-o,--output", job.output, "File to write")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("FILE");
    AddTrainingOptions(*command, job.training);
    command->get_option("--generation")
        ->required()
        ->description("Of the new file: 1, which LibNTC 0.5 to 0.7 read, or 3, which LibNTC 0.9 reads");
    command->get_option("--bits-per-pixel")
        ->description("Size of the latents (default: nearest to the old file's)");
    AddWeightOption(*command, options->set.weights);
    AddNumberOption(*command, "--mask-channel", options->set.maskChannel, {0, 15},
                    "Channel whose exact 0 and 1 are kept");
    command->add_flag("--resume", job.resume, "Continue the interrupted run of the same command");
    command->add_flag("--quiet", job.quiet, "No progress");
    AddJsonFlag(*command, job.json);
    command->callback([options, command, &action] {
        const bool hasNetwork = command->count("--network") > 0;
        action = [options, hasNetwork] { return Run(*options, hasNetwork); };
    });
}

} // namespace openntc::tool
