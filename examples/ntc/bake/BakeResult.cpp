// SPDX-License-Identifier: MIT
#include "bake/BakeResult.h"

#include "Interrupt.h"
#include "Json.h"
#include "Output.h"

#include <algorithm>

namespace openntc::tool {

namespace {

std::size_t Count(std::span<const BakeOutcome> outcomes, BakeStatus status) {
    return static_cast<std::size_t>(
        std::count_if(outcomes.begin(), outcomes.end(),
                      [&](const BakeOutcome& outcome) { return outcome.status == status; }));
}

void PrintText(const BakeOptions& options, std::span<const BakeOutcome> outcomes,
               std::span<const BakeRecord> vanished) {
    for (const BakeOutcome& outcome : outcomes) {
        if (outcome.status == BakeStatus::Due)
            WriteOutput(Printable(outcome.name) + ".ntc: to make (" + Printable(outcome.reason) + ")\n");
    }
    for (const BakeRecord& record : vanished)
        WriteOutput(Printable(record.name) + ".ntc: its sources are gone" +
                    (options.prunes && !options.isDryRun ? ": removed\n" : ": kept; --prune removes it\n"));
    if (options.quiet && options.IsPart())
        return; // ninja shows what a command says
    std::string text = Format("%zu material%s: %zu unchanged", outcomes.size(),
                              outcomes.size() == 1 ? "" : "s", Count(outcomes, BakeStatus::Unchanged));
    for (const BakeStatus status :
         {BakeStatus::Made, BakeStatus::Due, BakeStatus::Interrupted, BakeStatus::Failed}) {
        if (Count(outcomes, status) > 0)
            text += Format(", %zu %s", Count(outcomes, status), GetName(status));
    }
    WriteOutput(text + "\n");
}

void WriteOutcome(JsonWriter& json, const BakeOutcome& outcome) {
    json.BeginObject();
    json.Member("material", std::string_view(outcome.name));
    json.Member("file", std::string_view(outcome.name + ".ntc"));
    json.Member("status", std::string_view(GetName(outcome.status)));
    if (!outcome.reason.empty())
        json.Member("reason", std::string_view(outcome.reason));
    if (!outcome.error.empty())
        json.Member("error", std::string_view(outcome.error));
    if (outcome.record) {
        json.Member("bytes", outcome.record->output.bytes);
        json.Member("psnr", outcome.record->psnr);
        json.Member("bitsPerPixel", outcome.record->bitsPerPixel);
        json.Member("steps", outcome.record->steps);
        json.Member("kernel", std::string_view(outcome.record->kernel));
    }
    json.EndObject();
}

void PrintJson(const BakeOptions& options, std::span<const BakeOutcome> outcomes,
               std::span<const BakeRecord> vanished) {
    JsonWriter json;
    json.BeginObject();
    json.Member("folder", std::string_view(options.folder));
    json.Key("materials");
    json.BeginArray();
    for (const BakeOutcome& outcome : outcomes)
        WriteOutcome(json, outcome);
    json.EndArray();
    json.Key("vanished");
    json.BeginArray();
    for (const BakeRecord& record : vanished) {
        json.BeginObject();
        json.Member("material", std::string_view(record.name));
        json.Member("file", std::string_view(record.name + ".ntc"));
        json.Member("removed", options.prunes && !options.isDryRun);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    WriteOutput(json.Take());
}

} // namespace

const char* GetName(BakeStatus status) {
    switch (status) {
    case BakeStatus::Unchanged:
        return "unchanged";
    case BakeStatus::Due:
        return "due";
    case BakeStatus::Made:
        return "made";
    case BakeStatus::Failed:
        return "failed";
    case BakeStatus::Interrupted:
        return "interrupted";
    }
    return "";
}

int PrintResult(const BakeOptions& options, std::span<const BakeOutcome> outcomes,
                std::span<const BakeRecord> vanished) {
    if (options.json)
        PrintJson(options, outcomes, vanished);
    else
        PrintText(options, outcomes, vanished);
    FinishOutput();
    for (const BakeOutcome& outcome : outcomes) {
        if (outcome.status == BakeStatus::Failed)
            std::fprintf(stderr, "ntc: %s\n", outcome.error.c_str());
    }
    if (IsInterrupted())
        std::fprintf(stderr,
                     "ntc: %s: interrupted: finished files and states are kept: the same command goes on\n",
                     Printable(options.folder).c_str());
    return static_cast<int>(IsInterrupted() || Count(outcomes, BakeStatus::Failed) > 0 ? ExitCode::Failed
                                                                                       : ExitCode::Ok);
}

} // namespace openntc::tool
