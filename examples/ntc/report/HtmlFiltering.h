// SPDX-License-Identifier: MIT
// The part of a report's page on filtering.
#pragma once

#include "report/Report.h"

#include <functional>
#include <string>

namespace openntc::report {

/// Whether no other number of texels of the same filter is as fast or faster, beyond the spread, and closer
/// after the most frames. Of those that are equal within spread the closest one is on the front.
bool IsOnFilteringFront(const ReportRecord& report, const FilteringRecord& record);

/// Empty without any. `getFigure`: a chart by its name.
std::string WriteFiltering(const ReportRecord& report,
                           const std::function<std::string(const std::string&)>& getFigure);

} // namespace openntc::report
