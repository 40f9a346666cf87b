// SPDX-License-Identifier: MIT
#include "SuiteRunner.h"

#include "GuardedCase.h"

namespace openntc::conformance {

namespace {

using tool::CommandError;
using tool::ExitCode;
using tool::Format;

// Cases of a maths mode that failed alone too, after which failures are no longer tried alone: a decoder that is wrong
// everywhere would start twice for each.
constexpr int kMaxUselessRestarts = 16;
// How long a decoder that broke the next case may take to show that it was the case before.
constexpr double kUnaskedSeconds = 1;

// Why the decoder need not answer the case, or empty.
std::string FindMissing(const SuiteCase& suiteCase, const Capabilities& capabilities) {
    if (!capabilities.math[static_cast<std::size_t>(suiteCase.math)])
        return tool::GetName(suiteCase.math);
    const bool isOneMip = suiteCase.slice && suiteCase.sliceMip < 0;
    return suiteCase.linear && !capabilities.linear                  ? "linear"
           : isOneMip && !capabilities.slices                        ? "slice"
           : suiteCase.slice && !isOneMip && !capabilities.sliceMips ? "slice_mips"
           : suiteCase.outside && !capabilities.outside              ? "outside"
                                                                     : "";
}

} // namespace

void SuiteRunner::Run(std::span<const SuiteCase> cases, const AddResult& add) {
    for (const SuiteCase& suiteCase : cases) {
        if (mustPassOnly_ && !suiteCase.mustPass)
            continue;
        tool::ThrowIfInterrupted();
        CaseResult result = RunCase(suiteCase);
        if (pending_)
            add(*pending_);
        pending_ = std::move(result);
    }
    if (!pending_)
        return;
    const std::string unasked = subject_.Finish();
    if (!unasked.empty() && pending_->outcome == Outcome::Pass)
        Finish(*pending_, Outcome::Fail, "adapter: " + unasked + ", after its answer");
    add(*pending_);
    pending_.reset();
}

CaseResult SuiteRunner::RunCase(const SuiteCase& suiteCase) {
    const SuiteCase* const before = before_;
    Attempt attempt = Try(suiteCase);
    if (!IsDoubtful(suiteCase, attempt) || before == nullptr || !Restart())
        return attempt.result;
    Attempt alone = Try(suiteCase);
    if (alone.result.outcome != Outcome::Pass) {
        ++uselessRestarts_[static_cast<std::size_t>(suiteCase.math)];
        return alone.result;
    }
    if (attempt.ended && pending_ && pending_->outcome == Outcome::Pass) {
        const std::string unasked = FindUnasked(*before);
        if (!unasked.empty()) {
            Finish(*pending_, Outcome::Fail, "adapter: " + unasked + ", after its answer");
            return Try(suiteCase)
                .result; // again, so that what comes after its own answer shows with the next
        }
    }
    attempt.result.reason += "; passes alone in a fresh process: state of an earlier set";
    attempt.result.suite.cause = "state of an earlier set";
    return attempt.result;
}

// A failure that may come from what was asked before: wrong values without a cause, or a decoder out of step.
bool SuiteRunner::IsDoubtful(const SuiteCase& suiteCase, const Attempt& attempt) const {
    if (attempt.result.outcome != Outcome::Fail ||
        uselessRestarts_[static_cast<std::size_t>(suiteCase.math)] >= kMaxUselessRestarts)
        return false;
    return attempt.ended
               ? *attempt.ended == SubjectError::Kind::Broken || *attempt.ended == SubjectError::Kind::Failed
               : attempt.result.suite.cause.empty();
}

bool SuiteRunner::Restart() {
    open_.clear();
    before_ = nullptr;
    return subject_.Restart();
}

// What the decoder does after its answer to the case, with nothing else asked.
std::string SuiteRunner::FindUnasked(const SuiteCase& suiteCase) {
    if (!Restart())
        return {};
    const Attempt attempt = Try(suiteCase);
    std::string unasked =
        attempt.result.outcome == Outcome::Pass ? subject_.WaitForUnasked(kUnaskedSeconds) : std::string();
    Restart();
    return unasked;
}

SuiteRunner::Attempt SuiteRunner::Try(const SuiteCase& suiteCase) {
    Attempt attempt;
    attempt.result.name = suiteCase.name;
    attempt.result.about = suiteCase.about;
    attempt.result.mustPass = suiteCase.mustPass;
    attempt.ended = RunGuarded(attempt.result, subject_, [&] { RunChecks(suiteCase, attempt.result); });
    if (mustPassOnly_ && attempt.ended == SubjectError::Kind::NotSupported)
        Finish(attempt.result, Outcome::Fail,
               attempt.result.reason + ", although it claims what the case needs");
    // A subject that failed may have lost the set, and one that broke starts again.
    if (attempt.result.outcome == Outcome::Fail && attempt.ended)
        open_.clear();
    if (attempt.ended && *attempt.ended != SubjectError::Kind::Failed &&
        *attempt.ended != SubjectError::Kind::NotSupported)
        before_ = nullptr;
    return attempt;
}

void SuiteRunner::RunChecks(const SuiteCase& suiteCase, CaseResult& result) {
    if (const std::string missing = FindMissing(suiteCase, subject_.GetCapabilities()); !missing.empty())
        return Finish(result, Outcome::Skip, "not supported: " + missing);
    const std::string setPath = (folder_ / suiteCase.set).string();
    const std::string valuesPath = (folder_ / suiteCase.values).string();
    const std::vector<ValueRecord> records =
        tool::Require(ReadValues(tool::ReadAll(valuesPath), suiteCase), ExitCode::BadInput, valuesPath);
    if (open_ != setPath) {
        open_.clear();
        set_.emplace(tool::LoadTextureSet(setPath));
        file_ = tool::ReadAll(setPath);
        model_.emplace(file_);
        subject_.Open(setPath);
        open_ = setPath;
    }
    RequireInside(suiteCase, records, valuesPath);
    result.suite = CheckSuiteCase(suiteCase, records, *model_, subject_, diagnosis_);
    before_ = &suiteCase;
    const SuiteResult& suite = result.suite;
    if (suite.difference.empty()) {
        std::string text = Format("%zu texels; %s", suite.texels, suiteCase.about.c_str());
        if (suite.worstAccepted > 0)
            text += Format("; within bounds by %.3g", suite.worstAccepted);
        return Finish(result, Outcome::Pass, text);
    }
    std::string text =
        suite.difference + Format("; %zu of %zu texels differ; ", suite.differentTexels, suite.texels);
    text += suite.cause.empty() ? "covers: " + suiteCase.about : "looks like: " + suite.cause;
    Finish(result, Outcome::Fail, text);
}

void SuiteRunner::RequireInside(const SuiteCase& suiteCase, const std::vector<ValueRecord>& records,
                                const std::string& path) const {
    const std::span<const ColorMip> mips = set_->metadata.GetColorMips();
    const bool isOneMip = suiteCase.wholeMip || (suiteCase.slice && suiteCase.sliceMip < 0);
    if (suiteCase.slice) {
        const int first = suiteCase.GetSliceMip(records.front().texel.mip);
        if (first < 0 || first >= static_cast<int>(mips.size()) ||
            suiteCase.sliceMips > static_cast<int>(mips.size()) - first)
            throw CommandError(ExitCode::BadInput, path, "slice: mips outside the set");
        const ColorMip& size = mips[static_cast<std::size_t>(first)];
        if (suiteCase.slice->width > size.width - suiteCase.slice->left ||
            suiteCase.slice->height > size.height - suiteCase.slice->top)
            throw CommandError(ExitCode::BadInput, path, "slice: outside the mip");
    }
    for (const ValueRecord& record : records) {
        const tool::Texel& texel = record.texel;
        if (texel.mip < 0 || texel.mip >= static_cast<int>(mips.size()))
            throw CommandError(ExitCode::BadInput, path, "mip: the set has none of this number");
        if (isOneMip && texel.mip != records.front().texel.mip)
            throw CommandError(ExitCode::BadInput, path, "texel: of another mip");
        const ColorMip& size = mips[static_cast<std::size_t>(texel.mip)];
        Rect rect{0, 0, size.width, size.height};
        if (suiteCase.slice) {
            const int level = texel.mip - suiteCase.GetSliceMip(texel.mip);
            if (level < 0 || level >= suiteCase.sliceMips)
                throw CommandError(ExitCode::BadInput, path, "texel: of a mip that the slice has not");
            rect = GetSlicePart(*suiteCase.slice, level, size.width, size.height);
        }
        const bool isInside = texel.x >= rect.left && texel.y >= rect.top &&
                              texel.x - rect.left < rect.width && texel.y - rect.top < rect.height;
        const bool isNear = texel.x >= -kMaxDecodeTexel && texel.x < kMaxDecodeTexel &&
                            texel.y >= -kMaxDecodeTexel && texel.y < kMaxDecodeTexel;
        if (suiteCase.outside ? !isNear : !isInside)
            throw CommandError(ExitCode::BadInput, path, "texel: outside the image or the slice");
    }
}

} // namespace openntc::conformance
