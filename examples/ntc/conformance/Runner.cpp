// SPDX-License-Identifier: MIT
#include "Runner.h"

#include "BlockRunner.h"
#include "FilterRunner.h"
#include "GuardedCase.h"
#include "SuiteRunner.h"
#include "TextureRunner.h"

#include "../Failure.h"
#include "../Interrupt.h"
#include "../Output.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>
#include <set>

namespace openntc::conformance {

namespace fs = std::filesystem;

namespace {

using tool::CommandError;
using tool::ExitCode;
using tool::Format;

constexpr std::string_view kSuffixes[] = {".ntc", ".expect.json", ".texels"};

std::set<std::string> FindNames(const std::string& folder) {
    std::error_code error;
    std::set<std::string> names;
    fs::directory_iterator entry(folder, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        const std::string file = entry->path().filename().string();
        for (const std::string_view suffix : kSuffixes) {
            if (file.size() > suffix.size() && file.ends_with(suffix))
                names.insert(file.substr(0, file.size() - suffix.size()));
        }
    }
    if (error)
        throw CommandError(ExitCode::BadInput, folder, "folder: cannot be read: " + error.message());
    return names;
}

// NAME.ntc with NAME.expect.json or NAME.texels.
class Case {
public:
    Case(const fs::path& base, const std::string& name, Subject& subject) : base_(base), subject_(subject) {
        result_.name = name;
        result_.about = "what the loader makes of a set";
    }

    CaseResult Run() {
        RunGuarded(result_, subject_, [this] { RunChecks(); });
        return result_;
    }

private:
    std::string GetPath(std::string_view suffix) const { return base_.string() + std::string(suffix); }
    bool Exists(std::string_view suffix) const {
        std::error_code error;
        return fs::exists(GetPath(suffix), error);
    }

    void RunChecks() {
        if (!Exists(".ntc"))
            return Finish(result_, Outcome::Skip, "no .ntc file of this name");
        if (!Exists(".expect.json") && !Exists(".texels"))
            return Finish(result_, Outcome::Skip, "nothing is expected of it: no .expect.json or .texels");
        tool::Input input(GetPath(".ntc"));
        Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(input.GetStream());
        if (!metadata)
            return Finish(result_, Outcome::Fail, metadata.error().GetText());
        if (metadata->GetGeneration() > 1)
            return Finish(result_, Outcome::Skip, "of a later generation than the adapter decodes");
        if (Exists(".expect.json") && subject_.UsesOurLoader()) {
            const std::string path = GetPath(".expect.json");
            const Expectations expectations =
                tool::Require(ReadExpectations(tool::ReadAll(path)), ExitCode::BadInput, path);
            result_.metadata = CheckMetadata(expectations, *metadata);
        }
        if (Exists(".texels"))
            RunTexels(*metadata);

        if (!result_.metadata.difference.empty())
            Finish(result_, Outcome::Fail, result_.metadata.difference);
        else if (!result_.texels.difference.empty())
            Finish(result_, Outcome::Fail, result_.texels.difference);
        else
            Finish(result_, Outcome::Pass, Summarise());
    }

    void RunTexels(const TextureSetMetadata& metadata) {
        const std::string path = GetPath(".texels");
        const std::vector<TexelRecord> records =
            tool::Require(ReadTexels(tool::ReadAll(path)), ExitCode::BadInput, path);
        subject_.Open(GetPath(".ntc"));
        result_.texels = CheckTexels(records, metadata, subject_);
    }

    std::string Summarise() const {
        const MetadataResult& metadata = result_.metadata;
        const TexelResult& texels = result_.texels;
        std::string text = Format(
            "%d fields; %d fused mips; %d stream ranges; %d constants; %d weight buffers", metadata.fields,
            metadata.fusedMips, metadata.streamRanges, metadata.constants, metadata.weights);
        if (!Exists(".texels"))
            return text;
        text += Format("; %zu texels exact in int8 and int8_half", texels.exact);
        text += Format("; linear within %.2f of its bound", texels.worstLinearRatio);
        if (texels.psnr)
            text += Format("; PSNR %.4f dB (exact block %.4f dB)", *texels.psnr, *texels.psnrExact);
        return text;
    }

    fs::path base_;
    Subject& subject_;
    CaseResult result_;
};

} // namespace

const char* GetName(Outcome outcome) {
    return outcome == Outcome::Pass ? "PASS" : outcome == Outcome::Fail ? "FAIL" : "SKIP";
}

double CaseResult::GetWorstError() const {
    return std::max({texels.worstFloat, texels.worstHalf, suite.worst});
}

std::string CaseResult::GetLine() const {
    std::string line = std::string(GetName(outcome)) + " " + tool::Printable(name) + ": " + reason;
    if (outcome != Outcome::Skip)
        line += Format(", worst error %.9g", GetWorstError());
    return line;
}

void Totals::Add(Outcome outcome) {
    ++(outcome == Outcome::Pass ? passed : outcome == Outcome::Fail ? failed : skipped);
}

std::string Totals::GetLine() const {
    return Format("total: %d passed, %d failed, %d skipped", passed, failed, skipped);
}

Totals RunFolder(const std::string& folder, Subject& subject, bool mustPassOnly,
                 const std::function<void(const CaseResult&)>& report) {
    Totals totals;
    std::set<std::string> names = FindNames(folder);
    const auto add = [&](const CaseResult& result) {
        totals.Add(result.outcome);
        report(result);
    };
    const fs::path suitePath = fs::path(folder) / kSuiteFile;
    std::error_code ignored;
    if (fs::exists(suitePath, ignored)) {
        const std::vector<std::byte> json = tool::ReadAll(suitePath.string());
        const auto require = [&](auto read) {
            return tool::Require(std::move(read), ExitCode::BadInput, suitePath.string());
        };
        const std::vector<SuiteCase> cases = require(ReadSuite(json));
        std::set<std::string> sets;
        for (const SuiteCase& suiteCase : cases) {
            const std::string stem = fs::path(suiteCase.set).stem().string();
            if (!fs::exists(fs::path(folder) / (stem + ".texels"), ignored)) {
                names.erase(stem);
                sets.insert(stem);
            }
        }
        const SuiteParts parts{require(ReadBlockCases(json)), require(ReadTextureCases(json)),
                               require(ReadFilterCases(json))};
        SuiteRunner(folder, subject, mustPassOnly).Run(cases, add);
        RunBlockCases(folder, parts.blocks, subject, mustPassOnly, add);
        RunTextureCases(folder, parts.textures, subject, mustPassOnly, add);
        RunFilterCases(folder, parts.filtering, subject, mustPassOnly, add);
        // Adapters have no functions for metadata.
        for (const std::string& stem : sets) {
            const fs::path base = fs::path(folder) / stem;
            if (subject.UsesOurLoader() && fs::exists(base.string() + ".expect.json", ignored))
                add(Case(base, stem + "-metadata", subject).Run());
        }
    }
    if (names.empty() && totals.passed + totals.failed + totals.skipped == 0)
        throw CommandError(
            ExitCode::BadInput, folder,
            "folder: holds no vectors: no suite.json, and no NAME.ntc with NAME.expect.json or "
            "NAME.texels");
    for (const std::string& name : names) {
        tool::ThrowIfInterrupted();
        add(Case(fs::path(folder) / name, name, subject).Run());
    }
    return totals;
}

Totals RunFolder(const std::string& folder, const tool::BackendOptions& backend,
                 const std::function<void(const CaseResult&)>& report) {
    return RunFolder(folder, *MakeBackendSubject(backend), false, report);
}

} // namespace openntc::conformance
