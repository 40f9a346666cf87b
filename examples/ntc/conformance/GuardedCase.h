// SPDX-License-Identifier: MIT
// Runs the checks of one case, whose exceptions are results too.
#pragma once

#include "Runner.h"

#include "../Failure.h"
#include "../InputFile.h"
#include "../Interrupt.h"
#include "../Output.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace openntc::conformance {

inline void Finish(CaseResult& result, Outcome outcome, const std::string& reason) {
    result.outcome = outcome;
    result.reason = reason;
}

/// The kind of SubjectError that ended the case, if one did. Lets CommandError(NoDevice) and interrupts
/// through.
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

/// Runs a list of cases with name, about and mustPass by `check(case, result)`. Calls `add` for each that is
/// run, in their order, one late: what comes after an answer shows with the next, or at the end.
template <typename Case, typename Add, typename Check>
void RunCaseList(std::span<const Case> cases, Subject& subject, bool mustPassOnly, const Add& add,
                 Check check) {
    std::optional<CaseResult> pending;
    for (const Case& one : cases) {
        if (mustPassOnly && !one.mustPass)
            continue;
        tool::ThrowIfInterrupted();
        CaseResult result;
        result.name = one.name;
        result.about = one.about;
        result.mustPass = one.mustPass;
        const auto ended = RunGuarded(result, subject, [&] { check(one, result); });
        if (mustPassOnly && ended == SubjectError::Kind::NotSupported)
            Finish(result, Outcome::Fail, result.reason + ", although it claims what the case needs");
        if (pending)
            add(*pending);
        pending = std::move(result);
    }
    if (!pending)
        return;
    const std::string unasked = subject.Finish();
    if (!unasked.empty() && pending->outcome == Outcome::Pass)
        Finish(*pending, Outcome::Fail, "adapter: " + unasked + ", after its answer");
    add(*pending);
}

/// A file of that many bytes. Throws CommandError(BadInput).
inline std::vector<std::byte> ReadSized(const std::filesystem::path& path, std::size_t bytes) {
    std::vector<std::byte> file = tool::ReadAll(path.string());
    if (file.size() != bytes)
        throw tool::CommandError(tool::ExitCode::BadInput, path.string(),
                                 tool::Format("%zu bytes: suite.json wants %zu", file.size(), bytes));
    return file;
}

/// A failure's text behind what differs: the one known mistake that gives all of the answer, or what the case
/// covers.
inline void FinishDifferent(CaseResult& result, const std::string& counts, const std::string& about) {
    const std::string& cause = result.suite.cause;
    Finish(result, Outcome::Fail,
           result.suite.difference + "; " + counts + "; " +
               (cause.empty() ? "covers: " + about : "looks like: " + cause));
}

/// The cause of the one mistake for which `gives(mistake)` holds; empty where it is none, or several.
template <typename Infos, typename Gives>
std::string FindOneCause(const Infos& infos, Gives gives) {
    std::string cause;
    for (const auto& info : infos) {
        if (!gives(info.mistake))
            continue;
        if (!cause.empty())
            return {};
        cause = info.cause;
    }
    return cause;
}

} // namespace openntc::conformance
