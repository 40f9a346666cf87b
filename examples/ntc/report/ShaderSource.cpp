// SPDX-License-Identifier: MIT
#include "report/ShaderSource.h"

#include "Failure.h"
#include "GlslangProgram.h"
#include "report_coopvec.h"

#if OPENNTC_REPORT_HAS_COMPILER
#include "shader_compiler/Compiler.h"
#endif

#include <filesystem>

namespace openntc::report {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;

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
        return {tool::RunGlslang({request.glslang,
                                  source,
                                  {fs::path(request.sources) / "shaders"},
                                  request.defines,
                                  request.cooperativeVectors ? "vulkan1.3" : "vulkan1.1"}),
                {}};
    std::string defines;
    for (const std::string& define : request.defines)
        defines += (defines.empty() ? "" : " ") + define;
    if (const auto stored = report_coopvec::FindShader(source.filename().string(), defines))
        return {{stored->begin(), stored->end()}, {}};
    return {{}, "no glslang that knows it: name one with --glslang"};
}

} // namespace openntc::report
