// SPDX-License-Identifier: MIT
// The part of a report's page on encoding.
#pragma once

#include "report/Report.h"

#include <functional>
#include <string>
#include <vector>

namespace openntc::report {

/// The processor's for its kernels, the clock's for devices.
const std::vector<double>& GetChartSeconds(const TrainingRecord& record);

/// `avx2`, or `NAME (vulkan, 16384 texels a step)`.
std::string DescribeTrainer(const TrainingRecord& record);

/// Empty without any. `getFigure`: a chart by its name.
std::string WriteTraining(const ReportRecord& report,
                          const std::function<std::string(const std::string&)>& getFigure);

} // namespace openntc::report
