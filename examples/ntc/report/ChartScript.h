// SPDX-License-Identifier: MIT
// A gnuplot script that draws charts, and what several of them share.
#pragma once

#include "report/Charts.h"
#include "report/Report.h"

#include <cstddef>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

namespace openntc::report {

/// One for each maths mode; `kColorCount` of them.
inline constexpr const char* kColors[] = {"#1f6fb4", "#17a2a2", "#d1495b", "#8e6bbf", "#5a5a5a",
                                          "#e08a00", "#b0436e", "#2e7d32", "#8a5a2b"};
inline constexpr std::size_t kColorCount = std::size(kColors);
inline constexpr int kChartWidth = 1132; // of the page's text

/// A quoted string of gnuplot's; device names come from files.
std::string QuoteLabel(const std::string& text);

/// `instead` for infinities and NaN.
double GetFinite(double value, double instead);

/// Collects a script; every chart is a file of its own.
class ChartScript {
public:
    explicit ChartScript(const std::filesystem::path& folder) : folder_(folder) {}

    /// A chart of kChartWidth x `height` pixels. What is added until the next one belongs to it.
    void Begin(const std::string& name, const std::string& title, const std::string& caption, int height);
    void Add(const std::string& lines) { text_ += lines; }
    /// Rows of numbers as a named block; returns its name.
    std::string MakeBlock(const std::string& rows);
    /// Says in red above every chart that times were taken beside other work. Before the first Begin.
    void Warn(const std::string& warning) { warning_ = warning; }

    /// Runs gnuplot. Throws CommandError(NoDevice) without it.
    std::vector<Chart> Run();

private:
    std::filesystem::path folder_;
    std::string text_;
    std::string warning_;
    std::vector<Chart> charts_;
    int blocks_ = 0;
};

/// Times in a unit that fits: nanoseconds, or microseconds for slow devices.
struct TimeUnit {
    double factor = 1;
    const char* name = "ns";
};
TimeUnit PickUnit(const std::vector<const CaseRecord*>& cases);

/// The logarithmic time axis of a chart.
std::string MakeTimeAxis(const std::vector<const CaseRecord*>& cases, const TimeUnit& unit);

/// Labels 1, 2, 5 x 10^n for a logarithmic axis, whose own labels are powers of ten only; those where the others
/// would touch.
std::string MakeTics(const char* axis, double least, double most);

std::string DescribeDevice(const ReportRecord& report, const std::string& device);

/// Charts of rows: what decides accuracy on the rows, time along them.
void DrawAccuracyTime(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                      std::size_t number);
void DrawErrorTime(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                   std::size_t number);

/// The axis "generation": a row for each maths mode, size and instruction set. Name: generations-1 and so on.
void DrawGenerations(ChartScript& script, const ReportRecord& report, const DeviceRecord& device,
                     std::size_t number);

/// Block compression on load: a chart for each device and number of threads, a row for each format. Names: blocks-1 and so on.
void DrawBlocks(ChartScript& script, const ReportRecord& report);
void DrawFiltering(ChartScript& script, const ReportRecord& report);
/// Encodings by kernel. Name: training.
void DrawTraining(ChartScript& script, const ReportRecord& report);
/// Rendered scenes: a chart for each device, a row for each delivery. Names: scenes-1 and so on.
void DrawScenes(ChartScript& script, const ReportRecord& report);

} // namespace openntc::report
