// SPDX-License-Identifier: MIT
// `ntc bench load`: how long TextureSetMetadata::Load takes, weights included, from a file that is in memory.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Json.h"
#include "Output.h"
#include "TextureSet.h"

#include <memory>

namespace openntc::tool {

namespace {

struct LoadOptions {
    std::string file;
    int repeat = 5000;
    bool json = false;
};

int RunBenchLoad(const LoadOptions& options) {
    const std::vector<std::byte> bytes = ReadAll(options.file);
    const std::vector<double> microseconds = TimeLoads(bytes, options.repeat, options.file);
    const auto quantile = [&](double q) {
        return microseconds[static_cast<std::size_t>(q * static_cast<double>(microseconds.size() - 1))];
    };
    if (!options.json) {
        WriteOutput(Format(
            "cpu: %s\nload from memory, weights included: %.1f us, quartiles %.1f and %.1f (%d runs)\n",
            Printable(GetCpuName()).c_str(), quantile(0.5), quantile(0.25), quantile(0.75), options.repeat));
        return 0;
    }
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(options.file));
    json.Member("cpu", std::string_view(GetCpuName()));
    json.Member("fileBytes", static_cast<std::uint64_t>(bytes.size()));
    json.Key("microseconds");
    json.BeginObject();
    json.Member("median", quantile(0.5));
    json.Member("lowerQuartile", quantile(0.25));
    json.Member("upperQuartile", quantile(0.75));
    json.Member("runs", static_cast<std::uint64_t>(microseconds.size()));
    json.EndObject();
    json.EndObject();
    WriteOutput(json.Take());
    return 0;
}

} // namespace

void AddBenchLoadCommand(CLI::App& bench, Action& action) {
    auto options = std::make_shared<LoadOptions>();
    CLI::App* command =
        bench.add_subcommand("load", "Reading and checking a file's metadata and weights from memory");
    AddFileArgument(*command, options->file);
    command->add_option("--repeat", options->repeat, "Timed loads (default 5000)")
        ->check(CLI::Range(1, 1000000));
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunBenchLoad(*options); }; });
}

} // namespace openntc::tool
