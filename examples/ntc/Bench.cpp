// SPDX-License-Identifier: MIT
// `ntc bench`, and `ntc bench decode`: how fast each decoder is, on full decodes.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"
#include "Progress.h"

#include <memory>
#include <optional>

namespace openntc::tool {

namespace {

struct BenchOptions {
    std::string file;
    std::string device;
    std::vector<std::string> backends;
    BackendOptions vulkan; // for --math
    int repeat = 7;
    std::optional<DecodeMath> math;
    bool json = false;
};

std::string Describe(const BenchmarkResult& result) {
    const std::string name = Format("%-34s", result.name.c_str());
    if (!result.skipped.empty())
        return name + " skipped: " + result.skipped + "\n";
    std::string line = name + Format(" %9.3f Mtexel/s, %.3f ... %.3f (%zu runs)", result.rates.median,
                                     result.rates.minimum, result.rates.maximum, result.rates.runs);
    if (result.deviceRates)
        line += Format("; on the device %.3f, %.3f ... %.3f", result.deviceRates->median,
                       result.deviceRates->minimum, result.deviceRates->maximum);
    if (result.dotProducts)
        line += Format("; %.0f %% of the %.2f that dot products alone allow",
                       100.0 * result.rates.median / *result.dotProducts, *result.dotProducts);
    return line + "\n";
}

void WriteRates(JsonWriter& json, const char* key, const Rates& rates) {
    json.Key(key);
    json.BeginObject();
    json.Member("median", rates.median);
    json.Member("minimum", rates.minimum);
    json.Member("maximum", rates.maximum);
    json.Member("runs", static_cast<std::uint64_t>(rates.runs));
    json.EndObject();
}

void WriteResult(JsonWriter& json, const BenchmarkResult& result) {
    json.BeginObject();
    json.Member("name", std::string_view(result.name));
    json.Member("backend", GetName(result.backend));
    json.Member("threads", result.threads);
    if (!result.skipped.empty()) {
        json.Member("skipped", std::string_view(result.skipped));
    } else {
        WriteRates(json, "megatexelsPerSecond", result.rates);
        if (result.deviceRates)
            WriteRates(json, "megatexelsPerDeviceSecond", *result.deviceRates);
        if (result.dotProducts)
            json.Member("dotProductMegatexelsPerSecond", *result.dotProducts);
        if (!result.device.empty())
            json.Member("device", std::string_view(result.device));
        json.Member("crc32", result.crc32);
    }
    json.EndObject();
}

int RunBench(const BenchOptions& options) {
    TextureSet set = LoadTextureSet(options.file);
    DecodeOptions decode;
    decode.math =
        ChooseMath(set, options.math, [&](const std::string& text) { PrintWarning(text, options.json); });
    const DecodeData data = LoadDecodeData(set, decode.math);
    const std::vector<BenchmarkTarget> targets =
        ListTargets(options.backends, options.device, options.vulkan.matrices);
    const std::uint64_t texels = CountTexels(set.metadata);

    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(options.file));
    json.Member("cpu", std::string_view(GetCpuName()));
    json.Member("cores", GetCoreCount());
    json.Member("texels", texels);
    json.Member("math", GetName(decode.math, options.vulkan));
    json.Key("results");
    json.BeginArray();
    if (!options.json)
        WriteOutput(Format("cpu: %s, %d hardware threads\n%llu texels (all mips), 16 outputs, %s; median, "
                           "slowest ... fastest\n",
                           Printable(GetCpuName()).c_str(), GetCoreCount(),
                           static_cast<unsigned long long>(texels), GetName(decode.math, options.vulkan)));
    std::optional<std::uint32_t> crc;
    std::string device;
    bool different = false;
    for (const BenchmarkTarget& target : targets) {
        const BenchmarkResult result = RunBenchmark(target, set.metadata, data, decode, options.repeat);
        if (!result.skipped.empty() && target.required)
            throw CommandError(ExitCode::NoDevice, target.name, result.skipped);
        if (result.skipped.empty()) {
            different = different || (crc && *crc != result.crc32);
            crc = result.crc32;
        }
        if (!result.device.empty() && device.empty() && !options.json)
            WriteOutput("device: " + Printable(result.device) + "\n");
        device = result.device.empty() ? device : result.device;
        options.json ? WriteResult(json, result) : WriteOutput(Describe(result));
        if (!options.json)
            FinishOutput();
    }
    json.EndArray();
    json.EndObject();
    if (options.json)
        WriteOutput(json.Take());
    if (different)
        throw CommandError(ExitCode::Failed, options.file, "outputs: differ between decoders: must be equal");
    return 0;
}

} // namespace

void AddBenchCommand(CLI::App& app, Action& action) {
    CLI::App* bench = app.add_subcommand("bench", "Measure time");
    bench->require_subcommand(1);
    auto options = std::make_shared<BenchOptions>();
    CLI::App* command =
        bench->add_subcommand("decode", "Full decodes (all mips, 16 outputs) with every decoder");
    AddFileArgument(*command, options->file);
    command
        ->add_option("--backend", options->backends,
                     "Only these: cpu, reference, vulkan (default: all that exist)")
        ->check(CLI::IsMember({"cpu", "reference", "vulkan"}));
    command->add_option("--device", options->device, "Vulkan device: index or part of its name");
    AddNumberOption(*command, "--repeat", options->repeat, {1, 1000},
                    "Timed runs of each decoder (default 7)");
    AddMathOption(*command, options->math, &options->vulkan);
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunBench(*options); }; });
    AddBenchLoadCommand(*bench, action);
    AddBenchLoaderCommand(*bench, action);
    AddBenchSlicesCommand(*bench, action);
    AddBenchTilesCommand(*bench, action);
}

} // namespace openntc::tool
