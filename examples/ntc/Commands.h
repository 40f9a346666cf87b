// SPDX-License-Identifier: MIT
// The sub-commands of `ntc`. Each Add function declares options and returns nothing; the chosen command's
// work is put into `action` while the command line is parsed and runs after it.
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace openntc::tool {

/// Does the work and returns the exit code; throws CommandError.
using Action = std::function<int()>;

void AddInfoCommand(CLI::App& app, Action& action);
void AddValidateCommand(CLI::App& app, Action& action);
void AddDecodeCommand(CLI::App& app, Action& action);
void AddSampleCommand(CLI::App& app, Action& action);
void AddConstantsCommand(CLI::App& app, Action& action);
void AddExportCommand(CLI::App& app, Action& action);
void AddConformanceCommand(CLI::App& app, Action& action);
void AddDevicesCommand(CLI::App& app, Action& action);
void AddEncodeCommand(CLI::App& app, Action& action);
void AddBakeCommand(CLI::App& app, Action& action);
void AddConvertGltfCommand(CLI::App& app, Action& action);
void AddMigrateCommand(CLI::App& app, Action& action);
void AddCompareCommand(CLI::App& app, Action& action);
void AddBcTestCommand(CLI::App& app, Action& action);
void AddOptimizeBcCommand(CLI::App& app, Action& action);
void AddBenchCommand(CLI::App& app, Action& action);
void AddBenchLoadCommand(CLI::App& bench, Action& action); // `bench load`, added by AddBenchCommand
void AddBenchLoaderCommand(CLI::App& bench, Action& action);
void AddBenchSlicesCommand(CLI::App& bench, Action& action);
void AddBenchTilesCommand(CLI::App& bench, Action& action);
void AddCompileShadersCommand(CLI::App& app, Action& action);
void AddReportCommand(CLI::App& app, Action& action);

} // namespace openntc::tool
