// SPDX-License-Identifier: MIT
// GLSL and HLSL to SPIR-V in process: glslang's library, with the settings of `glslangValidator -V`, and the SPIR-V
// validator.
#pragma once

#include "shader_compiler/Permutations.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace openntc::shader_compiler {

struct CompileSettings {
    std::vector<std::filesystem::path> includeDirectories;
    std::string targetEnvironment = "vulkan1.1"; ///< vulkan1.0 … vulkan1.3
    bool validate = true;
    bool flatten = false; ///< one text without directives (Flatten.h) instead of SPIR-V
};

/// SPIR-V or, of CompileSettings::flatten, text; or the first error of the compiler or validator: `FILE:LINE: message`.
struct CompileResult {
    std::vector<std::uint32_t> words;
    std::string text{};
    std::string error{};
    double milliseconds = 0;

    bool IsGood() const { return error.empty(); }
};

/// Is that an environment's name?
bool IsTargetEnvironment(const std::string& name);

/// Does the glslang that we are linked with know GL_NV_cooperative_vector? Found out once, by compiling a line.
bool KnowsCooperativeVectors();

/// Compiles one permutation, in this process: a crash of the compiler is a crash of the caller.
CompileResult Compile(const Permutation& permutation, const CompileSettings& settings);

/// The validator alone; empty if the words are good, else its message.
std::string Validate(std::span<const std::uint32_t> words, const std::string& targetEnvironment);

/// Compiles all in `processes` child processes (0: one per core), so that a crash of the compiler is an error like others.
/// `progress`, if given, is called after every permutation, on the calling thread, and stops the work by returning false. The
/// result has the order of `permutations`.
/// Throws Failure(Input) with the first one that does not compile; nothing else is lost by stopping.
std::vector<CompileResult> CompileAll(const std::vector<Permutation>& permutations,
                                      const CompileSettings& settings, int processes = 0,
                                      const std::function<bool()>& progress = {});

} // namespace openntc::shader_compiler
