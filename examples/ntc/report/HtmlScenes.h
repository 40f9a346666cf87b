// SPDX-License-Identifier: MIT
// The part of a report's page on rendered scenes.
#pragma once

#include "report/Report.h"

#include <functional>
#include <string>
#include <vector>

namespace openntc::report {

/// Rows that vary filter and delivery: the effects are those that the scene calls for, and it is not the scene that calls for
/// all.
std::vector<const SceneRecord*> ListDeliveries(const ReportRecord& report, const std::string& device);

/// Whether no other row of the same device, scene, size and filter is as fast (within spread), as close to the reference and
/// as small in memory, and better in one of these. Rows of the reference mode with all texels count too.
bool IsOnSceneFront(const ReportRecord& report, const SceneRecord& record);

/// `on-sample, one texel, int8`.
std::string DescribeDelivery(const SceneRecord& record);

/// Empty without any. `getFigure`: a chart by its name.
std::string WriteScenes(const ReportRecord& report,
                        const std::function<std::string(const std::string&)>& getFigure);

} // namespace openntc::report
