// SPDX-License-Identifier: MIT
// `ntc`: inspect, decode and test texture sets. Options, outputs and exit codes are a contract; see
// docs/cli.md.
#include "Commands.h"
#include "Failure.h"
#include "Help.h"
#include "Output.h"
#include "RunMain.h"
#include "Version.h"

#include "openntc/core/Processor.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace {

using openntc::tool::CommandError;
using openntc::tool::ExitCode;

// CLI11 says only that a subcommand is required, even when one was given that does not exist.
std::string DescribeError(const CLI::App& app, const CLI::ParseError& error) {
    const CLI::App* command = &app;
    while (!command->get_subcommands().empty())
        command = command->get_subcommands().front();
    if (error.get_name() != "RequiredError" || command->get_require_subcommand_min() == 0)
        return error.what();
    const std::vector<std::string> unknown = command->remaining();
    std::string text = (command == &app ? "command: " : command->get_name() + ": command: ") +
                       (unknown.empty() ? "missing" : unknown.front()) + ": one of ";
    const char* separator = "";
    for (const CLI::App* known : command->get_subcommands([](const CLI::App*) { return true; })) {
        text += separator + known->get_name();
        separator = ", ";
    }
    return text;
}

// `--mips=9` of a flag that takes no value would count as `--mips`.
void RefuseFlagValues(CLI::App& app) {
    for (CLI::Option* option : app.get_options([](CLI::Option*) { return true; }))
        option->disable_flag_override();
    for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; }))
        RefuseFlagValues(*command);
}

int Run(int argc, char** argv) {
    CLI::App app("Neural texture compression files: inspect, decode, test", "ntc");
    app.require_subcommand(1);
    openntc::tool::UsePlainHelp(app);
    app.set_version_flag("--version", openntc::tool::DescribeVersion,
                         "Version, commit, compiler, kernels and libraries");
    openntc::tool::Action action;
    openntc::tool::AddInfoCommand(app, action);
    openntc::tool::AddValidateCommand(app, action);
    openntc::tool::AddDecodeCommand(app, action);
    openntc::tool::AddSampleCommand(app, action);
    openntc::tool::AddConstantsCommand(app, action);
    openntc::tool::AddExportCommand(app, action);
    openntc::tool::AddConformanceCommand(app, action);
    openntc::tool::AddEncodeCommand(app, action);
    openntc::tool::AddBakeCommand(app, action);
    openntc::tool::AddConvertGltfCommand(app, action);
    openntc::tool::AddMigrateCommand(app, action);
    openntc::tool::AddCompareCommand(app, action);
    openntc::tool::AddOptimizeBcCommand(app, action);
    openntc::tool::AddBcTestCommand(app, action);
    openntc::tool::AddBenchCommand(app, action);
    openntc::tool::AddCompileShadersCommand(app, action);
    openntc::tool::AddReportCommand(app, action);
    openntc::tool::AddDevicesCommand(app, action);
    openntc::tool::AddHelpCommand(app, action);
    RefuseFlagValues(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
            app.exit(error); // help or version, on standard output
            openntc::tool::FinishOutput();
            return 0;
        }
        throw CommandError(ExitCode::Usage, "command line", DescribeError(app, error));
    }
    if (!openntc::GetSimdCap()) // at once, and not after minutes of reading images
        throw CommandError(ExitCode::Usage, "environment", openntc::GetSimdCap().error().GetText());
    const int code = action();
    openntc::tool::FinishOutput();
    return code;
}

} // namespace

int main(int argc, char** argv) {
    return openntc::tool::RunMain("ntc", [&] { return Run(argc, argv); });
}
