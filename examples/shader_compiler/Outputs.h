// SPDX-License-Identifier: MIT
// Compiled permutations as an index, a blob or a C++ header. Blob and index have the bytes that openntc_add_shaders()
// in CMake gives them.
#pragma once

#include "shader_compiler/Compiler.h"
#include "shader_compiler/Permutations.h"

#include <span>
#include <string>
#include <vector>

namespace openntc::shader_compiler {

/// A line for every permutation: file (SPIR-V, or flattened text), source and defines, separated by tabs.
std::string MakeIndex(std::span<const Permutation> permutations, bool flat = false);

/// The file that openntc::ShaderBlob reads (include/openntc/permutation/ShaderBlob.h). `leftOut`: defines that no compiler
/// could handle, sorted, separated by spaces. Throws Failure(Output) at 4 GiB.
std::string MakeBlob(std::span<const Permutation> permutations, std::span<const CompileResult> results,
                     const std::string& leftOut);

/// A header that needs nothing else but OpenNTC's: namespace `name` with GetShaders() and FindShader(), as
/// openntc_add_shaders(OUTPUT HEADER) declares them.
std::string MakeHeader(const std::string& name, std::span<const Permutation> permutations,
                       std::span<const CompileResult> results, const std::string& leftOut);

/// A name that C++ allows: other characters become '_', and one goes before a leading digit.
std::string MakeIdentifier(const std::string& name);

} // namespace openntc::shader_compiler
