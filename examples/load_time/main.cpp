// SPDX-License-Identifier: MIT
// What loading materials costs: as raw texels, as blocks, as texture sets decoded and transcoded on load, and as texture sets that
// shaders sample.
#include "LoadInputs.h"
#include "LoadTable.h"

#include "Arguments.h"
#include "Failure.h"
#include "Output.h"
#include "RunMain.h"

#include <CLI/CLI.hpp>

namespace {

using namespace openntc;
using tool::CommandError;
using tool::ExitCode;

int Run(int argc, char** argv) {
    CLI::App app("What loading materials costs, stage by stage", "load_time");
    load_time::LoadOptions options;
    std::vector<std::string> inputs;
    bool json = false, markdown = false;
    app.add_option(
           "inputs", inputs,
           "Texture sets, folders of them, or a materials.json of ntc convert-gltf (default: the samples)")
        ->type_name("INPUT");
    app.add_option_function<std::string>(
           "--bc",
           [&](const std::string& name) {
               const auto block = tool::FindBlockFormat(name);
               if (!block && name != "auto")
                   tool::FailUsage("--bc", name + ": auto, bc1 ... bc7, bc4s, bc5s or bc6s");
               options.blocks = {!block, block};
           },
           "Blocks: auto (default: as the files say), or one format for all textures")
        ->type_name("BLOCKS");
    app.add_option_function<std::string>(
           "--quality",
           [&](const std::string& name) {
               options.effort = tool::SelectEffort(name, tool::BlockEffort::Fast);
           },
           "Search for good blocks: fast (default), normal or best")
        ->type_name("LEVEL");
    app.add_flag("--no-hints", options.noHints,
                 "Search for BC7 blocks, even where NAME.bcmodes of ntc optimize-bc lies beside a set");
    app.add_flag("--set-modes", options.setModes,
                 "Take the modes of BC7 blocks that sets of generation 3 keep (ntc optimize-bc --in-set)");
    app.add_option_function<std::string>(
           "--decompress",
           [&](const std::string& name) { options.decompressor = load_time::FindDecompressor(name); },
           "Latents that files keep compressed: cpu (default: all threads), gpu (the one that decodes, with "
           "VK_NV_memory_decompression), shader (a compute pass on it)")
        ->type_name("WHERE");
    tool::AddBackendOptions(app, options.backend);
    tool::AddNumberOption(app, "--threads", options.backend.threads, {0, 1024},
                          "Threads; 0, the default: all");
    tool::AddNumberOption(app, "--repeat", options.repeat, {1, 1000},
                          "Runs, of which medians count (default 3)");
    tool::AddNumberOption(app, "--warm-up", options.warmUp, {0, 60000},
                          "Milliseconds that a GPU works before times count (default 1000)");
    tool::AddNumberOption(app, "--batch", options.batch, {1, 1024},
                          "On a GPU: sets in one command buffer (default 8)");
    CLI::Option* pages = app.add_flag("--markdown", markdown, "Print the table for a page");
    tool::AddJsonFlag(app, json);
    pages->excludes("--json");
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success))
            return app.exit(error);
        throw CommandError(ExitCode::Usage, "command line", error.what());
    }
    options.sets = load_time::ListSets(inputs);
    const load_time::LoadTimes times = load_time::MeasureLoading(options);
    tool::WriteOutput(json       ? MakeJson(times, options)
                      : markdown ? MakeMarkdown(times, options)
                                 : MakeText(times, options));
    tool::FinishOutput();
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    return openntc::tool::RunMain("load_time", [&] { return Run(argc, argv); });
}
