// SPDX-License-Identifier: MIT
// Runs a folder of conformance vectors with one decoder.
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
    SuiteResult suite;    ///< of the project's own vectors
    std::string about;    ///< what such a case covers
    bool mustPass = true; ///< false for cases that a decoder may fail and still conform
    std::string device;   ///< name of the decoder under test, or of the Vulkan device
    double seconds = 0;

    /// Largest difference that is not accepted; 0 when there is none or nothing was compared.
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

/// Runs the cases of suite.json in its order, if there is one, and NAME.ntc with NAME.expect.json or NAME.texels for
/// every NAME, in alphabetical order. With `mustPassOnly` optional cases of suite.json are left out. Calls `report` after each. Metadata is compared only where the subject uses this
/// project's loader. Throws tool::CommandError: BadInput if the folder cannot be read, NoDevice if the device is absent.
Totals RunFolder(const std::string& folder, Subject& subject, bool mustPassOnly,
                 const std::function<void(const CaseResult&)>& report);

/// The same with one of our own decoders.
Totals RunFolder(const std::string& folder, const tool::BackendOptions& backend,
                 const std::function<void(const CaseResult&)>& report);

} // namespace openntc::conformance
