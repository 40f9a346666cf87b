// SPDX-License-Identifier: MIT
// Runs the suite's cases of block compression.
#pragma once

#include "BlockSuite.h"
#include "Runner.h"

#include <filesystem>
#include <functional>

namespace openntc::conformance {

/// Calls `add` for each case that is run, in their order. A failure says which block differs first, how many
/// do, and where exactly one known mistake gives all of them, right and wrong ones, what the encoder seems to do.
void RunBlockCases(const std::filesystem::path& folder, std::span<const BlockSuiteCase> cases,
                   Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add);

} // namespace openntc::conformance
