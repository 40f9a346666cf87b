// SPDX-License-Identifier: MIT
// What `ntc --version` says.
#pragma once

#include <string>

namespace openntc::tool {

/// `ntc 0.1.0`, then a line each for the commit, the compiler, the kernels that this machine runs, and the libraries of
/// this build. No line feed at the end.
std::string DescribeVersion();

} // namespace openntc::tool
