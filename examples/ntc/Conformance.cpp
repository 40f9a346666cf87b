// SPDX-License-Identifier: MIT
// `ntc conformance`: run a folder of vectors.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"
#include "conformance/Runner.h"

#include <memory>

namespace openntc::tool {

namespace {

struct Options {
    std::string folder;
    BackendOptions backend;
    bool json = false;
};

void WriteCase(JsonWriter& json, const conformance::CaseResult& result) {
    json.BeginObject();
    json.Member("name", std::string_view(result.name));
    json.Member("outcome", conformance::GetName(result.outcome));
    json.Member("reason", std::string_view(result.reason));
    json.Member("metadataFields", result.metadata.fields);
    json.Member("fusedMips", result.metadata.fusedMips);
    json.Member("streamRanges", result.metadata.streamRanges);
    json.Member("constants", result.metadata.constants);
    json.Member("weightBuffers", result.metadata.weights);
    json.Member("texels", static_cast<std::uint64_t>(result.texels.exact));
    json.Member("worstInt8", result.texels.worstFloat);
    json.Member("worstInt8Half", result.texels.worstHalf);
    json.Member("worstLinear", result.texels.worstLinear);
    json.Member("worstLinearOverBound", result.texels.worstLinearRatio);
    json.Key("psnr");
    result.texels.psnr ? json.Value(*result.texels.psnr) : json.Null();
    json.Key("psnrOfExactValues");
    result.texels.psnrExact ? json.Value(*result.texels.psnrExact) : json.Null();
    json.EndObject();
}

int RunConformance(const Options& options) {
    JsonWriter json;
    json.BeginObject();
    json.Member("backend", GetName(options.backend.backend));
    json.Key("cases");
    json.BeginArray();
    std::string device;
    const conformance::Totals totals =
        conformance::RunFolder(options.folder, options.backend, [&](const conformance::CaseResult& result) {
            if (!result.device.empty())
                device = result.device;
            if (options.json) {
                WriteCase(json, result);
            } else {
                WriteOutput(result.GetLine() + "\n");
                FinishOutput(); // one line as each case ends
            }
        });
    json.EndArray();
    json.Member("device", std::string_view(device));
    json.Member("passed", totals.passed);
    json.Member("failed", totals.failed);
    json.Member("skipped", totals.skipped);
    json.EndObject();
    WriteOutput(options.json ? json.Take() : totals.GetLine() + "\n");
    return static_cast<int>(totals.IsSuccess() ? ExitCode::Ok : ExitCode::Failed);
}

void AddRunOptions(CLI::App& command, const std::shared_ptr<Options>& options) {
    AddBackendOptions(command, options->backend);
    AddJsonFlag(command, options->json);
}

} // namespace

void AddConformanceCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand(
        "conformance", "Run the vectors in a folder; a folder named run or export is given as ./run");
    CLI::Option* folder =
        command->add_option("DIR", options->folder, "Folder of NAME.ntc, NAME.expect.json, NAME.texels");
    AddRunOptions(*command, options);
    command->require_subcommand(0, 1);

    CLI::App* run = command->add_subcommand("run", "The same as `ntc conformance DIR`");
    run->add_option("DIR", options->folder, "Folder of vectors")->required();
    AddRunOptions(*run, options);

    CLI::App* exportCommand = command->add_subcommand("export", "")->group("")->allow_extras();
    exportCommand->callback([] { FailUsage("conformance export", "command: not in this version"); });

    command->callback([options, command, folder, &action] {
        if (command->get_subcommands().empty() && folder->count() == 0)
            FailUsage("conformance", "DIR: missing");
        action = [options] { return RunConformance(*options); };
    });
}

} // namespace openntc::tool
