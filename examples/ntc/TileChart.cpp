// SPDX-License-Identifier: MIT
#include "Output.h"
#include "OutputFolder.h"
#include "TileFrames.h"

#include "report/ChartScript.h"

#include <filesystem>
#include <map>
#include <random>
#include <utility>

namespace openntc::tool {

void WriteTileChart(std::span<const TileFramesResult> results, const std::string& path) {
    namespace fs = std::filesystem;
    std::map<std::pair<char, double>, std::string> lines;
    for (const TileFramesResult& result : results)
        lines[{result.variant, result.changePercent}] += Format(
            "%d %g %g %g\n", result.textures, result.total.median, result.total.lower, result.total.upper);
    const fs::path scratch = fs::temp_directory_path() / Format("openntc-tiles-%u", std::random_device{}());
    fs::create_directories(scratch);
    report::ChartScript script(scratch);
    script.Begin("tiles", "CPU milliseconds of a frame of the tile manager", "", 480);
    script.Add("set logscale xy\nset xlabel 'textures'\nset ylabel 'ms'\nset key outside right\n");
    // The colour is the share that changes, shape and dashes are the variant.
    std::map<double, std::size_t> colors;
    for (const auto& [key, rows] : lines)
        colors.emplace(key.second, 0);
    std::size_t count = 0;
    for (auto& [change, color] : colors)
        color = count++ % std::size(report::kColors);
    constexpr int kShapes[] = {7, 5, 9}; // circle, square, triangle
    std::string plot;
    for (const auto& [key, rows] : lines) {
        const int variant = key.first - 'A';
        plot += Format(
            "%s%s using 1:2:3:4 with yerrorlines lw 2 pt %d ps 0.9 dt %d lc rgb '%s' title '%c, %g %%'",
            plot.empty() ? "plot " : ", ", script.MakeBlock(rows).c_str(), kShapes[variant], variant + 1,
            report::kColors[colors[key.second]], key.first, key.second);
    }
    script.Add(plot + "\n");
    const std::vector<report::Chart> charts = script.Run();
    fs::remove_all(scratch);
    WriteBytes(path, charts.at(0).svg);
}

} // namespace openntc::tool
