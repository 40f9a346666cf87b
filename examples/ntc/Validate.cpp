// SPDX-License-Identifier: MIT
// `ntc validate`: numbered findings.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Findings.h"
#include "Json.h"
#include "Output.h"

#include <algorithm>
#include <cstdio>
#include <memory>

namespace openntc::tool {

namespace {

struct ValidateOptions {
    std::vector<std::string> files;
    bool json = false;
};

bool IsUsable(const std::vector<Finding>& findings) {
    return std::none_of(findings.begin(), findings.end(),
                        [](const Finding& finding) { return finding.severity == Severity::Error; });
}

void PrintText(const std::string& file, const std::vector<Finding>& findings) {
    const std::string name = Printable(file);
    for (const Finding& finding : findings) {
        if (finding.severity != Severity::Error) // those end the command, on standard error
            WriteOutput(Format("%s: %s %d: %s\n", name.c_str(), GetName(finding.severity), finding.number,
                               finding.text.c_str()));
    }
    WriteOutput(Format("%s: %s\n", name.c_str(), IsUsable(findings) ? "valid" : "must not be used"));
}

void WriteJson(JsonWriter& json, const std::string& file, const std::vector<Finding>& findings) {
    json.BeginObject();
    json.Member("file", std::string_view(file));
    json.Member("usable", IsUsable(findings));
    json.Key("findings");
    json.BeginArray();
    for (const Finding& finding : findings) {
        json.BeginObject();
        json.Member("number", finding.number);
        json.Member("severity", GetName(finding.severity));
        json.Member("text", std::string_view(finding.text));
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
}

int RunValidate(const ValidateOptions& options) {
    CheckOneStandardInput(options.files);
    JsonWriter json;
    json.BeginObject();
    json.Key("files");
    json.BeginArray();
    std::vector<CommandError> errors;
    for (const std::string& file : options.files) {
        std::vector<Finding> findings;
        try {
            findings = FindProblems(file);
        } catch (const CommandError& error) {
            findings = {{1000, Severity::Error, error.what()}};
        }
        for (const Finding& finding : findings) {
            if (finding.severity == Severity::Error)
                errors.emplace_back(ExitCode::BadInput, file,
                                    Format("error %d: ", finding.number) + finding.text);
        }
        options.json ? WriteJson(json, file, findings) : PrintText(file, findings);
    }
    json.EndArray();
    json.EndObject();
    if (options.json)
        WriteOutput(json.Take());
    FinishOutput();
    for (const CommandError& error : errors)
        std::fprintf(stderr, "%s\n", error.GetLine().c_str());
    return static_cast<int>(errors.empty() ? ExitCode::Ok : ExitCode::BadInput);
}

} // namespace

void AddValidateCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<ValidateOptions>();
    CLI::App* command =
        app.add_subcommand("validate", "Numbered findings; exit 3 when a file must not be used");
    AddFilesArgument(*command, options->files);
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunValidate(*options); }; });
}

} // namespace openntc::tool
