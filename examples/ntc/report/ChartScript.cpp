// SPDX-License-Identifier: MIT
#include "report/ChartScript.h"

#include "Failure.h"
#include "Output.h"
#include "TextureSet.h"
#include "conformance/ChildProcess.h"

#include <algorithm>
#include <cmath>
#include <fstream>

namespace openntc::report {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;
using tool::Format;

namespace {

/// The text of the first element of that name.
void ReplaceElement(std::string& svg, const std::string& name, const std::string& text) {
    const std::size_t start = svg.find("<" + name + ">"), end = svg.find("</" + name + ">");
    if (start == std::string::npos || end == std::string::npos || end < start)
        return;
    const std::size_t first = start + name.size() + 2;
    svg.replace(first, end - first, tool::EscapeMarkup(text));
}

} // namespace

bool CanDrawCharts() {
    conformance::ChildProcess process;
    constexpr double kSeconds = 10;
    return process.Start({"gnuplot", "--version"}) &&
           process.ReadLine(conformance::ChildProcess::Clock::now() + std::chrono::seconds(10), kSeconds);
}

std::string QuoteLabel(const std::string& text) {
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

double GetFinite(double value, double instead) {
    return std::isfinite(value) ? value : instead;
}

void ChartScript::Begin(const std::string& name, const std::string& title, const std::string& caption,
                        int height) {
    text_ +=
        Format("reset\nset encoding utf8\nset terminal svg size %d,%d dynamic font 'Arial,15' background "
               "'white' noenhanced\n",
               kChartWidth, height);
    text_ += "set output " + QuoteLabel((folder_ / (name + ".svg")).string()) + "\n";
    text_ += "set title " + QuoteLabel(title) +
             " font ',18' noenhanced\nset grid lc rgb '#dddddd'\nset border lc rgb '#444444'\n"
             "set tics nomirror textcolor rgb '#222222'\nset bars 0.4\n";
    if (!warning_.empty())
        text_ += "set label " + QuoteLabel(warning_) +
                 " at screen 0.5, screen 0.022 center font ',13' textcolor rgb '#c00000'\nset bmargin 5\n";
    charts_.push_back({name, title, caption, {}});
}

std::string ChartScript::MakeBlock(const std::string& rows) {
    std::string name = "$data" + std::to_string(blocks_++);
    text_ += name + " << EOD\n" + rows + "EOD\n";
    return name;
}

std::vector<Chart> ChartScript::Run() {
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
        // gnuplot titles every document by its own name, and viewers show that.
        ReplaceElement(chart.svg, "title", chart.title);
        ReplaceElement(chart.svg, "desc", chart.caption);
    }
    return charts_;
}

TimeUnit PickUnit(const std::vector<const CaseRecord*>& cases) {
    double least = INFINITY;
    for (const CaseRecord* c : cases)
        least = std::min(least, c->time.median);
    return least >= 1000 ? TimeUnit{1e-3, "µs"} : TimeUnit{};
}

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

std::string MakeTimeAxis(const std::vector<const CaseRecord*>& cases, const TimeUnit& unit) {
    double least = INFINITY, most = 0;
    for (const CaseRecord* c : cases) {
        least = std::min(least, unit.factor * c->time.lowerQuartile);
        most = std::max(most, unit.factor * c->time.upperQuartile);
    }
    return std::string("set logscale x\nset xlabel 'median time per texel, ") + unit.name +
           " (logarithmic); bars: quartiles'\n" + Format("set xrange [%g:%g]\n", least / 1.3, most * 1.3) +
           MakeTics("x", least, most);
}

std::string DescribeDevice(const ReportRecord& report, const std::string& device) {
    return device + ", " + report.date.substr(0, 10);
}

} // namespace openntc::report
