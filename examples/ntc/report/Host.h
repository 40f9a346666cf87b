// SPDX-License-Identifier: MIT
// When, and beside how much other work, a report was measured.
#pragma once

#include <string>

namespace openntc::report {

/// Now, in UTC, as in 2026-11-28T06:37:12Z.
std::string GetDate();

/// Processes that wanted to run in the last minute, on average; 0 where the system does not say.
double GetLoad();

} // namespace openntc::report
