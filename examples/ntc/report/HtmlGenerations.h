// SPDX-License-Identifier: MIT
#pragma once

#include "report/Report.h"

#include <string>

namespace openntc::report {

/// A table of the axis "generation" on a device; empty where nothing of it was measured.
std::string WriteGenerations(const ReportRecord& report, const DeviceRecord& device);

} // namespace openntc::report
