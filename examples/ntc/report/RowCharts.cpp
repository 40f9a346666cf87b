// SPDX-License-Identifier: MIT
// Charts whose rows are networks, maths modes or block formats. Most cases lie within half a decibel of one another: drawn at their PSNR
// they would cover each other, on rows each one can be read, with the figure beside the row.
#include "report/RowCharts.h"
#include "Output.h"
#include "report/Analysis.h"
#include "report/Cases.h"
#include "report/ChartScript.h"
#include "report/HtmlBlocks.h"
#include "report/HtmlFiltering.h"

#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace openntc::report {

using tool::Format;

namespace {

static_assert(kColorCount >= static_cast<std::size_t>(kMathCount));

/// Axes of a chart with rows from the top down, figures at the right, the legend in one line below the title.
/// Maths modes that occur, in the order of Cases.h.
std::vector<Series> ListMaths(const std::vector<const CaseRecord*>& cases) {
    std::vector<Series> series;
    for (int math = 1; math <= kMathCount; ++math) {
        const std::string name = GetMathName(math);
        if (std::any_of(cases.begin(), cases.end(), [&](const CaseRecord* c) { return c->math == name; }))
            series.push_back({name, kColors[math - 1], kShapes[math - 1], {}});
    }
    return series;
}

std::string DescribeRange(double least, double most, const char* format) {
    const std::string low = Format(format, least), high = Format(format, most);
    return low == high ? high : low + " – " + high;
}

} // namespace

double GetOffset(std::size_t series, std::size_t count) {
    const double step = std::min(0.2, 0.74 / static_cast<double>(std::max<std::size_t>(count, 1)));
    return step * (0.5 * static_cast<double>(count - 1) - static_cast<double>(series));
}

void AddRows(ChartScript& script, const std::vector<Row>& rows, const char* figures, int height) {
    std::string left, right, lines;
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const int y = -static_cast<int>(i);
        left += (i > 0 ? ", " : "") + QuoteLabel(rows[i].label) + Format(" %d", y);
        right += (i > 0 ? ", " : "") + QuoteLabel(rows[i].figure) + Format(" %d", y);
        if (i > 0) // between rows
            lines +=
                Format("set arrow from graph 0, first %.1f to graph 1, first %.1f nohead lc rgb '#bbbbbb'\n",
                       y + 0.5, y + 0.5);
    }
    const double last = -static_cast<double>(rows.size()) + 0.5;
    const auto fromTop = [height](int pixels) { return 1 - static_cast<double>(pixels) / height; };
    script.Add(Format("set title offset 0, 1.9\nset lmargin at screen 0.115\nset rmargin at screen 0.86\nset "
                      "tmargin at screen %.4f\n",
                      fromTop(kHeadPixels)) +
               Format("set key at screen 0.5, screen %.4f center horizontal maxrows 1 samplen 1 width 0\n",
                      fromTop(62)) +
               Format("set label 2 %s at graph 1.008, screen %.4f left font ',13' textcolor rgb '#555555'\n",
                      QuoteLabel(figures).c_str(), fromTop(kHeadPixels - 12)) +
               Format("set yrange [%.1f:0.5]\nset y2range [%.1f:0.5]\n", last, last) + "set ytics (" + left +
               ")\nset y2tics (" + right + ")\nset grid noytics\n" + lines);
}

std::string PlotSeries(ChartScript& script, const std::vector<Series>& series) {
    std::string plots;
    for (const Series& s : series) {
        if (!s.rows.empty())
            plots += (plots.empty() ? "" : ", ") + script.MakeBlock(s.rows) +
                     Format(" using 1:2:3:4 with xerrorbars pt %d ps 0.9 lw 1.6 lc rgb '%s' title '%s'",
                            s.shape, s.color.c_str(), s.name.c_str());
    }
    return plots;
}

std::string MakePoint(const CaseRecord& c, const TimeUnit& unit, double y) {
    return Format("%.6g %.4f %.6g %.6g\n", unit.factor * c.time.median, y, unit.factor * c.time.lowerQuartile,
                  unit.factor * c.time.upperQuartile);
}

std::size_t FindSeries(const std::vector<Series>& series, const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(series.begin(), series.end(), [&](const Series& s) { return s.name == name; }) -
        series.begin());
}

void DrawAccuracyTime(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                      std::size_t number) {
    const std::vector<const CaseRecord*> cases = ListComparable(report, device.name);
    if (cases.empty())
        return;
    // A row for each encoding, the most accurate one on top.
    std::map<std::string, std::vector<const CaseRecord*>> encodings;
    for (const CaseRecord* c : cases)
        encodings[c->encoding].push_back(c);
    const auto getBest = [](const std::vector<const CaseRecord*>& list) {
        double best = -INFINITY;
        for (const CaseRecord* c : list)
            best = std::max(best, GetFinite(c->accuracy.psnrSource, 99));
        return best;
    };
    std::vector<std::string> order;
    for (const auto& [name, list] : encodings)
        order.push_back(name);
    std::stable_sort(order.begin(), order.end(), [&](const std::string& a, const std::string& b) {
        return getBest(encodings[a]) > getBest(encodings[b]);
    });
    std::vector<Series> series = ListMaths(cases);
    std::vector<Row> rows;
    std::map<const CaseRecord*, double> heights;
    const TimeUnit unit = PickUnit(cases);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const std::vector<const CaseRecord*>& list = encodings[order[i]];
        double least = INFINITY;
        for (const CaseRecord* c : list) {
            const std::size_t s = FindSeries(series, c->math);
            heights[c] = GetOffset(s, series.size()) - static_cast<double>(i);
            series[s].rows += MakePoint(*c, unit, heights[c]);
            least = std::min(least, GetFinite(c->accuracy.psnrSource, 99));
        }
        rows.push_back({list.front()->network + Format(", %g bpp", list.front()->bitsPerPixel),
                        DescribeRange(least, getBest(list), "%.1f") + " dB"});
    }
    const int height = kHeadPixels + 60 + 56 * static_cast<int>(rows.size());
    script.Begin(
        Format("accuracy-time-%zu", number), "Accuracy against time: " + DescribeDevice(report, device.name),
        "Sample bricks, one set, 9 outputs. A row for each network and number of bits per pixel, the most "
        "accurate on top, with its PSNR against the source; further left is faster. Ringed: the Pareto "
        "front; of points whose quartiles overlap in time the most accurate one stands for all.",
        height);
    script.Add(MakeTimeAxis(cases, unit));
    AddRows(script, rows, "PSNR", height);
    std::string rings;
    for (const FrontPoint& point : ListParetoFront(cases))
        rings += Format("%.6g %.4f\n", unit.factor * point.best->time.median, heights[point.best]);
    const std::string points = PlotSeries(script, series);
    script.Add("plot " + points + ", " + script.MakeBlock(rings) +
               " using 1:2 with points pt 6 ps 1.9 lw 2 lc rgb '#222222' title 'Pareto front'\n");
}

void DrawErrorTime(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                   std::size_t number) {
    std::vector<const CaseRecord*> cases;
    for (const CaseRecord* c : ListComparable(report, device.name)) {
        if (c->bitsPerPixel == Case{}.bitsPerPixel)
            cases.push_back(c);
    }
    if (cases.empty())
        return;
    std::map<std::string, std::pair<double, double>> errors; // least and most over the networks
    for (const CaseRecord* c : cases) {
        const double error = GetFinite(c->accuracy.worstLsbFp32, 1e4);
        const auto [found, isNew] = errors.emplace(c->math, std::pair(error, error));
        if (!isNew)
            found->second = {std::min(found->second.first, error), std::max(found->second.second, error)};
    }
    std::vector<std::string> order;
    for (const auto& [math, range] : errors)
        order.push_back(math);
    std::stable_sort(order.begin(), order.end(), [&](const std::string& a, const std::string& b) {
        return errors[a].second < errors[b].second;
    });
    std::vector<Series> series;
    for (int network = 1; network <= 4; ++network)
        series.push_back({GetNetworkName(network), kColors[network - 1], kShapes[network - 1], {}});
    const TimeUnit unit = PickUnit(cases);
    std::vector<Row> rows;
    for (std::size_t i = 0; i < order.size(); ++i) {
        for (const CaseRecord* c : cases) {
            const std::size_t s = FindSeries(series, c->network);
            if (c->math == order[i] && s < series.size())
                series[s].rows += MakePoint(*c, unit, GetOffset(s, series.size()) - static_cast<double>(i));
        }
        const auto& [least, most] = errors[order[i]];
        rows.push_back({order[i], most == 0 ? "none" : DescribeRange(least, most, "%.2g") + " / 255"});
    }
    const int height = kHeadPixels + 60 + 56 * static_cast<int>(rows.size());
    script.Begin(
        Format("error-time-%zu", number),
        "Arithmetic error against time: " + DescribeDevice(report, device.name),
        "A row for each maths mode at 4 bits per pixel, the most exact on top, with its worst difference "
        "from the FP32 decode of the same file, of all values and networks, in steps of 1/255. FP8 modes "
        "use the set's FP8 network, which is trained apart, so theirs includes that.",
        height);
    script.Add(MakeTimeAxis(cases, unit));
    AddRows(script, rows, "worst difference", height);
    script.Add("plot " + PlotSeries(script, series) + "\n");
}

void DrawBlocks(ChartScript& script, const ReportRecord& report) {
    const std::vector<BlockWay> ways = ListBlockWays(report);
    for (std::size_t way = 0; way < ways.size(); ++way) {
        std::vector<Series> levels; // fast, normal, best; best with hints
        std::vector<Row> rows;
        std::vector<double> first; // PSNR of a row's first level
        std::string labels;
        double least = INFINITY, most = 0;
        for (const BlockRecord& r : report.blocks) {
            if (!r.skipped.empty() || r.time.repeats == 0 || BlockWay{r.device, r.threads} != ways[way])
                continue;
            if (FindSeries(levels, r.level) == levels.size())
                levels.push_back({r.level,
                                  kColors[levels.size() % kColorCount],
                                  kShapes[levels.size() % kColorCount],
                                  {}});
            if (rows.empty() || rows.back().label != r.format) {
                rows.push_back({r.format, ""});
                first.push_back(r.psnrDecoded);
            }
            const double y = -static_cast<double>(rows.size() - 1) - 0.12;
            const double factor = 1e-6 * kTexels2K;
            levels[FindSeries(levels, r.level)].rows +=
                Format("%.6g %.4f %.6g %.6g\n", factor * r.time.median, y, factor * r.time.lowerQuartile,
                       factor * r.time.upperQuartile);
            labels += Format("%.6g %.4f ", factor * r.time.median, y + 0.34) +
                      QuoteLabel(std::isinf(r.psnrDecoded) ? "exact" : Format("%.2f dB", r.psnrDecoded)) +
                      "\n";
            rows.back().figure = Format("%+.2f dB", GetFinite(r.psnrDecoded - first.back(), 0));
            least = std::min(least, factor * r.time.lowerQuartile);
            most = std::max(most, factor * r.time.upperQuartile);
        }
        if (rows.empty() || !(least > 0))
            continue;
        const int height = kHeadPixels + 60 + 48 * static_cast<int>(rows.size());
        script.Begin(
            Format("blocks-%zu", way + 1),
            "Block compression on load: " + DescribeDevice(report, ways[way].GetName()),
            "A row for each format, a point for each level with the PSNR of its blocks against the "
            "texels that the decoder yields; further left is faster. At the right: what the best level "
            "gains over the fastest. Formats hold different textures: compare within a row.",
            height);
        script.Add(Format("set logscale x\nset xlabel 'milliseconds for 2048 x 2048 texels, from the median "
                          "(extrapolated, logarithmic); bars: quartiles'\nset xrange [%g:%g]\n",
                          least / 1.5, most * 1.5) +
                   MakeTics("x", least, most));
        AddRows(script, rows, "gain", height);
        const std::string points = PlotSeries(script, levels);
        script.Add("plot " + points + ", " + script.MakeBlock(labels) +
                   " using 1:2:3 with labels font ',11' textcolor rgb '#333333' notitle\n");
    }
}

void DrawFiltering(ChartScript& script, const ReportRecord& report) {
    std::vector<Series> ways;
    std::vector<Row> rows;
    std::string labels, rings;
    double least = INFINITY, most = 0;
    for (const FilteringRecord& r : report.filtering) {
        if (r.time.repeats == 0 || r.rmse.empty())
            continue;
        if (FindSeries(ways, r.texels) == ways.size())
            ways.push_back(
                {r.texels, kColors[ways.size() % kColorCount], kShapes[ways.size() % kColorCount], {}});
        const std::string label = r.filter + (r.scene == "floor" ? ", floor" : "");
        if (rows.empty() || rows.back().label != label)
            rows.push_back({label, ""});
        const std::size_t way = FindSeries(ways, r.texels);
        const double y = 0.22 - 0.17 * static_cast<double>(way) - static_cast<double>(rows.size() - 1);
        ways[way].rows +=
            Format("%.6g %.4f %.6g %.6g\n", r.time.median, y, r.time.lowerQuartile, r.time.upperQuartile);
        labels +=
            Format("%.6g %.4f ", r.time.median, y) +
            QuoteLabel(r.rmse.front() == 0 ? "exact" : Format("%.3f → %.3f", r.rmse.front(), r.rmse.back())) +
            "\n";
        if (IsOnFilteringFront(report, r))
            rings += Format("%.6g %.4f\n", r.time.median, y);
        if (r.texels == "all texels")
            rows.back().figure = Format("%.1f texels", r.texelsPerSample);
        least = std::min(least, r.time.lowerQuartile);
        most = std::max(most, r.time.upperQuartile);
    }
    if (rows.empty() || !(least > 0))
        return;
    const int height = kHeadPixels + 60 + 84 * static_cast<int>(rows.size());
    script.Begin(
        "filtering", "Filtering: " + DescribeDevice(report, report.filtering.front().device),
        "A row for each filter, a point for each number of texels that a pixel decodes; further left is "
        "faster. Beside it: the error against all texels after 1 and 64 frames. Ringed: no other "
        "point of the row is both faster and closer after 64 frames. At the right: texels of the filter.",
        height);
    script.Add(
        Format("set logscale x\nset xlabel 'nanoseconds per pixel and frame to decode its texels, median "
               "(logarithmic); bars: quartiles'\nset xrange [%g:%g]\n",
               least / 1.5, most * 2.5) +
        MakeTics("x", least, most));
    AddRows(script, rows, "all texels", height);
    script.Add("set lmargin at screen 0.15\n");
    const std::string points = PlotSeries(script, ways);
    script.Add("plot " + points + ", " + script.MakeBlock(labels) +
               " using 1:2:3 with labels left offset 1.8,0 font ',11' textcolor rgb '#333333' notitle, " +
               script.MakeBlock(rings) +
               " using 1:2 with points pt 6 ps 1.9 lw 2 lc rgb '#222222' title 'Pareto front'\n");
}

} // namespace openntc::report
