// SPDX-License-Identifier: MIT
#include "renderer/gpu/ShaderCache.h"

#include "Failure.h"
#include "GlslangProgram.h"
#include "shader_compiler/Compiler.h"

#include <chrono>

namespace openntc::renderer {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;

fs::path ShaderCache::FindSource(const std::string& file) const {
    for (const char* const folder : {"examples/renderer/shaders", "shaders/openntc/passes"}) {
        std::error_code ignored;
        fs::path path = sources_ / folder / file;
        if (fs::is_regular_file(path, ignored))
            return path;
    }
    throw CommandError(ExitCode::BadInput, file,
                       "shader: not in " + sources_.string() + ": name the sources' folder with --sources");
}

const std::string& ShaderCache::FindGlslang() {
    if (vectorGlslang_)
        return *vectorGlslang_;
    if (glslang_.empty())
        return vectorGlslang_.emplace(tool::FindCooperativeVectorGlslang());
    if (const std::string reason = tool::WhyNoCooperativeVectors(glslang_); !reason.empty())
        throw CommandError(ExitCode::BadInput, "--glslang", glslang_ + ": " + reason);
    return vectorGlslang_.emplace(glslang_);
}

std::string ShaderCache::WhyNoCooperativeVectors() {
    if (shader_compiler::KnowsCooperativeVectors() || !FindGlslang().empty())
        return {};
    return "no glslang on the path knows GL_NV_cooperative_vector: name one with --glslang";
}

std::span<const std::uint32_t> ShaderCache::Get(const std::string& file,
                                                const std::vector<std::string>& defines) {
    std::string all;
    for (const std::string& define : defines)
        all += (all.empty() ? "" : " ") + define;
    const auto [found, isNew] = entries_.try_emplace(file + "|" + all);
    Entry& entry = found->second;
    if (!isNew)
        return entry.words;
    try {
        shader_compiler::Permutation permutation;
        permutation.path = FindSource(file);
        permutation.source = file;
        permutation.defines = defines;
        if (permutation.path.extension() == ".frag")
            permutation.stage = shader_compiler::Stage::Fragment;
        else if (permutation.path.extension() == ".vert")
            permutation.stage = shader_compiler::Stage::Vertex;
        shader_compiler::CompileSettings settings;
        settings.includeDirectories = {sources_ / "examples/renderer/shaders", sources_ / "shaders"};
        settings.targetEnvironment = "vulkan1.2"; // SPIR-V 1.5: lavapipe 22.3 knows no helper lanes in 1.6
        settings.validate = false;                // the driver is the judge here, as in `ntc report`
        if (permutation.NeedsCooperativeVectors() && !shader_compiler::KnowsCooperativeVectors()) {
            const auto begin = std::chrono::steady_clock::now();
            std::vector<std::uint32_t> words = tool::RunGlslang(
                {FindGlslang(), permutation.path, settings.includeDirectories, defines, "vulkan1.3"});
            const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - begin;
            entry = {file, all, std::move(words), time.count()};
            return entry.words;
        }
        shader_compiler::CompileResult result = shader_compiler::Compile(permutation, settings);
        if (!result.IsGood())
            throw CommandError(ExitCode::BadInput, file, result.error);
        entry = {file, all, std::move(result.words), result.milliseconds};
        return entry.words;
    } catch (...) {
        entries_.erase(found);
        throw;
    }
}

} // namespace openntc::renderer
