// SPDX-License-Identifier: MIT
// report.html: one file, nothing loaded from elsewhere.
#pragma once

#include "report/Charts.h"
#include "report/Report.h"

#include <string>
#include <vector>

namespace openntc::report {

std::string WriteHtml(const ReportRecord& report, const std::vector<Chart>& charts);

} // namespace openntc::report
