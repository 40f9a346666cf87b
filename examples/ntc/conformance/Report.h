// SPDX-License-Identifier: MIT
// The results of a conformance run as text, JSON or JUnit XML.
#pragma once

#include "Runner.h"

#include <memory>
#include <string>

namespace openntc::conformance {

enum class ReportFormat { Text, Json, Junit };

/// Collects results and gives text as soon as the format allows.
class Report {
public:
    virtual ~Report() = default;
    /// What can be written once this case has ended; empty for formats that are written whole.
    virtual std::string Add(const CaseResult& result) = 0;
    /// The rest.
    virtual std::string Finish(const Totals& totals) = 0;
};

/// `subject`: cpu, reference, vulkan or adapter; `folder` is the name of the test suite.
std::unique_ptr<Report> MakeReport(ReportFormat format, const std::string& subject,
                                   const std::string& folder);

} // namespace openntc::conformance
