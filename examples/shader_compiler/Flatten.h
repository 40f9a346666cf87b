// SPDX-License-Identifier: MIT
// One file without directives: preprocessed text for hosts that have no #include and no preprocessor of their own.
// cmake/OpenNTCFlattenShader.cmake is the same for builds with CMake.
#pragma once

#include <string>
#include <string_view>

namespace openntc::shader_compiler {

/// `preprocessed` (glslang's, with #line) as one text: #version and every #extension once, at the top, where WebGL wants
/// them; then `comment` as a line of its own; then the code, without empty lines and indentation. No other directive is
/// left but #pragma.
std::string FlattenText(std::string_view preprocessed, std::string_view comment);

} // namespace openntc::shader_compiler
