// SPDX-License-Identifier: MIT
// report.json (schemas/report.schema.json).
#pragma once

#include "report/Report.h"

#include <string>

namespace openntc::report {

std::string WriteReport(const ReportRecord& report);

/// Throws CommandError(BadInput) naming file and member.
ReportRecord ReadReport(const std::string& path);

/// The file that tests/numerics writes for OPENNTC_HARD_CASES_JSON. Throws CommandError(BadInput).
std::vector<HardCaseRecord> ReadHardCases(const std::string& path);

} // namespace openntc::report
