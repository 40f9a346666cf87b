// SPDX-License-Identifier: MIT
// Runs the checks of one case, whose exceptions are results too.
#pragma once

#include "Runner.h"

#include "../Failure.h"
#include "../Interrupt.h"
#include "../Output.h"

#include <chrono>
#include <filesystem>
#include <optional>

namespace openntc::conformance {

inline void Finish(CaseResult& result, Outcome outcome, const std::string& reason) {
    result.outcome = outcome;
    result.reason = reason;
}

/// The kind of SubjectError that ended the case, if one did. Lets CommandError(NoDevice) and interrupts through.
template <typename Checks>
std::optional<SubjectError::Kind> RunGuarded(CaseResult& result, Subject& subject, Checks checks) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    std::optional<SubjectError::Kind> ended;
    try {
        checks();
    } catch (const SubjectError& error) {
        ended = error.GetKind();
        const bool isSkipped =
            ended == SubjectError::Kind::NotSupported || ended == SubjectError::Kind::NotRun;
        Finish(result, isSkipped ? Outcome::Skip : Outcome::Fail, error.what());
    } catch (const tool::CommandError& error) {
        if (error.GetCode() == tool::ExitCode::NoDevice || tool::IsInterrupted())
            throw;
        Finish(result, Outcome::Fail,
               std::filesystem::path(error.GetSubject()).filename().string() + ": " + error.what());
    }
    result.reason = tool::Printable(result.reason);
    result.device = subject.GetName();
    result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    return ended;
}

} // namespace openntc::conformance
