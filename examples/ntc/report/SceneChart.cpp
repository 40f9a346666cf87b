// SPDX-License-Identifier: MIT
#include "report/HtmlScenes.h"
#include "report/RowCharts.h"

#include "Output.h"
#include "report/Scenes.h"

#include <algorithm>
#include <cmath>

namespace openntc::report {

using tool::Format;

namespace {

/// A row of the chart: a delivery with all filters that it was drawn with.
struct DeliveryRow {
    std::string label;
    double psnr = -INFINITY; ///< of kSceneFilter, else the best
    std::string figure;
    std::vector<const SceneRecord*> records;
};

std::vector<DeliveryRow> MakeRows(const std::vector<const SceneRecord*>& records) {
    std::vector<DeliveryRow> rows;
    for (const SceneRecord* r : records) {
        const std::string label = DescribeDelivery(*r);
        auto row =
            std::find_if(rows.begin(), rows.end(), [&](const DeliveryRow& d) { return d.label == label; });
        if (row == rows.end())
            row = rows.insert(rows.end(), {label, -INFINITY, "", {}});
        row->records.push_back(r);
        if (r->filter == kSceneFilter || row->records.size() == 1) {
            row->psnr = r->psnr;
            row->figure = (std::isinf(r->psnr) ? std::string("exact") : Format("%.1f dB", r->psnr)) +
                          Format(", %.0f KiB", static_cast<double>(r->GetBytes("textures")) / 1024);
        }
    }
    std::stable_sort(rows.begin(), rows.end(),
                     [](const DeliveryRow& a, const DeliveryRow& b) { return a.psnr > b.psnr; });
    return rows;
}

} // namespace

void DrawScenes(ChartScript& script, const ReportRecord& report) {
    std::size_t number = 0;
    for (const DeviceRecord& device : report.devices) {
        const std::vector<const SceneRecord*> records = ListDeliveries(report, device.name);
        if (records.empty())
            continue;
        const std::vector<DeliveryRow> deliveries = MakeRows(records);
        std::vector<Series> filters;
        for (const SceneRecord* r : records) {
            const std::size_t f = filters.size();
            if (FindSeries(filters, r->filter) == f)
                filters.push_back({r->filter, kColors[f % kColorCount], kShapes[f % kColorCount], {}});
        }
        std::vector<Row> rows;
        std::string rings;
        double least = INFINITY, most = 0;
        for (const DeliveryRow& delivery : deliveries) {
            for (const SceneRecord* r : delivery.records) {
                const std::size_t f = FindSeries(filters, r->filter);
                const double y = GetOffset(f, filters.size()) - static_cast<double>(rows.size());
                filters[f].rows += Format("%.6g %.4f %.6g %.6g\n", r->time.median, y, r->time.lowerQuartile,
                                          r->time.upperQuartile);
                if (IsOnSceneFront(report, *r))
                    rings += Format("%.6g %.4f\n", r->time.median, y);
                least = std::min(least, r->time.lowerQuartile);
                most = std::max(most, r->time.upperQuartile);
            }
            rows.push_back({delivery.label, delivery.figure});
        }
        if (!(least > 0))
            continue;
        const SceneRecord& first = *records.front();
        const int height = kHeadPixels + 60 + 48 * static_cast<int>(rows.size());
        script.Begin(
            Format("scenes-%zu", ++number),
            Format("Scene %s, %d x %d: ", first.scene.c_str(), first.width, first.height) +
                DescribeDevice(report, device.name),
            Format("A row for each way to deliver texels, the closest to the reference on top; further "
                   "left is faster. At the right: PSNR against the reference and bytes of textures, both "
                   "with the %s filter. Ringed: no other row with the same filter is as fast, as close "
                   "and as small, and better in one of these.",
                   kSceneFilter),
            height);
        script.Add(Format("set logscale x\nset xlabel 'milliseconds a frame, median (logarithmic); bars: "
                          "quartiles'\nset xrange [%g:%g]\n",
                          least / 1.3, most * 1.3) +
                   MakeTics("x", least, most));
        AddRows(script, rows, "PSNR, textures", height);
        script.Add(
            "set lmargin at screen 0.29\nset key font ',12' samplen 0.5 width -2\n"); // long labels, eight filters
        const std::string points = PlotSeries(script, filters);
        script.Add("plot " + points + ", " + script.MakeBlock(rings) +
                   " using 1:2 with points pt 6 ps 1.9 lw 2 lc rgb '#222222' title 'Pareto front'\n");
    }
}

} // namespace openntc::report
