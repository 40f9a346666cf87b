// SPDX-License-Identifier: MIT
// `streaming`: a flight over a landscape of texture sets that are never all in memory.
#include "Session.h"

#include "Arguments.h"
#include "Failure.h"
#include "Output.h"
#include "RunMain.h"

#include <CLI/CLI.hpp>

#include <bit>
#include <string>

namespace {

using namespace openntc::landscape;
using openntc::tool::AddNumberOption;
using openntc::tool::CommandError;
using openntc::tool::ExitCode;
using openntc::tool::FailUsage;

void AddLandscapeOptions(CLI::App& app, LandscapeOptions& options) {
    app.add_option("FILE", options.files,
                   "Texture sets to repeat, square, of one network; default: the samples")
        ->type_name("");
    AddNumberOption(app, "--columns", options.columns, {1, 64}, "Texture sets across (default 16)");
    AddNumberOption(app, "--rows", options.rows, {1, 64}, "Texture sets down (default 8)");
    AddNumberOption(app, "--set-size", options.setSize, {64, 16384},
                    "Texels of each, a power of two (default 8192)", "TEXELS");
    AddNumberOption(app, "--tile", options.tileSize, {8, 1024},
                    "Size of a tile in texels of the coarsest mip that it serves (default 64)", "TEXELS");
}

void AddSessionOptions(CLI::App& app, SessionOptions& options, std::string& output) {
    app.add_option("-o,--output", output, "Folder for frames, maps of residency and the timeline")
        ->required()
        ->check(openntc::tool::GetOutputNameCheck())
        ->type_name("FOLDER");
    AddNumberOption(app, "--frames", options.frames, {1, 10000}, "Frames along the path (default 48)");
    AddNumberOption(app, "--width", options.width, {8, 4096}, "Pixels across (default 320)", "PIXELS");
    AddNumberOption(app, "--height", options.height, {8, 4096}, "Pixels down (default 180)", "PIXELS");
    AddNumberOption(app, "--samples", options.samples, {1, 8},
                    "Samples of a pixel along each axis (default 1)");
    AddNumberOption(app, "--budget", options.budget, {0.001, 1024},
                    "Memory for tiles (default 64, or an eighth of all latents where that is less)", "MIB");
    AddNumberOption(app, "--passes", options.passes, {0, 1000},
                    "Passes of a frame at most; 0, the default: until nothing is missing");
    AddNumberOption(app, "--tiles-per-pass", options.tilesPerPass, {0, 1000000},
                    "Tiles uploaded before a pass at most; 0, the default: all that arrived");
    AddNumberOption(app, "--threads", options.threads, {0, 64}, "Threads that read tiles (default 2)");
    AddNumberOption(
        app, "--verify", options.check, {0, 1000000},
        "Checks every N-th pixel against the C++ decoder, in the last frame all; 0: none (default 16)");
    app.add_flag("--compare", options.compares,
                 "Renders complete frames also with all latents resident, and compares every bit");
    app.add_option("--device", options.device,
                   "Vulkan device: its number or part of its name (`ntc devices`)")
        ->type_name("NAME");
    openntc::tool::AddJsonFlag(app, options.json);
}

int Run(int argc, char** argv) {
    CLI::App app("A flight over texture sets that are streamed tile by tile, in a Vulkan compute shader",
                 "streaming");
    SessionOptions options;
    std::string output;
    AddLandscapeOptions(app, options.landscape);
    AddSessionOptions(app, options, output);
    for (CLI::Option* option : app.get_options([](CLI::Option*) { return true; }))
        option->disable_flag_override();
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
            app.exit(error); // help, on standard output
            openntc::tool::FinishOutput();
            return 0;
        }
        throw CommandError(ExitCode::Usage, "command line", error.what());
    }
    if (!std::has_single_bit(static_cast<unsigned>(options.landscape.setSize)))
        FailUsage("--set-size", std::to_string(options.landscape.setSize) + ": must be a power of two");
    if (options.landscape.files.empty())
        options.landscape.files = {OPENNTC_SOURCE_DIR "/examples/materials/data/bricks.ntc",
                                   OPENNTC_SOURCE_DIR "/examples/materials/data/grille.ntc"};
    options.output = output;
    const Report report = RunSession(options);
    openntc::tool::WriteOutput(options.json ? MakeJson(report) : MakeText(report));
    openntc::tool::FinishOutput();
    const bool differs =
        report.GetWrongTexels() > 0 || (report.comparison && report.comparison->differentPixels > 0);
    return static_cast<int>(differs ? ExitCode::Failed : ExitCode::Ok);
}

} // namespace

int main(int argc, char** argv) {
    return openntc::tool::RunMain("streaming", [&] { return Run(argc, argv); });
}
