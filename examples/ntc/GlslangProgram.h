// SPDX-License-Identifier: MIT
// A glslang program, for what the glslang that we are linked with does not know.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace openntc::tool {

struct GlslangRequest {
    std::string program;          ///< with a folder, or to be found on the path
    std::filesystem::path source; ///< GLSL; its ending says the stage
    std::vector<std::filesystem::path> includeDirectories;
    std::vector<std::string> defines; ///< "NAME=VALUE"
    std::string targetEnvironment;    ///< "vulkan1.1"
};

/// SPIR-V. Throws CommandError(BadInput), named after the program, with what it said.
std::vector<std::uint32_t> RunGlslang(const GlslangRequest& request);

/// Why a program does not compile GL_NV_cooperative_vector: its first line; empty: it does.
std::string WhyNoCooperativeVectors(const std::string& program);

/// The first that does: of the environment's OPENNTC_GLSLANG, and of `glslang` and `glslangValidator` on the path. Empty: none.
std::string FindCooperativeVectorGlslang();

} // namespace openntc::tool
