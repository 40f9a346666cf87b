// SPDX-License-Identifier: MIT
#include "report/Charts.h"

#include "Output.h"
#include "report/Analysis.h"
#include "report/Cases.h"
#include "report/ChartScript.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>
#include <vector>

namespace openntc::report {

using tool::Format;

namespace {

/// Three digits, without an exponent.
std::string FormatTime(double time) {
    return time >= 1000 ? Format("%.0f", time) : Format("%.3g", time);
}

struct Bar {
    std::string label;
    const CaseRecord* c;
    int group;
};

void DrawBars(ChartScript& script, const std::vector<Bar>& bars, const TimeUnit& unit,
              const CaseRecord* base) {
    std::string rows;
    for (std::size_t i = 0; i < bars.size(); ++i) {
        const Spread& t = bars[i].c->time;
        rows += Format("%zu %.6g %.6g %.6g %d ", i, unit.factor * t.median, unit.factor * t.lowerQuartile,
                       unit.factor * t.upperQuartile, bars[i].group) +
                QuoteLabel(bars[i].label) +
                Format(" %s\n", QuoteLabel(FormatTime(unit.factor * t.median)).c_str());
    }
    const std::string data = script.MakeBlock(rows);
    script.Add("set palette defined (");
    for (int i = 0; i < 7; ++i)
        script.Add(Format("%s%d '%s'", i > 0 ? ", " : "", i, kColors[i]));
    script.Add(Format(")\nset cbrange [0:6]\nunset colorbox\nset boxwidth 0.7\nset style fill solid "
                      "0.85\nset xtics rotate by 40 right "
                      "font ',12'\nset grid noxtics\nset xrange [-0.7:%.1f]\nset key above\nset rmargin 3\n",
                      static_cast<double>(bars.size()) - 0.3));
    std::string line;
    if (base != nullptr)
        line = Format(", %.6g with lines dt 2 lc rgb '#222222' title 'base point'",
                      unit.factor * base->time.median);
    script.Add("plot " + data + " using 1:2:5:xtic(6) with boxes lc palette notitle, " + data +
               " using 1:3:(0):($4-$3) with vectors nohead lw 3 lc rgb '#222222' title 'quartiles', " + data +
               " using 1:4:7 with labels offset 0,0.7 font ',11' notitle" + line + "\n");
}

void DrawEffects(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                 std::size_t number) {
    const CaseRecord* base = FindBase(report, device.name);
    if (base == nullptr)
        return;
    std::vector<Bar> bars;
    int group = 0;
    const auto add = [&](const char* axis, auto&& makeLabel) {
        bool any = false;
        for (const CaseRecord* c : ListAxis(report, device.name, axis)) {
            if (c->math != base->math || c->material != base->material)
                continue;
            bars.push_back({makeLabel(*c), c, group});
            any = true;
        }
        group += any;
    };
    add("outputs, stored",
        [](const CaseRecord& c) { return Format("%d output%s", c.outputs, c.outputs > 1 ? "s" : ""); });
    add("outputs, linear", [](const CaseRecord& c) { return Format("%d, linear", c.outputs); });
    add("network", [](const CaseRecord& c) { return c.network; });
    add("bits per pixel", [](const CaseRecord& c) { return Format("%g bpp", c.bitsPerPixel); });
    add("sets per workgroup",
        [](const CaseRecord& c) { return Format("%d set%s", c.sets, c.sets > 1 ? "s" : ""); });
    add("weight fetch", [](const CaseRecord& c) { return "fetch: " + c.weights; });
    script.Begin(Format("effects-%zu", number), "Cost of each effect: " + DescribeDevice(report, device.name),
                 "One axis at a time from the base point: int8, medium network, 4 bits per pixel, 9 outputs "
                 "as stored, one "
                 "set. Dark bars: quartiles.",
                 560);
    std::vector<const CaseRecord*> cases;
    cases.reserve(bars.size());
    for (const Bar& bar : bars)
        cases.push_back(bar.c);
    const TimeUnit unit = PickUnit(cases);
    script.Add(std::string("set ylabel 'median time per texel, ") + unit.name +
               "'\nset yrange [0:*]\nset offsets 0,0,graph 0.15,0\n");
    DrawBars(script, bars, unit, base);

    bars.clear();
    for (const CaseRecord* c : ListAxis(report, device.name, "maths")) {
        if (c->network == base->network && c->material == base->material)
            bars.push_back({c->math, c, static_cast<int>(bars.size())});
    }
    if (bars.size() < 2)
        return;
    script.Begin(Format("maths-%zu", number), "Maths modes: " + DescribeDevice(report, device.name),
                 "The base point in every maths mode that the device has. The scale is logarithmic. Dark "
                 "bars: quartiles.",
                 460);
    double least = INFINITY, most = 0;
    for (const Bar& bar : bars) {
        least = std::min(least, unit.factor * bar.c->time.median);
        most = std::max(most, unit.factor * bar.c->time.median);
    }
    script.Add(std::string("set ylabel 'median time per texel, ") + unit.name +
               " (logarithmic)'\nset logscale y\n" +
               Format("set yrange [%g:%g]\n", least / 2, 2 * most * std::pow(most / least, 0.05)) +
               MakeTics("y", least, most));
    DrawBars(script, bars, unit, nullptr);
}

void DrawSets(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
              std::size_t number) {
    const std::vector<const CaseRecord*> cases = ListAxis(report, device.name, "sets per workgroup");
    std::set<std::string> maths;
    for (const CaseRecord* c : cases)
        maths.insert(c->math);
    if (cases.size() < 2)
        return;
    script.Begin(Format("sets-%zu", number), "Divergence: " + DescribeDevice(report, device.name),
                 "Neighbouring invocations of a workgroup decode different sets (latents, weights and "
                 "constants of their "
                 "own, the same network version). 1: one set, but chosen by an index. Such cases cannot "
                 "share weights in subgroups, which lavapipe's base point does. Bars: slowest and "
                 "fastest repeat.",
                 440);
    const TimeUnit unit = PickUnit(cases);
    script.Add(
        std::string("set xlabel 'different sets in a workgroup'\nset ylabel 'median time per texel, ") +
        unit.name +
        "'\nset yrange [0:*]\nset offsets 0, 0, graph 0.2, 0\n"
        "set logscale x 2\nset xrange [0.8:10]\nset xtics (1, 2, 4, 8)\nset key top left\n");
    std::string plots;
    for (const std::string& math : maths) {
        std::string rows;
        double base = 0;
        for (const CaseRecord* c : cases) {
            if (c->math == math)
                rows += Format("%d %.6g %.6g %.6g\n", c->sets, unit.factor * c->time.median,
                               unit.factor * c->time.minimum, unit.factor * c->time.maximum);
        }
        for (const CaseRecord* c : ListComparable(report, device.name)) {
            if (c->math == math && c->network == cases.front()->network &&
                c->bitsPerPixel == cases.front()->bitsPerPixel)
                base = unit.factor * c->time.median;
        }
        const int color = math == "int8" ? 0 : 5;
        plots += (plots.empty() ? "" : ", ") + script.MakeBlock(rows) +
                 Format(" using 1:2:3:4 with yerrorlines pt 7 lw 2 lc rgb '%s' title ", kColors[color]) +
                 QuoteLabel(math);
        if (base > 0)
            plots += Format(", %.6g with lines dt 2 lc rgb '%s' title ", base, kColors[color]) +
                     QuoteLabel(math + ", one set at a fixed place");
    }
    script.Add("plot " + plots + "\n");
}

/// Bits per pixel and PSNR.
using QualityPoints = std::vector<std::pair<double, double>>;

/// Least and most of what is drawn along an axis. Never empty, which gnuplot would warn of.
class AxisRange {
public:
    void Add(double value) {
        least_ = std::min(least_, value);
        most_ = std::max(most_, value);
    }
    std::string Set(const char* axis) const {
        const double margin = std::max(0.5, 0.08 * (most_ - least_));
        return std::string("set ") + axis + Format("range [%g:%g]\n", least_ - margin, most_ + margin);
    }

private:
    double least_ = INFINITY, most_ = -INFINITY;
};

/// Series of PSNR over bits per pixel.
class QualityPlot {
public:
    explicit QualityPlot(ChartScript& script) : script_(script) {}
    void Add(const QualityPoints& points, const std::string& title, const char* style) {
        if (points.empty())
            return;
        std::string rows;
        for (const auto& [bitsPerPixel, psnr] : points) {
            rows += Format("%g %.4f\n", bitsPerPixel, psnr);
            x_.Add(bitsPerPixel);
            y_.Add(psnr);
        }
        plots_ += (plots_.empty() ? "" : ", ") + script_.MakeBlock(rows) + " using 1:2 " + style +
                  Format(" lc rgb '%s' title ", kColors[color_++ % kColorCount]) + QuoteLabel(title);
    }
    void Draw() {
        script_.Add("set xlabel 'bits per pixel of mip 0'\nset ylabel 'PSNR against the source, dB'\nset key "
                    "bottom right\n" +
                    x_.Set("x") + y_.Set("y") + "plot " + plots_ + "\n");
    }

private:
    ChartScript& script_;
    AxisRange x_, y_;
    std::string plots_;
    std::size_t color_ = 0;
};

QualityPoints ListPoints(const std::vector<EncodingRecord>& sorted, const std::string& material,
                         const std::set<std::string>& networks) {
    QualityPoints points;
    for (const EncodingRecord& e : sorted) {
        if (e.material == material && networks.count(e.network) != 0)
            points.emplace_back(e.bitsPerPixel, GetFinite(e.psnr, 99));
    }
    return points;
}

void DrawQuality(ChartScript& script, const ReportRecord& report) {
    std::vector<EncodingRecord> sorted = report.encodings;
    std::sort(sorted.begin(), sorted.end(), [](const EncodingRecord& a, const EncodingRecord& b) {
        return a.bitsPerPixel < b.bitsPerPixel;
    });
    std::map<std::string, std::uint64_t> materials; // and the steps of training
    for (const EncodingRecord& e : sorted)
        materials[e.material] = e.steps;
    const auto describe = [](const std::string& material, std::uint64_t steps) {
        return "OpenNTC, " + material + Format(", %llu steps", static_cast<unsigned long long>(steps));
    };
    if (materials.count(kBricks) != 0) {
        script.Begin("quality-bpp", "Quality against bits per pixel: sample bricks",
                     "Int8 network, all mips, exact decode. A material of this project: other encoders' "
                     "figures are of "
                     "other materials and cannot be set beside it.",
                     440);
        QualityPlot plot(script);
        const std::string title = describe(kBricks, materials[kBricks]);
        plot.Add(ListPoints(sorted, kBricks, {"medium"}), title + ", medium network",
                 "with linespoints pt 7 lw 2");
        plot.Add(ListPoints(sorted, kBricks, {"small", "large", "xlarge"}),
                 title + ", small, large and xlarge networks", "with points pt 6 ps 1.4 lw 2");
        plot.Add(ListPoints(sorted, kBricks, {"gen3"}), title + ", generation 3",
                 "with linespoints pt 5 lw 2");
        plot.Draw();
    }
    std::size_t number = 0;
    // The materials of published figures, if this report has one of them: the same texels on one chart.
    for (const auto& [material, steps] : materials) {
        std::map<std::string, QualityPoints> published;
        for (const PublishedPoint& p : ListPublishedPoints()) {
            if (p.material == material)
                published[p.encoder].emplace_back(p.bitsPerPixel, p.psnr);
        }
        if (material == kBricks)
            continue;
        script.Begin(Format("quality-material-%zu", ++number), "Quality against bits per pixel: " + material,
                     std::string("Int8 network, all mips, exact decode. LibNTC: ") + kPublishedSource + ".",
                     440);
        QualityPlot plot(script);
        plot.Add(ListPoints(sorted, material, {"small", "medium", "large", "xlarge"}),
                 describe(material, steps), "with linespoints pt 7 lw 2");
        for (const auto& [encoder, points] : published) {
            std::string title = encoder;
            title.append(", ").append(material).append(", 100000 steps");
            plot.Add(points, title, "with linespoints pt 9 dt 2 lw 1.5");
        }
        plot.Draw();
    }
}

void DrawStreaming(ChartScript& script, const ReportRecord& report) {
    if (report.streaming.size() < 2)
        return;
    script.Begin("streaming", "Streaming: how close the pictures are, by the time of the loader",
                 "PSNR of what was shown against what was wanted (60: nothing differs), and the mean time "
                 "that the demand "
                 "loader took a frame. One line: less memory for all tiles that are asked for; the other: "
                 "all the memory, "
                 "and fewer tiles a frame.",
                 440);
    std::string budgets, limits;
    for (const StreamingRecord& r : report.streaming) {
        const std::string label =
            r.tilesAFrameLimit > 0 ? Format("%d a frame", r.tilesAFrameLimit)
            : r.budgetTiles == r.allTiles
                ? std::string("all")
                : Format("1/%.0f", static_cast<double>(r.allTiles) / static_cast<double>(r.budgetTiles));
        const std::string row =
            Format("%.6g %.4f ", r.millisecondsAFrame.median, GetFinite(std::min(r.psnr, 60.0), 60)) +
            QuoteLabel(label) + "\n";
        if (r.tilesAFrameLimit == 0)
            budgets += row;
        if (r.tilesAFrameLimit > 0 || r.budgetTiles == r.allTiles)
            limits += row;
    }
    std::string plots;
    const auto add = [&](const std::string& rows, const char* title, int color) {
        if (rows.empty())
            return;
        const std::string data = script.MakeBlock(rows);
        plots +=
            (plots.empty() ? "" : ", ") + data +
            Format(" using 1:2 with linespoints pt 7 lw 2 lc rgb '%s' title '%s', ", kColors[color], title) +
            data + " using 1:2:3 with labels offset 0,0.8 font ',12' notitle";
    };
    add(budgets, "parts of the memory of all tiles", 0);
    add(limits, "tiles read a frame", 5);
    script.Add(
        "set xlabel 'median milliseconds of the loader a frame'\nset ylabel 'PSNR against what was wanted, "
        "dB'\n"
        "set xrange [0:*]\nset offsets 0, graph 0.05, graph 0.12, graph 0.08\nset key above\nplot " +
        plots + "\n");
}

} // namespace

std::vector<Chart> DrawCharts(const ReportRecord& report, const std::filesystem::path& scratch) {
    ChartScript script(scratch);
    if (IsOverloaded(report))
        script.Warn(Format("Load %.1f on %d threads: times include waiting for other work.", report.load,
                           report.cores));
    for (std::size_t i = 0; i < report.devices.size(); ++i) {
        DrawAccuracyTime(script, report, report.devices[i], i + 1);
        DrawErrorTime(script, report, report.devices[i], i + 1);
        DrawEffects(script, report, report.devices[i], i + 1);
        DrawSets(script, report, report.devices[i], i + 1);
        DrawGenerations(script, report, report.devices[i], i + 1);
    }
    DrawStreaming(script, report);
    DrawBlocks(script, report);
    DrawFiltering(script, report);
    DrawScenes(script, report);
    DrawTraining(script, report);
    DrawQuality(script, report);
    return script.Run();
}

} // namespace openntc::report
