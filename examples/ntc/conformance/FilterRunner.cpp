// SPDX-License-Identifier: MIT
#include "FilterRunner.h"

#include "GuardedCase.h"

namespace openntc::conformance {

namespace {

using tool::Format;

void CheckFilter(const std::filesystem::path& folder, const FilterSuiteCase& filterCase, Subject& subject,
                 CaseResult& result) {
    if (!subject.GetCapabilities().filtering)
        return Finish(result, Outcome::Skip, "not supported: filtering");
    const std::string path = (folder / filterCase.lookups).string();
    const FilterFile file =
        tool::Require(ReadFilterFile(tool::ReadAll(path)), tool::ExitCode::BadInput, path);
    const FilterRequest& request = filterCase.request;
    const FilterTaps taps = subject.FilterLookups(request, file.lookups);
    result.suite.texels = file.lookups.size();
    if (taps.size() != file.lookups.size())
        return Finish(result, Outcome::Fail,
                      Format("%zu lookups: expected %zu", taps.size(), file.lookups.size()));
    const FilterDifference difference = CompareFilterTaps(request, taps, file.taps);
    if (difference.different == 0)
        return Finish(result, Outcome::Pass, Format("%zu lookups; ", taps.size()) + filterCase.about);
    result.suite.difference = difference.first;
    result.suite.cause = FindOneCause(ListFilterMistakes(), [&](FilterMistake mistake) {
        return CompareFilterTaps(request, taps, RunFilter(request, file.lookups, mistake)).different == 0;
    });
    FinishDifferent(result, Format("%zu of %zu lookups differ", difference.different, taps.size()),
                    filterCase.about);
}

} // namespace

void RunFilterCases(const std::filesystem::path& folder, std::span<const FilterSuiteCase> cases,
                    Subject& subject, bool mustPassOnly, const std::function<void(const CaseResult&)>& add) {
    RunCaseList(cases, subject, mustPassOnly, add, [&](const FilterSuiteCase& one, CaseResult& result) {
        CheckFilter(folder, one, subject, result);
    });
}

} // namespace openntc::conformance
