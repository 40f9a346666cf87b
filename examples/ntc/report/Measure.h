// SPDX-License-Identifier: MIT
// Runs the list of cases.
#pragma once

#include "report/Report.h"
#include "report/Scenes.h"
#include "report/TrainingCurves.h"

#include <filesystem>
#include <string>
#include <vector>

namespace openntc::report {

struct MeasureSettings {
    bool quick = false;
    bool json = false;                ///< events are JSON, one object a line
    std::vector<std::string> devices; ///< "cpu" or part of a Vulkan device's name; empty: what there is
    std::vector<std::string> filters; ///< parts of case names; empty: all
    std::filesystem::path cache;
    std::string model;
    std::string sources;
    std::string glslang;
    std::uint64_t steps = 6000;
    TrainingSettings training;
    SceneSettings scenes;          ///< but what this struct has, which Measure fills in
    std::filesystem::path scratch; ///< a file that may be written and removed
};

/// Throws CommandError; when interrupted, only before a device is open: then the report is marked as cancelled.
/// Progress goes to standard error.
ReportRecord Measure(const MeasureSettings& settings);

} // namespace openntc::report
