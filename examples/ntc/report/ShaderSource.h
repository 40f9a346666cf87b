// SPDX-License-Identifier: MIT
// SPIR-V of the shaders that the report runs, compiled while the command runs or, of cooperative vectors, kept in the program.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace openntc::report {

struct ShaderRequest {
    std::string sources; ///< folder of OpenNTC's source
    std::string shader;  ///< path in it
    std::string glslang; ///< a glslang program, for what the built-in one does not know; may be empty
    std::vector<std::string> defines;
    bool cooperativeVectors = false;
};

struct ShaderResult {
    std::vector<std::uint32_t> words;
    std::string missing; ///< why nobody can compile it; empty: there are words
};

/// Throws CommandError(BadInput) if the source is not there or does not compile.
ShaderResult CompileReportShader(const ShaderRequest& request);

} // namespace openntc::report
