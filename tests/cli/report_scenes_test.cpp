// SPDX-License-Identifier: MIT
// `ntc report --cases scene`: what the renderer draws, in one table; what is skipped is counted.
#ifdef RENDERER_PROGRAM
#include "cli/Program.h"

#include <rapidjson/prettywriter.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

using namespace openntc_tests;

namespace {

constexpr const char* kReport = " --device llvmpipe --cache cache --steps 40 --size 32x18 --json ";

ProgramResult RunSceneReport(const Folder& folder, const std::string& arguments, bool isQuick = true) {
    // lavapipe without LLVM's optimisations
    std::string command = "--version >/dev/null; GALLIVM_PERF=nopt '" NTC_PROGRAM "' report";
    command += isQuick ? " --quick" : "";
    return RunProgram(folder, command + kReport + arguments);
}

std::string WriteJson(const rapidjson::Document& document) {
    rapidjson::StringBuffer buffer;
    rapidjson::PrettyWriter<rapidjson::StringBuffer> writer(buffer);
    document.Accept(writer);
    return {buffer.GetString(), buffer.GetSize()};
}

double GetKind(const rapidjson::Value& record, const std::string& kind) {
    for (const auto& entry : record["bytes"].GetArray()) {
        if (entry["kind"].GetString() == kind)
            return entry["bytes"].GetDouble();
    }
    return 0;
}

std::set<std::string> GetEffects(const rapidjson::Value& record) {
    std::set<std::string> effects;
    for (const auto& effect : record["effectsOn"].GetArray()) {
        const std::string name = effect.GetString();
        if (!name.starts_with("decoder") && !name.starts_with("filter")) // which no scene calls for
            effects.insert(name);
    }
    return effects;
}

void SetSceneTimes(rapidjson::Value& record, double milliseconds) {
    for (const char* member : {"median", "lowerQuartile", "upperQuartile", "minimum", "maximum"})
        record["millisecondsAFrame"][member].SetDouble(milliseconds);
}

/// Rows of the table of deliveries that are on the front, by their page.
std::size_t CountFront(const Folder& folder, const rapidjson::Document& report) {
    WriteText(folder / "edited.json", WriteJson(report));
    REQUIRE(RunProgram(folder, "report -o edited --from edited.json").code == 0);
    const std::string page = ReadText(folder / "edited/report.html");
    std::size_t count = 0;
    for (std::size_t at = page.find("<h2 id=scenes>");
         (at = page.find("<td class=text>yes</td>", at)) != std::string::npos; ++at)
        ++count;
    return count;
}

} // namespace

TEST_CASE("a small report of scenes: deliveries against the reference, and effects that a scene calls for") {
    const Folder folder;
    const ProgramResult made =
        RunSceneReport(folder, "-o out --cases 'scene sample reference' --cases 'scene sample on-sample' "
                               "--cases 'scene everything'");
    if (made.code == 4) {
        MESSAGE("SKIP: ntc-renderer on lavapipe: ", made.errors);
        return;
    }
    INFO(made.errors);
    REQUIRE(made.code == 0);
    const auto output = ParseValid(made.output, "report-output");
    CHECK(output["measured"].GetInt() == 5);
    CHECK(output["skipped"].GetInt() == 0);
    auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    std::map<std::string, const rapidjson::Value*> records;
    for (const auto& record : report["scenes"].GetArray()) {
        CAPTURE(record["id"].GetString());
        records[record["id"].GetString()] = &record;
        CHECK(record["skipped"].GetStringLength() == 0);
        CHECK(record["millisecondsAFrame"]["minimum"].GetDouble() > 0);
        CHECK(record["width"].GetInt() == 32);
        CHECK(record["permutations"].GetInt() > 0);
        double sum = 0; // "textures" is that of all kinds but geometry and targets
        for (const auto& entry : record["bytes"].GetArray())
            sum += entry["bytes"].GetDouble();
        for (const char* kind : {"textures", "geometry", "targets"})
            sum -= GetKind(record, kind);
        CHECK(GetKind(record, "textures") == sum);
    }
    const auto& reference = *records.at("scene sample reference trilinear off");
    CHECK(std::string(reference["psnr"].GetString()) == "inf");
    CHECK(reference["flip"].GetDouble() == 0);
    CHECK(reference["texelsDecoded"].GetDouble() == 0);
    for (const std::string scene : {"sample", "everything"}) {
        CAPTURE(scene);
        const std::string id = "scene " + scene + " on-sample trilinear one-tap int8";
        const auto &derived = *records.at(id), &all = *records.at(id + " effects all");
        CHECK(derived["psnr"].GetDouble() > 15);
        CHECK(derived["flip"].GetDouble() > 0);
        CHECK(derived["texelsDecoded"].GetDouble() > 0);
        CHECK(derived["texelsDecoded"].GetDouble() == derived["texelsRead"].GetDouble());
        CHECK(GetKind(derived, "textures") < GetKind(reference, "textures"));
        // The same picture, whatever is on without being called for.
        CHECK(all["otherPixels"].GetInt() == 0);
        CHECK(all["psnr"].GetDouble() == derived["psnr"].GetDouble());
        CHECK(all["texelsDecoded"].GetDouble() == derived["texelsDecoded"].GetDouble());
        const std::set<std::string> called = GetEffects(derived), forced = GetEffects(all);
        CHECK(std::includes(forced.begin(), forced.end(), called.begin(), called.end()));
        // Only a scene that does not call for everything pays for what it does not call for.
        const bool callsForAll = scene == "everything";
        CHECK((called == forced) == callsForAll);
        CHECK((called.count("transmission") == 1) == callsForAll);
        CHECK((all["texelsRead"].GetDouble() == derived["texelsRead"].GetDouble()) == callsForAll);
    }

    const std::string page = ReadText(folder / "out/report.html");
    CHECK(page.find("<h2 id=scenes>") != std::string::npos);
    CHECK(page.find("<title>Scene sample, 32 x 18") != std::string::npos);
    CHECK(page.find("<h3 id=effects>") != std::string::npos);
    CHECK(page.find("the same bits") != std::string::npos);

    // The front: as exact, as fast, as small, and better in one.
    rapidjson::Value *first = nullptr, *second = nullptr;
    for (auto& record : report["scenes"].GetArray()) {
        if (record["id"] == "scene sample reference trilinear off")
            first = &record;
        else if (record["id"] == "scene sample on-sample trilinear one-tap int8")
            second = &record;
    }
    SetSceneTimes(*first, 1);
    SetSceneTimes(*second, 2);
    CHECK(CountFront(folder, report) == 2); // the second is smaller
    for (auto& entry : (*second)["bytes"].GetArray())
        entry["bytes"].SetUint64(1u << 30);
    CHECK(CountFront(folder, report) == 1);
    SetSceneTimes(*second, 0.5);
    CHECK(CountFront(folder, report) == 2); // faster
    (*second)["psnr"].SetString("inf", 3);
    SetSceneTimes(*second, 1);
    CHECK(CountFront(folder, report) == 1); // as fast and as exact, and larger

    report.RemoveMember("scenes"); // files of before
    CHECK(CountFront(folder, report) == 0);
}

TEST_CASE("a small report of scenes: a maths mode that no texture set serves is no row") {
    const Folder folder;
    const ProgramResult made =
        RunSceneReport(folder, "-o out --cases 'scene sample on-sample trilinear off fp8'", false);
    if (made.code == 4) {
        MESSAGE("SKIP: ntc-renderer on lavapipe: ", made.errors);
        return;
    }
    INFO(made.errors);
    REQUIRE(made.code == 0);
    const auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    REQUIRE(report["scenes"].Size() == 1);
    const std::string skipped = report["scenes"][0]["skipped"].GetString();
    CHECK(skipped == "fp8: no texture set has FP8 weights");
}

TEST_CASE("a report of scenes that is cancelled keeps what it measured, and says first what it cannot make") {
    const Folder folder;
    // Stopped once two scenes are drawn, whatever the machine's speed; no gnuplot in its PATH.
    const ProgramResult result = RunProgram(
        folder, "--version >/dev/null; GALLIVM_PERF=nopt PATH=/nonexistent '" NTC_PROGRAM "' report" +
                    std::string(kReport) +
                    "--cases 'scene sample reference' -o out 2>progress & work=$!; "
                    "until grep -q '\"report\",\"done\":2' progress || ! kill -0 $work; do sleep 0.1; done; "
                    "kill -TERM $work; wait $work; code=$?; cat progress >&2; exit $code");
    CHECK(result.code == 1);
    CHECK(result.errors.find("only report.json will be made") < result.errors.find("\"done\":1"));
    CHECK(result.errors.find("out/report.json has what was measured before") != std::string::npos);
    const rapidjson::Document report = ParseValid(ReadText(folder / "out/report.json"), "report");
    CHECK(report["cancelled"].GetBool());
    CHECK(report["scenes"].Size() >= 2);
    CHECK(report["scenes"].Size() < 9); // references with each filter, and with each way to draw
    for (const rapidjson::Value& scene : report["scenes"].GetArray())
        CHECK(scene["millisecondsAFrame"]["median"].GetDouble() > 0);
    REQUIRE(RunProgram(folder, "report -o page --from out/report.json").code == 0);
    CHECK(ReadText(folder / "page/report.html").find("cancelled before its end") != std::string::npos);
}

TEST_CASE("a report of scenes says and counts what was not drawn") {
    const Folder folder;
    const std::string cases = "--cases 'scene sample reference' ";
    const ProgramResult missing = RunSceneReport(folder, cases + "-o out --renderer nowhere/ntc-renderer");
    if (missing.code == 4) {
        MESSAGE("SKIP: no lavapipe: ", missing.errors);
        return;
    }
    INFO(missing.errors);
    REQUIRE(missing.code == 0);
    CHECK(ParseValid(missing.output, "report-output")["skipped"].GetInt() == 1);
    const auto report = ParseValid(ReadText(folder / "out/report.json"), "report");
    CHECK(std::string(report["scenes"][0]["skipped"].GetString()).find("nowhere/ntc-renderer: ") == 0);
    CHECK(ReadText(folder / "out/report.html").find("Not drawn here: 1") != std::string::npos);
    // What the program refuses is told in its words.
    WriteText(folder / "renderer.sh", "#!/bin/sh\necho 'ntc-renderer: --mode: it has none' >&2\nexit 2\n");
    fs::permissions(folder / "renderer.sh", fs::perms::owner_all);
    REQUIRE(RunSceneReport(folder, cases + "-o refused --renderer ./renderer.sh").code == 0);
    const auto refused = ParseValid(ReadText(folder / "refused/report.json"), "report");
    CHECK(std::string(refused["scenes"][0]["skipped"].GetString()) == "ntc-renderer: --mode: it has none");
    CheckFails(RunProgram(folder, "report -o out --size 0x3"), 2);
    CheckFails(RunProgram(folder, "report -o out --size 3"), 2);
}
#endif
