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
    std::string plot = "plot ";
    std::size_t color = 0;
    for (const auto& [key, rows] : lines) {
        plot += Format("%s%s using 1:2:3:4 with yerrorlines lw 2 pt 7 ps 0.6 lc rgb '%s' title '%c, %g %%'",
                       color > 0 ? ", " : "", script.MakeBlock(rows).c_str(),
                       report::kColors[color % std::size(report::kColors)], key.first, key.second);
        ++color;
    }
    script.Add(plot + "\n");
    const std::vector<report::Chart> charts = script.Run();
    fs::remove_all(scratch);
    WriteBytes(path, charts.at(0).svg);
}

} // namespace openntc::tool
