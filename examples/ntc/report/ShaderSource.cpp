// SPDX-License-Identifier: MIT
#include "report/ShaderSource.h"

#include "Failure.h"
#include "TextureSet.h"
#include "conformance/ChildProcess.h"
#include "report_coopvec.h"

#if OPENNTC_REPORT_HAS_COMPILER
#include "shader_compiler/Compiler.h"
#endif

#include <cstring>
#include <filesystem>
#include <random>

namespace openntc::report {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;

namespace {

std::vector<std::uint32_t> RunGlslang(const ShaderRequest& request, const fs::path& source) {
    const fs::path output =
        fs::temp_directory_path() / ("ntc-report-" + std::to_string(std::random_device()()) + ".spv");
    std::vector<std::string> command = {request.glslang,
                                        "--quiet",
                                        "-V",
                                        "--target-env",
                                        request.cooperativeVectors ? "vulkan1.3" : "vulkan1.1",
                                        "-I" + (fs::path(request.sources) / "shaders").string()};
    for (const std::string& define : request.defines)
        command.push_back("-D" + define);
    command.insert(command.end(), {"-o", output.string(), source.string()});
    conformance::ChildProcess process;
    constexpr double kSeconds = 60;
    const auto deadline = conformance::ChildProcess::Clock::now() + std::chrono::seconds(60);
    std::string lines;
    if (Expected<void> started = process.Start(command); !started)
        throw CommandError(ExitCode::BadInput, request.glslang, started.error().GetText());
    Expected<std::string> line = process.ReadLine(deadline, kSeconds);
    for (; line; line = process.ReadLine(deadline, kSeconds))
        lines += (lines.empty() ? "" : "; ") + *line;
    std::error_code ignored;
    if (!fs::exists(output, ignored))
        throw CommandError(ExitCode::BadInput, request.glslang,
                           lines.empty() ? line.error().GetText() : lines);
    const std::vector<std::byte> bytes = tool::ReadAll(output.string());
    fs::remove(output, ignored);
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), words.size() * 4);
    return words;
}

} // namespace

// In order: the compiler that is part of the program, a glslang that is named, and SPIR-V that is part of the program.
ShaderResult CompileReportShader(const ShaderRequest& request) {
    const fs::path source = fs::path(request.sources) / request.shader;
    std::error_code ignored;
    if (!fs::is_regular_file(source, ignored))
        throw CommandError(ExitCode::BadInput, source.string(),
                           "shader: missing: name the source with --sources");
#if OPENNTC_REPORT_HAS_COMPILER
    if (!request.cooperativeVectors || shader_compiler::KnowsCooperativeVectors()) {
        shader_compiler::Permutation permutation;
        permutation.path = source;
        permutation.source = source.filename().string();
        permutation.defines = request.defines;
        shader_compiler::CompileSettings settings;
        settings.includeDirectories = {fs::path(request.sources) / "shaders"};
        settings.targetEnvironment = request.cooperativeVectors ? "vulkan1.3" : "vulkan1.1";
        settings.validate = false; // the driver is the judge here; `ntc compile-shaders` validates
        shader_compiler::CompileResult result = shader_compiler::Compile(permutation, settings);
        if (!result.IsGood())
            throw CommandError(ExitCode::BadInput, source.string(), result.error);
        return {std::move(result.words), {}};
    }
#endif
    if (!request.glslang.empty())
        return {RunGlslang(request, source), {}};
    std::string defines;
    for (const std::string& define : request.defines)
        defines += (defines.empty() ? "" : " ") + define;
    if (const auto stored = report_coopvec::FindShader(source.filename().string(), defines))
        return {{stored->begin(), stored->end()}, {}};
    return {{}, "no glslang that knows it: name one with --glslang"};
}

} // namespace openntc::report
