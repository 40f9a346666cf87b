// SPDX-License-Identifier: MIT
// What differs between two reports, and whether that is noise.
#pragma once

#include "report/Report.h"

#include <string>

namespace openntc::report {

/// The rule, in words, for pages and manuals.
extern const char* const kChangeRule;

/// Cases of the same name on the same device. A time has changed when all repeats of one report are slower than all of the
/// other (their ranges do not overlap) and the medians differ by more than 5 %. Accuracy has changed when PSNR differs by
/// more than 0.005 dB or the worst error by more than 0.005 / 255.
void CompareReports(const ReportRecord& old, ReportRecord& report);

/// Lines for people: counts, then the cases that changed.
std::string DescribeChanges(const ReportRecord& report);

} // namespace openntc::report
