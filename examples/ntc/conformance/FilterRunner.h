// SPDX-License-Identifier: MIT
// Runs the suite's cases of filtering.
#pragma once

#include "FilterSuite.h"
#include "Runner.h"

#include <filesystem>
#include <functional>

namespace openntc::conformance {

/// Calls `add` for each case that is run, in their order. A failure says which lookup differs first, how many
/// do, and where exactly one known mistake gives all of them what the filter seems to do.
void RunFilterCases(const std::filesystem::path& folder, std::span<const FilterSuiteCase> cases,
                    Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add);

} // namespace openntc::conformance
