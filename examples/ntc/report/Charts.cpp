// SPDX-License-Identifier: MIT
#include "report/Charts.h"

#include "Failure.h"
#include "Output.h"
#include "TextureSet.h"
#include "conformance/ChildProcess.h"
#include "report/Analysis.h"
#include "report/Cases.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>

namespace openntc::report {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;
using tool::Format;

namespace {

constexpr double kExact = 0.003; // where an error of zero is drawn on a logarithmic scale
constexpr const char* kColors[] = {"#1f6fb4", "#17a2a2", "#d1495b", "#8e6bbf",
                                   "#5a5a5a", "#e08a00", "#b0436e"};

/// A quoted string of gnuplot's; device names come from files.
std::string Quote(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (static_cast<unsigned char>(c) < 0x20)
            continue;
        if (c == '"' || c == '\\' || c == '$' || c == '`')
            result += c == '"' ? "'" : " ";
        else
            result += c;
    }
    return result + "\"";
}

double Finite(double value, double instead) {
    return std::isfinite(value) ? value : instead;
}

/// Collects a script; every chart is a file of its own.
class Script {
public:
    explicit Script(const fs::path& folder) : folder_(folder) {}

    void Begin(const std::string& name, const std::string& title, const std::string& caption, int width = 900,
               int height = 560) {
        text_ += Format("reset\nset encoding utf8\nset terminal svg size %d,%d font 'Arial,14' background "
                        "'white' noenhanced\n",
                        width, height);
        text_ += "set output " + Quote((folder_ / (name + ".svg")).string()) + "\n";
        text_ += "set title " + Quote(title) +
                 " noenhanced\nset grid lc rgb '#dddddd'\nset border lc rgb '#444444'\n"
                 "set tics nomirror textcolor rgb '#222222'\n";
        charts_.push_back({name, title, caption, {}});
    }
    void Add(const std::string& lines) { text_ += lines; }
    std::string MakeBlock(const std::string& rows) {
        std::string name = "$data" + std::to_string(blocks_++);
        text_ += name + " << EOD\n" + rows + "EOD\n";
        return name;
    }

    std::vector<Chart> Run() {
        const fs::path script = folder_ / "charts.gp";
        std::ofstream(script, std::ios::binary) << text_ << "unset output\nset print '-'\nprint 'done'\n";
        conformance::ChildProcess process;
        constexpr double kSeconds = 60;
        const auto deadline = conformance::ChildProcess::Clock::now() + std::chrono::seconds(60);
        const char* missing =
            "gnuplot: cannot be run: charts need it (Debian: gnuplot-nox); report.json can be made "
            "without, and its page elsewhere with --from";
        if (!process.Start({"gnuplot", script.string()}))
            throw CommandError(ExitCode::NoDevice, "charts", missing);
        const Expected<std::string> line = process.ReadLine(deadline, kSeconds);
        if (!line || *line != "done")
            throw CommandError(ExitCode::NoDevice, "charts",
                               line || std::string(line.error().GetText()) == "ended with exit code 127"
                                   ? missing
                                   : std::string("gnuplot: ") + line.error().GetText());
        for (Chart& chart : charts_) {
            const std::vector<std::byte> bytes = tool::ReadAll((folder_ / (chart.name + ".svg")).string());
            chart.svg.assign(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        }
        return charts_;
    }

private:
    fs::path folder_;
    std::string text_;
    std::vector<Chart> charts_;
    int blocks_ = 0;
};

std::string DescribeDevice(const ReportRecord& report, const std::string& device) {
    return device + ", " + report.date.substr(0, 10);
}

std::string GetPointLabel(const CaseRecord& c) {
    return c.network + Format(" %g bpp", c.bitsPerPixel);
}

/// Times in a unit that fits: nanoseconds, or microseconds for slow devices.
struct TimeUnit {
    double factor = 1;
    const char* name = "ns";
};
TimeUnit PickUnit(const std::vector<const CaseRecord*>& cases) {
    double least = INFINITY;
    for (const CaseRecord* c : cases)
        least = std::min(least, c->time.median);
    return least >= 1000 ? TimeUnit{1e-3, "µs"} : TimeUnit{};
}

/// Labels 1, 2, 5 x 10^n for a logarithmic axis, whose own labels are powers of ten only; those where the others
/// would touch.
std::string MakeTics(const char* axis, double least, double most) {
    const bool isLong = most > 1000 * least;
    std::string tics;
    for (double decade = std::pow(10.0, std::floor(std::log10(least)) - 1); decade <= 10 * most;
         decade *= 10) {
        for (const double digit : {1.0, 2.0, 5.0}) {
            if (isLong && digit > 1)
                break;
            tics += (tics.empty() ? "" : ", ") + Format("'%g' %g", digit * decade, digit * decade);
        }
    }
    return std::string("set ") + axis + "tics (" + tics + ")\n";
}

/// The logarithmic time axis of a chart.
std::string MakeTimeAxis(const std::vector<const CaseRecord*>& cases, const TimeUnit& unit) {
    double least = INFINITY, most = 0;
    for (const CaseRecord* c : cases) {
        least = std::min(least, unit.factor * c->time.median);
        most = std::max(most, unit.factor * c->time.median);
    }
    return std::string("set logscale x\nset xlabel 'median time per texel, ") + unit.name +
           " (logarithmic)'\n" + Format("set xrange [%g:%g]\n", least / 1.3, most * 1.3) +
           MakeTics("x", least, most);
}

/// A range that is never empty.
std::string MakeRange(const char* axis, double least, double most) {
    const double margin = std::max(0.5, 0.08 * (most - least));
    return std::string("set ") + axis + Format("range [%g:%g]\n", least - margin, most + margin);
}

/// Names of maths modes in the order of Cases.h.
std::vector<std::string> ListMaths() {
    std::vector<std::string> names;
    for (int math = 1; math <= 7; ++math)
        names.emplace_back(GetMathName(math));
    return names;
}

/// One colour per maths mode; returns the parts of a plot command.
template <typename F>
std::string PlotByMath(Script& script, const std::vector<const CaseRecord*>& cases, F&& makeRow) {
    std::string plots;
    const std::vector<std::string> maths = ListMaths();
    for (std::size_t m = 0; m < maths.size(); ++m) {
        std::string rows;
        for (const CaseRecord* c : cases) {
            if (c->math == maths[m])
                rows += makeRow(*c);
        }
        if (!rows.empty())
            plots += (plots.empty() ? "" : ", ") + script.MakeBlock(rows) +
                     Format(" using 1:2 with points pt 7 ps 0.9 lc rgb '%s' title '%s'", kColors[m],
                            maths[m].c_str());
    }
    return plots;
}

void DrawAccuracyTime(Script& script, const ReportRecord& report, const DeviceRecord& device,
                      std::size_t number) {
    const std::vector<const CaseRecord*> cases = ListComparable(report, device.name);
    if (cases.empty())
        return;
    const std::vector<const CaseRecord*> front = ListParetoFront(cases);
    script.Begin(Format("accuracy-time-%zu", number),
                 "Accuracy against time: " + DescribeDevice(report, device.name),
                 "Every maths mode and network at 4 bits per pixel, and the medium network at other bits per "
                 "pixel: sample "
                 "bricks, one set, 9 outputs. Up and left is better; the line is the Pareto front.");
    const TimeUnit unit = PickUnit(cases);
    script.Add(MakeTimeAxis(cases, unit) +
               "set ylabel 'PSNR against the source, dB'\nset key outside right top "
               "reverse Left\n");
    double least = INFINITY, most = -INFINITY;
    for (const CaseRecord* c : cases) {
        least = std::min(least, Finite(c->accuracy.psnrSource, 99));
        most = std::max(most, Finite(c->accuracy.psnrSource, 99));
    }
    script.Add(MakeRange("y", least, most));
    const auto makeRow = [&unit](const CaseRecord& c) {
        return Format("%.6g %.6g\n", unit.factor * c.time.median, Finite(c.accuracy.psnrSource, 99));
    };
    std::string rows, labels, key;
    for (std::size_t i = 0; i < front.size(); ++i) {
        const CaseRecord& c = *front[i];
        if (i > 0) // a step: the earlier one stays the best until the next
            rows += Format("%.6g %.6g\n", unit.factor * c.time.median,
                           Finite(front[i - 1]->accuracy.psnrSource, 99));
        rows += makeRow(c);
        labels +=
            Format("%.6g %.6g %zu\n", unit.factor * c.time.median, Finite(c.accuracy.psnrSource, 99), i + 1);
        key += ", keyentry with points pt 6 ps 1.2 lc rgb '#222222' title " +
               Quote(Format("%zu: ", i + 1) + c.math + ", " + GetPointLabel(c));
    }
    const std::string line = script.MakeBlock(rows), names = script.MakeBlock(labels);
    const std::string points = PlotByMath(script, cases, makeRow);
    script.Add("plot " + points + ", " + line +
               " using 1:2 with lines lw 2 dt 2 lc rgb '#222222' title 'Pareto front:'" + key + ", " + names +
               " using 1:2 with points pt 6 ps 1.7 lw 1.5 lc rgb '#222222' notitle, " + names +
               " using 1:2:3 with labels offset -1.3,0.7 font ',12' notitle\n");
}

void DrawErrorTime(Script& script, const ReportRecord& report, const DeviceRecord& device,
                   std::size_t number) {
    const std::vector<const CaseRecord*> cases = ListComparable(report, device.name);
    if (cases.empty())
        return;
    script.Begin(Format("error-time-%zu", number),
                 "Arithmetic error against time: " + DescribeDevice(report, device.name),
                 "Difference from the FP32 decode of the same file, worst of all values, in steps of 1/255. "
                 "FP8 modes use "
                 "the set's FP8 network, which is trained apart, so theirs includes that.");
    const TimeUnit unit = PickUnit(cases);
    script.Add(
        MakeTimeAxis(cases, unit) +
        Format(
            "set logscale y\nset ylabel 'worst difference from FP32, 1/255 (logarithmic)'\nset key outside "
            "right top reverse Left\nset yrange [%g:400]\nset offsets 0, 0, graph 0.05, 0\n"
            "set ytics ('0' %g, '0.01' 0.01, '0.1' 0.1, '1' 1, '2' 2, '5' 5, '10' 10, '20' 20, '50' 50, "
            "'100' 100, '255' 255)\n",
            kExact / 1.5, kExact));
    const std::string points = PlotByMath(script, cases, [&unit](const CaseRecord& c) {
        return Format("%.6g %.6g\n", unit.factor * c.time.median,
                      std::max(Finite(c.accuracy.worstLsbFp32, 1e4), kExact));
    });
    script.Add("plot " + points + "\n");
}

/// Three digits, without an exponent.
std::string FormatTime(double time) {
    return time >= 1000 ? Format("%.0f", time) : Format("%.3g", time);
}

struct Bar {
    std::string label;
    const CaseRecord* c;
    int group;
};

void DrawBars(Script& script, const std::vector<Bar>& bars, const TimeUnit& unit, const CaseRecord* base) {
    std::string rows;
    for (std::size_t i = 0; i < bars.size(); ++i) {
        const Spread& t = bars[i].c->time;
        rows += Format("%zu %.6g %.6g %.6g %d ", i, unit.factor * t.median, unit.factor * t.lowerQuartile,
                       unit.factor * t.upperQuartile, bars[i].group) +
                Quote(bars[i].label) + Format(" %s\n", Quote(FormatTime(unit.factor * t.median)).c_str());
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

void DrawEffects(Script& script, const ReportRecord& report, const DeviceRecord& device, std::size_t number) {
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
                 "set.",
                 1000, 560);
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
                 "The base point in every maths mode that the device has. The scale is logarithmic.", 900,
                 480);
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

void DrawSets(Script& script, const ReportRecord& report, const DeviceRecord& device, std::size_t number) {
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
                 900, 460);
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
                 Format(" using 1:2:3:4 with yerrorlines pt 7 lw 2 lc rgb '%s' title '%s'", kColors[color],
                        math.c_str());
        if (base > 0)
            plots += Format(", %.6g with lines dt 2 lc rgb '%s' title '%s, one set at a fixed place'", base,
                            kColors[color], math.c_str());
    }
    script.Add("plot " + plots + "\n");
}

void DrawQuality(Script& script, const ReportRecord& report) {
    if (report.encodings.empty())
        return;
    script.Begin(
        "quality-bpp", "Quality against bits per pixel",
        std::string(
            "Int8 network, all mips, exact decode. Ours: the steps of training in the key. LibNTC: ") +
            kPublishedSource + ".");
    script.Add("set xlabel 'bits per pixel of mip 0'\nset ylabel 'PSNR against the source, dB'\nset key "
               "below height 2\n"
               "set offsets graph 0.08, graph 0.08, graph 0.08, graph 0.08\n");
    std::string plots;
    int color = 0;
    const auto addSeries = [&](const std::string& rows, const std::string& title, const char* style) {
        plots += (plots.empty() ? "" : ", ") + script.MakeBlock(rows) + " using 1:2 " + style +
                 Format(" lc rgb '%s' title ", kColors[color++ % 7]) + Quote(title);
    };
    std::vector<EncodingRecord> sorted = report.encodings;
    std::sort(sorted.begin(), sorted.end(), [](const EncodingRecord& a, const EncodingRecord& b) {
        return a.bitsPerPixel < b.bitsPerPixel;
    });
    std::set<std::string> materials;
    for (const EncodingRecord& e : sorted)
        materials.insert(e.material);
    for (const std::string& material : materials) {
        std::string line, others;
        std::uint64_t steps = 0;
        for (const EncodingRecord& e : sorted) {
            if (e.material != material)
                continue;
            const bool onLine = material != kBricks || e.network == "medium";
            (onLine ? line : others) += Format("%g %.4f\n", e.bitsPerPixel, Finite(e.psnr, 99));
            steps = e.steps;
        }
        const std::string title =
            "OpenNTC, " + material + Format(", %llu steps", static_cast<unsigned long long>(steps));
        if (!line.empty())
            addSeries(line, title + (material == kBricks ? ", medium network" : ""),
                      "with linespoints pt 7 lw 2");
        if (!others.empty())
            addSeries(others, title + ", other networks", "with points pt 6 ps 1.2 lw 2");
    }
    std::set<std::pair<std::string, std::string>> published;
    for (const PublishedPoint& p : ListPublishedPoints())
        published.emplace(p.encoder, p.material);
    for (const auto& [encoder, material] : published) {
        std::string rows;
        for (const PublishedPoint& p : ListPublishedPoints()) {
            if (p.encoder == encoder && p.material == material)
                rows += Format("%g %g\n", p.bitsPerPixel, p.psnr);
        }
        std::string title = encoder;
        title.append(", ").append(material).append(", 100000 steps");
        addSeries(rows, title, "with linespoints pt 9 dt 2 lw 1.5");
    }
    script.Add(Format("set bmargin %d\n", color + 6)); // axis, and a line of the key for each series
    script.Add("plot " + plots + "\n");
}

} // namespace

std::vector<Chart> DrawCharts(const ReportRecord& report, const fs::path& scratch) {
    Script script(scratch);
    for (std::size_t i = 0; i < report.devices.size(); ++i) {
        DrawAccuracyTime(script, report, report.devices[i], i + 1);
        DrawErrorTime(script, report, report.devices[i], i + 1);
        DrawEffects(script, report, report.devices[i], i + 1);
        DrawSets(script, report, report.devices[i], i + 1);
    }
    DrawQuality(script, report);
    return script.Run();
}

} // namespace openntc::report
