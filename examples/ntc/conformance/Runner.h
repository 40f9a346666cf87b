// SPDX-License-Identifier: MIT
// Runs a folder of conformance vectors with one back end.
#pragma once

#include "Checks.h"

#include <functional>
#include <string>
#include <vector>

namespace openntc::conformance {

enum class Outcome { Pass, Fail, Skip };

struct CaseResult {
    std::string name;
    Outcome outcome = Outcome::Pass;
    std::string reason;
    MetadataResult metadata;
    TexelResult texels;
    std::string device; ///< of the Vulkan back end

    /// Largest difference in the exact blocks; 0 when they are equal or were not compared.
    double GetWorstError() const;
    /// `PASS|FAIL|SKIP NAME: reason, worst error`
    std::string GetLine() const;
};

struct Totals {
    int passed = 0;
    int failed = 0;
    int skipped = 0;

    void Add(Outcome outcome);
    /// `total: P passed, F failed, S skipped`
    std::string GetLine() const;
    /// True if something ran and nothing failed.
    bool IsSuccess() const { return failed == 0 && passed > 0; }
};

const char* GetName(Outcome outcome);

/// Runs NAME.ntc, NAME.expect.json and NAME.texels of `folder` for every NAME, in alphabetical order, and
/// calls `report` after each. Throws tool::CommandError: BadInput if the folder cannot be read, NoDevice if
/// the back end is absent.
Totals RunFolder(const std::string& folder, const tool::BackendOptions& backend,
                 const std::function<void(const CaseResult&)>& report);

} // namespace openntc::conformance
