// SPDX-License-Identifier: MIT
// `ntc bench tiles`: what a frame of the tile manager costs, in CPU time of one thread.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Json.h"
#include "Output.h"
#include "TileFrames.h"

#include <memory>
#include <string>
#include <vector>

namespace openntc::tool {

namespace {

struct TilesOptions {
    std::vector<std::string> variants = {"A", "B", "C"};
    std::vector<int> textures = {100, 1000, 10000};
    std::vector<double> changes = {0.1, 1, 10};
    int frames = 24;
    int repeat = 1;
    std::string chart;
    bool isEach = false;
    bool json = false;
};

void WriteSpread(JsonWriter& json, const char* name, const Spread& spread) {
    json.Key(name);
    json.BeginObject();
    json.Member("median", spread.median);
    json.Member("lowerQuartile", spread.lower);
    json.Member("upperQuartile", spread.upper);
    json.EndObject();
}

std::string MakeJson(const std::vector<TileFramesResult>& results, const TilesOptions& options) {
    JsonWriter json;
    json.BeginObject();
    json.Member("cpu", std::string_view(GetCpuName()));
    json.Member("frames", static_cast<std::uint64_t>(options.frames));
    json.Member("runs", static_cast<std::uint64_t>(options.repeat));
    json.Member("oneByOne", options.isEach);
    json.Key("results");
    json.BeginArray();
    for (const TileFramesResult& result : results) {
        json.BeginObject();
        json.Member("variant", std::string_view(&result.variant, 1));
        json.Member("textures", static_cast<std::uint64_t>(result.textures));
        json.Member("changePercent", result.changePercent);
        json.Member("changedRegions", static_cast<std::uint64_t>(result.changedRegions));
        WriteSpread(json, "milliseconds", result.total);
        json.Key("phases");
        json.BeginObject();
        for (std::size_t i = 0; i < kTilePhases; ++i)
            json.Member(kTilePhaseNames[i], result.phases[i]);
        json.EndObject();
        json.Member("mapOrders", result.mapOrders);
        json.Member("unmapOrders", result.unmapOrders);
        json.Member("usedSlots", result.usedSlots);
        json.Member("heaps", result.heaps);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    return json.Take();
}

std::string MakeTable(const std::vector<TileFramesResult>& results, const TilesOptions& options) {
    std::string text =
        Format("cpu: %s\nCPU milliseconds of a frame, one thread: median and quartiles of %d frames\n",
               Printable(GetCpuName()).c_str(), options.frames * options.repeat);
    text +=
        "variant  textures  change    median     lower     upper    update   heaps  trim  allocate  fetch  "
        "confirm  residency   maps  unmaps\n";
    for (const TileFramesResult& result : results) {
        text += Format("%c %15d %6.1f %% %9.4f %9.4f %9.4f", result.variant, result.textures,
                       result.changePercent, result.total.median, result.total.lower, result.total.upper);
        for (const double phase : result.phases)
            text += Format(" %8.4f", phase);
        text += Format(" %7.0f %7.0f\n", result.mapOrders, result.unmapOrders);
    }
    return text;
}

int RunBenchTiles(const TilesOptions& options) {
    std::vector<TileFramesResult> results;
    for (const int textures : options.textures) {
        for (const double change : options.changes) {
            for (const std::string& variant : options.variants)
                results.push_back(RunTileFrames(
                    {variant[0], textures, change, options.frames, options.repeat, options.isEach}));
        }
    }
    if (!options.chart.empty())
        WriteTileChart(results, options.chart);
    WriteOutput(options.json ? MakeJson(results, options) : MakeTable(results, options));
    return 0;
}

} // namespace

void AddBenchTilesCommand(CLI::App& bench, Action& action) {
    auto options = std::make_shared<TilesOptions>();
    CLI::App* command = bench.add_subcommand(
        "tiles", "Frames of the tile manager: feedback, orders, residency of many textures");
    command
        ->add_option("--variant", options->variants,
                     "A: every texture is updated; B: those with a changed region; C: whole textures change "
                     "(default all)")
        ->check(CLI::IsMember({"A", "B", "C"}));
    command->add_option("--textures", options->textures, "How many (default 100 1000 10000)")
        ->check(CLI::Range(1, 100000));
    command->add_option("--change", options->changes, "Percent of the regions per frame (default 0.1 1 10)")
        ->check(CLI::Range(0.001, 100.0));
    command->add_option("--frames", options->frames, "Timed frames of a run, after 12 others (default 24)")
        ->check(CLI::Range(1, 10000));
    command->add_option("--repeat", options->repeat, "Runs (default 1)")->check(CLI::Range(1, 1000));
    command->add_flag("--each", options->isEach,
                      "Update textures one by one (default: one call for all that are updated)");
    command->add_option("--chart", options->chart, "Write the medians as an SVG chart")->type_name("FILE");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunBenchTiles(*options); }; });
}

} // namespace openntc::tool
