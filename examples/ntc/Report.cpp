// SPDX-License-Identifier: MIT
// `ntc report`: what accuracy costs in time.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "encode/StateFile.h"
#include "report/Changes.h"
#include "report/Charts.h"
#include "report/Encodings.h"
#include "report/Html.h"
#include "report/Measure.h"
#include "report/ReportJson.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

struct Options {
    std::string output;
    std::string from;
    std::string old;
    std::string hardCases;
    std::string cache;
    std::string chart;
    report::MeasureSettings measure;
};

void WriteText(const fs::path& path, const std::string& text) {
    WriteWholeFile(path.string(), {std::as_bytes(std::span(text))});
}

std::string MakeJson(const report::ReportRecord& report, const std::vector<fs::path>& files) {
    std::uint64_t measured = 0, changed = 0, accuracy = 0;
    for (const report::CaseRecord& c : report.cases)
        measured += c.skipped.empty();
    for (const report::SceneRecord& scene : report.scenes)
        measured += scene.skipped.empty();
    for (const report::ChangeRecord& c : report.changes) {
        changed += c.changed;
        accuracy += c.accuracyChanged;
    }
    JsonWriter json;
    json.BeginObject();
    json.Key("files");
    json.BeginArray();
    for (const fs::path& file : files)
        json.Value(std::string_view(file.string()));
    json.EndArray();
    json.Member("measured", measured);
    json.Member("skipped", static_cast<std::uint64_t>(report.cases.size() + report.scenes.size()) - measured);
    json.Member("seconds", report.seconds);
    json.Member("cacheFilled", report.cacheFilled);
    json.Member("cacheSeconds", report.cacheSeconds);
    json.Member("timesChanged", changed);
    json.Member("accuracyChanged", accuracy);
    json.EndObject();
    return json.Take();
}

/// The model of the tests' shared data, or nothing.
std::string FindSharedModel() {
    const char* shared = std::getenv("OPENNTC_SHARED_DIR");
    std::error_code ignored;
    const fs::path model = fs::path(shared != nullptr ? shared : "") / "assets" / "FlightHelmet";
    return shared != nullptr && fs::is_directory(model, ignored) ? model.string() : "";
}

int RunReport(Options options) {
    report::ReportRecord old;
    if (!options.old.empty())
        old = report::ReadReport(options.old); // before minutes of work
    std::vector<report::HardCaseRecord> hardCases;
    if (!options.hardCases.empty())
        hardCases = report::ReadHardCases(options.hardCases);

    OutputFolder folder(options.output);
    report::ReportRecord report;
    if (!options.from.empty()) {
        report = report::ReadReport(options.from);
    } else {
        options.measure.cache =
            options.cache.empty() ? report::GetDefaultCache(options.output) : fs::path(options.cache);
        if (options.measure.model.empty() && !options.measure.quick)
            options.measure.model = FindSharedModel();
        if (!report::CanDrawCharts())
            std::fputs("report: no gnuplot (Debian: gnuplot-nox): only report.json will be made\n", stderr);
        options.measure.scratch = fs::path(options.output) / ".ntc-picture.tmp";
        report = report::Measure(options.measure);
        report.tool = "ntc report";
    }
    if (!hardCases.empty())
        report.hardCases = std::move(hardCases);
    if (!options.old.empty())
        report::CompareReports(old, report);
    // The numbers first: they are good without gnuplot too.
    WriteText(fs::path(options.output) / "report.json", report::WriteReport(report));
    std::vector<fs::path> files = {fs::path(options.output) / "report.json"};
    if (report.cancelled && options.from.empty())
        throw CommandError(ExitCode::Failed, "cancelled",
                           files.front().string() + " has what was measured before; --from makes its page");

    const std::unique_ptr<OutputFolder> scratch =
        std::make_unique<OutputFolder>(fs::path(options.output) / ".charts");
    const std::vector<report::Chart> charts =
        report::DrawCharts(report, scratch->Stage("charts").parent_path());
    WriteText(folder.Stage("report.html"), report::WriteHtml(report, charts));
    if (!options.chart.empty() && !charts.empty())
        WriteText(options.chart, charts.front().svg);
    const std::vector<fs::path> committed = folder.Commit();
    files.insert(files.end(), committed.begin(), committed.end());
    if (options.measure.json) {
        WriteOutput(MakeJson(report, files));
        return 0;
    }
    if (!options.old.empty())
        WriteOutput(report::DescribeChanges(report));
    for (const fs::path& file : files)
        WriteOutput(file.string() + "\n");
    return 0;
}

void AddSceneOptions(CLI::App& command, report::SceneSettings& scenes) {
    scenes.renderer = report::FindRenderer();
    command
        .add_option("--renderer", scenes.renderer, "The program ntc-renderer (default: the one beside this)")
        ->type_name("FILE");
    command
        .add_option("--scene", scenes.model,
                    "A glTF model with texture sets to draw (default: the renderer's sample scene)")
        ->type_name("FILE");
    command.add_option("--material-dir", scenes.materialDir, "Its texture sets (default: beside it)")
        ->type_name("DIR");
    command
        .add_option_function<std::string>(
            "--size",
            [&scenes](const std::string& text) {
                const std::size_t cross = std::min(text.find('x'), text.size());
                scenes.width =
                    static_cast<int>(ParseNumber("--size", text.substr(0, cross), {1, 16384}, true));
                scenes.height = static_cast<int>(
                    ParseNumber("--size", text.substr(std::min(cross + 1, text.size())), {1, 16384}, true));
            },
            "Of drawn scenes (default: 1920x1080 on a GPU, else small)")
        ->type_name("WIDTHxHEIGHT");
}

// The source tree that this program was built from; once installed without it, <prefix>/share/openntc.
std::string FindSources() {
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    const fs::path installed = program.parent_path().parent_path() / "share" / "openntc";
    return fs::is_directory(OPENNTC_SOURCE_DIR, error) || !fs::is_directory(installed, error)
               ? OPENNTC_SOURCE_DIR
               : installed.string();
}

} // namespace

void AddReportCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<Options>();
    report::MeasureSettings& measure = options->measure;
    measure.sources = FindSources();
    CLI::App* command =
        app.add_subcommand("report", "What accuracy costs in time: measurements, charts, pictures");
    command->add_option("-o,--output", options->output, "Folder for report.json and report.html")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("DIR");
    command->add_flag("--quick", measure.quick, "Fewer cases and repeats");
    command
        ->add_option(
            "--device", measure.devices,
            "cpu, or part of a Vulkan device's name; may be repeated (default: a Vulkan device and cpu)")
        ->type_name("D");
    command->add_option("--cases", measure.filters, "Only cases with this in their name; may be repeated")
        ->type_name("TEXT");
    command->add_option("--compare", options->old, "An older report.json: what changed, and is it noise?")
        ->type_name("FILE");
    command->add_option("--from", options->from, "Make the page of this report.json; nothing is measured")
        ->type_name("FILE");
    command
        ->add_option("--hard-cases", options->hardCases,
                     "Worst errors that the numerics test wrote, for the page")
        ->type_name("FILE");
    command
        ->add_option("--chart", options->chart, "Write the accuracy/time chart of the first device there too")
        ->type_name("SVG");
    command
        ->add_option("--cache", options->cache,
                     "Encodings; filled when empty (default: in the user's cache folder)")
        ->type_name("DIR");
    AddNumberOption(*command, "--steps", measure.steps, {1, 1e9},
                    "Training steps of encodings that are not in the cache (6000)");
    command
        ->add_option("--model", measure.model,
                     "A glTF model: one of its materials is measured too (default: FlightHelmet in "
                     "OPENNTC_SHARED_DIR, if there; not with --quick)")
        ->type_name("DIR");
    command->add_option("--sources", measure.sources, "Folder of OpenNTC's source, for shaders")
        ->type_name("DIR");
    command->add_option("--glslang", measure.glslang, "A glslang program that knows GL_NV_cooperative_vector")
        ->type_name("FILE");
    AddSceneOptions(*command, measure.scenes);
    command
        ->add_option("--training-material", measure.training.manifest,
                     "Material whose encoding is timed, as `ntc encode` takes it (default: the report's)")
        ->type_name("FILE");
    AddNumberOption(
        *command, "--training-seconds", measure.training.seconds, {1e-3, 1e6},
        "A curve of encodings ends with the first that takes longer (default 3, with --quick 0.2)");
    AddNumberOption(*command, "--training-batch", measure.training.batchTexels, {1024, 65536},
                    "Texels of a device's training step, a multiple of 1024 (default: the encoder's)");
    AddJsonFlag(*command, measure.json);
    command->callback([options, &action] { action = [options] { return RunReport(*options); }; });
}

} // namespace openntc::tool
