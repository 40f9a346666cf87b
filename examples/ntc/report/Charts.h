// SPDX-License-Identifier: MIT
// Charts of a report, drawn by gnuplot.
#pragma once

#include "report/Report.h"

#include <filesystem>
#include <string>
#include <vector>

namespace openntc::report {

struct Chart {
    std::string name; ///< without ending: accuracy-time-1
    std::string title;
    std::string caption;
    std::string svg;
};

/// Whether DrawCharts can work here: gnuplot starts.
bool CanDrawCharts();

/// `scratch`: a folder for gnuplot's script and results. Throws CommandError(NoDevice) without gnuplot.
std::vector<Chart> DrawCharts(const ReportRecord& report, const std::filesystem::path& scratch);

} // namespace openntc::report
