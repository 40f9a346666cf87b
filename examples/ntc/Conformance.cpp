// SPDX-License-Identifier: MIT
// `ntc conformance`: run a folder of vectors, write the project's own, serve a decoder to somebody else's
// runner.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "conformance/Report.h"
#include "conformance/Suite.h"

#include <filesystem>
#include <map>
#include <memory>
#include <span>

namespace openntc::tool {

namespace {

struct ConformanceOptions {
    std::string folder;
    BackendOptions backend;
    bool json = false;
    conformance::ReportFormat format = conformance::ReportFormat::Text;
    std::string output;
    std::string adapter;
    std::vector<std::string> adapterArguments;
    double timeoutSeconds = 60;
    bool mustPassOnly = false;
};

// The file that this program runs from, which is started again to hold a shared library.
std::string GetOwnProgram() {
    std::error_code error;
    const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
    return error ? "ntc" : path.string();
}

bool IsLibrary(const std::string& path) {
    return path.ends_with(".so") || path.ends_with(".dylib") || path.ends_with(".dll");
}

std::unique_ptr<conformance::Subject> MakeSubject(const ConformanceOptions& options) {
    if (options.adapter.empty())
        return conformance::MakeBackendSubject(options.backend);
    conformance::AdapterOptions adapter;
    adapter.timeoutSeconds = options.timeoutSeconds;
    if (IsLibrary(options.adapter))
        adapter.command = {GetOwnProgram(), "conformance", "serve", "--library", options.adapter};
    else
        adapter.command = {options.adapter};
    adapter.command.insert(adapter.command.end(), options.adapterArguments.begin(),
                           options.adapterArguments.end());
    return conformance::MakeAdapterSubject(adapter);
}

int RunConformance(const ConformanceOptions& options) {
    const std::unique_ptr<conformance::Subject> subject = MakeSubject(options);
    const std::unique_ptr<conformance::Report> report = conformance::MakeReport(
        options.json ? conformance::ReportFormat::Json : options.format,
        options.adapter.empty() ? GetName(options.backend.backend) : "adapter", options.folder);
    std::string text;
    const auto write = [&](const std::string& part) {
        if (!options.output.empty()) {
            text += part;
        } else if (!part.empty()) {
            WriteOutput(part);
            FinishOutput(); // one line as each case ends
        }
    };
    const conformance::Totals totals =
        conformance::RunFolder(options.folder, *subject, options.mustPassOnly,
                               [&](const conformance::CaseResult& result) { write(report->Add(result)); });
    write(report->Finish(totals));
    if (!options.output.empty())
        WriteBytes(options.output, text);
    return static_cast<int>(totals.IsSuccess() ? ExitCode::Ok : ExitCode::Failed);
}

int RunExport(const ConformanceOptions& options) {
    const conformance::ExportedFiles suite = conformance::ExportSuite(options.folder);
    if (!options.json) {
        WriteOutput(
            Format("%s: %zu cases in %zu files\n", options.folder.c_str(), suite.cases, suite.files.size()));
        return static_cast<int>(ExitCode::Ok);
    }
    JsonWriter json;
    json.BeginObject();
    json.Member("folder", std::string_view(options.folder));
    json.Member("cases", static_cast<std::uint64_t>(suite.cases));
    json.Key("files");
    json.BeginArray();
    for (const std::filesystem::path& file : suite.files)
        json.Value(std::string_view(file.string()));
    json.EndArray();
    json.EndObject();
    WriteOutput(json.Take());
    return static_cast<int>(ExitCode::Ok);
}

void AddRunOptions(CLI::App& command, const std::shared_ptr<ConformanceOptions>& options) {
    AddBackendOptions(command, options->backend);
    AddJsonFlag(command, options->json);
    static const std::map<std::string, conformance::ReportFormat> kFormats = {
        {"text", conformance::ReportFormat::Text},
        {"json", conformance::ReportFormat::Json},
        {"junit", conformance::ReportFormat::Junit}};
    command.add_option("--format", options->format, "text, json or junit")
        ->transform(CLI::CheckedTransformer(kFormats));
    command.add_option("--output", options->output, "Write the report to a file instead of standard output")
        ->check(GetOutputNameCheck());
    command.add_option("--adapter", options->adapter,
                       "Test this decoder: a shared library (.so, .dylib, .dll) with the functions of "
                       "openntc_adapter.h, or a program that speaks the adapter protocol");
    command.add_option("--adapter-argument", options->adapterArguments, "Argument for the adapter program")
        ->allow_extra_args(false);
    AddNumberOption(command, "--timeout", options->timeoutSeconds, {0.1, 86400.0},
                    "Seconds that an adapter may take for an answer");
    command.add_flag("--mustpass", options->mustPassOnly,
                     "Leave out the cases that are not on the mustpass list");
}

void AddServeCommand(CLI::App& command, Action& action) {
    struct ServeOptions {
        BackendOptions backend;
        std::string library;
    };
    auto options = std::make_shared<ServeOptions>();
    CLI::App* serve = command.add_subcommand(
        "serve", "Answer the adapter protocol on standard input and output with one of our decoders");
    AddBackendOptions(*serve, options->backend);
    serve->add_option("--library", options->library,
                      "A shared library with the functions of openntc_adapter.h");
    serve->callback([options, &action] {
        action = [options] {
            const std::unique_ptr<conformance::Subject> subject =
                options->library.empty() ? conformance::MakeBackendSubject(options->backend)
                                         : conformance::MakeLibrarySubject(options->library);
            conformance::ServeSubject(*subject);
            return static_cast<int>(ExitCode::Ok);
        };
    });
}

} // namespace

void AddConformanceCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ConformanceOptions>();
    CLI::App* command = app.add_subcommand(
        "conformance", "Run the vectors in a folder; a folder named run, export or serve is given as ./run");
    CLI::Option* folder = command->add_option(
        "DIR", options->folder,
        "Folder of `ntc conformance export`, or of NAME.ntc, NAME.expect.json, NAME.texels");
    AddRunOptions(*command, options);
    command->require_subcommand(0, 1);

    CLI::App* run = command->add_subcommand("run", "The same as `ntc conformance DIR`");
    run->add_option("DIR", options->folder, "Folder of vectors")->required();
    AddRunOptions(*run, options);

    CLI::App* exportCommand = command->add_subcommand("export", "Write the project's vectors to a folder");
    exportCommand->add_option("DIR", options->folder, "Folder to write")
        ->required()
        ->check(GetOutputNameCheck());
    AddJsonFlag(*exportCommand, options->json);

    command->callback([options, command, folder, &action] {
        if (command->get_subcommands().empty() && folder->count() == 0)
            FailUsage("conformance", "DIR: missing");
        std::error_code ignored;
        if (command->get_subcommands().empty() && !std::filesystem::exists(options->folder, ignored))
            throw CommandError(ExitCode::BadInput, options->folder,
                               "DIR: no such folder, and no command of conformance: run, export, serve");
        if (action == nullptr)
            action = [options] { return RunConformance(*options); };
    });
    exportCommand->callback([options, &action] { action = [options] { return RunExport(*options); }; });
    AddServeCommand(*command, action);
}

} // namespace openntc::tool
