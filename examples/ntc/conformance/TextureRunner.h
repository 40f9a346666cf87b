// SPDX-License-Identifier: MIT
// Runs the suite's cases of textures.
#pragma once

#include "Runner.h"
#include "TextureSuite.h"

#include <filesystem>
#include <functional>

namespace openntc::conformance {

/// Calls `add` for each case that is run, in their order. A failure says which component differs first, how
/// many do, and where exactly one known mistake gives all of them what the pass seems to do.
void RunTextureCases(const std::filesystem::path& folder, std::span<const TextureSuiteCase> cases,
                     Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add);

} // namespace openntc::conformance
