// SPDX-License-Identifier: MIT
// `ntc compile-shaders`: shader permutations to SPIR-V files, a header or one blob, without CMake.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "Progress.h"

#include "shader_compiler/Compiler.h"
#include "shader_compiler/Failure.h"
#include "shader_compiler/Outputs.h"
#include "shader_compiler/Permutations.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;
using namespace openntc::shader_compiler;

struct CompileShadersOptions {
    std::vector<std::string> sources;
    std::string list;
    std::vector<std::string> networks;
    std::vector<std::string> maths;
    std::vector<std::string> defines;
    std::string stage;
    std::string entry;
    std::vector<std::string> includeDirectories;
    std::string targetEnvironment = "vulkan1.1";
    std::string outputFolder;
    std::string header;
    std::string blob;
    int jobs = 0;
    bool noValidation = false;
    bool dryRun = false;
    bool flatten = false;
    bool json = false;
};

struct Plan {
    std::vector<shader_compiler::Permutation> permutations;
    std::vector<std::string> leftOut; // defines for which there is no compiler, sorted
};

const std::vector<std::string> kNetworks = {"small", "medium", "large", "xlarge", "gen2", "gen3"};
const std::vector<std::string> kMaths = {"int8",        "int8_half",    "fp8",
                                         "fp16",        "fp32",         "coopvec_int8",
                                         "coopvec_fp8", "coopmat_int8", "coopmat_int8_half"};

// The number of a name counts from 1, as in InferenceConstants.h and MathModes.h.
void AddNamedAxis(std::vector<DefineAxis>& axes, const char* macro, const char* option,
                  const std::vector<std::string>& known, const std::vector<std::string>& names) {
    DefineAxis axis{macro, {}};
    for (const std::string& name : names) {
        std::string lower = name;
        std::transform(lower.begin(), lower.end(), lower.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        const auto found = std::find(known.begin(), known.end(), lower);
        if (found == known.end()) {
            std::string all;
            for (const std::string& other : known) {
                all += all.empty() ? "" : ", ";
                all += other;
            }
            FailUsage(option, std::string(name).append(": one of ").append(all));
        }
        axis.values.push_back(std::to_string(found - known.begin() + 1));
    }
    if (!axis.values.empty())
        axes.push_back(axis);
}

Plan MakePlan(const CompileShadersOptions& options) {
    std::vector<SourceRequest> sources;
    const std::string stage =
        options.flatten ? "frag" : options.stage; // any will do; functions alone have none
    for (const std::string& source : options.sources)
        sources.push_back({source, stage, options.entry, {}});
    if (!options.list.empty()) {
        std::vector<SourceRequest> listed = ReadListFile(options.list);
        sources.insert(sources.end(), listed.begin(), listed.end());
    }
    if (sources.empty())
        FailUsage("compile-shaders", "SOURCES: missing, and no --list");
    std::vector<DefineAxis> axes;
    AddNamedAxis(axes, "NETWORK_VERSION", "--network", kNetworks, options.networks);
    AddNamedAxis(axes, "NTC_MATH", "--math", kMaths, options.maths);
    for (const std::string& define : options.defines)
        axes.push_back(ParseDefine(define));

    Plan plan;
    std::set<std::string> leftOut;
    for (shader_compiler::Permutation& permutation : ListPermutations(sources, axes)) {
        const bool canCompile = options.flatten || KnowsCooperativeVectors();
        if (permutation.NeedsCooperativeVectors() && (permutation.hlsl || !canCompile)) {
            for (const std::string& define : permutation.defines) {
                if (shader_compiler::IsCooperativeMath(define))
                    leftOut.insert(define);
            }
        } else {
            plan.permutations.push_back(std::move(permutation));
        }
    }
    plan.leftOut.assign(leftOut.begin(), leftOut.end());
    if (plan.permutations.empty())
        throw CommandError(
            ExitCode::NoDevice, "compile-shaders",
            "permutations: none is left: cooperative vectors and matrices need GLSL and a glslang that knows "
            "GL_NV_cooperative_vector");
    return plan;
}

std::string Join(const std::vector<std::string>& words) {
    std::string text;
    for (const std::string& word : words)
        text += (text.empty() ? "" : " ") + word;
    return text;
}

std::string GetIndexedFile(const std::string& line) {
    return line.substr(0, line.find('\t'));
}

/// The lines of earlier calls whose files are still in the folder and are not written anew: a folder is often
/// filled by several calls, one for each network.
std::string ListOtherFiles(const fs::path& folder, const std::string& index) {
    std::set<std::string> written;
    std::istringstream made(index);
    for (std::string line; std::getline(made, line);)
        written.insert(GetIndexedFile(line));
    std::string others;
    std::ifstream earlier(folder / "index.txt");
    for (std::string line; std::getline(earlier, line);) {
        const std::string file = GetIndexedFile(line);
        std::error_code error;
        if (!written.contains(file) && fs::is_regular_file(folder / file, error))
            others += line + "\n";
    }
    return others;
}

void WriteFolder(const CompileShadersOptions& options, const Plan& plan,
                 const std::vector<CompileResult>& results) {
    OutputFolder folder(options.outputFolder);
    for (std::size_t i = 0; i < results.size(); ++i) {
        if (options.flatten) {
            WriteBytes(folder.Stage(plan.permutations[i].GetFlatName()), results[i].text);
            continue;
        }
        const auto bytes = std::as_bytes(std::span(results[i].words));
        WriteBytes(folder.Stage(plan.permutations[i].GetFileName()),
                   {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    const std::string index = MakeIndex(plan.permutations, options.flatten);
    WriteBytes(folder.Stage("index.txt"), ListOtherFiles(options.outputFolder, index) + index);
    folder.Commit();
}

std::size_t GetSize(const CompileResult& result) {
    return result.text.size() + 4 * result.words.size();
}

std::string MakeJson(const Plan& plan, const std::vector<CompileResult>& results, double seconds, bool flat) {
    JsonWriter json;
    json.BeginObject();
    json.Key("permutations");
    json.BeginArray();
    for (std::size_t i = 0; i < plan.permutations.size(); ++i) {
        const shader_compiler::Permutation& permutation = plan.permutations[i];
        json.BeginObject();
        json.Member("source", std::string_view(permutation.source));
        json.Member("defines", std::string_view(permutation.GetDefines()));
        json.Member("file", std::string_view(flat ? permutation.GetFlatName() : permutation.GetFileName()));
        if (!results.empty()) {
            json.Member("bytes", static_cast<std::uint64_t>(GetSize(results[i])));
            json.Member("milliseconds", results[i].milliseconds);
        }
        json.EndObject();
    }
    json.EndArray();
    json.Key("leftOut");
    json.BeginArray();
    for (const std::string& define : plan.leftOut)
        json.Value(std::string_view(define));
    json.EndArray();
    if (!results.empty())
        json.Member("seconds", seconds);
    json.EndObject();
    return json.Take();
}

int RunPlan(const CompileShadersOptions& options) {
    const Plan plan = MakePlan(options);
    if (!plan.leftOut.empty() && !options.json)
        std::fprintf(
            stderr,
            "ntc: note: left out: %s: cooperative vectors and matrices need GLSL and a glslang that knows "
            "GL_NV_cooperative_vector\n",
            Join(plan.leftOut).c_str());
    if (options.dryRun) {
        WriteOutput(options.json ? MakeJson(plan, {}, 0, options.flatten)
                                 : MakeIndex(plan.permutations, options.flatten));
        return 0;
    }
    CompileSettings settings;
    settings.includeDirectories.assign(options.includeDirectories.begin(), options.includeDirectories.end());
    settings.targetEnvironment = options.targetEnvironment;
    settings.validate = !options.noValidation;
    settings.flatten = options.flatten;
    const auto begin = std::chrono::steady_clock::now();
    std::vector<CompileResult> results;
    {
        Progress progress("compile-shaders", plan.permutations.size(), options.json);
        results = CompileAll(plan.permutations, settings, options.jobs, [&] {
            progress.Advance(1);
            return !IsInterrupted();
        });
    }
    ThrowIfInterrupted();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const std::string leftOut = Join(plan.leftOut);
    if (!options.outputFolder.empty())
        WriteFolder(options, plan, results);
    if (!options.header.empty()) {
        const std::string name = MakeIdentifier(fs::path(options.header).stem().string());
        WriteBytes(options.header, MakeHeader(name, plan.permutations, results, leftOut));
    }
    if (!options.blob.empty())
        WriteBytes(options.blob, MakeBlob(plan.permutations, results, leftOut));
    if (options.json) {
        WriteOutput(MakeJson(plan, results, seconds, options.flatten));
    } else {
        std::uint64_t bytes = 0;
        for (const CompileResult& result : results)
            bytes += GetSize(result);
        WriteOutput(Format("%zu permutations, %llu bytes of %s, %.1f s\n", results.size(),
                           static_cast<unsigned long long>(bytes), options.flatten ? "text" : "SPIR-V",
                           seconds));
    }
    return 0;
}

int RunCompileShaders(const CompileShadersOptions& options) {
    if (options.flatten && (!options.header.empty() || !options.blob.empty()))
        FailUsage("--flatten", "--header and --blob hold SPIR-V; text goes to --output-dir");
    if (!options.dryRun && options.outputFolder.empty() && options.header.empty() && options.blob.empty())
        FailUsage("compile-shaders", "output: missing: --output-dir, --header, --blob or --dry-run");
    if (!IsTargetEnvironment(options.targetEnvironment))
        FailUsage("--target-env",
                  options.targetEnvironment + ": vulkan1.0, vulkan1.1, vulkan1.2 or vulkan1.3");
    try {
        return RunPlan(options);
    } catch (const shader_compiler::Failure& failure) {
        ExitCode code = ExitCode::Usage;
        if (failure.GetKind() == FailureKind::Input)
            code = ExitCode::BadInput;
        else if (failure.GetKind() == FailureKind::Output)
            code = ExitCode::Failed;
        throw CommandError(code, failure.GetSubject(), failure.what());
    }
}

} // namespace

void AddCompileShadersCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<CompileShadersOptions>();
    CLI::App* command = app.add_subcommand("compile-shaders", "Shader permutations to SPIR-V");
    command->add_option("SOURCES", options->sources,
                        "GLSL (x.comp, x.frag, x.vert) or HLSL (x.comp.hlsl ...) files");
    command->add_option("--list", options->list, "File of lines: PATH -T cs|ps|vs [-E entry] [-D X={0,1}]...")
        ->type_name("FILE");
    command
        ->add_option("--network", options->networks,
                     "NETWORK_VERSION: small, medium, large, xlarge, gen2, gen3")
        ->delimiter(',')
        ->type_name("NAME,...");
    command
        ->add_option("--math", options->maths,
                     "NTC_MATH: int8, int8_half, fp8, fp16, fp32, coopvec_int8, coopvec_fp8, coopmat_int8, "
                     "coopmat_int8_half")
        ->delimiter(',')
        ->type_name("MODE,...");
    command
        ->add_option(
            "-D,--define", options->defines,
            "NAME, NAME=VALUE or NAME={V1,V2,...}; an empty value leaves it undefined; may be repeated")
        ->type_name("DEFINE")
        ->allow_extra_args(false);
    command
        ->add_option("--stage", options->stage, "comp, frag or vert, of SOURCES whose ending does not say it")
        ->check(CLI::IsMember({"comp", "frag", "vert"}));
    command->add_option("--entry", options->entry, "Entry point of HLSL SOURCES (default main)");
    command
        ->add_option("-I,--include-dir", options->includeDirectories,
                     "Folder of included files; may be repeated")
        ->type_name("DIR")
        ->allow_extra_args(false);
    command->add_option("--target-env", options->targetEnvironment,
                        "vulkan1.0 ... vulkan1.3 (default vulkan1.1)");
    command
        ->add_option(
            "--output-dir", options->outputFolder,
            "Write a .spv file (of --flatten .glsl or .hlsl) for each permutation, and index.txt, which "
            "keeps the lines of files of earlier calls")
        ->type_name("DIR");
    command->add_option("--header", options->header, "Write one C++ header with FindShader()")
        ->type_name("FILE");
    command->add_option("--blob", options->blob, "Write one file for openntc::ShaderBlob")->type_name("FILE");
    command->add_option("--jobs", options->jobs, "Threads (default: one per core)")
        ->check(CLI::Range(1, 1024));
    command->add_flag("--no-validation", options->noValidation, "Do not run the SPIR-V validator");
    command->add_flag("--dry-run", options->dryRun, "Print what would be compiled: file, source and defines");
    command->add_flag(
        "--flatten", options->flatten,
        "Text without #include and other directives instead of SPIR-V, for hosts that have none; "
        "SOURCES may be headers");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunCompileShaders(*options); }; });
}

} // namespace openntc::tool
