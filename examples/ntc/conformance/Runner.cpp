// SPDX-License-Identifier: MIT
#include "Runner.h"

#include "../Failure.h"
#include "../Interrupt.h"
#include "../Output.h"

#include <algorithm>
#include <filesystem>
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
        throw CommandError(ExitCode::BadInput, folder, "folder: cannot be read");
    return names;
}

// True for the library's message about a schemaVersion of the generations that this version does not read.
bool IsOtherGeneration(std::string_view text) {
    return text.starts_with("schemaVersion: 2:") || text.starts_with("schemaVersion: 3:");
}

class Case {
public:
    Case(const fs::path& base, const std::string& name, const tool::BackendOptions& backend)
        : base_(base), backend_(backend) {
        result_.name = name;
    }

    CaseResult Run() {
        try {
            RunChecks();
        } catch (const CommandError& error) {
            if (error.GetCode() == ExitCode::NoDevice || tool::IsInterrupted())
                throw;
            Finish(Outcome::Fail, fs::path(error.GetSubject()).filename().string() + ": " + error.what());
        }
        result_.reason = tool::Printable(result_.reason);
        return result_;
    }

private:
    std::string GetPath(std::string_view suffix) const { return base_.string() + std::string(suffix); }
    bool Exists(std::string_view suffix) const {
        std::error_code error;
        return fs::exists(GetPath(suffix), error);
    }
    void Finish(Outcome outcome, const std::string& reason) {
        result_.outcome = outcome;
        result_.reason = reason;
    }

    void RunChecks() {
        if (!Exists(".ntc"))
            return Finish(Outcome::Skip, "no .ntc file of this name");
        if (!Exists(".expect.json") && !Exists(".texels"))
            return Finish(Outcome::Skip, "nothing is expected of it: no .expect.json or .texels");
        tool::Input input(GetPath(".ntc"));
        Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(input.GetStream());
        if (!metadata) {
            const char* text = metadata.error().GetText();
            return Finish(IsOtherGeneration(text) ? Outcome::Skip : Outcome::Fail, text);
        }
        tool::TextureSet set{std::move(input), std::move(*metadata)};

        if (Exists(".expect.json")) {
            const std::string path = GetPath(".expect.json");
            const Expectations expectations =
                tool::Require(ReadExpectations(tool::ReadAll(path)), ExitCode::BadInput, path);
            result_.metadata = CheckMetadata(expectations, set.metadata);
        }
        if (Exists(".texels"))
            RunTexels(set);

        if (!result_.metadata.difference.empty())
            Finish(Outcome::Fail, result_.metadata.difference);
        else if (!result_.texels.difference.empty())
            Finish(Outcome::Fail, result_.texels.difference);
        else
            Finish(Outcome::Pass, Summarise());
    }

    void RunTexels(tool::TextureSet& set) {
        const std::string path = GetPath(".texels");
        const std::vector<TexelRecord> records =
            tool::Require(ReadTexels(tool::ReadAll(path)), ExitCode::BadInput, path);
        const tool::DecodeData data = tool::LoadDecodeData(set);
        const std::unique_ptr<tool::Decoder> decoder = tool::RequireDecoder(path, data, backend_);
        result_.device = decoder->GetDeviceName();
        const Arithmetic arithmetic =
            backend_.backend == tool::Backend::Vulkan ? Arithmetic::Vulkan : Arithmetic::Host;
        result_.texels = CheckTexels(records, set.metadata, *decoder, arithmetic, path);
    }

    std::string Summarise() const {
        const MetadataResult& metadata = result_.metadata;
        const TexelResult& texels = result_.texels;
        std::string text = Format(
            "%d fields; %d fused mips; %d stream ranges; %d constants; %d weight buffers", metadata.fields,
            metadata.fusedMips, metadata.streamRanges, metadata.constants, metadata.weights);
        text += Format("; %zu texels exact in int8 and int8_half", texels.exact);
        text += Format("; linear within %.2f of its bound", texels.worstLinearRatio);
        if (texels.psnr)
            text += Format("; PSNR %.4f dB (exact block %.4f dB)", *texels.psnr, *texels.psnrExact);
        return text;
    }

    fs::path base_;
    const tool::BackendOptions& backend_;
    CaseResult result_;
};

} // namespace

const char* GetName(Outcome outcome) {
    return outcome == Outcome::Pass ? "PASS" : outcome == Outcome::Fail ? "FAIL" : "SKIP";
}

double CaseResult::GetWorstError() const {
    return std::max(texels.worstFloat, texels.worstHalf);
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

Totals RunFolder(const std::string& folder, const tool::BackendOptions& backend,
                 const std::function<void(const CaseResult&)>& report) {
    Totals totals;
    for (const std::string& name : FindNames(folder)) {
        tool::ThrowIfInterrupted();
        const CaseResult result = Case(fs::path(folder) / name, name, backend).Run();
        totals.Add(result.outcome);
        report(result);
    }
    return totals;
}

} // namespace openntc::conformance
