// SPDX-License-Identifier: MIT
// Runs the cases of suite.json one after the other, and finds out whose fault a failure is: the case's, or that of what
// was asked before it.
#pragma once

#include "Diagnosis.h"
#include "Runner.h"

#include "../TextureSet.h"

#include <array>
#include <filesystem>
#include <functional>
#include <optional>

namespace openntc::conformance {

class SuiteRunner {
public:
    using AddResult = std::function<void(const CaseResult&)>;

    SuiteRunner(std::filesystem::path folder, Subject& subject, bool mustPassOnly)
        : folder_(std::move(folder)), subject_(subject), mustPassOnly_(mustPassOnly) {}

    /// Calls `add` for each case that is run, in their order, one case late: what a decoder does after its answer shows
    /// with the next.
    void Run(std::span<const SuiteCase> cases, const AddResult& add);

private:
    struct Attempt {
        CaseResult result;
        std::optional<SubjectError::Kind> ended;
    };

    Attempt Try(const SuiteCase& suiteCase);
    void RunChecks(const SuiteCase& suiteCase, CaseResult& result);
    CaseResult RunCase(const SuiteCase& suiteCase);
    bool IsDoubtful(const SuiteCase& suiteCase, const Attempt& attempt) const;
    bool Restart();
    std::string FindUnasked(const SuiteCase& suiteCase);
    void RequireInside(const SuiteCase& suiteCase, const std::vector<ValueRecord>& records,
                       const std::string& path) const;

    std::filesystem::path folder_;
    Subject& subject_;
    bool mustPassOnly_;
    Diagnosis diagnosis_;
    std::string open_; // path of the set that the subject has open
    std::optional<tool::TextureSet> set_;
    std::vector<std::byte> file_;
    std::optional<Model> model_;
    const SuiteCase* before_ = nullptr;    // the case that the subject answered last, in this process
    std::optional<CaseResult> pending_;    // the result of the case before, not reported yet
    std::array<int, 6> uselessRestarts_{}; // per DecodeMath, which counts from 1
};

} // namespace openntc::conformance
