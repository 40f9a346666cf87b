// SPDX-License-Identifier: MIT
#include "report/ChartScript.h"
#include "report/Generations.h"
#include "report/RowCharts.h"

#include "Output.h"

#include <algorithm>
#include <cmath>

namespace openntc::report {

using tool::Format;

namespace {

std::string DescribeRatio(const CaseRecord& c) {
    return c.againstGeneration1.repeats == 0 ? "" : Format("%.2f ×", c.againstGeneration1.median);
}

} // namespace

void DrawGenerations(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                     std::size_t number) {
    const std::vector<const CaseRecord*> cases = ListGenerations(report, device.name);
    std::vector<Series> series;
    for (std::size_t i = 0; i < 3; ++i)
        series.push_back({Format("generation %zu", i + 1), kColors[i], kShapes[i], {}});
    const TimeUnit unit = PickUnit(cases);
    std::vector<Row> rows;
    std::string labels;
    bool hasLater = false;
    double least = INFINITY, most = 0;
    for (const CaseRecord* c : cases) {
        const int generation = GetGenerationOfNetwork(c->network);
        hasLater = hasLater || generation > 1;
        if (const std::string shared = DescribeShared(*c); rows.empty() || rows.back().label != shared)
            rows.push_back({shared, ""});
        const double y = 0.3 * (2 - generation) - static_cast<double>(rows.size() - 1);
        series[static_cast<std::size_t>(generation - 1)].rows += MakePoint(*c, unit, y);
        least = std::min(least, unit.factor * c->time.lowerQuartile);
        most = std::max(most, unit.factor * c->time.upperQuartile);
        labels += Format("%.6g %.4f ", unit.factor * c->time.upperQuartile, y) +
                  QuoteLabel(Format("%.2f dB", GetFinite(c->accuracy.psnrSource, 99))) + "\n";
        if (generation == 3)
            rows.back().figure = DescribeRatio(*c);
    }
    if (!hasLater)
        return;
    const int height = kHeadPixels + 60 + 66 * static_cast<int>(rows.size());
    script.Begin(
        Format("generations-%zu", number), "Generations of files: " + DescribeDevice(report, device.name),
        "Sample bricks, 9 outputs, medium network of generation 1, at equal bits per pixel; rows with an "
        "instruction set: one thread, the processor's time. Further "
        "left is faster. Beside each point: PSNR against the source. At the right: time of "
        "generation 3 by that of generation 1, median over repeats in turns. Generation 2 has the "
        "latents and the network of generation 3, filled up with zeros: no encoder makes it.",
        height);
    script.Add(MakeTimeAxis(cases, unit));
    AddRows(script, rows, "3 : 1", height);
    // Long labels; room for those behind the last points.
    script.Add(Format("set lmargin at screen 0.2\nset xrange [%g:%g]\n", least / 1.3,
                      1.3 * most * std::pow(most / least, 0.12)));
    const std::string points = PlotSeries(script, series);
    script.Add("plot " + points + ", " + script.MakeBlock(labels) +
               " using 1:2:3 with labels left offset 1,0 font ',11' textcolor rgb '#333333' notitle\n");
}

} // namespace openntc::report
